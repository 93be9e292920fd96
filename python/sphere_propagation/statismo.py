# SPDX-License-Identifier: GPL-3.0-only
"""Shape models that statismo and scalismo wrote: HDF5 (.h5), or the same tree as HDF5/JSON
(.json)."""

from __future__ import annotations

import json
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Dict, Iterator, List, NamedTuple, Optional

import numpy as np

from .errors import FileError

SUFFIXES = (".h5", ".hdf5", ".json")
NEEDED = ("h5py",)  # for all but .json
HDF5_MAGIC = b"\x89HDF\r\n\x1a\n"
MODEL = "model/mean"  # relative to the group of a model
ORTHONORMAL = 1e-3  # how far off 32-bit floats may leave it


class Found(NamedTuple):
    """Arrays as ShapeModel has them."""

    mean: np.ndarray
    modes: np.ndarray
    eigenvalues: np.ndarray
    scores: np.ndarray
    faces: np.ndarray
    noise_variance: float


def is_statismo(path: Path) -> bool:
    """By its name, or what it begins with."""
    if path.suffix.lower() in SUFFIXES:
        return True
    with open(path, "rb") as file:
        return file.read(len(HDF5_MAGIC)) == HDF5_MAGIC


def read(path: Path) -> Found:
    """The model at the root of the file; else the only one of a surface in it, as the catalog or
    the groups tell; else that in /shape, as face models of several parts have it."""
    with _tree(path) as tree:
        places = [place for place in ("", *tree.groups()) if tree.array(place, MODEL) is not None]
        if not places:
            raise FileError(
                f"{path} is not a shape model: it has no /model/mean, as statismo and scalismo "
                "write."
            )
        if len(places) > 1 and "" not in places:
            shapes = [place for place in places if tree.kind(place) == "POLYGON_MESH"] or places
            named = [place for place in shapes if place.strip("/").lower() == "shape"]
            places = named or shapes
            if len(places) > 1:
                raise FileError(
                    f"{path} holds several models, {', '.join(places)}: keep one of them in a file "
                    "of its own."
                )
        return _model(path, tree, places[0])


def _model(path: Path, tree: _Tree, place: str) -> Found:
    def needed(name: str) -> np.ndarray:
        found = tree.array(place, name)
        if found is None:
            raise FileError(f"{path} is not a shape model: it has no {place}/{name}.")
        if found.dtype.kind not in "fiu" or not np.isfinite(found).all():
            raise FileError(f"{path} is not a shape model: {place}/{name} are not finite numbers.")
        return found

    kind = tree.kind(place)
    if kind not in ("POLYGON_MESH", "", "UNKNOWN"):
        raise FileError(
            f"{path} is not a model of surfaces but of {kind.replace('_', ' ').lower()}: models of "
            "triangle meshes (POLYGON_MESH) are read."
        )
    if tree.array(place, "representer/cells") is None:
        raise FileError(
            f"{path} has no triangles (representer/cells): its representer is an older one. Read "
            "it with statismo or scalismo and save it again."
        )
    mean = needed("model/mean").astype(float).ravel()
    variances = needed("model/pcaVariance").astype(float).ravel()
    basis, cells = needed("model/pcaBasis").astype(float), needed("representer/cells")
    if not mean.size or mean.size % 3 or basis.shape != (mean.size, len(variances)):
        raise FileError(
            f"{path} is not a shape model: its arrays do not fit together (mean {mean.shape}, "
            f"pcaBasis {basis.shape}, pcaVariance {variances.shape})."
        )
    if (variances < 0).any():
        raise FileError(f"{path} is not a shape model: a variance is negative.")
    # 3 x F, as documented; F x 3 where whoever wrote it turned it round.
    if cells.ndim != 2 or 3 not in cells.shape:
        raise FileError(
            f"{path} is not a model of triangles: representer/cells are of shape {cells.shape}."
        )
    faces = (cells.T if cells.shape[0] == 3 else cells).astype(np.int64)
    deviations = np.sqrt(variances)
    scaled = basis * deviations
    if tree.version() == (0, 8):  # whose basis has the standard deviations in it
        scaled = basis
        basis = np.divide(scaled, deviations, out=np.zeros_like(basis), where=deviations > 1e-8)
    standard = tree.array(place, "modelinfo/scores")  # in standard deviations, M x K
    if standard is None or standard.ndim != 2 or standard.shape[0] != len(variances):
        standard = np.zeros((len(variances), 0))
    standard = standard.astype(float)
    used = deviations > 1e-6 * deviations.max(initial=0)
    gram = basis[:, used].T @ basis[:, used]
    ordered = (np.diff(variances) <= 0).all()
    if np.abs(gram - np.eye(len(gram))).max(initial=0) > ORTHONORMAL or not ordered:
        # The same normal distribution, along its principal axes.
        basis, deviations, turn = np.linalg.svd(scaled, full_matrices=False)
        variances, standard = deviations**2, turn @ standard
    noise = tree.array(place, "model/noiseVariance")
    modes = basis.T.reshape(len(variances), -1, 3)
    mean = mean.reshape(-1, 3)
    return Found(
        mean,
        modes,
        variances,
        (standard * deviations[:, None]).T,
        _outwards(mean, faces),
        max(0.0, float(np.ravel(noise)[0])) if noise is not None and noise.size else 0.0,
    )


def _outwards(mean: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Closed surfaces that look inwards are turned, as no normal of theirs would agree with a
    surface's."""
    if not faces.size or faces.min() < 0 or faces.max() >= len(mean):
        return faces  # read_model says what is wrong
    a, b = faces, np.roll(faces, -1, axis=1)
    edges = np.sort(np.stack([a.ravel(), b.ravel()], 1), axis=1)
    _, counts = np.unique(edges, axis=0, return_counts=True)
    corners = mean[faces]
    volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    return faces[:, ::-1] if (counts == 2).all() and volume < 0 else faces


# ---------------------------------------------------------------- trees of arrays


class _Tree:
    """What both kinds of files are: arrays and texts by their path, / between groups."""

    def array(self, place: str, name: str) -> Optional[np.ndarray]:
        """None where there is none."""
        raise NotImplementedError

    def attribute(self, group: str, name: str) -> str:
        """Empty where there is none."""
        raise NotImplementedError

    def groups(self) -> List[str]:
        """Those below the root."""
        raise NotImplementedError

    def kind(self, place: str) -> str:
        """Of what there is a model."""
        return self.attribute(f"{place}/representer", "datasetType")

    def version(self):
        """(0, 9) where the file says nothing, but for representers that are older than that."""
        said = [self.array("", f"version/{name}Version") for name in ("major", "minor")]
        if all(part is not None and part.size == 1 for part in said):
            return tuple(int(np.ravel(part)[0]) for part in said)
        old = self.attribute("/representer", "name") in ("vtkPolyDataRepresenter",)
        return (0, 8) if old else (0, 9)


class _Hdf5(_Tree):
    def __init__(self, file):
        self._file = file

    def array(self, place, name):
        found = self._file.get(f"{place}/{name}")
        return np.asarray(found[()]) if hasattr(found, "shape") else None

    def attribute(self, group, name):
        found = self._file.get(group)
        value = found.attrs.get(name, "") if found is not None else ""
        value = np.ravel(value)[0] if np.size(value) else ""  # some write arrays of one text
        return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)

    def groups(self):
        return [f"/{name}" for name, found in self._file.items() if not hasattr(found, "shape")]


class _Json(_Tree):
    """HDF5/JSON: groups and datasets by identifier, linked from their groups."""

    def __init__(self, document: Dict[str, Any]):
        self._groups, self._data = document["groups"], document.get("datasets", {})
        self._root = document["root"]

    def _links(self, identifier: str) -> Dict[str, Dict[str, Any]]:
        return {link["title"]: link for link in self._groups[identifier].get("links", ())}

    def _linked(self, path: str) -> Optional[Dict[str, Any]]:
        link: Dict[str, Any] = {"collection": "groups", "id": self._root}
        for name in filter(None, path.split("/")):
            if link.get("collection") != "groups":
                return None
            found = self._links(link["id"]).get(name)
            if found is None:
                return None
            link = found
        return link

    def array(self, place, name):
        link = self._linked(f"{place}/{name}")
        if link is None or link.get("collection") != "datasets":
            return None
        data = self._data[link["id"]]
        found = np.asarray(data["value"])
        extents = data.get("shape", {}).get("dims", found.shape)
        return found.reshape(extents) if found.size == np.prod(extents, dtype=int) else found

    def attribute(self, group, name):
        link = self._linked(group)
        if link is None or link.get("collection") != "groups":
            return ""
        for attribute in self._groups[link["id"]].get("attributes", ()):
            if attribute["name"] == name:
                return str(np.ravel(attribute["value"])[0])
        return ""

    def groups(self):
        links = self._links(self._root).values()
        return [f"/{link['title']}" for link in links if link.get("collection") == "groups"]


@contextmanager
def _tree(path: Path) -> Iterator[_Tree]:
    if path.suffix.lower() == ".json":
        try:
            yield _Json(json.loads(path.read_text(encoding="utf-8")))
        except (ValueError, KeyError, TypeError, AttributeError, IndexError) as error:
            raise FileError(
                f"{path} is not a shape model: it is not HDF5/JSON as scalismo writes."
            ) from error
        return
    try:
        import h5py
    except ImportError as error:
        raise FileError(
            f"{path} is read by the package h5py, which is not installed: "
            "pip install 'sphere-propagation[models]'"
        ) from error
    try:
        file = h5py.File(path, "r")
    except FileNotFoundError:
        raise
    except OSError as error:
        raise FileError(
            f"{path} is not an HDF5 file, as models of statismo and scalismo are."
        ) from error
    with file:
        try:
            yield _Hdf5(file)
        except (RuntimeError, OSError) as error:  # h5py's, where a file is damaged
            if isinstance(error, FileError):
                raise
            raise FileError(f"{path} is damaged, or cut short: {error}") from error
