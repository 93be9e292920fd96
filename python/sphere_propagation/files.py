"""Meshes in folders, PLY files with maps and colours, and MeshLab projects."""
from __future__ import annotations

import re
import xml.etree.ElementTree as xml
from pathlib import Path
from typing import List, NamedTuple, Optional, Sequence

import numpy as np

from . import plugin
from .pipeline import PipelineError, Surface

SUFFIXES = (".ply", ".stl", ".obj", ".off")


def mesh_files(folder) -> List[Path]:
    """The meshes of a folder in natural order: phase_2 before phase_10."""
    folder = Path(folder)
    if not folder.is_dir():
        raise PipelineError(f"There is no folder {folder}.")
    natural = lambda path: [(0, int(part), "") if part.isdigit() else (1, 0, part) for part in re.split(r"(\d+)", path.name.lower())]
    paths = sorted((path for path in folder.iterdir() if path.suffix.lower() in SUFFIXES and path.is_file()), key=natural)
    if not paths:
        raise PipelineError(f"The folder {folder} holds no mesh ({', '.join(SUFFIXES)}).")
    for a, b in zip(paths, paths[1:]):
        if a.stem == b.stem:
            raise PipelineError(f"{a.name} and {b.name} have the same name: layers could not be told apart.")
    return paths


def read_mesh(path) -> Surface:
    """A mesh from a file, as PyMeshLab reads it (duplicated vertices of STL files are merged)."""
    path = Path(path)
    meshes = plugin.load().MeshSet()
    try:
        meshes.load_new_mesh(str(path))
    except Exception as error:  # pymeshlab.PyMeshLabException
        reason = " ".join(line.strip() for line in str(error).splitlines()[1:] if line.strip())
        raise PipelineError(f"{path} cannot be read. {reason}".strip()) from error
    mesh = meshes.current_mesh()
    if mesh.face_number() == 0:
        raise PipelineError(f"{path} holds no triangles.")
    return Surface(path.stem, mesh.vertex_matrix(), mesh.face_matrix())


def write_ply(path, vertices, faces, colors: Optional[np.ndarray] = None, texture: Optional[np.ndarray] = None) -> None:
    """A binary PLY file of floats. colors: (n, 3) in [0, 1]; texture: the map as (n, 2) texture coordinates."""
    columns = [(name, "<f4", vertices[:, k]) for k, name in enumerate("xyz")]
    if colors is not None:
        opaque = np.c_[np.round(255 * np.clip(colors, 0, 1)), np.full(len(colors), 255)]
        columns += [(name, "u1", opaque[:, k]) for k, name in enumerate(("red", "green", "blue", "alpha"))]
    if texture is not None:
        columns += [(name, "<f4", texture[:, k]) for k, name in enumerate(("texture_u", "texture_v"))]
    vertex = np.empty(len(vertices), [(name, kind) for name, kind, _ in columns])
    for name, _, values in columns:
        vertex[name] = values
    face = np.empty(len(faces), [("count", "u1"), ("indices", "<i4", 3)])
    face["count"], face["indices"] = 3, faces
    words = {"<f4": "float", "u1": "uchar"}
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertex)}"]
    header += [f"property {words[kind]} {name}" for name, kind, _ in columns]
    header += [f"element face {len(face)}", "property list uchar int vertex_indices", "end_header", ""]
    Path(path).write_bytes("\n".join(header).encode() + vertex.tobytes() + face.tobytes())


# How MeshLab shows a layer, as it writes it into projects: solid, smooth shading, vertex colours. First which of solid, triangle
# wires, edges and points; then for points, edges, wires and solid which of position, vertex normal, face normal, vertex colour, face
# colour, two kinds of texture and of index; then 17 + 15 switches, of which: visible, lit from one side; fixed colours for boxes and
# wires, wires without shading, points smaller with distance.
SHOWN = "1000" + "110100000" + "000000000" + "000000000" + "110100010" + "10000000000100000" + "010100000001001"


class ProjectLayer(NamedTuple):
    label: str
    path: Path
    visible: bool = True
    matrix: Optional[np.ndarray] = None  # 4 x 4; default: the identity


def write_project(path, layers: Sequence[ProjectLayer]) -> None:
    """A MeshLab project; the layers' files lie in the project's folder or below it."""
    path = Path(path)
    root = xml.Element("MeshLabProject")
    group = xml.SubElement(root, "MeshGroup")
    for layer in layers:
        filename = layer.path.relative_to(path.parent).as_posix()
        mesh = xml.SubElement(group, "MLMesh", label=layer.label, filename=filename, visible=str(int(layer.visible)))
        matrix = np.eye(4) if layer.matrix is None else layer.matrix
        rows = "".join(" ".join(f"{value:.9g}" for value in row) + " \n" for row in matrix)
        xml.SubElement(mesh, "MLMatrix44").text = "\n" + rows
        xml.SubElement(mesh, "RenderingOption", pointSize="3", wireWidth="1", boxColor="234 234 234 255", pointColor="131 149 69 255",
                       wireColor="64 64 64 255", solidColor="192 192 192 255").text = SHOWN
    xml.SubElement(root, "RasterGroup")
    text = xml.tostring(root, encoding="unicode").replace("<MLMesh", "\n <MLMesh").replace("</MeshGroup>", "\n</MeshGroup>")
    path.write_text("<!DOCTYPE MeshLabDocument>\n" + text + "\n", encoding="utf-8")
