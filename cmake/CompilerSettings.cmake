# SPDX-License-Identifier: GPL-3.0-only
# Flags of this project's own targets; link `sphere_propagation_settings` PRIVATE. Other people's headers come in as SYSTEM and stay silent.
add_library(sphere_propagation_settings INTERFACE)

# Fused multiply-adds change the last bit from one processor to the next: results should not depend on the machine.
target_compile_options(sphere_propagation_settings INTERFACE
  -Wall -Wextra -Wpedantic $<IF:$<CXX_COMPILER_ID:GNU>,-Wshadow=local,-Wshadow> -Wfloat-conversion -Wnon-virtual-dtor -Woverloaded-virtual -Wextra-semi
  -ffp-contract=off)

if(SPHERE_PROPAGATION_WERROR)
  target_compile_options(sphere_propagation_settings INTERFACE -Werror)
endif()

if(SPHERE_PROPAGATION_SANITIZE)
  target_compile_options(sphere_propagation_settings INTERFACE
    -fsanitize=${SPHERE_PROPAGATION_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  # What the address sanitizer finds as well, at the access itself (null, object-size, pointer-overflow), and what does no harm here
  # (alignment: Eigen asserts its own) took as long to compile, and to run, as all other checks together.
  if(SPHERE_PROPAGATION_SANITIZE MATCHES "address" AND SPHERE_PROPAGATION_SANITIZE MATCHES "undefined")
    target_compile_options(sphere_propagation_settings INTERFACE -fno-sanitize=null,alignment,object-size,pointer-overflow)
  endif()
  target_compile_definitions(sphere_propagation_settings INTERFACE _GLIBCXX_ASSERTIONS)
  target_link_options(sphere_propagation_settings INTERFACE -fsanitize=${SPHERE_PROPAGATION_SANITIZE})
endif()
