# SPDX-License-Identifier: GPL-3.0-only
"""Which subjects of a study stand out, and why: figures of each against those of all, as robust
z-scores. The page that shows it is study_page.py's.

A figure's z is 0.6745 (x - median) / MAD, where MAD is the median distance from the median: for a
normal distribution these are standard deviations, and subjects that stand out do not widen what
they are judged by (B. Iglewicz, D. Hoaglin: How to detect and handle outliers, 1993, who recommend
the limit 3.5). Lengths and volumes are compared by their logarithm, since they are skewed.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, Mapping, NamedTuple, Optional, Sequence

import numpy as np

from ..errors import InputError

NOT_REPEATED = ("anotherPose", "fitOfOtherSize", "fitIsFarOff", "shapeIsUnusual")  # are figures
NORMAL = 0.6745  # median distance from the median of a normal distribution, in standard deviations
NOTHING = 1e-4  # lengths that nobody minds, of the cube root of the median volume
FEWEST = 5  # subjects that a figure is compared among
CURVE = 20  # places of a cycle at which volume curves are compared
DEFAULTS: Dict[str, Any] = {"threshold": 3.5, "pictures": 1000}
LENGTH, PART, ANGLE, VOLUME, TIMES = (
    "length",
    "share",
    "angle",
    "volume",
    "times",
)  # kinds of figures


class Measure(NamedTuple):
    """least: the smallest spread (robust standard deviation) that is believed, so that figures
    which hardly differ are not called outliers; of the logarithm for lengths, volumes and times."""

    name: str
    title: str
    kind: str
    least: float
    both: bool  # too small stands out as well
    means: str
    of: Callable[[Mapping[str, Any]], Optional[float]]  # a record with what scores say of it

    @property
    def by_logarithm(self) -> bool:
        return self.kind in (LENGTH, VOLUME, TIMES)


def _largest(name: str) -> Callable[[Mapping[str, Any]], Optional[float]]:
    return lambda record: max(record[name]) if record.get(name) else None


def _of_fit(name: str) -> Callable[[Mapping[str, Any]], Optional[float]]:
    return lambda record: (record.get("fit") or {}).get(name)


def _repaired(record: Mapping[str, Any]) -> Optional[float]:
    counts = zip(record.get("repaired_faces", ()), record["vertices"])
    return max((float(n) / max(2 * v - 4, 1) for n, v in counts), default=None)


def _volume_change(record: Mapping[str, Any]) -> Optional[float]:
    volume = record["volume"]
    return (max(volume) - min(volume)) / (max(volume) or 1.0) if len(volume) > 1 else None


def _jump(record: Mapping[str, Any]) -> Optional[float]:
    """Over a cycle's end only where its phases are a cycle."""
    v = np.asarray(record["volume"], float)
    if len(v) < 4:
        return None
    if "branch_distance" in record:
        v = np.r_[v[-1], v, v[0]]
    return float(np.abs(v[1:-1] - (v[:-2] + v[2:]) / 2).max() / (v.max() or 1.0))


MEASURES = (
    Measure(
        "fit",
        "fit to the atlas",
        LENGTH,
        0.05,
        False,
        "mean distance of the subject's frame from the atlas as it was fitted: large where the "
        "atlas knows nothing like it, or the frame is another organ, cut off, or turned",
        _of_fit("surface_distance"),
    ),
    Measure(
        "residual",
        "residual",
        LENGTH,
        0.05,
        False,
        "mean distance of a phase's vertices from the frame's surface as it was deformed to fit "
        "them, the worst phase: large where a phase is not the same thing any more",
        _largest("residual_mean"),
    ),
    Measure(
        "residual_p95",
        "residual, its worst 5 %",
        LENGTH,
        0.05,
        False,
        "the same, exceeded at 5 % of a phase's vertices: large where a part of a phase is missing "
        "or added",
        _largest("residual_p95"),
    ),
    Measure(
        "repaired",
        "faces repaired",
        PART,
        0.002,
        False,
        "share of a phase's faces that were flipped when its map arrived and were put right, the "
        "worst phase: their landmarks are less certain",
        _repaired,
    ),
    Measure(
        "angles",
        "angle error",
        ANGLE,
        0.5,
        False,
        "mean difference of the faces' angles on the sphere and on the surface, the worst phase: "
        "large where a map is distorted",
        _largest("angle_error_mean"),
    ),
    Measure(
        "landmarks",
        "landmark mesh to surface",
        LENGTH,
        0.05,
        False,
        "mean distance of the landmarks' mesh from the surface, the worst phase: what the "
        "landmarks leave out",
        _largest("surface_distance_mean"),
    ),
    Measure(
        "volume",
        "largest volume",
        VOLUME,
        0.05,
        True,
        "far from others' where a segmentation is of something else, or a file has another unit",
        _largest("volume"),
    ),
    Measure(
        "change",
        "volume change",
        PART,
        0.01,
        True,
        "largest minus smallest volume, as a share of the largest: the ejection fraction of a "
        "ventricle",
        _volume_change,
    ),
    Measure(
        "jump",
        "volume jump",
        PART,
        0.005,
        False,
        "how far a phase's volume lies from the mean of its two neighbours, as a share of the "
        "largest, the worst phase: large where one phase is segmented otherwise, or files are in "
        "another order",
        _jump,
    ),
    Measure(
        "curve",
        "volume curve",
        PART,
        0.005,
        False,
        "root mean square distance of the volume curve, from its largest (1) to its smallest (0), "
        "from the study's median curve, which starts at the largest volume as well",
        lambda record: None,  # no record knows it: compare_curves does
    ),
    Measure(
        "closure",
        "closure of the cycle",
        LENGTH,
        0.05,
        False,
        "distance of the landmarks that came the two ways round the cycle where these meet: large "
        "where correspondence drifted",
        lambda record: record.get("branch_distance"),
    ),
    Measure(
        "deviation",
        "deviation from the model",
        TIMES,
        0.05,
        False,
        "how far from the mean the subject's shapes lie in the model, 1 is as far as shapes "
        "usually are; the worst phase",
        _largest("deviation"),
    ),
    Measure(
        "unseen",
        "outside of the model",
        LENGTH,
        0.05,
        False,
        "root mean square distance of the landmarks from the nearest shape that the model's modes "
        "can show, the worst phase",
        _largest("residual"),
    ),
)


class Reference(NamedTuple):
    """What a figure is judged by. spread: a robust standard deviation, of the logarithm where the
    measure goes by it; start: what was added before."""

    count: int
    median: float
    spread: float
    start: float

    def z(self, measure: Measure, value: float) -> float:
        found = (_transformed(measure, value, self.start) - self._middle(measure)) / self.spread
        return float(abs(found) if measure.both else found)

    def limit(self, measure: Measure, threshold: float) -> float:
        """The value beyond which a figure stands out."""
        at = self._middle(measure) + threshold * self.spread
        return float(np.exp(at) - self.start if measure.by_logarithm else at)

    def _middle(self, measure: Measure) -> float:
        return float(_transformed(measure, self.median, self.start))


@dataclass
class Subject:
    """A subject and what is said of it. score: its largest z, endless where something is wrong
    whatever the others are like; reasons: the worst first."""

    name: str
    chunk: str
    status: str  # done, excluded, left out (not like the others) or failed
    figures: Dict[str, float] = field(default_factory=dict)
    score: float = 0.0
    reasons: List[str] = field(default_factory=list)
    phases: int = 0
    warnings: List[str] = field(
        default_factory=list
    )  # of the steps, which do not make it stand out
    curve: List[float] = field(default_factory=list)  # volumes as parts of the largest
    why: str = ""  # it is excluded, as whoever did it says


def checked(table: Mapping[str, Any]) -> Dict[str, Any]:
    """The study's [quality] with defaults; InputError, naming the key, where it cannot be."""
    for key in table:
        if key not in DEFAULTS:
            raise InputError(
                f"[quality] has a key {key!r}, which means nothing. Keys that there are: "
                f"{', '.join(DEFAULTS)}."
            )
    made = {**DEFAULTS, **table}
    threshold, pictures = made["threshold"], made["pictures"]
    if not _is_number(threshold) or not 1 <= threshold <= 100:
        raise InputError(
            f"threshold of [quality] must be a number from 1 to 100, not {threshold!r}."
        )
    if not _is_number(pictures) or pictures != int(pictures) or not 0 <= pictures <= 20000:
        raise InputError(
            f"pictures of [quality] must be a whole number from 0 to 20000, not {pictures!r}."
        )
    return {"threshold": float(threshold), "pictures": int(pictures)}


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and np.isfinite(value)


def write(folder: Path = Path(".")) -> int:
    """report.html and the subjects' own pages of the study in `folder`; returns how many subjects
    stand out."""
    from . import study_page

    return study_page.write(folder)


# ---------------------------------------------------------------- figures


def figures_of(record: Mapping[str, Any], scored: Optional[Mapping[str, Any]]) -> Dict[str, float]:
    """What is known of a subject that was done; `scored`: its entry in scores/."""
    both = dict(record)
    for key in ("deviation", "residual"):
        if scored and scored.get(key):
            both[key] = scored[key]
    found = {measure.name: measure.of(both) for measure in MEASURES}
    return {
        name: float(value) for name, value in found.items() if value is not None and value == value
    }


def curve_of(volume: Sequence[float]) -> List[float]:
    """From the largest volume on, at CURVE places of the cycle, 1 the largest and 0 the smallest;
    empty where there is none."""
    v = np.asarray(volume, float)
    if len(v) < 4 or v.max() <= v.min():
        return []
    v = np.roll((v - v.min()) / (v.max() - v.min()), -int(v.argmax()))
    at = np.arange(CURVE) * len(v) / CURVE
    return list(np.interp(at, np.arange(len(v) + 1), np.r_[v, v[0]]))


def compare_curves(
    subjects: Sequence[Subject], curves: Mapping[str, Sequence[float]]
) -> np.ndarray:
    """Adds the figure "curve"; returns the median curve, empty where there is none."""
    known = [one for one in subjects if curves.get(one.name)]
    used = [curves[one.name] for one in known if one.status == "done"]
    if len(used) < FEWEST:
        return np.zeros(0)
    middle = np.median(np.asarray(used), 0)
    for one in known:
        away = np.asarray(curves[one.name]) - middle
        one.figures["curve"] = float(np.sqrt((away**2).mean()))
    return middle


# ---------------------------------------------------------------- judgement


def judge(subjects: Sequence[Subject], threshold: float, unit: str = "mm") -> Dict[str, Reference]:
    """Fills in scores and reasons, and puts the subjects in order: those that could not be done
    first, then by score. Excluded ones are judged, and do not judge."""
    references = {}
    sizes = [one.figures["volume"] for one in subjects if "volume" in one.figures]
    nothing = NOTHING * float(np.cbrt(np.median(sizes))) if sizes else 0.0
    for measure in MEASURES:
        values = [
            one.figures[measure.name]
            for one in subjects
            if one.status == "done" and measure.name in one.figures
        ]
        if len(values) >= FEWEST:
            references[measure.name] = _reference(measure, np.asarray(values), nothing)
    usual = _usual_count([one.phases for one in subjects if one.status == "done"])
    for one in subjects:
        if one.status == "failed":
            continue
        found = []
        for measure in MEASURES:
            known = references.get(measure.name)
            if known is None or measure.name not in one.figures:
                continue
            value = one.figures[measure.name]
            z = known.z(measure, value)
            one.score = max(one.score, z)
            if z > threshold:
                found.append((z, _reason(measure, value, z, known, unit)))
        said = [text for _, text in sorted(found, key=lambda pair: -pair[0])]
        if usual and one.phases and one.phases != usual:
            said.append(f"{one.phases} phases, others have {usual}")
            one.score = max(one.score, threshold)
        one.reasons = one.reasons + said
    return references


def in_order(subjects: Sequence[Subject]) -> List[Subject]:
    return sorted(subjects, key=lambda one: (one.status != "failed", -one.score, one.name))


def stands_out(subject: Subject, threshold: float) -> bool:
    return subject.status in ("failed", "left out") or subject.score >= threshold


def warnings_of(record: Mapping[str, Any]) -> List[str]:
    """What the steps warned of, in words, but of what is said elsewhere; the same of several phases
    is one."""
    found: Dict[str, str] = {}
    for one in record.get("warnings", ()):
        if one["message"] not in NOT_REPEATED:
            layer = f"{one['layer']}: " if one.get("layer") else ""
            found.setdefault(one["message"] or one["text"], layer + one["text"].removeprefix(layer))
    return list(found.values())


def flipped(record: Mapping[str, Any]) -> List[str]:
    """What is wrong whatever others are like: a map that is none."""
    count = int(sum(record.get("flipped_faces", ())))
    return [f"{count} face{'s' * (count > 1)} flipped: no valid map"] if count else []


def value_of(measure: Measure, value: float, unit: str) -> str:
    """In words."""
    if measure.kind == PART:
        return f"{100 * value:.3g} %"
    after = {LENGTH: f" {unit}", VOLUME: f" {unit}³", ANGLE: "°", TIMES: ""}[measure.kind]
    return f"{value:.3g}{after}" if abs(value) < 1000 else f"{value:.0f}{after}"


def _reason(measure: Measure, value: float, z: float, known: Reference, unit: str) -> str:
    middle = value_of(measure, known.median, unit)
    return f"{measure.title} {value_of(measure, value, unit)} (median {middle}, z {z:.1f})"


def _usual_count(counts: Sequence[int]) -> int:
    """What at least nine of ten have; 0 where there is no such."""
    if len(counts) < FEWEST:
        return 0
    values, often = np.unique(counts, return_counts=True)
    return int(values[often.argmax()]) if often.max() >= 0.9 * len(counts) else 0


def _transformed(measure: Measure, value, start: float):
    return np.log(np.maximum(value, 0) + start) if measure.by_logarithm else value


def _reference(measure: Measure, values: np.ndarray, nothing: float) -> Reference:
    median = float(np.median(values))
    # A volume is never near 0; a distance can be, and then its logarithm says nothing.
    start = 0.0 if measure.kind == VOLUME and values.min() > 0 else median or float(values.mean())
    start = start if start > 0 or values.min() > 0 else 1.0
    if measure.kind == LENGTH:  # rounding, where modes show all shapes as they are
        start = max(start, nothing)
    x = _transformed(measure, values, start)
    spread = float(np.median(np.abs(x - np.median(x)))) / NORMAL
    return Reference(len(values), median, max(spread, measure.least), start)


def expected_by_chance(count: int, threshold: float) -> float:
    """Subjects that would stand out if every measure were spread normally and by itself."""
    from math import erfc, sqrt

    one_side = erfc(threshold / sqrt(2)) / 2
    tails = sum(2 if measure.both else 1 for measure in MEASURES)
    return count * (1 - (1 - one_side) ** tails)


def batches(blocks: Mapping[str, Sequence[str]]) -> Iterator[tuple]:
    """(block, chunk) in order."""
    for block, chunks in blocks.items():
        for chunk in chunks:
            yield block, chunk
