# SPDX-License-Identifier: GPL-3.0-only
"""Threads wait for their turn; a call inside another one is refused, and waits for nobody."""

import asyncio
import os
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import sphere_propagation as sp
from sphere_propagation import turns
from sphere_propagation.progress import Silent


def same(maps, others):
    return all(np.array_equal(a.positions, b.positions) for a, b in zip(maps, others))


def test_threads_and_asyncio_give_what_one_thread_gives(cycle):
    surfaces = cycle.surfaces[:4]
    alone = [sp.parameterise_root(surface) for surface in surfaces]
    with ThreadPoolExecutor(4) as threads:
        assert same(threads.map(sp.parameterise_root, surfaces), alone)

    async def together():
        return await asyncio.gather(
            *(
                asyncio.get_running_loop().run_in_executor(None, sp.parameterise_root, surface)
                for surface in surfaces
            )
        )

    assert same(asyncio.run(together()), alone)


def test_a_refusal_of_one_thread_leaves_the_others_alone(cycle):
    surface = cycle.surfaces[0]
    opened = sp.Surface(surface.vertices, surface.faces[1:], "opened")
    with ThreadPoolExecutor(4) as threads:
        jobs = [threads.submit(sp.parameterise_root, s) for s in 3 * [surface, opened]]
    for good, bad in zip(jobs[::2], jobs[1::2]):
        assert len(good.result().positions) == len(surface.vertices)
        assert isinstance(bad.exception(), sp.FilterError) and "opened" in str(bad.exception())


def test_files_are_read_in_threads(cycle, tmp_path, monkeypatch):
    """PyMeshLab goes to a file's folder: relative paths still mean the same to all threads."""
    monkeypatch.chdir(tmp_path)
    paths = []
    for i, surface in enumerate(3 * cycle.surfaces):
        (tmp_path / str(i)).mkdir()
        paths.append(f"{i}/heart.ply")
        sp.write_ply(paths[-1], surface.vertices, surface.faces)
    with ThreadPoolExecutor(4) as threads:
        found = list(threads.map(sp.read_mesh, paths))
    for surface, read in zip(3 * cycle.surfaces, found):
        assert np.array_equal(read.faces, surface.faces)
    assert os.getcwd() == str(tmp_path)


def test_a_progress_callback_may_call(cycle):
    """It is called between filters."""

    class Curious(Silent):
        def done(self, found):
            phantoms.append(sp.make_phantom(phases=1, voxel_size=4))

    phantoms = []
    sp.correspond(cycle.surfaces[:2], root=0, frequency=1, progress=Curious())
    assert len(phantoms) == 3


def test_a_call_inside_a_filter_is_refused_and_waits_for_nobody(cycle):
    with turns.turn("first"), pytest.raises(sp.SpherePropagationError, match="in the same thread"):
        sp.parameterise_root(cycle.surfaces[0])
    sp.parameterise_root(cycle.surfaces[0])


def test_a_process_that_is_forked_meanwhile_waits_for_nobody():
    with turns.turn("of the parent"):
        child = os.fork()
        if not child:
            with turns.turn("of the child"):
                os._exit(7)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
