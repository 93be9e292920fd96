# SPDX-License-Identifier: GPL-3.0-only
"""One HTML page to explore a shape model: its modes by sliders, its shapes played, distances as
colours, landmarks that are dragged. Everything is inside; see docs/explore.md."""

from __future__ import annotations

import base64
import html
import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Dict, List, Optional, Sequence, Tuple, Union

import numpy as np

from .errors import InputError
from .model import ShapeModel
from .model_files import beside, read_model
from .parameters import path_of, whole_number
from .surface import array_of
from .units import DEFAULT_UNIT, unit_named
from .version import version
from .views import upright

SOURCES = Path(__file__).with_name("explorer_page")
SCRIPTS = ("model.js", "renderer.js", "page.js")  # in this order, each uses those before it
LARGEST = 5_000_000  # bytes of a page whose modes are 32-bit floats; larger ones get 16-bit numbers
MOST_PARTS = 20  # more than that are crumbs, no parts
CYCLE_SECONDS, SLOWEST, QUICKEST = 4.0, 1.5, 10.0  # how shapes are played: per second
NOISE = 0.5  # of fixed landmarks, as a share of how far landmarks vary per coordinate
LEAST_NOISE = 1e-3  # the same; 32-bit floats know no less


@dataclass(frozen=True, eq=False)
class Explorer:
    """The page. Shown inline by Jupyter where it is the last value of a cell."""

    html: str = field(repr=False)
    about: str

    def save(self, path) -> Path:
        """Writes it as a file for any browser."""
        path = path_of(path)
        path.write_text(self.html, encoding="utf-8")
        return path

    def _repr_html_(self) -> str:
        return (
            f'<iframe srcdoc="{html.escape(self.html)}" title="{html.escape(self.about)}" '
            'style="width: 100%; height: 640px; border: 1px solid #d8dce2"></iframe>'
        )


def explore(
    model: Union[ShapeModel, str, Path],
    *,
    title: Optional[str] = None,
    unit: Optional[str] = None,
    modes: int = 30,
    cyclic: bool = False,
    up: Optional[Sequence[float]] = None,
) -> Explorer:
    """A page to explore a shape model, for browsers and Jupyter: `sp.explore(model)`, or
    `sp.explore("model.npz").save("page.html")`.

    model: one of shape_model or read_model, or the path of its .npz file.
    title: the page's (default: the name of the file's folder). unit: of lengths, for its texts
    (default: what landmarks.npz beside the file says, else mm).
    modes: how many of the first the page has, at most; training shapes are shown in these.
    cyclic: whether the first shape follows the last when they are played; up: direction that is
    upright at first (default: the long axis).
    """
    if not isinstance(model, ShapeModel):
        path = path_of(model)
        model = read_model(path)
        unit = unit or beside(path)[1]
        title = title or (path.resolve().parent.name if path.stem == "model" else path.stem)
    if not isinstance(title, (str, type(None))):
        raise InputError(f"title must be a text, not {title!r}.")
    modes = whole_number("modes", modes)
    if modes < 1:
        raise InputError(f"modes must be 1 or more, not {modes}.")
    if up is not None:
        up = array_of("up", up)
        if up.shape != (3,) or up.dtype.kind not in "fiu" or not np.linalg.norm(up) > 0:
            raise InputError(f"up must be a direction, three numbers, not {up!r}.")
    data = _data(model, modes)
    data.update(
        title=title or "Shape model",
        unit=unit_named(unit or DEFAULT_UNIT),
        cyclic=bool(cyclic),
        noun="phase" if cyclic else "shape",
        view=_rounded(upright(np.asarray(model.mean, float), up).ravel()),
    )
    page = _page(data)
    if len(page.encode()) > LARGEST:
        data["directions"] = _quantised(_directions(model, data["modes"]))
        page = _page(data)
    return Explorer(page, f"{data['title']}: {data['about']}")


def _data(model: ShapeModel, most: int) -> Dict[str, Any]:
    """What page.js reads; lengths in the model's unit, scores in standard deviations."""
    mean = np.asarray(model.mean, float)
    kept = min(most, len(model.modes))
    variances = np.asarray(model.eigenvalues[:kept], float)
    sd = np.sqrt(variances)
    scores = np.divide(
        model.scores[:, :kept], sd, out=np.zeros((len(model.scores), kept)), where=sd > 0
    )
    total = model.total_variance or 1.0
    centre = (mean.min(0) + mean.max(0)) / 2
    typical = float(np.sqrt(variances.sum() / mean.size)) or 1.0
    part, names = _parts(np.asarray(model.faces), len(mean))
    count = len(model.scores)
    about = f"{_counted(count, 'shape')}, {_counted(len(mean), 'landmark')}, "
    about += _counted(kept, "mode")
    if kept:
        about += f" with {100 * min(1.0, variances.sum() / total):.4g} % of the variance"
    if kept < len(model.modes):
        about += f" of {len(model.modes)}"
    return {
        "about": about,
        "landmarks": len(mean),
        "modes": kept,
        "names": list(model.names),
        "centre": centre.tolist(),
        "mean": _packed(mean - centre, "float32"),
        "directions": _packed(_directions(model, kept), "float32"),
        "scores": _packed(scores, "float32"),
        "shares": _rounded(variances / total),
        "faces": _packed(model.faces, "uint16" if len(mean) <= 65536 else "int32"),
        "numbers": None if model.lid is None or not model.lid.any() else _kept_numbers(model),
        "parts": _packed(part, "uint8") if len(names) > 1 else None,
        "partNames": names,
        "noise": float(f"{NOISE * typical:.2g}"),
        "leastNoise": LEAST_NOISE * typical,
        "perSecond": float(np.clip(count / CYCLE_SECONDS, SLOWEST, QUICKEST)),
    }


def _directions(model: ShapeModel, kept: int) -> np.ndarray:
    """Where a standard deviation along each mode moves the landmarks."""
    return np.sqrt(model.eigenvalues[:kept])[:, None, None] * model.modes[:kept]


def _kept_numbers(model: ShapeModel) -> List[int]:
    """Of the model's landmarks, as they counted before those on lids were left out."""
    return np.flatnonzero(~np.asarray(model.lid, bool)).tolist()


def _parts(faces: np.ndarray, count: int) -> Tuple[np.ndarray, List[str]]:
    """Surfaces that do not touch: per landmark the number of its, and their names. The largest
    first; landmarks without a face belong to it."""
    label = np.arange(count)
    while len(faces):
        before = label.copy()
        np.minimum.at(label, faces, label[faces].min(1)[:, None])
        label = label[label]
        if np.array_equal(label, before):
            break
    used = np.zeros(count, bool)
    used[faces] = True
    found, sizes = np.unique(label[used], return_counts=True)
    found = found[np.argsort(-sizes, kind="stable")]
    if not 1 < len(found) <= MOST_PARTS:
        return np.zeros(count, int), ["surface"]
    part = np.zeros(count, int)
    for number, which in enumerate(found):
        part[label == which] = number
    return part, [f"part {number + 1}" for number in range(len(found))]


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}{'' if count == 1 else 's'}"


def _rounded(values: np.ndarray) -> List[float]:
    return [float(f"{value:.6g}") for value in values]


def _packed(values: np.ndarray, kind: str) -> Dict[str, Any]:
    little = np.ascontiguousarray(values, np.dtype(kind).newbyteorder("<"))
    return {"type": kind, "base64": base64.b64encode(little.tobytes()).decode()}


def _quantised(rows: np.ndarray) -> Dict[str, Any]:
    """In 16 bits: off by at most 1/65534 of the largest number of the row."""
    flat = rows.reshape(len(rows), -1)
    scales = np.abs(flat).max(1) / 32767
    numbers = np.rint(flat / np.where(scales > 0, scales, 1)[:, None])
    return {**_packed(numbers, "int16"), "scales": scales.tolist()}


def _page(data: Dict[str, Any]) -> str:
    scripts = "\n".join(_source(name) for name in SCRIPTS)
    parts = {
        "title": html.escape(data["title"]),
        "made": html.escape(f"sphere-propagation {version()}, GPL-3.0-only"),
        "style": _source("style.css"),
        "script": f'(() => {{\n"use strict";\n{scripts}}})();',
        # Nothing in it can end the element that it stands in.
        "data": json.dumps(data, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c"),
    }
    before, *rest = _source("page.html").split("{{")
    made = [before]
    for piece in rest:
        name, after = piece.split("}}", 1)
        made += [parts[name], after]
    return "".join(made)


def _source(name: str) -> str:
    return (SOURCES / name).read_text(encoding="utf-8")
