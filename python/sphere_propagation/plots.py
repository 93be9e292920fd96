# SPDX-License-Identifier: GPL-3.0-only
"""Curves, dots and bars in a frame with ticks, on a page of drawing.py."""

from __future__ import annotations

from typing import Callable, List, Optional, Sequence, Tuple

import numpy as np

from .drawing import GREY, GRID, RULE, Drawing, extent_of, points_wide

TITLE, LABEL, TICK, LEGEND = (points_wide(size) for size in (13, 11, 10, 10.5))
MINUS = "\N{MINUS SIGN}"
# Pixels around a frame with labels and numbers of five digits.
LEFT, RIGHT, BELOW, ABOVE = 110, 22, 62, 46


def panels(width: float, height: float, widths: Sequence[float] = (1,)):
    """A page, and frames side by side in it, with so wide parts of it each."""
    drawing, plots, start = Drawing(width, height), [], 0.0
    for part in widths:
        share = width * part / sum(widths)
        frame = (start + LEFT, ABOVE, share - LEFT - RIGHT, height - ABOVE - BELOW)
        plots.append(Plot(drawing, *frame))
        start += share
    return drawing, plots


class Plot:
    """One frame. First its limits, then what lies in it, which `finish` draws above the grid.

    x, y: the limits, from and to.
    """

    def __init__(self, drawing: Drawing, left: float, top: float, width: float, height: float):
        self.drawing = drawing
        self.left, self.top, self.width, self.height = left, top, width, height
        self.x, self.y = (0.0, 1.0), (0.0, 1.0)
        self.key: List[Tuple[str, str, float]] = []  # what is what: words, colour, dashed or dots
        self._later: List[Callable[[], None]] = []

    def at(self, x, y) -> np.ndarray:
        """Pixels of the page."""
        (x0, x1), (y0, y1) = self.x, self.y
        right = self.left + self.width * (np.asarray(x, float) - x0) / (x1 - x0)
        down = self.top + self.height * (y1 - np.asarray(y, float)) / (y1 - y0)
        return np.stack(np.broadcast_arrays(right, down), -1)

    def curve(
        self, x, y, color: str, width: float, label: str = "", *, dots: float = 0, dashes=None
    ) -> None:
        """Through points, which are dots where these have a radius."""

        def draw():
            self.drawing.line(self.at(x, y), color, width, dashes)
            if dots:
                self.drawing.dots(self.at(x, y), dots, color)

        self._later.append(draw)
        self._name(label, color, dots if not dashes else -1)

    def band(self, x, low, high, color: str) -> None:
        """Between two curves."""
        self._later.append(
            lambda: self.drawing.area(
                np.concatenate([self.at(x, high), self.at(x, low)[::-1]]), color
            )
        )

    def dots(self, x, y, colors, radius: float, label: str = "", rim: float = 0.0) -> None:
        self._later.append(lambda: self.drawing.dots(self.at(x, y), radius, colors, rim))
        self._name(label, colors, radius)

    def bars(self, values, thickness: float, color: str) -> None:
        """From the left, at heights n - 1 to 0."""

        def draw():
            for k, value in zip(range(len(values) - 1, -1, -1), values):
                low, high = k - thickness / 2, k + thickness / 2
                corners = self.at([0, value, value, 0], [low, low, high, high])
                self.drawing.area(corners, color)

        self._later.append(draw)

    def histogram(
        self, counts, edges, color: str, *, filled: bool = False, label: str = ""
    ) -> None:
        x, y = np.repeat(edges, 2), np.r_[0, np.repeat(counts, 2), 0]
        if filled:
            self._later.append(lambda: self.drawing.area(self.at(x, y), color))
        else:
            self._later.append(lambda: self.drawing.line(self.at(x, y), color, 2.8))
        self._name(label, color, 0)

    def rule(self, *, x: Optional[float] = None, y: Optional[float] = None) -> None:
        """All across."""
        self._later.append(
            lambda: self.drawing.line(
                self.at(self.x, [y, y]) if x is None else self.at([x, x], self.y), RULE, 1.1
            )
        )

    def _name(self, label: str, color: str, dots: float) -> None:
        if label:
            self.key.append((label, color, dots))

    def finish(
        self,
        title: str,
        x: str = "",
        y: str = "",
        *,
        whole: bool = False,
        names: Optional[Sequence[str]] = None,
        grid: str = "y",
        highest: float = np.inf,
    ) -> None:
        """Draws it. whole: x has whole numbers; names: beside the heights n - 1 to 0, instead of
        numbers; grid: y or both; highest: above that y has no number."""
        page, right, below = self.drawing, self.left + self.width, self.top + self.height
        across = ticks(*self.x, max(2, int(self.width / 55)), whole)
        if names is None:
            up = [tick for tick in ticks(*self.y, max(2, int(self.height / 34))) if tick <= highest]
            words = labels(up)
        else:
            up, words = list(range(len(names) - 1, -1, -1)), list(names)
        for tick in up:
            page.line(self.at(self.x, [tick, tick]), GRID, 1)
        for tick in across if grid == "both" else ():
            page.line(self.at([tick, tick], self.y), GRID, 1)
        page.line([(self.left, below), (right, below)], RULE, 1)
        for draw in self._later:
            draw()
        for tick, word in zip(up, words):
            page.text(self.left - 6, self.at(0, tick)[1], word, TICK, color=GREY, across=1.0)
        for tick, word in zip(across, labels(across)):
            page.text(self.at(tick, 0)[0], below + 14, word, TICK, color=GREY, across=0.5)
        page.text(self.left, self.top - 16, title, TITLE, bold=True)
        page.text(self.left + self.width / 2, below + 36, x, LABEL, color=GREY, across=0.5)
        if y:
            beside = max((extent_of(word, TICK)[0] for word in words), default=0)
            center = self.left - 6 - beside - 8 - LABEL / 2
            for k, line in enumerate(reversed(y.split("\n"))):
                where = (center - 1.3 * k * LABEL, self.top + self.height / 2)
                page.text(*where, line, LABEL, color=GREY, across=0.5, upwards=True)

    def legend(self, left: float, top: float, columns: int = 1) -> None:
        """The names, in reading order, from there on."""
        wide = max((extent_of(label, LEGEND)[0] for label, _, _ in self.key), default=0) + 62
        for k, (label, color, dots) in enumerate(self.key):
            x, y = left + k % columns * wide, top + k // columns * 1.5 * LEGEND + LEGEND / 2
            if dots < 0:
                self.drawing.line([(x, y), (x + 29, y)], color, 2.5, (10, 7))
            elif dots < 4:
                self.drawing.line([(x, y), (x + 29, y)], color, 3)
            if dots > 0:
                self.drawing.dots([(x + 14.5, y)], dots, color)
            self.drawing.text(x + 40, y, label, LEGEND)


def room(values, share: float, above: Optional[float] = None) -> Tuple[float, float]:
    """Limits with so large a share of the extent beside it."""
    low, high = float(np.min(values)), float(np.max(values))
    extent = (high - low) or max(abs(high), 1.0)
    return low - share * extent, high + (share if above is None else above) * extent


def ticks(low: float, high: float, most: int, whole: bool = False) -> List[float]:
    """Round numbers from low to high, not more than `most`."""
    raw = (high - low) / most
    power = 10.0 ** np.floor(np.log10(raw))
    step = power * next(f for f in (1, 2, 2.5, 5, 10) if f * power >= raw * (1 - 1e-9))
    if whole:
        step = max(1.0, np.ceil(step))
    first, last = np.ceil(low / step - 1e-9), np.floor(high / step + 1e-9)
    return [float(k * step) for k in np.arange(first, last + 1)]


def labels(numbers: Sequence[float]) -> List[str]:
    """With as many digits as tell them apart."""
    step = min(np.diff(numbers), default=1.0)
    steps = ((n, step * 10**n) for n in range(12))
    digits = next((n for n, scaled in steps if abs(scaled - round(scaled)) < 1e-6 * scaled), 12)
    return [f"{number + 0.0:.{digits}f}".replace("-", MINUS) for number in numbers]
