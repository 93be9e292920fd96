# SPDX-License-Identifier: GPL-3.0-only
"""Where the data, the yardstick and the plugins are that the benchmarks work with."""

import os
import sys
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[1]
DATA = Path(os.environ.get("SPHERE_PROPAGATION_DATA") or PROJECT / "../shared/data").resolve()
PLUGIN = Path(
    os.environ.get("SPHERE_PROPAGATION_PLUGIN")
    or PROJECT / "build/pymeshlab/plugins/libfilter_sphere_propagation.so"
).resolve()
VOLUME_PLUGIN = PLUGIN.with_name("libfilter_label_volume.so")


def given_data():
    """The folder that the program's only argument names, else DATA; ends the program where it has
    no hearts."""
    data = Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else DATA
    if not (data / "heart_truth").is_dir():
        sys.exit(f"No data in {data}: name the folder with heart_cine and heart_truth.")
    return data


def yardstick(data):
    """The yardstick's modules `measure` and `phantom`; ends the program where they are not beside
    the data."""
    folder = data.resolve().parent / "yardstick"
    if not (folder / "measure.py").is_file():
        sys.exit(f"No yardstick beside {data}: name the folder with heart_cine and heart_truth.")
    sys.path.insert(0, str(folder))
    import measure
    import phantom

    return measure, phantom
