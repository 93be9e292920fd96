# SPDX-License-Identifier: GPL-3.0-only
"""A filter that runs out of memory leaves the project as it was, also while it writes.

One allocation after the other fails, in a process of its own into which an `operator new` is
preloaded that does so.
"""

import ctypes
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parent
BIG = 10**12
LAST = 100  # allocations before the end, among which are those of the commit


def mapped():
    from documents import COLOR, REMESH, ROOT, small_cycle

    ms = small_cycle(2)
    ms.apply_filter(ROOT)
    ms.apply_filter(REMESH, frequency=2)
    ms.apply_filter(COLOR)
    ms.set_current_mesh(0)
    return ms


def scenario(name):
    """A project, a filter and its parameters, and whether the filter makes layers."""
    import documents as d

    if name == "a map":
        return d.small_cycle(1), d.ROOT, {"threads": 1}
    if name == "a map again":
        return mapped(), d.ROOT, {"area_weight": 0.5, "threads": 1}
    if name == "quality of faces":
        return mapped(), d.COLOR, {"pattern": "Area ratio"}
    if name == "layers that are replaced":
        return mapped(), d.REMESH, {"frequency": 3, "threads": 1}
    return mapped(), d.SPHERES, {}


SCENARIOS = [
    "a map",
    "a map again",
    "quality of faces",
    "layers that are replaced",
    "new layers",
]


def run(library, name):
    """Lets each of the last allocations of the filter fail; prints how many of these it told of."""
    import documents as d
    import pymeshlab
    from environment import PLUGIN

    pymeshlab.load_plugin(str(PLUGIN))
    fault = ctypes.CDLL(library)
    fault.fail_allocation.argtypes = [ctypes.c_long]
    fault.stop_failing.restype = ctypes.c_long

    def attempt(ms, filter_name, parameters, n):
        message = None
        fault.fail_allocation(n)
        try:
            ms.apply_filter(filter_name, **parameters)
        except pymeshlab.PyMeshLabException as error:
            message = str(error)
        except MemoryError:
            message = "PyMeshLab"  # what it allocates itself, before or after the filter
        return message, fault.stop_failing()

    kept = []
    for _ in range(2):  # what is set up once is set up in the first
        kept.append(scenario(name))
        message, left = attempt(*kept[-1], BIG)
        assert message is None
    count = BIG - left
    told = 0
    project = scenario(name)
    before = d.snapshot(project[0])
    for n in range(max(0, count - LAST), count):
        message, _ = attempt(*project, n)
        same = d.snapshot(project[0]) == before
        if message is not None and "not enough memory" in message:
            told += 1
            assert same, f"allocation {n} of {count}: the project was changed"
        if not same:  # written, and PyMeshLab failed behind that
            kept.append(project)
            project = scenario(name)
            before = d.snapshot(project[0])
    print(told)


@pytest.mark.skipif(shutil.which("c++") is None, reason="no compiler")
@pytest.mark.parametrize("name", SCENARIOS)
def test_the_project_stays_as_it_was(name, tmp_path):
    library = tmp_path / "failing_new.so"
    subprocess.run(
        ["c++", "-std=c++17", "-O1", "-shared", "-fPIC", HERE / "failing_new.cpp", "-o", library],
        check=True,
    )
    code = f"import test_out_of_memory as t; t.run({str(library)!r}, {name!r})"
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=HERE,
        env=dict(os.environ, LD_PRELOAD=str(library)),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-4000:]
    assert int(done.stdout.split()[-1]) > 3
