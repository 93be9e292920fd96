# SPDX-License-Identifier: GPL-3.0-only
"""From a folder of subjects to one model: steps that an engine (Snakemake) runs on a laptop or on
a cluster. docs/cohorts.md says what it does; `sphere-propagation cohort` starts it."""
