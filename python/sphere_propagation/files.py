# SPDX-License-Identifier: GPL-3.0-only
"""Mesh files and the maps in them; which files are label volumes."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Dict, List, Optional, Tuple

import numpy as np

from . import filters, layers
from .errors import FileError
from .sphere_map import SphereMap
from .surface import Surface
from .turns import turn

SUFFIXES = (".ply", ".stl", ".obj", ".off")
VOLUME_SUFFIXES = (".nii", ".nii.gz", ".hdr", ".img", ".hdr.gz", ".img.gz", ".nrrd", ".nhdr")
VOLUME_SUFFIXES += (".mha", ".mhd")
APPLE_DOUBLE = b"\0\5\x16\7"  # how macOS's files begin


def mesh_files(*paths) -> List[Path]:
    """The mesh files that files and folders stand for, in order of time.

    A folder stands for its meshes in natural order: phase_2 before phase_10. Files whose names
    differ in their numbers alone come in the order of these numbers, whatever a shell's * makes of
    them; otherwise the order is kept.
    """
    return _in_order(paths, SUFFIXES)


def input_files(*paths) -> List[Path]:
    """As mesh_files, but a folder without meshes stands for its label volumes."""
    return _in_order(paths, SUFFIXES, VOLUME_SUFFIXES)


def is_label_volume(path) -> bool:
    return Path(path).name.lower().endswith(VOLUME_SUFFIXES)


def stem_of(path) -> str:
    """A file's name without its suffix; .nii.gz is one."""
    path = Path(path)
    packed = path.name.lower().endswith((".nii.gz", ".hdr.gz", ".img.gz"))
    return path.name[: -len(".nii.gz")] if packed else path.stem


def _inputs(files: List[Path]) -> List[Path]:
    """Without what macOS keeps beside files on foreign disks (._name), and without the voxels of a
    pair (.img), which its header (.hdr) stands for."""

    def of_macos(path: Path) -> bool:
        if not path.name.startswith("._") or not path.is_file():
            return False
        with open(path, "rb") as file:
            return file.read(4) == APPLE_DOUBLE

    def ends(path: Path, *suffixes: str) -> bool:
        return path.name.lower().endswith(suffixes)

    headers = {path.with_name(stem_of(path)) for path in files if ends(path, ".hdr", ".hdr.gz")}
    return [
        path
        for path in files
        if not of_macos(path)
        and not (ends(path, ".img", ".img.gz") and path.with_name(stem_of(path)) in headers)
    ]


def _in_order(paths, *kinds: Tuple[str, ...]) -> List[Path]:
    """kinds: suffixes; a folder stands for the first kind that it has."""
    found: List[Path] = []
    given = [Path(path) for path in paths]
    given = _inputs(given) or given
    if len({re.sub(r"\d+", "#", str(path)) for path in given}) == 1:
        given.sort(key=lambda path: _natural(str(path)))
    for path in given:
        if path.is_dir():
            files = sorted(
                _inputs([file for file in path.iterdir() if file.is_file()]),
                key=lambda file: _natural(file.name),
            )
            inside = [
                [file for file in files if file.name.lower().endswith(suffixes)]
                for suffixes in kinds
            ]
            if not any(inside):
                volumes = " and no label volume" if VOLUME_SUFFIXES in kinds else ""
                raise FileError(
                    f"The folder {path} holds no mesh{volumes} ({', '.join(sum(kinds, ()))})."
                )
            found += next(filter(None, inside))
        elif path.is_file():
            found.append(path)
        else:
            raise FileError(f"There is no file or folder {path}.")
    stems: Dict[str, Path] = {}
    for path in found:
        if stem_of(path) in stems:
            raise FileError(
                f"{stems[stem_of(path)]} and {path} have the same name: layers could not be told "
                "apart."
            )
        stems[stem_of(path)] = path
    return found


def _natural(name: str):
    return [
        (0, int(part), "") if part.isdecimal() else (1, 0, part)
        for part in re.split(r"(\d+)", name.lower())
    ]


def read_mesh(path) -> Surface:
    """A mesh from a file (PLY, STL, OBJ, OFF and whatever else PyMeshLab reads; duplicated vertices
    of STL files are merged)."""
    meshes, path = _load(path)
    return layers.surface_of(meshes.current_mesh(), path.stem)


def read_meshes(*paths) -> List[Surface]:
    """The meshes of files and folders, in order of time; see mesh_files."""
    return [read_mesh(path) for path in mesh_files(*paths)]


def read_map(path) -> SphereMap:
    """The map to the sphere that a file carries as texture coordinates, certified; a FileError when
    it carries none."""
    meshes, path = _load(path)
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


def _load(path):
    path = Path(path)
    if not path.is_file():
        raise FileError(f"There is no file {path}.")
    if path.suffix.lower() == ".ply" and not _has_ply_header(path):
        # PyMeshLab may crash over these.
        raise FileError(f"{path} cannot be read as a mesh. It has no PLY header.")
    meshes = layers.mesh_set()
    with turn(f"Reading {path}"):
        here = os.getcwd()
        try:
            meshes.load_new_mesh(str(path.resolve()))
        except Exception as error:  # PyMeshLab's, or what its parsers stumble over
            layers.keep(meshes)
            lines = [line.strip() for line in str(error).splitlines() if line.strip()]
            reason = " ".join(lines[1:] or [line for line in lines if "format" in line.lower()])
            raise FileError(f"{path} cannot be read as a mesh. {reason}".strip()) from error
        finally:
            # PyMeshLab goes to the file's folder, and stays there when it cannot read the file.
            os.chdir(here)
    if meshes.current_mesh().face_number() == 0:
        raise FileError(f"{path} holds no triangles.")
    return meshes, path


def _has_ply_header(path: Path) -> bool:
    with open(path, "rb") as file:
        start = file.read(1 << 20)
    return start[:3] == b"ply" and b"end_header" in start


def write_ply(
    path, vertices, faces, colors: Optional[np.ndarray] = None, texture: Optional[np.ndarray] = None
) -> None:
    """A binary PLY file of floats. colors: (n, 3) in [0, 1]; texture: the map as (n, 2) texture
    coordinates."""
    columns = [(name, "<f4", vertices[:, k]) for k, name in enumerate("xyz")]
    if colors is not None:
        opaque = np.c_[np.round(255 * np.clip(colors, 0, 1)), np.full(len(colors), 255)]
        columns += [
            (name, "u1", opaque[:, k]) for k, name in enumerate(("red", "green", "blue", "alpha"))
        ]
    if texture is not None:
        columns += [
            (name, "<f4", texture[:, k]) for k, name in enumerate(("texture_u", "texture_v"))
        ]
    vertex = np.empty(len(vertices), [(name, kind) for name, kind, _ in columns])
    for name, _, values in columns:
        vertex[name] = values
    face = np.empty(len(faces), [("count", "u1"), ("indices", "<i4", 3)])
    face["count"], face["indices"] = 3, faces
    words = {"<f4": "float", "u1": "uchar"}
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertex)}"]
    header += [f"property {words[kind]} {name}" for name, kind, _ in columns]
    header += [
        f"element face {len(face)}",
        "property list uchar int vertex_indices",
        "end_header",
        "",
    ]
    Path(path).write_bytes("\n".join(header).encode() + vertex.tobytes() + face.tobytes())
