# SPDX-License-Identifier: GPL-3.0-only
"""Pictures of shape models: modes (figure 3 of the paper), how good the model is,
scores and volumes."""

from __future__ import annotations

from typing import List, Optional, Sequence

import numpy as np

from .drawing import GREY, INK, RULE, Drawing, extent_of, points_wide
from .model import ShapeModel
from .pictures import PUBLISHED, ROBUST, Scene, soft_normals
from .plots import LABEL, MINUS, Plot, labels, panels, room, ticks
from .units import volume_unit
from .views import Row, upright

# ColorBrewer's RdBu from blue to red, as vcg_ext/display/displacement_colors.h has it.
DISPLACEMENT = (
    np.array(
        [
            (33, 102, 172),
            (67, 147, 195),
            (146, 197, 222),
            (209, 229, 240),
            (247, 247, 247),
            (253, 219, 199),
            (244, 165, 130),
            (214, 96, 77),
            (178, 24, 43),
        ]
    )
    / 255
)
MODE_COLORS = (ROBUST, PUBLISHED, "#6d4aad")
# Matplotlib's twilight_shifted and viridis, at equal steps.
ROUND = (
    "#301437 #4e186f #5e45a6 #6276ba #7ca2c2 #b3c6ce #e2d9e2 #d4bcac #c68962 #b25652 #8d2b50 "
    "#581647 #2f1436"
)
ONWARDS = (
    "#440154 #481f70 #443983 #3b528b #31688e #287c8e #21918c #20a486 #35b779 #5ec962 #90d743 "
    "#c8e020 #fde725"
)


def displacements(model: ShapeModel, shape: np.ndarray) -> np.ndarray:
    """How far each landmark lies from the mean's, along the mean's normal; outwards is positive."""
    corners = model.mean[model.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    sums = np.stack(
        [
            np.bincount(model.faces.ravel(), np.repeat(normals[:, k], 3), len(model.mean))
            for k in range(3)
        ],
        1,
    )
    return ((shape - model.mean) * sums).sum(1) / np.maximum(np.linalg.norm(sums, axis=1), 1e-300)


def displacement_colors(values: np.ndarray, reach: float) -> np.ndarray:
    """Red, green, blue in [0, 1]: red outwards, white 0, blue inwards, full at `reach`."""
    at = np.clip((np.asarray(values) / max(reach, 1e-300) + 1) / 2, 0, 1) * (len(DISPLACEMENT) - 1)
    return np.stack(
        [np.interp(at, np.arange(len(DISPLACEMENT)), DISPLACEMENT[:, k]) for k in range(3)], -1
    )


def modes(
    model: ShapeModel,
    path,
    *,
    title: str = "",
    unit: str = "mm",
    up: Optional[Sequence[float]] = None,
    shown: int = 3,
    deviations: float = 3.0,
) -> None:
    """Mean and both ends of the first modes, coloured by displacement from the mean (figure 3 of
    the paper)."""
    shown = min(shown, len(model.modes))
    shapes = {
        (m, sign): model.along(m, sign * deviations) if m >= 0 else model.mean
        for m in range(shown)
        for sign in (-1, 0, 1)
    }
    moved = {key: displacements(model, shape) for key, shape in shapes.items()}
    reach = max((np.abs(values).max() for values in moved.values()), default=0.0) or 1.0
    rotation = upright(model.mean, up)
    seen = np.concatenate([model.mean, *shapes.values()]) @ rotation.T
    center, extent = (seen.min(0) + seen.max(0)) / 2, 0.53 * (seen.max(0) - seen.min(0))[:2]
    cells, dpi = 3 * max(shown, 1), 100
    width = dpi * (1.25 * cells + 0.5)
    wide = (width - 0.2 * dpi) / max(shown, 1)  # a mode
    # Pixels of the page, so that none has to be interpolated.
    size = [max(2, int((shown - 0.04) * wide / (cells + (shown - 1) / 8)))]
    scale = size[0] / (2 * extent[0])
    size.append(max(2, round(2 * extent[1] * scale)))
    gap = size[0] // 8  # between modes
    across = shown * (3 * size[0] + gap) - gap
    scene = Scene(across, size[1])
    for k, (key, shape) in enumerate(shapes.items()):
        place = (k * size[0] + k // 3 * gap, 0, *size)
        panel = scene.panel(place, rotation, center, scale)
        colors = displacement_colors(moved[key], reach)
        panel.surface(shape, model.faces, colors, soft_normals(shape, model.faces))

    top, below = 100, 100 + size[1]
    page = Drawing(width, below + 120)
    page.text(25, 30, title or "Mean shape and modes", points_wide(17), bold=True)
    if shown:
        page.image(scene.parts([(0, 0, across, size[1])])[0], 10 + 0.02 * wide, top)
    for m in range(shown):
        left = 10 + m * wide
        share = 100 * model.eigenvalues[m] / model.total_variance
        words = f"mode {m + 1}: {share:.1f} % of the variance"
        page.text(left + wide / 2, 80, words, points_wide(13), across=0.5)
        for k, sign in enumerate((-1, 0, 1)):
            words = "mean" if sign == 0 else f"{MINUS if sign < 0 else '+'}{deviations:g} sd"
            middle = left + (0.02 + (k + 0.5) * 0.32) * wide
            page.text(middle, below + 15, words, points_wide(12), color=GREY, across=0.5)
    half = (0.17 if shown > 1 else 0.32) * width
    bar = displacement_colors(np.linspace(-reach, reach, round(2 * half)), reach)
    page.image(
        np.repeat(np.round(255 * bar[None]).astype(np.uint8), 16, 0), width / 2 - half, below + 52
    )
    for place, words in (
        (-half, f"{reach:.1f} {unit} inwards"),
        (0, "0"),
        (half, f"{reach:.1f} {unit} outwards"),
    ):
        page.text(width / 2 + place, below + 82, words, points_wide(11), color=GREY, across=0.5)
    page.save(path)


def measures(model: ShapeModel, path, *, unit: str = "mm") -> None:
    """Compactness, generalisation and specificity by number of modes, with their standard
    errors."""
    drawing, plots = panels(1360, 430, (1, 1, 1))
    count = np.arange(1, len(model.modes) + 1)
    drawn = (
        (
            "Compactness",
            "share of the variance, %",
            100 * model.figures["variance_share"],
            None,
            INK,
            "",
        ),
        (
            "Generalisation",
            f"distance of a shape left out, {unit}",
            model.generalisation,
            model.figures["generalisation_error"],
            ROBUST,
            "#d3e7e5",
        ),
        (
            "Specificity",
            f"distance of a random shape, {unit}",
            model.specificity,
            model.figures["specificity_error"],
            PUBLISHED,
            "#f4dbd0",
        ),
    )
    for plot, (title, label, values, error, color, light) in zip(plots, drawn):
        plot.x = (0.5, len(count) + 0.5)
        plot.y = (0, 105 if error is None else (1.15 * (values + error).max() or 1.0))
        if error is not None:
            plot.band(count, values - error, values + error, light)
        plot.curve(count, values, color, 3, dots=3.3)
        plot.finish(title, "modes", label, whole=True)
    drawing.save(path)


def scores(row: Row, model: ShapeModel, path, *, shown: int = 3) -> None:
    """Scores of the first modes in standard deviations. Of phases over time, with their path in
    the plane of the first two; of shapes by name, with their places in that plane."""
    shown = min(shown, len(model.modes))
    units = model.scores[:, :shown] / np.sqrt(model.eigenvalues[:shown])
    labels = [
        f"mode {m + 1} ({100 * model.eigenvalues[m] / model.total_variance:.1f} %)"
        for m in range(shown)
    ]
    (_scores_of_phases if row.timed else _scores_of_shapes)(row, units, labels, model.names, path)


def _scores_of_phases(row: Row, units, names_of_modes, names, path) -> None:
    closed, phases = row.result.order == "Cyclic time", np.asarray(row.numbers())
    plane = units.shape[1] > 1
    drawing, (over, *rest) = panels(1280 if plane else 760, 460, (1.45, 1)[: 1 + plane])
    over.x, over.y = (phases[0] - 0.5, phases[-1] + 0.5), room(units, 0.1, 0.32)
    over.rule(y=0)
    for m, label in enumerate(names_of_modes):
        over.curve(phases, units[:, m], MODE_COLORS[m % 3], 3, label, dots=3.3)
    over.finish("Scores over the phases", "phase", "standard deviations", whole=True)
    over.legend(over.left + 10, over.top + 8, 3)
    for plot in rest:
        plot.width -= 72
        plot.x, plot.y = room(units[:, 0], 0.12), room(units[:, 1], 0.12)
        way = np.r_[0 : len(phases), 0] if closed else np.arange(len(phases))
        plot.curve(units[way, 0], units[way, 1], RULE, 1.9)
        # A cycle's last phase is followed by the first: their colours are, too.
        last, scheme = phases[-1] + closed, (ROUND if closed else ONWARDS).split()
        share = (phases - phases[0]) / max(last - phases[0], 1)
        plot.dots(units[:, 0], units[:, 1], _between(scheme, share), 4.7, rim=1.1)
        plot.finish("Path through the first two modes", *PLANE, grid="both")
        _key_of_phases(plot, scheme, phases[0], last)
        step = max(1, len(phases) // 6)
        named = range(0, len(phases) - step // 2, step)
        _name_points(plot, units[:, :2], [str(phase) for phase in phases], named, 10)
    drawing.save(path)


def _between(scheme: Sequence[str], share) -> List[str]:
    """Colours at so large a share of the way through a scheme."""
    known = np.array([[int(color[k : k + 2], 16) for k in (1, 3, 5)] for color in scheme])
    at = np.asarray(share, float) * (len(scheme) - 1)
    found = [np.interp(at, np.arange(len(scheme)), known[:, k]) for k in range(3)]
    return ["#%02x%02x%02x" % tuple(map(round, color)) for color in zip(*found)]


def _key_of_phases(plot: Plot, scheme: Sequence[str], first: int, last: int) -> None:
    """The colours of phases, right of a plot."""
    page, left, height = plot.drawing, round(plot.left + plot.width + 12), round(plot.height)
    colors = _between(scheme, np.linspace(1, 0, height))
    strip = [[int(color[k : k + 2], 16) for k in (1, 3, 5)] for color in colors]
    page.image(np.repeat(np.array(strip, np.uint8)[:, None], 18, 1), left, plot.top)
    numbers = ticks(first, max(last, first + 1), 8, whole=True)
    for number, word in zip(numbers, labels(numbers)):
        down = plot.top + plot.height * (1 - (number - first) / max(last - first, 1))
        page.text(left + 24, down, word, points_wide(10), color=GREY)
    middle = plot.top + plot.height / 2
    page.text(left + 54, middle, "phase", points_wide(11), color=GREY, across=0.5, upwards=True)


PLANE = ("mode 1, standard deviations", "mode 2, standard deviations")
BY_NAME = 48  # so many shapes have room for their names


def _beside_names(names: Sequence[str]) -> float:
    """Pixels that they take left of a plot, more than numbers do."""
    widest = max(extent_of(name, points_wide(10))[0] for name in names)
    return max(0.0, widest + 14 - 60)


def _scores_of_shapes(row: Row, units, names_of_modes, names, path) -> None:
    plane, few = units.shape[1] > 1, len(names) <= BY_NAME
    height = max(460, 150 + 24 * len(names)) if few else 460
    beside = _beside_names(names) if few else 0
    drawing, (left, *rest) = panels((1280 if plane else 760) + beside, height + 35)
    full = drawing.width - beside
    plots = [left]
    left.height -= 35  # for the legend
    left.left += beside
    left.width = full / (1 + plane) - 128
    if plane:
        right = Plot(drawing, left.left + left.width + 128, left.top, left.width, left.height)
        plots.append(right)
    if few:
        place = np.arange(len(names))[::-1]
        left.x, left.y = room(units, 0.05), (-0.6, len(names) - 0.4)
        left.rule(x=0)
        for m, label in enumerate(names_of_modes):
            left.dots(units[:, m], place, MODE_COLORS[m % 3], 4.05, label)
        left.finish("Scores of the shapes", "standard deviations", names=list(names), grid="both")
    else:
        edges = np.linspace(units.min(), units.max(), 31)
        counts = [np.histogram(scores, edges)[0] for scores in units.T]
        left.x, left.y = room(units, 0.05), (0, 1.05 * max(map(max, counts)))
        for m, label in enumerate(names_of_modes):
            left.histogram(counts[m], edges, MODE_COLORS[m % 3], label=label)
        left.finish("Scores of the shapes", "standard deviations", "shapes")
    left.legend(left.left, drawing.height - 28, 3)
    for plot in plots[1:]:
        plot.x, plot.y = room(units[:, 0], 0.16), room(units[:, 1], 0.16)
        plot.dots(units[:, 0], units[:, 1], ROBUST, 4.4, rim=1.1)
        plot.finish("The shapes in the first two modes", *PLANE, grid="both")
        # Those that stand out come first; of many shapes they are the only ones.
        far = np.argsort(-np.hypot(units[:, 0], units[:, 1]))[: len(names) if few else 8]
        _name_points(plot, units[:, :2], names, far, 9)
    drawing.save(path)


def _name_points(plot: Plot, points: np.ndarray, names: Sequence[str], order, size: float) -> None:
    """Names beside points, the first of `order` first: right or left of its point, above or below,
    where a name overlaps no other and hides as few points as can be. One that has no such place
    inside the plot is left out."""
    size = points_wide(size)
    least = np.array([plot.left, plot.top])
    most = least + [plot.width, plot.height]
    at, taken = plot.at(*points.T), []
    for i in order:
        wide, high = extent_of(names[i], size)
        places = []
        for right, above in ((1, 1), (0, 1), (1, 0), (0, 0)):
            x = at[i, 0] + (8 if right else -8 - wide)
            y = at[i, 1] - (5 + high if above else -5)
            low, up = np.array([x, y]), np.array([x + wide, y + high])
            if (low < least).any() or (up > most).any():
                continue
            if any((low < other[1]).all() and (other[0] < up).all() for other in taken):
                continue
            hidden = ((at > low - 4) & (at < up + 4)).all(1)
            hidden[i] = False
            places.append((int(hidden.sum()), len(places), (low, up)))
        if places:
            taken.append(min(places, key=lambda place: place[:2])[2])
            low, up = taken[-1]
            plot.drawing.text(low[0], (low[1] + up[1]) / 2, names[i], size)


def volumes(row: Row, path, truth: Optional[np.ndarray] = None) -> None:
    """What the surfaces enclose: phase by phase, or shape by shape. truth: the same of the thing
    itself, where it is known."""
    per_unit, unit = volume_unit(row.result.unit)
    values = np.abs([surface.volume for surface in row.result.surfaces]) / per_unit
    if row.timed:
        _volumes_of_phases(
            row, values, unit, None if truth is None else abs(truth) / per_unit, path
        )
    else:
        _volumes_of_shapes(row, values, unit, path)


def _volumes_of_phases(row: Row, values, unit: str, truth, path) -> None:
    drawing, (plot,) = panels(860, 430)
    phases = row.numbers()
    plot.x, plot.y = (phases[0] - 0.5, phases[-1] + 0.5), (0, 1.2 * values.max() or 1.0)
    plot.curve(phases, values, ROBUST, 3.3, "" if truth is None else row.title, dots=3.3)
    if truth is not None:
        plot.curve(phases, truth, GREY, 2.5, "the phantom itself", dashes=(10, 7))
    title = "Volume over the phases"
    if row.result.order == "Cyclic time" and values.max() > 0:
        title += f": {100 * (1 - values.min() / values.max()):.0f} % ejected"
    plot.finish(title, "phase", f"volume, {unit}", whole=True)
    plot.legend(plot.left + 10, plot.top + plot.height - 25 * len(plot.key) - 6)
    others = values if truth is None else truth
    highest, lowest = int(values.argmax()), int(values.argmin())
    for phase, value, down in (
        (highest, max(values[highest], others[highest]), -20),
        (lowest, min(values[lowest], others[lowest]), 20),
    ):
        leftwards = 2 * phase > len(phases)  # so that it stays within the picture
        x, y = plot.at(phases[phase], value)
        words = f"{values[phase]:.4g} {unit}"
        across = 1.0 if leftwards else 0.0
        drawing.text(x + (-11 if leftwards else 11), y + down, words, LABEL, across=across)
    drawing.save(path)


def _volumes_of_shapes(row: Row, values, unit: str, path) -> None:
    names = [surface.name for surface in row.result.surfaces]
    few = len(names) <= BY_NAME
    beside = _beside_names(names) if few else 0
    drawing, (plot,) = panels(860 + beside, max(300, 140 + 24 * len(names)) if few else 430)
    plot.left, plot.width = plot.left + beside, plot.width - beside
    if few:
        plot.x, plot.y = (0, 1.05 * values.max() or 1.0), (-0.6, len(names) - 0.4)
        plot.bars(values, 0.62, ROBUST)
        plot.finish("Volume of the shapes", f"volume, {unit}", names=names, grid="both")
    else:
        counts, edges = np.histogram(values, 30)
        plot.x, plot.y = room(values, 0.05), (0, 1.05 * counts.max())
        plot.histogram(counts, edges, ROBUST, filled=True)
        plot.finish("Volume of the shapes", f"volume, {unit}", "shapes", grid="both")
    drawing.save(path)
