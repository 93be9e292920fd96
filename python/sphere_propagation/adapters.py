# SPDX-License-Identifier: GPL-3.0-only
"""Surfaces and label volumes of other libraries, in place of arrays and files.

Objects are known by what they offer, so nothing is imported that the user has not. What could be
meant in two ways is refused, and the error says the lines that decide.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Dict, Iterator, List, NamedTuple, NoReturn, Optional, Tuple

import numpy as np

from .attention import warn
from .errors import InputError
from .nifti import write_nifti

TRIANGLE = 5  # vtkCellType's VTK_TRIANGLE
POINTSET, TRIANGLES = 1008, 1009  # GIFTI's intents
TO_RAS = np.diag([-1.0, -1.0, 1.0, 1.0])  # from LPS, which ITK speaks, and back
MAX_LENGTH = 32767  # of a NIfTI file's axis


class Mesh(NamedTuple):
    """What a Surface is made of."""

    vertices: Any
    faces: Any
    name: Optional[str] = None
    space: str = ""


class Volume(NamedTuple):
    """Labels (x, y, z) or (x, y, z, time), and the way (4, 4) from indices to RAS in mm."""

    labels: np.ndarray
    affine: np.ndarray
    name: str = "volume"


def is_path(thing: Any) -> bool:
    """Whether it names a file or folder."""
    return isinstance(thing, (str, os.PathLike))


def _kind(thing: Any) -> str:
    return f"{type(thing).__module__.partition('.')[0]}.{type(thing).__name__}"


def _library(thing: Any) -> str:
    return type(thing).__module__.partition(".")[0]


def _value(thing: Any, name: str) -> Any:
    """An attribute, or what a method of no arguments returns; None where there is none."""
    found = getattr(thing, name, None)
    return found() if callable(found) else found


# ---------------------------------------------------------------- surfaces


def mesh_of(thing: Any, name: str) -> Mesh:
    """The mesh that an object of another library is. Raises InputError for everything else."""
    for adapt in (_prepared, _path, _pair, _vtk, _pymeshlab, _gifti, _meshio, _attributes):
        found = adapt(thing, name)
        if found is not None:
            return found
    if _is_image(thing):
        _refuse_image(name, thing)
    if isinstance(thing, np.ndarray):
        raise InputError(
            f"{name} is one array, of shape {thing.shape}: a surface is (vertices, faces)."
        )
    raise InputError(
        f"{name} must be a Surface, (vertices, faces), a file, or a mesh of trimesh, pyvista, vtk, "
        f"meshio, open3d, pymeshlab or nibabel, not {type(thing).__name__}."
    )


def is_prepared(thing: Any) -> bool:
    """Whether it is what prepare() returns."""
    from .preparation import PreparedSurface  # which needs what is here

    return isinstance(thing, PreparedSurface)


def _prepared(thing: Any, name: str) -> Optional[Mesh]:
    if not is_prepared(thing):
        return None
    found = thing.surface
    return Mesh(found.vertices, found.faces, found.name, found.space)


def _path(thing: Any, name: str) -> Optional[Mesh]:
    if not is_path(thing):
        return None
    from . import files  # which needs what is here

    path = Path(thing)
    if path.is_dir():
        raise InputError(
            f"{name} is the folder {path}. Its meshes are surfaces = sp.read_meshes({str(path)!r})"
        )
    if files.is_label_volume(path):
        raise InputError(
            f"{name} is {path}, a label volume. Its surfaces are "
            f"surfaces = sp.read_label_volume({str(path)!r}, labels=1).surfaces"
        )
    found = files.read_mesh(path)
    return Mesh(found.vertices, found.faces, found.name, found.space)


def _pair(thing: Any, name: str) -> Optional[Mesh]:
    if not isinstance(thing, (tuple, list)) or len(thing) != 2:
        return None
    if any(is_path(part) for part in thing):
        raise InputError(f"{name} holds two files: a surface is one of them.")
    return Mesh(*thing)


def _vtk(thing: Any, name: str) -> Optional[Mesh]:
    """Of vtk, pyvista and vedo."""
    data = getattr(thing, "dataset", None) if _library(thing) == "vedo" else thing
    if not callable(getattr(data, "IsA", None)) or not hasattr(data, "GetClassName"):
        return None
    what = data.GetClassName()
    if data.IsA("vtkPolyData"):
        cells = data.GetPolys()
        _refuse_points(name, what, cells.GetNumberOfCells() + data.GetNumberOfStrips(), data)
        if data.GetNumberOfStrips() or (np.diff(numbers_of(cells.GetOffsetsArray())) != 3).any():
            raise InputError(
                f"{name} ({what}) has strips, or polygons other than triangles. Triangles of it "
                "are mesh = pyvista.wrap(mesh).triangulate()"
            )
    elif data.IsA("vtkUnstructuredGrid"):
        cells = data.GetCells()
        _refuse_points(name, what, cells.GetNumberOfCells(), data)
        kinds = {data.GetCellType(i) for i in range(data.GetNumberOfCells())}
        if kinds != {TRIANGLE}:
            raise InputError(
                f"{name} ({what}) has cells other than triangles. What surrounds them is "
                "mesh = pyvista.wrap(mesh).extract_surface().triangulate()"
            )
    elif data.IsA("vtkAlgorithm"):
        raise InputError(
            f"{name} is a {what}, which makes a mesh: {name}.Update(), then {name}.GetOutput()"
        )
    elif data.IsA("vtkImageData"):
        return _refuse_image(name, thing)
    else:
        raise InputError(
            f"{name} is a {what}, no surface of triangles. What surrounds it is "
            "mesh = pyvista.wrap(mesh).extract_surface().triangulate()"
        )
    vertices = numbers_of(data.GetPoints().GetData()).copy()
    return Mesh(vertices, numbers_of(cells.GetConnectivityArray()).reshape(-1, 3).copy())


def _refuse_points(name: str, what: str, cells: int, data: Any) -> None:
    if not cells:
        raise InputError(
            f"{name} ({what}) has {data.GetNumberOfPoints()} points and no faces. A surface "
            "through points has to be made first, as by mesh = "
            "pyvista.wrap(mesh).reconstruct_surface()"
        )


def numbers_of(array: Any) -> np.ndarray:
    """A vtkDataArray's; where there is one there is vtk."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    return vtk_to_numpy(array)


def _pymeshlab(thing: Any, name: str) -> Optional[Mesh]:
    if callable(getattr(thing, "current_mesh", None)) and hasattr(thing, "mesh_number"):
        if thing.mesh_number() != 1:
            raise InputError(
                f"{name} is a MeshSet of {thing.mesh_number()} meshes. All are surfaces = "
                "list(meshes), the current one is surface = meshes.current_mesh()"
            )
        thing = thing.current_mesh()
    if not callable(getattr(thing, "face_matrix", None)):
        return None
    label = thing.label() if hasattr(thing, "label") else ""
    return Mesh(thing.transformed_vertex_matrix(), thing.face_matrix(), label or None)


def _gifti(thing: Any, name: str) -> Optional[Mesh]:
    arrays = getattr(thing, "darrays", None)
    if arrays is None:
        return None
    points = [array for array in arrays if array.intent == POINTSET]
    faces = [array for array in arrays if array.intent == TRIANGLES]
    if len(points) != 1 or len(faces) != 1:
        raise InputError(
            f"{name} (GIFTI) holds {len(points)} arrays of coordinates and {len(faces)} of "
            'triangles. One of each makes a surface: surface = (a.agg_data("pointset"), '
            'b.agg_data("triangle"))'
        )
    _say_whose_frame(points[0], name)
    return Mesh(points[0].data, faces[0].data)


def _say_whose_frame(points: Any, name: str) -> None:
    """GIFTI may tell of another frame than that of its coordinates, which are taken as they are."""
    space = getattr(points, "coordsys", None)
    matrix = getattr(space, "xform", None)
    if matrix is not None and not np.allclose(matrix, np.eye(4), atol=1e-6):
        warn(
            f"{name} tells of a transformation into another frame (GIFTI's "
            "CoordinateSystemTransformMatrix), which is not applied: the coordinates are those "
            "that the file holds."
        )
    meta = dict(getattr(points, "meta", None) or {})
    try:
        center = [float(meta[f"VolGeomC_{axis}"]) for axis in "RAS"]
    except (KeyError, ValueError):
        return
    if any(center):
        where = ", ".join(f"{coordinate:g}" for coordinate in center)
        warn(
            f"{name} comes from FreeSurfer, whose image lay at ({where}), and GIFTI does not say "
            "whether its coordinates have that added: they are those that the file holds."
        )


def _meshio(thing: Any, name: str) -> Optional[Mesh]:
    cells = getattr(thing, "cells", None)
    if not isinstance(cells, list) or not hasattr(thing, "points"):
        return None
    if not all(hasattr(block, "type") and hasattr(block, "data") for block in cells):
        return None
    kinds = {block.type for block in cells} - {"vertex", "line"}  # which bound nothing
    if kinds - {"triangle"}:
        raise InputError(
            f"{name} has cells other than triangles ({', '.join(sorted(kinds))}). What surrounds "
            "them is mesh = pyvista.from_meshio(mesh).extract_surface().triangulate()"
        )
    if not kinds:
        raise InputError(f"{name} has {len(thing.points)} points and no faces.")
    faces = [block.data for block in cells if block.type == "triangle"]
    return Mesh(thing.points, np.concatenate(faces))


def _attributes(thing: Any, name: str) -> Optional[Mesh]:
    """Of trimesh, open3d, nilearn, ShapeWorks and whatever else calls its parts so."""
    if hasattr(thing, "geometry") and hasattr(thing, "graph"):
        places = list(getattr(thing.graph, "nodes_geometry", ()))
        if len(places) == 1 and hasattr(thing, "to_mesh"):  # as files with one mesh are loaded
            thing = thing.to_mesh()
            return Mesh(_value(thing, "vertices"), _value(thing, "faces"))
        raise InputError(
            f"{name} is a scene of {len(thing.geometry)} meshes. One mesh of all, in place, is "
            "mesh = scene.to_mesh()"
        )
    if hasattr(thing, "vertex") and hasattr(thing, "triangle"):  # open3d's tensors
        positions = getattr(thing.vertex, "positions", None)
        indices = getattr(thing.triangle, "indices", None)
        if positions is not None and indices is not None:
            return Mesh(
                *(part.numpy() if hasattr(part, "numpy") else part for part in (positions, indices))
            )
    if isinstance(thing, (np.ndarray, Mapping)):
        return None
    for points in ("vertices", "points", "coordinates"):
        for faces in ("faces", "triangles"):
            if hasattr(thing, points) and hasattr(thing, faces):
                return Mesh(_value(thing, points), _value(thing, faces))
    for points in ("vertices", "points", "coordinates"):
        if hasattr(thing, points):
            raise InputError(f"{name} ({_kind(thing)}) has {points} and no faces.")
    return None


def surfaces_in(things: Any) -> List[Tuple[Any, str]]:
    """The members of a sequence of surfaces, and what those without a name are called."""
    from .surface import Surface

    if is_path(things):
        from . import files

        if files.is_label_volume(things):
            raise InputError(
                f"{things} is a label volume. Its surfaces are "
                f"surfaces = sp.read_label_volume({str(things)!r}, labels=1).surfaces"
            )
        return [(surface, surface.name) for surface in files.read_meshes(things)]
    if isinstance(things, Mapping):
        return [(thing, str(name)) for name, thing in things.items()]
    if callable(getattr(things, "IsA", None)) and things.IsA("vtkMultiBlockDataSet"):
        blocks = [things.GetBlock(i) for i in range(things.GetNumberOfBlocks())]
        names = list(things.keys()) if hasattr(things, "keys") else [None] * len(blocks)
        return [
            (block, name if isinstance(name, str) else f"surface {i}")
            for i, (block, name) in enumerate(zip(blocks, names))
        ]
    alone = isinstance(things, Surface) or is_prepared(things) or hasattr(things, "IsA")
    if alone or not hasattr(things, "__iter__"):
        what = type(things).__name__
        raise InputError(
            f"surfaces must be a list of surfaces, not {what}: one of them is [surface]."
        )
    return [(thing, f"surface {i}") for i, thing in enumerate(things)]


# ---------------------------------------------------------------- label volumes


@contextmanager
def volume_file(thing: Any) -> Iterator[Tuple[str, Dict[str, str]]]:
    """A file that holds the label volume: the file that was given, or one for the time being, with
    what to call it where the filter names it. Of a folder and of several volumes: the lines that
    the filter takes."""
    from . import files  # which needs what is here

    if is_path(thing) and not Path(thing).is_dir():
        yield str(thing), {}
        return
    if is_path(thing) or (isinstance(thing, (list, tuple)) and thing and all(map(is_path, thing))):
        paths = files.input_files(*([thing] if is_path(thing) else thing))
        others = [path for path in paths if not files.is_label_volume(path)]
        if others:
            raise InputError(f"{others[0]} is not a label volume.")
        yield files.volume_lines(paths, files.names_of(paths)), {}
        return
    several = isinstance(thing, list) and bool(thing) and all(map(is_label_volume, thing))
    called: Dict[str, str] = {}
    with tempfile.TemporaryDirectory() as folder:
        for i, member in enumerate(thing if several else [thing]):
            if is_path(member):
                if str(member) in called:
                    files.names_of([Path(member)] * 2)  # says so
                called[str(member)] = f"{files.stem_of(member)} {i}"
                continue
            volume = volume_of(member)
            name = f"{volume.name} {i}" if several else volume.name
            path = Path(folder) / f"{name}.nii"
            write_nifti(path, volume.labels, volume.affine)
            called[str(path)] = name
        if several:
            yield files.volume_lines([*map(Path, called)], [*called.values()]), called
        else:
            yield str(path), called


def is_label_volume(thing: Any) -> bool:
    """Whether it is a file of labels, an image, or (labels, affine), and no mesh."""
    if is_path(thing):
        from . import files

        return files.is_label_volume(thing)
    if isinstance(thing, tuple):
        return len(thing) == 2 and np.ndim(thing[0]) > 2
    return _is_image(thing)


def volume_of(thing: Any) -> Volume:
    """The label volume that an object of another library is. Raises InputError for everything
    else."""
    found = _labels_and_affine(thing)
    if found is None:
        found = next((adapt(thing) for known, adapt in _OF_IMAGES if known(thing)), None)
    if found is not None:
        return _checked(found)
    if isinstance(thing, np.ndarray):
        raise InputError(
            f"An array of shape {thing.shape} does not say where its voxels lie: give (labels, "
            "affine), as affine = np.diag([dx, dy, dz, 1.0]) with the spacing in mm."
        )
    if callable(getattr(thing, "IsA", None)) and thing.IsA("vtkImageData"):
        raise InputError(
            f"A {thing.GetClassName()} does not say whether its axes are RAS or LPS, nor which of "
            "its arrays holds the labels: give (labels, affine), as labels = "
            'image.point_data["labels"].reshape(image.dimensions, order="F") and affine = '
            "np.diag([*image.spacing, 1.0]); affine[:3, 3] = image.origin"
        )
    if isinstance(thing, (list, tuple)) and thing:
        raise InputError(
            "A list must hold label volumes, each a file, an image of nibabel or SimpleITK, or "
            "(labels, affine); one array with its affine is the tuple (labels, affine)."
        )
    raise InputError(
        "A label volume must be a file, an image of nibabel or SimpleITK, or (labels, affine), not "
        f"{type(thing).__name__}."
    )


def _is_image(thing: Any) -> bool:
    """Whether it is one of another library; nothing is converted."""
    return any(known(thing) for known, _ in _OF_IMAGES)


def _refuse_image(name: str, thing: Any) -> NoReturn:
    raise InputError(
        f"{name} is an image ({_kind(thing)}). A label volume's surfaces are "
        "surfaces = sp.read_label_volume(image, labels=1).surfaces"
    )


def _labels_and_affine(thing: Any) -> Optional[Volume]:
    if not isinstance(thing, tuple) or len(thing) != 2 or any(map(is_path, thing)):
        return None
    if isinstance(thing[1], Mapping):
        raise InputError(
            "An array with a header does not say in one way where its voxels lie: give the file "
            'itself, surfaces = sp.read_label_volume("labels.nrrd").surfaces'
        )
    labels, affine = (_array(part) for part in thing)
    if affine.shape != (4, 4) and affine.ndim == labels.ndim:
        return None  # two volumes
    if affine.shape != (4, 4) or affine.dtype.kind not in "fiu":
        raise InputError(
            f"An affine must be numbers of shape (4, 4), not {affine.dtype} of shape "
            f"{affine.shape}: affine = np.diag([dx, dy, dz, 1.0]) with the spacing in mm."
        )
    return Volume(labels, affine)


def _array(thing: Any) -> np.ndarray:
    try:
        return np.asarray(thing)
    except Exception as error:  # whatever its library raises
        raise InputError(f"{_kind(thing)} cannot be made an array: {error}") from error


def _is_simpleitk(thing: Any) -> bool:
    return _library(thing) == "SimpleITK" and hasattr(thing, "GetDirection")


def _simpleitk(thing: Any) -> Volume:
    if thing.GetNumberOfComponentsPerPixel() != 1:
        raise InputError("The SimpleITK image has several values per voxel, not one label.")
    size = thing.GetDimension()
    affine = _from_lps(
        thing.GetSpacing(), thing.GetOrigin(), np.reshape(thing.GetDirection(), (size, size))
    )
    # Which is there, as this is its image.
    labels = sys.modules["SimpleITK"].GetArrayViewFromImage(thing)
    return Volume(labels.transpose(), affine)


def _is_itk(thing: Any) -> bool:
    return _library(thing) == "itk" and hasattr(thing, "GetDirection")


def _itk(thing: Any) -> Volume:
    direction = np.asarray(sys.modules["itk"].array_from_matrix(thing.GetDirection()))
    return Volume(
        np.asarray(thing).transpose(), _from_lps(thing.GetSpacing(), thing.GetOrigin(), direction)
    )


def _is_ants(thing: Any) -> bool:
    return _library(thing) == "ants" and hasattr(thing, "direction")


def _ants(thing: Any) -> Volume:
    return Volume(thing.numpy(), _from_lps(thing.spacing, thing.origin, thing.direction))


def _from_lps(spacing: Any, origin: Any, direction: Any) -> np.ndarray:
    """ITK's way from indices to LPS as one to RAS; of time, only its place is known."""
    spacing, origin, direction = (np.array(list(x), float) for x in (spacing, origin, direction))
    if len(spacing) < 3:
        raise InputError(f"A label volume has three axes, not {len(spacing)}.")
    if direction[3:, :3].any() or direction[:3, 3:].any():
        raise InputError("The image's axes mix space and time.")
    affine = np.eye(4)
    affine[:3, :3], affine[:3, 3] = direction[:3, :3] * spacing[:3], origin[:3]
    return TO_RAS @ affine


def _has_affine(thing: Any) -> bool:
    if not hasattr(thing, "affine") or isinstance(thing, type):
        return False
    return _array(thing.affine).shape == (4, 4)


def _with_affine(thing: Any) -> Volume:
    """nibabel's images, torchio's, MONAI's arrays and whatever else knows its affine, to RAS."""
    affine = _array(thing.affine)
    if hasattr(thing, "dataobj"):
        labels, affine = np.asanyarray(thing.dataobj), affine * _millimetres(thing)
        if not any(
            getattr(thing, "header", {}).get(code, 1) for code in ("sform_code", "qform_code")
        ):
            warn(
                f"{_kind(thing)} does not say where its voxels lie (sform and qform are empty), so "
                "that left and right are nibabel's guess: give (labels, affine) to decide."
            )
    else:
        labels = _array(thing.numpy() if hasattr(thing, "numpy") else thing)
    if _library(thing) in ("torchio", "monai"):  # whose first axis is of channels
        if labels.ndim != 4 or len(labels) != 1:
            raise InputError(
                f"{_kind(thing)} of shape {labels.shape} has not one channel: give (labels, "
                "affine), as (image.numpy()[0], image.affine)"
            )
        labels = labels[0]
        meta = getattr(thing, "meta", None) or {}
        if str(meta.get("space", "RAS")) == "LPS":
            affine = TO_RAS @ affine
    file = thing.get_filename() if hasattr(thing, "get_filename") else None
    return Volume(labels, affine, _stem(file) if file else "volume")


# By what an image of another library is known, and what makes a label volume of it.
_OF_IMAGES = (
    (_is_simpleitk, _simpleitk),
    (_is_itk, _itk),
    (_is_ants, _ants),
    (_has_affine, _with_affine),
)


def _stem(file: Any) -> str:
    from .files import stem_of

    return stem_of(file)


def _millimetres(image: Any) -> np.ndarray:
    """How many there are in a unit of a nibabel image's header, for each row of its affine."""
    header = getattr(image, "header", None)
    units = header.get_xyzt_units()[0] if hasattr(header, "get_xyzt_units") else "mm"
    factor = {"meter": 1000.0, "micron": 0.001}.get(units, 1.0)
    return np.array([[factor], [factor], [factor], [1.0]])


def _checked(volume: Volume) -> Volume:
    labels, affine = np.asanyarray(volume.labels), np.asarray(volume.affine, float)
    while labels.ndim > 3 and labels.shape[-1] == 1:
        labels = labels[..., 0]
    if labels.ndim == 5 and labels.shape[3] == 1:  # NIfTI's fifth axis, when time lies there
        labels = labels[:, :, :, 0]
    if labels.ndim not in (3, 4) or not labels.size or labels.dtype.kind not in "biuf":
        raise InputError(
            "Labels must be numbers of shape (x, y, z) or (x, y, z, time), not "
            f"{labels.dtype} of shape {labels.shape}."
        )
    if max(labels.shape) > MAX_LENGTH:
        raise InputError(f"An axis of {max(labels.shape)} voxels is too long: {labels.shape}.")
    if isinstance(labels, np.ma.MaskedArray):
        labels = labels.filled(0)
    if (
        not np.isfinite(affine).all()
        or not np.array_equal(affine[3], [0, 0, 0, 1])
        or not np.linalg.det(affine[:3, :3])
    ):
        raise InputError(
            "The affine must lead from indices to mm in RAS, with rows of numbers, the last of "
            f"them 0 0 0 1, not {affine.tolist()}."
        )
    return Volume(labels, affine, volume.name)
