# SPDX-License-Identifier: GPL-3.0-only
"""python -m sphere_propagation.cohort STEP [NUMBER]: one step of a study, in its output folder, as
the Snakefile calls them."""

from __future__ import annotations

import os
import sys

from sphere_propagation.cohort import steps

# The same sums in the same order, and one core for a job. NumPy reads it when it is loaded, which
# is before this; the Snakefile sets it.
ALONE = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
if any(os.environ.get(name) != value for name, value in ALONE.items()):
    words = [sys.executable, "-m", "sphere_propagation.cohort", *sys.argv[1:]]
    os.execve(sys.executable, words, {**os.environ, **ALONE})

sys.exit(steps.main(sys.argv[1:]))
