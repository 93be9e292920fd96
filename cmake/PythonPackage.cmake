# SPDX-License-Identifier: GPL-3.0-only
# What CMake puts into the Python package beside its modules (pyproject.toml): the plugins for PyMeshLab, as component `python`.
set(python_plugins filter_sphere_propagation filter_label_volume)

# After the plugins' targets.
function(install_python_plugins)
  foreach(plugin ${python_plugins})
    if(TARGET ${plugin})
      install(TARGETS ${plugin} LIBRARY DESTINATION . COMPONENT python EXCLUDE_FROM_ALL)
    endif()
  endforeach()
endfunction()

# Plugins that were built before, with the libraries that they need in lib/, as by scripts/wheel: there is nothing to compile.
if(SPHERE_PROPAGATION_PLUGIN_DIR)
  add_custom_target(plugins)
  foreach(plugin ${python_plugins})
    install(FILES ${SPHERE_PROPAGATION_PLUGIN_DIR}/lib${plugin}.so DESTINATION . COMPONENT python EXCLUDE_FROM_ALL)
  endforeach()
  install(DIRECTORY ${SPHERE_PROPAGATION_PLUGIN_DIR}/lib DESTINATION . COMPONENT python EXCLUDE_FROM_ALL)
endif()
