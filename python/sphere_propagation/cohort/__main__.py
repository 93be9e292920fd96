# SPDX-License-Identifier: GPL-3.0-only
"""python -m sphere_propagation.cohort STEP [NUMBER]: one step of a study, in its output folder, as
the Snakefile calls them."""

from __future__ import annotations

import os
import sys

for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"  # the same sums in the same order, and one core for a job

from sphere_propagation.cohort import steps  # noqa: E402

sys.exit(steps.main(sys.argv[1:]))
