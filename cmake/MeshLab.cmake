# SPDX-License-Identifier: GPL-3.0-only
# Where MeshLab's headers are, and add_meshlab_plugin(NAME SOURCES...).
#
# MESHLAB_SOURCE_DIR  an unpacked MeshLab source tree; scripts/build names one, otherwise scripts/needs finds or fetches it
# MESHLAB_VERSION     what the host checks, e.g. 2025.07d (double), 2025.07 (float) or 2020.09
# MESHLAB_SCALAR      double or float; must be the host's

set(MESHLAB_VERSION 2025.07d CACHE STRING "MeshLab version the plugin is for")
set(MESHLAB_SCALAR double CACHE STRING "Scalar type of that MeshLab")
set(MESHLAB_SOURCE_DIR "$ENV{MESHLAB_SOURCE_DIR}" CACHE PATH "Unpacked MeshLab source tree (empty: fetched into the user's cache)")

if(NOT MESHLAB_SOURCE_DIR)
  string(REGEX REPLACE "d$" "" release ${MESHLAB_VERSION})
  execute_process(COMMAND ${PROJECT_SOURCE_DIR}/scripts/needs headers ${release}
                  OUTPUT_VARIABLE MESHLAB_SOURCE_DIR OUTPUT_STRIP_TRAILING_WHITESPACE RESULT_VARIABLE failed)
  if(failed)
    message(FATAL_ERROR "MeshLab's headers could not be fetched: see above, or set MESHLAB_SOURCE_DIR to an unpacked MeshLab ${release}.")
  endif()
endif()

# 2020.09 keeps vcglib beside src, later versions inside.
set(vcglib_dir ${MESHLAB_SOURCE_DIR}/src/vcglib)
if(NOT EXISTS ${vcglib_dir}/vcg)
  set(vcglib_dir ${MESHLAB_SOURCE_DIR}/vcglib)
endif()
if(NOT EXISTS ${vcglib_dir}/vcg/complex/complex.h)
  message(FATAL_ERROR "MESHLAB_SOURCE_DIR=${MESHLAB_SOURCE_DIR} holds no MeshLab source tree.")
endif()

add_library(vcglib INTERFACE)
target_include_directories(vcglib SYSTEM INTERFACE ${vcglib_dir})

if(SPHERE_PROPAGATION_PLUGINS)
  need_package(Qt5 5.12 COMPONENTS Core Widgets OpenGL Xml)

  add_library(meshlab_headers INTERFACE)
  target_include_directories(meshlab_headers SYSTEM INTERFACE ${MESHLAB_SOURCE_DIR}/src)
  target_compile_definitions(meshlab_headers INTERFACE
    MESHLAB_VERSION=${MESHLAB_VERSION} MESHLAB_SCALAR=${MESHLAB_SCALAR})
  # The interfaces of MeshLab 2021 and later, or those of 2020.09, which has others and checks no version.
  set(meshlab_host meshlab_2025)
  if(MESHLAB_VERSION STREQUAL "2020.09")
    set(meshlab_host meshlab_2020)
    target_compile_definitions(meshlab_headers INTERFACE HOST_IS_MESHLAB_2020)
  endif()
  target_link_libraries(meshlab_headers INTERFACE vcglib Qt5::Core Qt5::Widgets Qt5::OpenGL Qt5::Xml)

  # An empty library that carries the name of MeshLab's own. PyMeshLab loads plugins with RTLD_LOCAL, so a plugin finds the
  # host's functions only when it names the library that holds them; the real one is loaded before any plugin.
  file(WRITE ${PROJECT_BINARY_DIR}/stub/stub.cpp "")
  add_library(meshlab_common_stub SHARED ${PROJECT_BINARY_DIR}/stub/stub.cpp)
  set_target_properties(meshlab_common_stub PROPERTIES
    OUTPUT_NAME meshlab-common LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/stub)
endif()

include(EmbedTexts)
add_custom_target(plugins) # all of them, without tests and benchmarks
set(MESHLAB_PLUGIN_EXPORTS ${CMAKE_CURRENT_LIST_DIR}/plugin_exports.map)

# What the plugins share, compiled once.
if(SPHERE_PROPAGATION_PLUGINS)
  file(GLOB host_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/host/*.cpp ${PROJECT_SOURCE_DIR}/host/${meshlab_host}/*.cpp)
  add_library(host OBJECT ${host_sources})
  set_target_properties(host PROPERTIES POSITION_INDEPENDENT_CODE ON)
  target_link_libraries(host PUBLIC vcg_ext meshlab_headers PRIVATE sphere_propagation_settings)
  compile_by_folder(host)
endif()

# A plugin build/<preset>/plugins/lib<NAME>.so. Its functions that only the host defines stay undefined until it is loaded.
# <NAME>.cpp, which holds the plugin's class, is compiled by itself: Qt's macros (slots, emit) are for no other file.
function(add_meshlab_plugin NAME)
  add_library(${NAME} MODULE ${ARGN})
  target_link_libraries(${NAME} PRIVATE host sphere_propagation_settings)
  compile_by_folder(${NAME} EXCEPT ${NAME}.cpp)
  add_dependencies(${NAME} meshlab_common_stub)
  add_dependencies(plugins ${NAME})
  target_compile_definitions(${NAME} PRIVATE QT_PLUGIN)
  # Only Qt's two entry points are visible: other plugins bring their own Eigen and VCG, built with other flags.
  target_link_options(${NAME} PRIVATE
    "LINKER:--push-state,--no-as-needed,$<TARGET_FILE:meshlab_common_stub>,--pop-state"
    "LINKER:--version-script=${MESHLAB_PLUGIN_EXPORTS}")
  embed_texts(${NAME} ${CMAKE_CURRENT_SOURCE_DIR}/help)
  set_target_properties(${NAME} PROPERTIES
    AUTOMOC ON
    AUTOGEN_ORIGIN_DEPENDS OFF # moc needs no library to be built
    SKIP_BUILD_RPATH ON
    LINK_DEPENDS ${MESHLAB_PLUGIN_EXPORTS}
    LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/plugins)
endfunction()
