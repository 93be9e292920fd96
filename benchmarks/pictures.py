#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-only
"""Prints what the pictures of `sphere-propagation run` cost beside what is computed.

    pictures.py [DATA]

    DATA    folder with heart_cine (default SPHERE_PROPAGATION_DATA, else ../shared/data)

CPU seconds of the whole command, the least of three: with --no-pictures, and what the pictures add
to that, of which as much is spent on loading Pillow and VTK as a process that does nothing else
takes. Once before, unmeasured: Python compiles what it imports for the first time.
"""

import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

from setting import given_data

PROJECT = Path(__file__).resolve().parents[1]
LIBRARIES = "import PIL.ImageDraw, PIL.ImageFont, vtkmodules.vtkRenderingOpenGL2"


def cpu_seconds(*arguments):
    """Of a process of this Python, the least of three; run once more before."""
    environment = {**os.environ, "PYTHONPATH": str(PROJECT / "python")}
    found = []
    for _ in range(4):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(
            [sys.executable, *map(str, arguments)],
            check=True,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env=environment,
        )
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        found.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return min(found[1:])


def main():
    heart = sorted((given_data() / "heart_cine").glob("endo_*.ply"))
    sample = sorted((PROJECT / "sample_projects/ventricle/surfaces").glob("*.ply"))
    loading = cpu_seconds("-c", LIBRARIES) - cpu_seconds("-c", "import numpy, PIL.Image")
    print("| phases | computation | pictures | of which loading libraries |")
    print("| --- | --- | --- | --- |")
    for files, name in ((sample, "the sample's 5"), (heart[::3], "10"), (heart, "30")):
        with tempfile.TemporaryDirectory() as folder:
            run = ("-m", "sphere_propagation", "run", *files, "-o", folder, "--order", "cyclic")
            without = cpu_seconds(*run, "--no-pictures")
            pictures = cpu_seconds(*run) - without
        print(f"| {name} | {without:.1f} | {pictures:.1f} | {loading:.1f} |", flush=True)


if __name__ == "__main__":
    main()
