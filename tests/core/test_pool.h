// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Threads for tests that ask for some and do not mind which.

#include "vcg_ext/base/thread_pool.h"

namespace sphere_propagation::test {

inline ThreadPool pool(2);

}  // namespace sphere_propagation::test
