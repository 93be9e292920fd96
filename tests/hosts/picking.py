# SPDX-License-Identifier: GPL-3.0-only
"""Points picked by real clicks in MeshLab's Pick Points, of 2020.09 and 2025.07. Needs xdotool;
real clicks have to wait for a window that says nothing, so no test of scripts/test has them."""

import os
import subprocess
import time
from pathlib import Path

from gui import GuiError, until

CLICKS = ((0.45, 0.5), (0.4, 0.55), (0.5, 0.4))  # across and down, in shares of the view


class Pointer:
    """The pointer on the display of a MeshLab."""

    def __init__(self, gui):
        entries = Path(f"/proc/{gui.process.pid}/environ").read_text().split("\0")
        environment = dict(entry.split("=", 1) for entry in entries if "=" in entry)
        self._display = dict(os.environ, DISPLAY=environment["DISPLAY"])

    def _do(self, *words):
        subprocess.run(["xdotool", *map(str, words)], env=self._display, check=True)

    def click(self, x, y, button):
        # A move before, or Qt does not know where the pointer is; one behind draws anew.
        self._do("mousemove", x, y, "sleep", 0.3, "mousemove", x + 1, y, "sleep", 0.3)
        self._do("mousedown", button, "sleep", 0.4, "mouseup", button, "sleep", 1)
        self._do("mousemove", x + 30, y + 30, "sleep", 0.3)


def pick(gui, file, picture="picked", clicks=CLICKS):
    """Picks points on the current layer by clicks into the view, and saves them. Returns whether
    Pick Points took any: it asks for no file where it has none."""
    gui.trigger("PickPoints")
    until(lambda: any(w["class"] == "PickPointsDialog" for w in gui.widgets()), "its dialog")
    x, y, width, height = next(w["place"] for w in gui.widgets() if w["class"] == "GLArea")
    pointer = Pointer(gui)
    time.sleep(3)
    for across, down in clicks:
        pointer.click(int(x + across * width), int(y + down * height), 3)
        time.sleep(1)
    gui.picture(picture)
    left, top, width, height = next(
        w["place"] for w in gui.widgets() if w["text"] == "Save" and w["window"] == "Form"
    )
    pointer.click(left + width // 2, top + height // 2, 1)

    def named():
        try:
            gui.ask("choose file", file=str(file))
        except GuiError:
            return False
        return True

    try:
        until(named, "the file dialog", patience=10)
    except GuiError:
        return False
    until(lambda: file.exists() and "</PickedPoints>" in file.read_text(), "the file")
    return True
