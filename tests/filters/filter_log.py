# SPDX-License-Identifier: GPL-3.0-only
"""What filters write into MeshLab's log, which PyMeshLab keeps from Python: read from a process of
its own."""

import os
import subprocess
import sys
from pathlib import Path

from environment import PLUGIN

BEFORE = f"""
import sys
sys.path.insert(0, {str(Path(__file__).parent)!r})
import numpy as np
import pymeshlab
from documents import *
for file in {[str(PLUGIN), str(PLUGIN.with_name("libfilter_label_volume.so"))]!r}:
    if __import__("os").path.exists(file):
        pymeshlab.load_plugin(file)
ms = pymeshlab.MeshSet(verbose=True)
"""


def log_of(script, folder=None):
    """All that is printed while `script` runs, in this folder. It knows `ms`, an empty project that
    writes its log, pymeshlab, np, and what documents.py holds."""
    run = subprocess.run(
        [sys.executable, "-c", BEFORE + script],
        capture_output=True,
        text=True,
        check=False,
        cwd=folder,
        env=os.environ,
    )
    assert run.returncode == 0, run.stderr
    return run.stdout + run.stderr


def lines_of(script, folder=None):
    """The lines of the log alone, without percentages."""
    lines = [line for line in log_of(script, folder).splitlines() if line.startswith("LOG: ")]
    lines = [line.split(" ", 2)[2].strip() for line in lines]
    return [line for line in lines if not line.endswith("% ]")]
