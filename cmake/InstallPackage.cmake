# SPDX-License-Identifier: GPL-3.0-only
# Installs vcg_ext as the package that find_package(sphere_propagation) finds: component `vcg_ext`. For vcg_ext/CMakeLists.txt.
include(CMakePackageConfigHelpers)
include(GNUInstallDirs)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/sphere_propagation)

install(TARGETS vcg_ext EXPORT sphere_propagation
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT vcg_ext
        INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/vcg_ext DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT vcg_ext
        FILES_MATCHING PATTERN "*.h")
install(EXPORT sphere_propagation NAMESPACE sphere_propagation:: FILE sphere_propagationTargets.cmake
        DESTINATION ${package_dir} COMPONENT vcg_ext)

configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/sphere_propagationConfig.cmake.in
  ${PROJECT_BINARY_DIR}/sphere_propagationConfig.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/sphere_propagationConfigVersion.cmake
  VERSION ${PROJECT_VERSION} COMPATIBILITY SameMajorVersion)
install(FILES ${PROJECT_BINARY_DIR}/sphere_propagationConfig.cmake ${PROJECT_BINARY_DIR}/sphere_propagationConfigVersion.cmake
        DESTINATION ${package_dir} COMPONENT vcg_ext)
