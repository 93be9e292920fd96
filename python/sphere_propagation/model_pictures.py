# SPDX-License-Identifier: GPL-3.0-only
"""Pictures of shape models: modes (figure 3 of the paper), how good the model is,
scores and volumes."""

from __future__ import annotations

from typing import Optional, Sequence

import numpy as np

from .model import ShapeModel
from .pictures import (
    GREY,
    INK,
    PUBLISHED,
    ROBUST,
    Scene,
    add_image,
    new_figure,
    panel_title,
    panels,
    quiet_axes,
    save,
    soft_normals,
)
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
MINUS = "\N{MINUS SIGN}"


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
    cells = 3 * max(shown, 1)
    width, dpi = 1.5 * cells + 0.5, 100
    wide = (width - 0.2) / max(shown, 1) / width  # a mode
    # Pixels of the page, so that none has to be interpolated.
    size = [max(2, int((shown - 0.04) * wide * width * dpi / (cells + (shown - 1) / 8)))]
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

    picture = size[1] / dpi
    top, bottom = 1.0, 1.2
    height = picture + top + bottom
    figure = new_figure(width, height, dpi)
    figure.text(
        0.25 / width,
        1 - 0.3 / height,
        title or "Mean shape and modes",
        fontsize=17,
        color=INK,
        weight="bold",
        va="center",
    )
    if shown:
        left = 0.1 / width + 0.02 * wide
        place = (left, bottom / height, across / dpi / width, picture / height)
        add_image(figure, scene.parts([(0, 0, across, size[1])])[0], place)
    for m in range(shown):
        left = 0.1 / width + m * wide
        share = model.eigenvalues[m] / model.total_variance
        figure.text(
            left + wide / 2,
            1 - 0.8 / height,
            f"mode {m + 1}: {100 * share:.1f} % of the variance",
            fontsize=13,
            color=INK,
            ha="center",
            va="center",
        )
        for k, sign in enumerate((-1, 0, 1)):
            words = "mean" if sign == 0 else f"{MINUS if sign < 0 else '+'}{deviations:g} sd"
            figure.text(
                left + 0.02 * wide + (k + 0.5) * 0.32 * wide,
                (bottom - 0.15) / height,
                words,
                fontsize=12,
                color=GREY,
                ha="center",
                va="center",
            )
    bar = figure.add_axes([0.33, 0.52 / height, 0.34, 0.16 / height])
    bar.imshow(
        displacement_colors(np.linspace(-reach, reach, 512), reach)[None],
        aspect="auto",
        extent=[-reach, reach, 0, 1],
    )
    bar.set_yticks([])
    bar.set_xticks(
        [-reach, 0, reach],
        [f"{reach:.1f} {unit} inwards", "0", f"{reach:.1f} {unit} outwards"],
        fontsize=11,
        color=GREY,
    )
    bar.tick_params(length=0)
    for spine in bar.spines.values():
        spine.set_visible(False)
    save(figure, path)


def measures(model: ShapeModel, path, *, unit: str = "mm") -> None:
    """Compactness, generalisation and specificity by number of modes, with their standard
    errors."""
    figure, axes = panels(13.6, 4.3, (1, 1, 1))
    count = np.arange(1, len(model.modes) + 1)
    drawn = (
        (
            "Compactness",
            "share of the variance, %",
            100 * model.figures["variance_share"],
            None,
            INK,
        ),
        (
            "Generalisation",
            f"distance of a shape left out, {unit}",
            model.generalisation,
            model.figures["generalisation_error"],
            ROBUST,
        ),
        (
            "Specificity",
            f"distance of a random shape, {unit}",
            model.specificity,
            model.figures["specificity_error"],
            PUBLISHED,
        ),
    )
    for axis, (title, label, values, error, color) in zip(axes, drawn):
        if error is not None:
            axis.fill_between(count, values - error, values + error, color=color, alpha=0.18, lw=0)
        axis.plot(count, values, color=color, lw=2.2, marker="o", ms=4)
        _titles(axis, title, "modes", label)
        axis.set_xlim(0.5, len(count) + 0.5)
        axis.set_ylim(0, 105 if error is None else 1.15 * (values + error).max())
        axis.xaxis.get_major_locator().set_params(integer=True)
        quiet_axes(axis)
    save(figure, path)


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


def _scores_of_phases(row: Row, units, labels, names, path) -> None:
    closed, phases = row.result.order == "Cyclic time", np.asarray(row.numbers())
    plane = units.shape[1] > 1
    figure, (over, *rest) = panels(12.8 if plane else 7.6, 4.6, (1.45, 1)[: 1 + plane])
    for m, label in enumerate(labels):
        color = MODE_COLORS[m % 3]
        over.plot(phases, units[:, m], color=color, lw=2.2, marker="o", ms=4, label=label)
    over.axhline(0, color="#9ca3af", lw=0.8)
    _titles(over, "Scores over the phases", "phase", "standard deviations")
    over.set_xlim(phases[0] - 0.5, phases[-1] + 0.5)
    low, high = units.min(), units.max()
    over.set_ylim(low - 0.1 * (high - low), high + 0.32 * (high - low))
    over.xaxis.get_major_locator().set_params(integer=True)
    over.legend(fontsize=10.5, loc="upper left", ncol=3, labelcolor=INK, frameon=False)
    quiet_axes(over)
    for axis in rest:
        way = np.r_[0 : len(phases), 0] if closed else np.arange(len(phases))
        axis.plot(units[way, 0], units[way, 1], color="#9ca3af", lw=1.4, zorder=1)
        dots = axis.scatter(
            units[:, 0],
            units[:, 1],
            c=phases,
            cmap="twilight_shifted" if closed else "viridis",
            # A cycle's last phase is followed by the first: their colours are, too.
            vmin=phases[0],
            vmax=phases[-1] + closed,
            s=46,
            zorder=2,
            edgecolors="white",
            linewidths=0.8,
        )
        _titles(axis, "Path through the first two modes", *PLANE)
        axis.margins(0.12)
        quiet_axes(axis, both=True)
        inch = 1 / figure.get_figwidth()
        left, below, across, up = axis.get_position().bounds
        axis.set_position([left, below, across - 0.72 * inch, up])
        bar = figure.add_axes([left + across - 0.6 * inch, below, 0.18 * inch, up])
        key = figure.colorbar(dots, cax=bar)
        key.set_label("phase", fontsize=11, color=GREY)
        key.ax.yaxis.get_major_locator().set_params(integer=True)
        key.ax.tick_params(colors=GREY, length=0)
        key.outline.set_visible(False)
    for axis in rest:
        step = max(1, len(phases) // 6)
        named = range(0, len(phases) - step // 2, step)
        _name_points(axis, units[:, :2], [str(phase) for phase in phases], named, 10)
    save(figure, path)


PLANE = ("mode 1, standard deviations", "mode 2, standard deviations")
BY_NAME = 48  # so many shapes have room for their names


def _scores_of_shapes(row: Row, units, labels, names, path) -> None:
    plane, few = units.shape[1] > 1, len(names) <= BY_NAME
    height = max(4.6, 1.5 + 0.24 * len(names)) if few else 4.6
    figure = new_figure(12.8 if plane else 7.6, height)
    axes = figure.subplots(1, 1 + plane, squeeze=False)
    left, *rest = axes[0]
    if few:
        place = np.arange(len(names))[::-1]
        for m, label in enumerate(labels):
            left.scatter(units[:, m], place, color=MODE_COLORS[m % 3], s=34, label=label, zorder=3)
        left.axvline(0, color="#9ca3af", lw=0.8)
        left.set_yticks(place, names)
        _titles(left, "Scores of the shapes", "standard deviations", "")
        quiet_axes(left, both=True)
    else:
        bins = np.linspace(units.min(), units.max(), 31)
        for m, label in enumerate(labels):
            color = MODE_COLORS[m % 3]
            left.hist(units[:, m], bins, color=color, histtype="step", lw=2, label=label)
        _titles(left, "Scores of the shapes", "standard deviations", "shapes")
        quiet_axes(left)
    figure.legend(
        *left.get_legend_handles_labels(),
        fontsize=10.5,
        loc="lower left",
        ncol=3,
        labelcolor=INK,
        frameon=False,
    )
    for axis in rest:
        axis.scatter(
            units[:, 0], units[:, 1], color=ROBUST, s=40, zorder=2, edgecolors="white", lw=0.8
        )
        _titles(axis, "The shapes in the first two modes", *PLANE)
        axis.margins(0.16)
        quiet_axes(axis, both=True)
    figure.tight_layout(w_pad=2.5, rect=(0, 0.35 / height, 1, 1))
    for axis in rest:
        # Those that stand out come first; of many shapes they are the only ones.
        far = np.argsort(-np.hypot(units[:, 0], units[:, 1]))[: len(names) if few else 8]
        _name_points(axis, units[:, :2], names, far, 9)
    save(figure, path)


def _name_points(axis, points: np.ndarray, names: Sequence[str], order, size: float) -> None:
    """Names beside points, the first of `order` first: right or left of its point, above or below,
    where a name overlaps no other and hides as few points as can be. One that has no such place
    inside the axis is left out. The axis has its final size by then."""
    renderer, unit = axis.figure.canvas.get_renderer(), axis.figure.dpi / 72
    frame, at, taken = axis.get_window_extent(renderer), axis.transData.transform(points), []
    for i in order:
        text = axis.annotate(names[i], points[i], (0, 0), textcoords="offset points", fontsize=size)
        extent = text.get_window_extent(renderer)
        places = []
        for right, above in ((1, 1), (0, 1), (1, 0), (0, 0)):
            offset = np.array([6 if right else -6, 4 if above else -4])
            low = at[i] + unit * offset - [(1 - right) * extent.width, (1 - above) * extent.height]
            high = low + [extent.width, extent.height]
            if (low < frame.min).any() or (high > frame.max).any():
                continue
            if any((low < other[1]).all() and (other[0] < high).all() for other in taken):
                continue
            hidden = ((at > low - 3 * unit) & (at < high + 3 * unit)).all(1)
            hidden[i] = False
            places.append((int(hidden.sum()), len(places), offset, (low, high)))
        if not places:
            text.remove()
            continue
        _, _, offset, box = min(places, key=lambda place: place[:2])
        taken.append(box)
        text.set(
            position=offset,
            color=INK,
            ha="left" if offset[0] > 0 else "right",
            va="bottom" if offset[1] > 0 else "top",
        )


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
    figure, (axis,) = panels(8.6, 4.3)
    phases = row.numbers()
    label = f"{row.title}" if truth is not None else None
    axis.plot(phases, values, color=ROBUST, lw=2.4, marker="o", ms=4, label=label)
    if truth is not None:
        axis.plot(phases, truth, color=GREY, lw=1.8, ls=(0, (4, 3)), label="the phantom itself")
    others = values if truth is None else truth
    highest, lowest = int(values.argmax()), int(values.argmin())
    for phase, at, above in (
        (highest, max(values[highest], others[highest]), 10),
        (lowest, min(values[lowest], others[lowest]), -19),
    ):
        leftwards = 2 * phase > len(phases)  # so that it stays within the picture
        axis.annotate(
            f"{values[phase]:.4g} {unit}",
            (phases[phase], at),
            textcoords="offset points",
            xytext=(-8 if leftwards else 8, above),
            ha="right" if leftwards else "left",
            fontsize=11,
            color=INK,
        )
    title = "Volume over the phases"
    if row.result.order == "Cyclic time" and values.max() > 0:
        title += f": {100 * (1 - values.min() / values.max()):.0f} % ejected"
    _titles(axis, title, "phase", f"volume, {unit}")
    axis.set_xlim(phases[0] - 0.5, phases[-1] + 0.5)
    axis.set_ylim(0, 1.2 * values.max())
    axis.xaxis.get_major_locator().set_params(integer=True)
    if truth is not None:
        axis.legend(fontsize=10.5, loc="lower left", labelcolor=INK, frameon=False)
    quiet_axes(axis)
    save(figure, path)


def _volumes_of_shapes(row: Row, values, unit: str, path) -> None:
    names = [surface.name for surface in row.result.surfaces]
    few = len(names) <= BY_NAME
    figure = new_figure(8.6, max(3.0, 1.4 + 0.24 * len(names)) if few else 4.3)
    axis = figure.subplots()
    if few:
        place = np.arange(len(names))[::-1]
        axis.barh(place, values, height=0.62, color=ROBUST)
        axis.set_yticks(place, names)
        _titles(axis, "Volume of the shapes", f"volume, {unit}", "")
    else:
        axis.hist(values, 30, color=ROBUST)
        _titles(axis, "Volume of the shapes", f"volume, {unit}", "shapes")
    quiet_axes(axis, both=True)
    figure.tight_layout()
    save(figure, path)


def _titles(axis, title: str, x: str, y: str) -> None:
    panel_title(axis, title)
    axis.set_xlabel(x, fontsize=11, color=GREY)
    axis.set_ylabel(y, fontsize=11, color=GREY)
