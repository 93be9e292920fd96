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

# sanitize(TARGET KIND): a library as "address" (with undefined behaviour) or "thread" sanitizers see it, whatever the build's type:
# with assertions, Eigen's too, and lines of the source.
#
# By -Og with the inlining of -O1, which takes two thirds of the time to compile and is as quick; for threads, where it is not,
# by -O1.
function(sanitize TARGET KIND)
  set(flags -g1 -UNDEBUG -D_GLIBCXX_ASSERTIONS -fno-sanitize-recover=all -fno-omit-frame-pointer)
  if(KIND STREQUAL "address")
    # What the address sanitizer finds as well, at the access itself (null, object-size, pointer-overflow), and what does no harm
    # here (alignment: Eigen asserts its own) took as long to compile, and to run, as all other checks together.
    # Eigen would shift what it allocates here, but not in the tests, which give it back.
    list(APPEND flags -DEIGEN_MALLOC_ALREADY_ALIGNED=1 -Og -finline-small-functions -finline-functions-called-once
         -fsanitize=address,undefined -fno-sanitize=null,alignment,object-size,pointer-overflow)
    target_link_options(${TARGET} INTERFACE -fsanitize=address,undefined)
  else()
    list(APPEND flags -O1 -fsanitize=thread)
    target_link_options(${TARGET} INTERFACE -fsanitize=thread)
  endif()
  target_compile_options(${TARGET} PRIVATE ${flags})
endfunction()
