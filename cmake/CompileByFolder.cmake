# SPDX-License-Identifier: GPL-3.0-only
# compile_by_folder(TARGET [EXCEPT FILE...]): all sources of a folder are compiled as one (a unity build), so that the headers of
# Eigen, VCG and Qt are read, and what is instantiated of them compiled, once per folder instead of once per file.
#
# What is one: the folders below the target's own, each with all that it holds (vcg_ext/mesh, vcg_ext/propagation), or the sources
# beside its CMakeLists.txt. Names in their anonymous namespaces must differ. -DSPHERE_PROPAGATION_COMPILE_BY_FOLDER=OFF
# compiles every file by itself, which is quicker for those who change one again and again; scripts/lint does so, too.
option(SPHERE_PROPAGATION_COMPILE_BY_FOLDER "Compile all sources of a folder as one: quicker from empty" ON)

function(compile_by_folder TARGET)
  cmake_parse_arguments(PARSE_ARGV 1 ARG "" "" EXCEPT)
  get_target_property(sources ${TARGET} SOURCES)
  get_target_property(root ${TARGET} SOURCE_DIR)
  foreach(source ${sources})
    get_filename_component(path ${source} ABSOLUTE BASE_DIR ${root})
    file(RELATIVE_PATH path ${root} ${path})
    if(path MATCHES "\\.cpp$" AND NOT path IN_LIST ARG_EXCEPT)
      set(folder ${TARGET})
      if(path MATCHES "^([^/]+)/")
        set(folder ${CMAKE_MATCH_1})
      endif()
      set_source_files_properties(${source} TARGET_DIRECTORY ${TARGET} PROPERTIES UNITY_GROUP ${folder})
    endif()
  endforeach()
  set_target_properties(${TARGET} PROPERTIES UNITY_BUILD ${SPHERE_PROPAGATION_COMPILE_BY_FOLDER} UNITY_BUILD_MODE GROUP)
endfunction()

# compile_tests_by_folder(TARGET): the same for tests, which lie side by side: those of one folder's sources are one, as the header
# that each of them includes first tells. What they share is compiled file by file.
function(compile_tests_by_folder TARGET)
  get_target_property(sources ${TARGET} SOURCES)
  foreach(source ${sources})
    file(STRINGS ${source} tested REGEX "^#include \"" LIMIT_COUNT 1)
    if(source MATCHES "_test\\.cpp$" AND tested MATCHES "^#include \"vcg_ext/([^/]+)/")
      set_source_files_properties(${source} TARGET_DIRECTORY ${TARGET} PROPERTIES UNITY_GROUP tests_of_${CMAKE_MATCH_1})
    endif()
  endforeach()
  set_target_properties(${TARGET} PROPERTIES UNITY_BUILD ${SPHERE_PROPAGATION_COMPILE_BY_FOLDER} UNITY_BUILD_MODE GROUP)
endfunction()
