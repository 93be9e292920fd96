#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-only
"""What the page to explore a model costs in headless Chromium, at 1002 landmarks and 30 modes.

    scripts/measure --explorer

CPU milliseconds of the main thread, in which the page's own work is done, up to handing buffers and
commands to WebGL; a picture of a screen of 60 Hz has 16.7. And how many pictures a second there
were when shapes were played here, where Chromium has no graphics card and draws by software.
"""

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np
import sphere_propagation as sp

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "python"))
import browser

SCORES = "explorer.setScores(Array.from({length: 30}, (_, m) => Math.sin(i + m)))"
FIX = "explorer.fix(600, [0.01 * i, 0, 0])"
WORK = {
    "a shape from its scores": SCORES,
    "a picture (shape, normals, colours, texts, buffers)": f"{SCORES}; explorer.colours()",
    "the posterior of six landmarks": FIX,
    "the standard deviations that are left": "explorer.uncertainty()",
}
SECONDS = 5
PLAYED = """new Promise((go) => {
  let count = 0;
  const start = performance.now();
  const next = () => {
    if (performance.now() - start < 1000 * %d) return ++count, requestAnimationFrame(next);
    explorer.stop();
    go(count);
  };
  explorer.play();
  requestAnimationFrame(next);
})"""


def model():
    """31 bodies of random shape, of 1002 landmarks each."""
    chance = np.random.default_rng(7)
    ball = sp.make_phantom(phases=1, voxel_size=4.0)[0]
    made = sp.remesh([ball], [sp.parameterise_root(ball)], frequency=10)
    shapes = made.points[0] + chance.normal(size=(31, len(made.points[0]), 3))
    return sp.shape_model(shapes, made.faces, alignment="None")


def renderers(profile):
    """Processes of this browser that run pages."""
    for file in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            words = file.read_bytes().decode(errors="replace")
        except OSError:
            continue
        if "--type=renderer" in words and str(profile) in words:
            yield int(file.parent.name)


def spent(processes):
    """Milliseconds of CPU of their main threads."""
    files = (Path(f"/proc/{process}/task/{process}/schedstat") for process in processes)
    return sum(int(file.read_text().split()[0]) for file in files) / 1e6


def main():
    argparse.ArgumentParser(description=__doc__.splitlines()[0]).parse_args()
    if not browser.program():
        sys.exit("Chromium is not installed")
    with tempfile.TemporaryDirectory() as folder:
        page = sp.explore(model()).save(Path(folder) / "page.html")
        window = browser.Browser(folder)
        window.open(page)
        window.run(
            "for (let j = 0; j < 5; ++j) explorer.fix(150 * j, explorer.vertices()[150 * j])"
        )
        processes = list(renderers(folder))
        print("CPU ms  of")
        for name, work in WORK.items():
            loop = f"(() => {{ for (let i = 0; i < %d; ++i) {{ {work}; }} }})()"
            window.run(loop % 20)  # compiled
            before = spent(processes)
            window.run(loop % 100)
            print(f"{(spent(processes) - before) / 100:6.2f}  {name}", flush=True)
        window.drawn()  # what waits
        print(f"{window.run(PLAYED % SECONDS) / SECONDS:6.1f}  pictures a second, played here")
        window.close()


if __name__ == "__main__":
    main()
