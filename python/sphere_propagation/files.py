# SPDX-License-Identifier: GPL-3.0-only
"""Mesh files and the maps in them; which files are label volumes."""

from __future__ import annotations

import os
import re
import tempfile
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Dict, Iterator, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from . import filters, layers, readers
from .attention import silenced, warn
from .errors import FileError, InputError
from .parameters import path_of
from .results import LIST as RESULTS
from .sphere_map import SphereMap
from .surface import Surface, array_of, count_others
from .turns import turn

SUFFIXES = (*readers.OF_MESHLAB, *readers.SUFFIXES)
VOLUME_SUFFIXES = (".nii", ".nii.gz", ".hdr", ".img", ".hdr.gz", ".img.gz", ".nrrd", ".nhdr")
VOLUME_SUFFIXES += (".mha", ".mhd")


def mesh_files(*paths) -> List[Path]:
    """The mesh files that files and folders stand for, in order of time.

    A folder stands for its meshes in natural order: phase_2 before phase_10; one that holds none
    itself for those of the folders in it, and in these. Files whose names
    differ in their numbers alone come in the order of these numbers, whatever a shell's * makes of
    them; otherwise the order is kept.
    """
    with turn("Looking for files"):
        return _in_order(paths, SUFFIXES)


def input_files(*paths) -> List[Path]:
    """As mesh_files, but a folder without meshes stands for its label volumes."""
    with turn("Looking for files"):
        return _in_order(paths, SUFFIXES, VOLUME_SUFFIXES)


def is_label_volume(path) -> bool:
    return Path(path).name.lower().endswith(VOLUME_SUFFIXES)


def volume_lines(paths: Sequence[Path], names: Sequence[str]) -> str:
    """As the import takes several files: one a line, each with what its layers are to be called."""
    for path, name in zip(paths, names):
        if any(letter in f"{path}{name}" for letter in "\n\t"):
            raise FileError(f"{str(path)!r} has a tab or a new line in its name: rename it.")
    return "\n".join(f"{path}\t{name}" for path, name in zip(paths, names))


def stem_of(path) -> str:
    """A file's name without its suffix; .nii.gz and .surf.gii are one, lh.white has none."""
    path = Path(path)
    for suffix in (".nii.gz", ".hdr.gz", ".img.gz", ".surf.gii"):
        if path.name.lower().endswith(suffix):
            return path.name[: -len(suffix)]
    known = path.suffix.lower() in (*SUFFIXES, *VOLUME_SUFFIXES)
    return path.name if readers.FREESURFER.match(path.name) and not known else path.stem


def _inputs(files: List[Path]) -> List[Path]:
    """Without what macOS keeps beside files on foreign disks (._name), and without the voxels of a
    pair (.img), which its header (.hdr) stands for."""

    def of_macos(path: Path) -> bool:
        if not path.name.startswith("._") or not path.is_file():
            return False
        with open(path, "rb") as file:
            return file.read(4) == readers.APPLE_DOUBLE

    def ends(path: Path, *suffixes: str) -> bool:
        return path.name.lower().endswith(suffixes)

    headers = {path.with_name(stem_of(path)) for path in files if ends(path, ".hdr", ".hdr.gz")}
    return [
        path
        for path in files
        if not of_macos(path)
        and not (ends(path, ".img", ".img.gz") and path.with_name(stem_of(path)) in headers)
    ]


def files_of_any_name(*paths) -> List[Path]:
    """As mesh_files, each file once, where names may be the same: they lie in several folders."""
    with turn("Looking for files"):
        found = _in_order(paths, SUFFIXES, distinct=False)
    return list({path.resolve(): path for path in reversed(found)}.values())[::-1]


def _in_order(paths, *kinds: Tuple[str, ...], distinct: bool = True) -> List[Path]:
    """kinds: suffixes; a folder stands for the first kind that it has. distinct: whether names must
    be."""
    found: List[Path] = []
    given = [path_of(path) for path in paths]
    given = _inputs(given) or given
    if len({re.sub(r"\d+", "#", str(path)) for path in given}) == 1:
        given.sort(key=lambda path: _natural(str(path)))
    for path in given:
        if path.is_dir():
            found += _in_folder(path, kinds)
        elif path.is_file():
            found.append(path)
        else:
            raise FileError(f"There is no file or folder {path}.")
    if distinct:
        names_of(found)
    return found


def names_of(paths: Sequence[Path]) -> List[str]:
    """What surfaces of files are called: after the file; where several folders hold one name, after
    the folder alone if that is the name in all of them, and after both else."""
    stems = [stem_of(path) for path in paths]
    homes = [path.absolute().parts[:-1] for path in paths]
    at: Dict[Tuple[Tuple[str, ...], str], Path] = {}
    for path, stem, home in zip(paths, stems, homes):
        if (home, stem) in at:
            raise FileError(
                f"{at[home, stem]} and {path} have the same name: layers could not be told apart."
            )
        at[home, stem] = path
    if len(set(stems)) == len(stems):
        return stems
    # As much of their folders' paths as tells these apart.
    depth = next(
        depth
        for depth in range(1, max(map(len, homes)) + 1)
        if len({(home[-depth:], stem) for home, stem in zip(homes, stems)}) == len(stems)
    )
    shared = {stem for stem in stems if stems.count(stem) > 1}
    one = len(set(stems)) == 1
    return [
        stem
        if stem not in shared
        else "_".join((*_without_common(homes, home, depth), *([] if one else [stem])))
        for stem, home in zip(stems, homes)
    ]


def _without_common(
    homes: Sequence[Tuple[str, ...]], home: Tuple[str, ...], depth: int
) -> Tuple[str, ...]:
    """The last parts of a folder's path, but for those at its end that all share."""
    end = depth
    while end > 1 and len({other[-1 - (depth - end)] for other in homes}) == 1:
        end -= 1
    return home[-depth:][:end]


def _in_folder(folder: Path, kinds: Sequence[Tuple[str, ...]]) -> List[Path]:
    """The files of the first kind that it has; where it has none, those of the folders in it."""
    taken = _directly_in(folder, kinds)
    below = [path for path in sorted(folder.iterdir(), key=_by_name) if _is_read_into(path)]
    if not taken:
        found = [path for path in below if _holds(path, kinds)]
        if found:
            return [path for home in found for path in _in_folder(home, kinds)]
        volumes = " and no label volume" if VOLUME_SUFFIXES in kinds else ""
        raise FileError(
            f"The folder {folder} holds no mesh{volumes} ({', '.join(sum(kinds, ()))})."
        )
    left = [path.name for path in below if _holds(path, kinds)]
    if left:
        warn(
            f"The folder {folder} holds files to read and folders of such files: the files are "
            f"taken, and not what is in {', '.join(left[:3])}{', …' if len(left) > 3 else ''}; "
            "give these folders by name."
        )
    return taken


def _is_read_into(path: Path) -> bool:
    """No folder of results, and none that systems hide."""
    return (
        path.is_dir()
        and not path.name.startswith((".", "__"))
        and not (path / RESULTS).is_file()
        and path.resolve() not in path.absolute().parents  # a circle
    )


def _holds(folder: Path, kinds: Sequence[Tuple[str, ...]]) -> bool:
    with silenced():
        return bool(_directly_in(folder, kinds)) or any(
            _holds(path, kinds) for path in folder.iterdir() if _is_read_into(path)
        )


def _by_name(path: Path):
    return _natural(path.name)


def _directly_in(folder: Path, kinds: Sequence[Tuple[str, ...]]) -> List[Path]:
    files = sorted(
        _inputs([p for p in folder.iterdir() if p.is_file() and not p.name.startswith("._")]),
        key=_by_name,
    )
    inside = [
        [
            path
            for path in files
            if (suffixes == SUFFIXES and _is_of_freesurfer(path))
            or (path.name.lower().endswith(suffixes) and not readers.NO_SURFACES.search(path.name))
        ]
        for suffixes in kinds
    ]
    if not any(inside):
        return []
    unnamed = [path.name for path in files if path not in inside[0] and readers.is_freesurfer(path)]
    if unnamed:
        warn(
            f"The folder {folder} holds surfaces of FreeSurfer's that are not called lh.… or rh.…: "
            f"they are not taken unless they are given by name ({', '.join(unnamed)})."
        )
    taken, *others = filter(None, inside)
    if others:
        names = ", ".join(path.name for path in others[0][:3])
        warn(
            f"The folder {folder} holds meshes and label volumes: the meshes are taken, and not "
            f"{names}{', …' if len(others[0]) > 3 else ''}."
        )
    return taken


def _is_of_freesurfer(path: Path) -> bool:
    """By its name, which has no suffix, and by what it holds: lh.curv is no surface."""
    return bool(readers.FREESURFER.match(path.name)) and readers.is_freesurfer(path)


def _natural(name: str):
    return [
        (0, int(part), "") if part.isdecimal() else (1, 0, part)
        for part in re.split(r"(\d+)", name.lower())
    ]


def read_mesh(path) -> Surface:
    """A mesh from a file: PLY, STL, OBJ, OFF and whatever else PyMeshLab reads; VTK, VTP, VTU,
    GIFTI and FreeSurfer's with the extra `surfaces`. Vertices that STL and VTK files split are
    merged.

    A file that says SPACE=LPS, as 3D Slicer writes, is turned into RAS; `space` of the surface is
    RAS where the file said one of the two.
    """
    return surface_in(path)[0]


def surface_in(path) -> Tuple[Surface, Dict[str, np.ndarray]]:
    """As read_mesh, and the numbers per vertex that a VTK file has beside it, by name."""
    with _reading(path) as path:
        found = readers.read(path)
        if found is not None:
            return Surface(found.vertices, found.faces, stem_of(path), found.space), found.scalars
        meshes, space = _load(path), readers.space_in_header(path)
    surface = layers.surface_of(meshes.current_mesh(), stem_of(path))
    vertices = readers.turned(space, surface.vertices)
    return Surface(vertices, surface.faces, surface.name, space and "RAS"), {}


def read_meshes(*paths) -> List[Surface]:
    """The meshes of files and folders, in order of time; see mesh_files."""
    files = mesh_files(*paths)
    surfaces = [replace(read_mesh(path), name=name) for path, name in zip(files, names_of(files))]
    warn_of_frames(surfaces)
    return surfaces


def warn_of_frames(surfaces: Sequence[Surface]) -> None:
    """Where some say their frame and others do not."""
    silent = [surface.name for surface in surfaces if not surface.space]
    telling = [surface.name for surface in surfaces if surface.space]
    if silent and telling:
        others = f" (and {count_others(len(silent) - 1)})" if len(silent) > 1 else ""
        warn(
            f"{silent[0]}{others} does not say whether it is in RAS or LPS, as {telling[0]} does: "
            "all are taken to be in RAS."
        )


def read_map(path) -> SphereMap:
    """The map to the sphere that a file carries as texture coordinates, certified; a FileError when
    it carries none."""
    with _reading(path) as path:
        if path.suffix.lower() in readers.SUFFIXES or readers.is_freesurfer(path):
            raise FileError(f"{path} carries no map: a PLY file can.")
        meshes = _load(path)
    mesh = meshes.current_mesh()
    if not mesh.has_vertex_tex_coord():
        raise FileError(f"{path} carries no map: it has no texture coordinates per vertex.")
    texture = mesh.vertex_tex_coord_matrix()
    longitude, colatitude = 2 * np.pi * texture[:, 0], np.pi * texture[:, 1]
    positions = np.stack(
        [
            np.sin(colatitude) * np.cos(longitude),
            np.sin(colatitude) * np.sin(longitude),
            np.cos(colatitude),
        ],
        1,
    )
    figures = filters.evaluate([layers.surface_of(mesh)], [positions])
    if not figures["valid"][0]:
        raise FileError(f"{path} carries no valid map: its texture coordinates are something else.")
    return SphereMap(positions, texture, layers.row(figures, 0, filters.MAP_FIGURES))


@contextmanager
def _reading(path) -> Iterator[Path]:
    """A file that is there. While one is read no other thread is at it: PyMeshLab goes to the
    file's folder, where relative paths mean something else."""
    path = path_of(path)
    with turn(f"Reading {path}"):
        if path.is_dir():
            raise FileError(f"{path} is a folder: read_meshes takes all meshes in it.")
        if not path.is_file():
            raise FileError(f"There is no file {path}.")
        if is_label_volume(path):
            raise FileError(
                f"{path} is a label volume: read_label_volume, and the command run, make surfaces "
                "of it."
            )
        yield path


def _load(path: Path):
    """A MeshSet with the mesh in a file that PyMeshLab opens, for one whose turn it is."""
    # PyMeshLab may crash over these.
    if path.suffix.lower() == ".ply" and not _has_ply_header(path):
        raise FileError(f"{path} cannot be read as a mesh. It has no PLY header.")
    if readers.faces_lack_vertices(path):
        raise FileError(f"{path} cannot be read as a mesh. Its faces name vertices that it lacks.")
    meshes = layers.mesh_set()
    with _plain_name(path) as name:
        here = os.getcwd()
        try:
            meshes.load_new_mesh(str(name))
        except Exception as error:  # PyMeshLab's, or what its parsers stumble over
            layers.keep(meshes)
            lines = [line.strip() for line in str(error).splitlines() if line.strip()]
            reason = " ".join(lines[1:] or [line for line in lines if "format" in line.lower()])
            reason = reason.replace(str(name), str(path))
            raise FileError(f"{path} cannot be read as a mesh. {reason}".strip()) from error
        finally:
            # PyMeshLab goes to the file's folder, and stays there when it cannot read the file.
            os.chdir(here)
    if meshes.current_mesh().face_number() == 0:
        raise FileError(f"{path} holds no triangles.")
    return meshes


@contextmanager
def _plain_name(path: Path) -> Iterator[Path]:
    """A file that PyMeshLab understands: in every locale, of which it loses other names where
    LC_ALL=C, and in the types that it knows."""
    path = path.resolve()
    plain = readers.plain_ply(path) if path.suffix.lower() == ".ply" else None
    if path.suffix.lower() == ".stl":
        readers.refuse_cut_off_stl(path)
    if plain is None and str(path).isascii():
        yield path
        return
    with tempfile.TemporaryDirectory() as folder:
        name = Path(folder) / f"mesh{path.suffix}"
        if plain is None:
            name.symlink_to(path)
        else:
            name.write_bytes(plain)
        yield name


def _has_ply_header(path: Path) -> bool:
    with open(path, "rb") as file:
        start = file.read(1 << 20)
    return start[:3] == b"ply" and b"end_header" in start


def write_ply(
    path,
    vertices,
    faces,
    colors: Optional[np.ndarray] = None,
    texture: Optional[np.ndarray] = None,
    *,
    space: str = "RAS",
    scalars: Optional[Mapping[str, np.ndarray]] = None,
) -> None:
    """A binary PLY file of floats. colors: (n, 3) in [0, 1]; texture: the map as (n, 2) texture
    coordinates; space: RAS or LPS, the frame of the vertices, which the file says as 3D Slicer
    reads it; scalars: more numbers per vertex, by name."""
    surface = Surface(vertices, faces, path_of(path).stem, space)
    vertices, faces, count = surface.vertices, surface.faces, len(surface.vertices)
    columns = [(name, "<f4", vertices[:, k]) for k, name in enumerate("xyz")]
    if colors is not None:
        colors = _per_vertex("colors", colors, (count, 3))
        opaque = np.c_[np.round(255 * np.clip(colors, 0, 1)), np.full(len(colors), 255)]
        columns += [
            (name, "u1", opaque[:, k]) for k, name in enumerate(("red", "green", "blue", "alpha"))
        ]
    if texture is not None:
        texture = _per_vertex("texture", texture, (count, 2))
        columns += [
            (name, "<f4", texture[:, k]) for k, name in enumerate(("texture_u", "texture_v"))
        ]
    if scalars is not None and not isinstance(scalars, Mapping):
        raise InputError(f"scalars must be a dictionary, not {type(scalars).__name__}.")
    for name, values in (scalars or {}).items():
        values = _per_vertex(name, values, (count,))
        columns.append((_property(name, [name for name, _, _ in columns]), "<f4", values))
    vertex = np.empty(len(vertices), [(name, kind) for name, kind, _ in columns])
    for name, _, values in columns:
        vertex[name] = values
    face = np.empty(len(faces), [("count", "u1"), ("indices", "<i4", 3)])
    face["count"], face["indices"] = 3, faces
    words = {"<f4": "float", "u1": "uchar"}
    header = ["ply", "format binary_little_endian 1.0", f"comment SPACE={surface.space or 'RAS'}"]
    header += [f"element vertex {len(vertex)}"]
    header += [f"property {words[kind]} {name}" for name, kind, _ in columns]
    header += [
        f"element face {len(face)}",
        "property list uchar int vertex_indices",
        "end_header",
        "",
    ]
    with turn(f"Writing {path}"):
        Path(path).write_bytes("\n".join(header).encode() + vertex.tobytes() + face.tobytes())


def _per_vertex(name: str, values, shape: Tuple[int, ...]) -> np.ndarray:
    found = array_of(name, values)
    if found.shape != shape or found.dtype.kind not in "biuf":
        raise InputError(
            f"{name} must be numbers of shape {shape}, not {found.dtype} of shape {found.shape}."
        )
    return found


def _property(name: str, taken: Sequence[str]) -> str:
    """A name that PLY allows, and that means nothing else."""
    word = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_") or "scalar"
    while word in taken or word in ("nx", "ny", "nz", "s", "t", "u", "v", "quality", "flags"):
        word += "_"
    return word
