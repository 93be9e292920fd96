# SPDX-License-Identifier: GPL-3.0-only
"""Shape models from files."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Dict, List, Mapping, Optional, Tuple

import numpy as np

from . import statismo
from .errors import FileError, InputError
from .model import ShapeModel
from .parameters import path_of, whole_number

NAMES = ("anchor_names", "anchor_landmarks")  # arrays of texts, and of numbers
MEASURED = ("generalisation", "generalisation_error", "specificity", "specificity_error")
NEEDED = ("mean", "modes", "eigenvalues", "scores", "faces")


def read_model(path) -> ShapeModel:
    """A shape model as `shape_model(export_file="model.npz")` and `run` leave it (.npz), or as
    statismo and scalismo write it: .h5 (by h5py, the extra `models`) and .json.

    Files of `cohort` have names, the total variance, and generalisation and specificity, of its
    subjects' frames. Others say nothing of names, which are those in landmarks.npz beside it, where
    `run` put it, else "shape 0" and so on; nor of modes that were left out: total_variance is that
    of its own, and compactness and variance_share are all figures. Models of other programs have no
    training shapes, as a rule: then scores are (0, M). Triangles of theirs are taken as they are,
    outwards.
    """
    path = path_of(path)
    _require_no_folder(path)
    found = _arrays(path)
    missing = [name for name in NEEDED if name not in found]
    if missing:
        raise FileError(
            f"{path} is not a shape model: it has no {' and no '.join(missing)}. Models are what "
            'shape_model(…, export_file="model.npz") and "sphere-propagation run" write.'
        )
    mean, modes, eigenvalues, scores, faces = (found[name] for name in NEEDED)
    fits = (
        mean.ndim == 2
        and len(mean) > 0
        and mean.shape[1] == 3
        and scores.ndim == 2
        and eigenvalues.shape == scores.shape[1:]
        and modes.shape == (len(eigenvalues), *mean.shape)
        and faces.ndim == 2
        and faces.shape[1] == 3
        and faces.dtype.kind in "iu"
        and all(values.dtype.kind in "fiu" for values in (mean, modes, eigenvalues, scores))
    )
    if not fits:
        shapes = ", ".join(f"{name} {found[name].shape}" for name in NEEDED)
        raise FileError(f"{path} is not a shape model: its arrays do not fit together ({shapes}).")
    if faces.size and not 0 <= faces.min() <= faces.max() < len(mean):
        raise FileError(f"{path} is not a shape model: a face names a landmark that is not there.")
    if not all(np.isfinite(values).all() for values in (mean, modes, eigenvalues, scores)):
        raise FileError(f"{path} is not a shape model: some of its numbers are infinite or NaN.")
    if (eigenvalues < 0).any():
        raise FileError(f"{path} is not a shape model: an eigenvalue is negative.")
    compactness = np.cumsum(eigenvalues, dtype=float)
    total = float(compactness[-1]) if len(eigenvalues) else 0.0
    if "total_variance" in found:
        total = float(found["total_variance"])
    names = [str(name) for name in np.ravel(found.get("names", ()))] or beside(path)[0]
    measured = {name: found[name] for name in MEASURED if np.ndim(found.get(name)) == 1}
    return ShapeModel(
        mean,
        modes,
        eigenvalues,
        scores,
        faces.astype(np.int32),
        names if len(names) == len(scores) else [f"shape {k}" for k in range(len(scores))],
        total,
        {"compactness": compactness, "variance_share": compactness / (total or 1.0), **measured},
        found.get("lid"),
        float(found["noise_variance"]) if "noise_variance" in found else 0.0,
        _names_in(path, found),
    )


def name_landmarks(path, names: Mapping[str, int]) -> None:
    """Writes names of landmarks into a model's .npz file, {name: number}, so that anchors of these
    names are fitted to it; what it had before is replaced. With `anchor_snap` the numbers are in
    `correspond(...).anchors.landmarks`."""
    path = path_of(path)
    count = len(read_model(path).mean)
    if statismo.is_statismo(path):
        raise FileError(f"{path}: names of landmarks are kept in .npz files alone.")
    checked = checked_names(names, count)
    arrays = {key: values for key, values in _arrays(path).items() if key not in NAMES}
    np.savez(path, **arrays, **name_arrays(checked))


def checked_names(names: Optional[Mapping[str, int]], count: int) -> Dict[str, int]:
    if names is None:
        return {}
    if not isinstance(names, Mapping):
        raise InputError(
            f"Names of landmarks must be a dictionary, name -> number, not {type(names).__name__}."
        )
    found = {}
    for name, number in names.items():
        number = whole_number(f"The landmark called {name}", number)
        if not isinstance(name, str) or not name or not 0 <= number < count:
            raise InputError(
                f"{name!r} cannot be the name of landmark {number}: names are texts, and the "
                f"landmarks are numbered from 0 to {count - 1}."
            )
        found[name] = number
    return found


def name_arrays(names: Mapping[str, int]) -> Dict[str, np.ndarray]:
    """As a model's file has them; none where there are no names."""
    if not names:
        return {}
    return dict(zip(NAMES, (np.array(list(names)), np.array(list(names.values()), np.int32))))


def _require_no_folder(path: Path) -> None:
    if not path.is_dir():
        return
    models = sorted(path.rglob("model.npz"))
    if not models:
        raise FileError(f"{path} is a folder, and there is no model.npz in it.")
    others = f", or another of its {len(models)}" if len(models) > 1 else ""
    raise FileError(f"{path} is a folder: name the model in it, {models[0]}{others}.")


def _names_in(path: Path, found: Mapping[str, np.ndarray]) -> Dict[str, int]:
    names, numbers = (np.ravel(found.get(key, ())) for key in NAMES)
    if len(names) != len(numbers) or any(not 0 <= n < len(found["mean"]) for n in numbers):
        raise FileError(
            f"{path} is not a shape model: its {' and '.join(NAMES)} do not fit together."
        )
    return {str(name): int(number) for name, number in zip(names, numbers)}


def beside(path: Path) -> Tuple[List[str], Optional[str]]:
    """Names of the shapes and their unit, as landmarks.npz beside a model has them; none where
    there is no such file."""
    try:
        with np.load(path.with_name("landmarks.npz")) as file:
            return [str(name) for name in file["names"]], str(file["unit"])
    except (OSError, KeyError, ValueError, zipfile.BadZipFile):
        return [], None


def _arrays(path: Path) -> Dict[str, np.ndarray]:
    if path.is_file() and statismo.is_statismo(path):
        found = statismo.read(path)._asdict()
        return {name: np.asarray(values) for name, values in found.items()}
    try:
        with np.load(path) as file:  # which unpickles nothing
            return {name: file[name] for name in file.files}
    except FileNotFoundError:
        raise
    except (OSError, ValueError, AttributeError, EOFError, zipfile.BadZipFile) as error:
        raise FileError(f"{path} is no .npz file of NumPy, as shape models are.") from error
