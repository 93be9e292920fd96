# SPDX-License-Identifier: GPL-3.0-only
"""Pages of text, lines and images, in pixels from the upper left corner: as PNG by Pillow, which is
there in a few milliseconds, and as SVG and PDF by Matplotlib, which takes half a second to load.
"""

from __future__ import annotations

import os
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path
from typing import List, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np

INK, GREY, RULE, GRID = "#1c2530", "#5b6570", "#9ca3af", "#e5e7eb"
FINER = 4  # lines are drawn so many times as large, and reduced
DPI = 100  # of all pages: what a point is, of which fonts have so many


class Text(NamedTuple):
    x: float
    y: float
    words: str
    size: float  # pixels
    color: str
    bold: bool
    across: float  # 0: begins at x, 0.5: is centred there, 1: ends there
    upwards: bool  # read from below


class Line(NamedTuple):
    points: np.ndarray
    color: str
    width: float
    dashes: Optional[Tuple[float, float]] = None


class Area(NamedTuple):
    points: np.ndarray  # its corners
    color: str


class Dots(NamedTuple):
    points: np.ndarray
    radius: float
    colors: Sequence[str]
    rim: float  # of white, so wide


class Picture(NamedTuple):
    pixels: np.ndarray
    left: int
    top: int


class Drawing:
    """A white page of so many pixels. What is drawn later lies above."""

    def __init__(self, width: float, height: float):
        self.width, self.height = round(width), round(height)
        self.parts: List[Union[Text, Line, Area, Dots, Picture]] = []

    def text(
        self,
        x: float,
        y: float,
        words: str,
        size: float,
        *,
        color: str = INK,
        bold: bool = False,
        across: float = 0.0,
        upwards: bool = False,
    ) -> None:
        """One line, centred on y; upwards: centred on x, and `across` means y."""
        self.parts.append(Text(x, y, _one_line(words), size, color, bold, across, upwards))

    def line(self, points, color: str, width: float, dashes=None) -> None:
        self.parts.append(Line(np.asarray(points, float), color, width, dashes))

    def area(self, points, color: str) -> None:
        self.parts.append(Area(np.asarray(points, float), color))

    def dots(self, points, radius: float, colors, rim: float = 0.0) -> None:
        """colors: one for all, or one for each."""
        points = np.asarray(points, float).reshape(-1, 2)
        each = [colors] * len(points) if isinstance(colors, str) else list(colors)
        self.parts.append(Dots(points, radius, each, rim))

    def image(self, pixels: np.ndarray, left: float, top: float) -> None:
        """Bytes (height, width, 3)."""
        self.parts.append(Picture(pixels, round(left), round(top)))

    @property
    def words(self) -> List[str]:
        """All texts."""
        return [part.words for part in self.parts if isinstance(part, Text)]

    def save(self, paths) -> None:
        """To a file, or to several; the endings choose the formats (png, svg, pdf)."""
        for path in [paths] if isinstance(paths, (str, os.PathLike)) else paths:
            (_Raster if str(path).endswith(".png") else _Vector)(self).write(path)


def points_wide(size: float) -> float:
    """Pixels of a font of so many points."""
    return size * DPI / 72


@lru_cache(maxsize=64)
def _font(size: float, bold: bool):
    from PIL import ImageFont

    return ImageFont.truetype(_font_file(bold), size)


@lru_cache(maxsize=2)
def _font_file(bold: bool) -> str:
    """DejaVu Sans, as Matplotlib brings it along: found without loading that, where it lies as it
    is installed."""
    name = f"DejaVuSans{'-Bold' if bold else ''}.ttf"
    for folder in find_spec("matplotlib").submodule_search_locations:
        path = Path(folder) / "mpl-data/fonts/ttf" / name
        if path.exists():
            return str(path)
    from matplotlib.font_manager import findfont

    return findfont(f"DejaVu Sans:weight={'bold' if bold else 'normal'}")


def extent_of(words: str, size: float, bold: bool = False) -> Tuple[float, float]:
    """How wide a text is, and how high its font."""
    return _font(size, bold).getlength(_one_line(words)), size


def _one_line(words: str) -> str:
    """Names of files can have line breaks, which Pillow refuses to measure."""
    return " ".join(words.splitlines())


@lru_cache(maxsize=256)
def _disc(x: float, y: float, radius: float):
    """A mask of one, so far from its corner: dots of a plot are alike."""
    from PIL import Image, ImageDraw

    side = int(np.ceil(2 * radius)) + 2
    mask, r = Image.new("L", (FINER * side, FINER * side)), FINER * radius
    x, y = FINER * x, FINER * y
    ImageDraw.Draw(mask).ellipse((x - r, y - r, x + r, y + r), fill=255)
    return mask.reduce(FINER)


class _Raster:
    def __init__(self, drawing: Drawing):
        from PIL import Image

        self._page = Image.new("RGB", (drawing.width, drawing.height), "white")
        for part in drawing.parts:
            getattr(self, type(part).__name__.lower())(part)

    def write(self, path) -> None:
        # Quick compression: files a fifth larger, written in half the time.
        self._page.save(path, "PNG", compress_level=1, dpi=(DPI, DPI))

    def text(self, text: Text) -> None:
        from PIL import Image, ImageDraw

        font = _font(text.size, text.bold)
        if not text.upwards:
            anchor = {0.0: "l", 0.5: "m", 1.0: "r"}[text.across] + "m"
            ImageDraw.Draw(self._page).text(
                (text.x, text.y), text.words, text.color, font, anchor=anchor
            )
            return
        long, high = int(font.getlength(text.words)) + 2, int(1.5 * text.size)
        mask = Image.new("L", (long, high))
        ImageDraw.Draw(mask).text((1, high / 2), text.words, 255, font, anchor="lm")
        mask = mask.transpose(Image.Transpose.ROTATE_90)
        corner = (round(text.x - high / 2), round(text.y - (1 - text.across) * long))
        self._page.paste(text.color, corner, mask)

    def line(self, line: Line) -> None:
        width = max(1, round(line.width * FINER))

        def draw(pen, at):
            for piece in _dashed(line.points, line.dashes):
                way = at(piece)
                pen.line(way, fill=255, width=width, joint="curve")
                if not line.dashes and len(way) > 2:  # round ends
                    for x, y in (way[0], way[-1]):
                        r = width / 2
                        pen.ellipse((x - r, y - r, x + r, y + r), fill=255)

        self._smooth(line.points, line.width, line.color, draw)

    def area(self, area: Area) -> None:
        self._smooth(
            area.points, 1, area.color, lambda pen, at: pen.polygon(at(area.points), fill=255)
        )

    def dots(self, dots: Dots) -> None:
        for point, color in zip(dots.points, dots.colors):
            for radius, ink in ((dots.radius + dots.rim, "white"), (dots.radius, color)):
                if ink != "white" or dots.rim > 0:
                    self._dot(point, radius, ink)

    def _dot(self, point, radius: float, color: str) -> None:
        corner = np.floor(point - radius)
        inside = np.round(FINER * (point - corner)) / FINER
        self._page.paste(color, tuple(map(int, corner)), _disc(*map(float, inside), radius))

    def picture(self, picture: Picture) -> None:
        from PIL import Image

        pixels = np.ascontiguousarray(picture.pixels)
        self._page.paste(Image.fromarray(pixels), (picture.left, picture.top))

    def _smooth(self, points, width: float, color: str, draw) -> None:
        """Through a mask of what `draw` draws, so large and reduced."""
        from PIL import Image, ImageDraw

        low = np.floor(points.min(0) - width / 2 - 2).astype(int)
        high = np.ceil(points.max(0) + width / 2 + 2).astype(int)
        mask = Image.new("L", tuple(int(length) for length in FINER * (high - low)))
        draw(ImageDraw.Draw(mask), lambda way: list(map(tuple, FINER * (way - low))))
        self._page.paste(color, tuple(map(int, low)), mask.reduce(FINER))


def _dashed(points: np.ndarray, dashes) -> List[np.ndarray]:
    """The pieces of a line; dashes: so long, and so long between."""
    if dashes is None:
        return [points]
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    along = np.r_[0, np.cumsum(steps)]

    def place(at):
        return np.array([np.interp(at, along, points[:, k]) for k in range(2)]).T

    pieces = []
    for start in np.arange(0, along[-1], sum(dashes)):
        end = min(start + dashes[0], along[-1])
        inner = along[(along > start) & (along < end)]
        pieces.append(place(np.r_[start, inner, end]))
    return pieces


class _Vector:
    """The same by Matplotlib, where text stays text and lines stay lines."""

    def __init__(self, drawing: Drawing):
        from matplotlib.figure import Figure
        from matplotlib.transforms import Affine2D

        self._figure = Figure(
            figsize=(drawing.width / DPI, drawing.height / DPI), dpi=DPI, facecolor="white"
        )
        self._size = np.array([drawing.width, drawing.height])
        self._pixels = (
            Affine2D().scale(1 / drawing.width, -1 / drawing.height).translate(0, 1)
            + self._figure.transFigure
        )
        for part in drawing.parts:
            getattr(self, type(part).__name__.lower())(part)
        for order, artist in enumerate(self._figure.get_children()):
            artist.set_zorder(order)  # above what was drawn before, of whatever kind

    def write(self, path) -> None:
        self._figure.savefig(path, facecolor="white")

    def text(self, text: Text) -> None:
        self._figure.text(
            text.x,
            text.y,
            text.words,
            transform=self._pixels,
            fontsize=text.size * 72 / DPI,
            color=text.color,
            weight="bold" if text.bold else "normal",
            parse_math=False,
            **(
                {
                    "rotation": 90,
                    "ha": "center",
                    "va": {0.0: "bottom", 0.5: "center", 1.0: "top"}[text.across],
                }
                if text.upwards
                else {
                    "ha": {0.0: "left", 0.5: "center", 1.0: "right"}[text.across],
                    "va": "center",
                }
            ),
        )

    def line(self, line: Line) -> None:
        from matplotlib.lines import Line2D

        width = line.width * 72 / DPI
        dashes = tuple(length / line.width for length in line.dashes) if line.dashes else None
        self._figure.add_artist(
            Line2D(
                *line.points.T,
                transform=self._pixels,
                color=line.color,
                linewidth=width,
                linestyle=(0, dashes) if dashes else "-",
                solid_capstyle="round",
                dash_capstyle="butt",
            )
        )

    def area(self, area: Area) -> None:
        from matplotlib.patches import Polygon

        self._figure.add_artist(
            Polygon(area.points, transform=self._pixels, facecolor=area.color, edgecolor="none")
        )

    def dots(self, dots: Dots) -> None:
        from matplotlib.patches import Circle

        for point, color in zip(dots.points, dots.colors):
            self._figure.add_artist(
                Circle(
                    point,
                    dots.radius + dots.rim / 2,
                    transform=self._pixels,
                    facecolor=color,
                    edgecolor="white" if dots.rim else "none",
                    linewidth=dots.rim * 72 / DPI,
                )
            )

    def picture(self, picture: Picture) -> None:
        from matplotlib.image import BboxImage
        from matplotlib.transforms import Bbox, TransformedBbox

        height, width = picture.pixels.shape[:2]
        left, below = picture.left, picture.top + height
        place = Bbox.from_bounds(
            left / self._size[0],
            1 - below / self._size[1],
            width / self._size[0],
            height / self._size[1],
        )
        shown = BboxImage(
            TransformedBbox(place, self._figure.transFigure), interpolation="none", origin="upper"
        )
        shown.set_data(picture.pixels)
        self._figure.add_artist(shown)
