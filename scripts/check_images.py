#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-only
"""Are the pictures of docs/images as old as what draws them? scripts/check_images.py [--record |
--gui]

docs/images/drawn_by.sha256 says of each picture what its sources were when it was drawn: one digest
over all of them. --record writes it down, for the pictures that are named, or for those of the GUI
with --gui; scripts/make-images does so. Without it pictures whose sources have changed since are
named, with 1 as the exit code; those of MeshLab's GUI only with --gui, since it takes MeshLab to
make them.
"""

import hashlib
import sys
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[1]
IMAGES = PROJECT / "docs/images"
LIST = IMAGES / "drawn_by.sha256"

PACKAGE = "python/sphere_propagation/"
MAPS = tuple(f"{PACKAGE}{name}.py" for name in ("pictures", "drawing", "plots", "views", "colors"))
MODELS = (PACKAGE + "model_pictures.py", *MAPS)
PHANTOM = (PACKAGE + "phantom.py",)
HEART = ("scripts/draw-modes",)
EXPLORER = tuple(
    f"{PACKAGE}explorer{end}"
    for end in (".py", "_page/page.html", "_page/style.css", "_page/page.js", "_page/renderer.js")
)
GUI = ("tests/hosts/check_gui.py", "sample_projects/ventricle/ventricle.mlp", "docs/filters.md")


def sources(picture: str):
    """What draws it; of the GUI's pictures also what the dialogs show."""
    if picture == "gui_pick_points":
        return ("tests/hosts/picking.py", "sample_projects/ventricle/ventricle.mlp")
    if picture.startswith("gui_"):
        return GUI
    if picture == "levels":
        return ("scripts/draw-levels",)
    if picture.startswith("heart_"):
        return (*HEART, *MAPS)
    if picture == "fitting":
        return ("scripts/draw-fitting", *MAPS)
    if picture == "anchors":
        return ("scripts/draw-anchors", *MAPS)
    if picture == "groupwise":
        return ("scripts/draw-groupwise", *MAPS)
    if picture == "calibration":
        return ("benchmarks/fitting.py",)
    if picture == "uncertainty":
        return ("benchmarks/propagation.py", "benchmarks/made_motions.py")
    if picture == "explore":
        return ("scripts/draw-explorer", *EXPLORER)
    if picture in ("modes", "model"):
        return (*HEART, *MODELS)
    if picture in ("scan_modes", "scan_scores", "scan_volume"):
        return (*PHANTOM, *MODELS)
    return (*PHANTOM, *MAPS)


def digest_of(picture: str) -> str:
    found = hashlib.sha256()
    for source in sources(picture):
        found.update(source.encode() + b"\0" + (PROJECT / source).read_bytes() + b"\0")
    return found.hexdigest()


def recorded():
    lines = LIST.read_text().splitlines() if LIST.is_file() else []
    return {name: digest for digest, name in (line.split("  ", 1) for line in lines)}


def main(arguments) -> int:
    gui = "--gui" in arguments
    there = sorted(path.stem for path in IMAGES.glob("*.png"))
    known = recorded()
    if "--record" in arguments:
        names = [word for word in arguments if not word.startswith("--")]
        for name in names or [name for name in there if name.startswith("gui_") == gui]:
            known[name] = digest_of(name)
        LIST.write_text("".join(f"{known[name]}  {name}\n" for name in there if name in known))
        return 0
    old = [
        name
        for name in there
        if known.get(name) != digest_of(name) and (gui or not name.startswith("gui_"))
    ]
    for name in old:
        print(f"docs/images/{name}.png is older than what draws it: {', '.join(sources(name))}")
    if old:
        by_gui = " --gui" if any(name.startswith("gui_") for name in old) else ""
        print(f"Make it again: scripts/make-images{by_gui}")
    return int(bool(old))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
