# SPDX-License-Identifier: GPL-3.0-only
# Read by ctest: the shared data beside the checkout, unless the caller names another folder.
get_filename_component(shared_data ${CMAKE_CURRENT_LIST_DIR}/../../shared/data ABSOLUTE)
if(NOT DEFINED ENV{SPHERE_PROPAGATION_DATA} AND EXISTS ${shared_data})
  set(ENV{SPHERE_PROPAGATION_DATA} ${shared_data})
endif()
