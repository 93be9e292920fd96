# SPDX-License-Identifier: GPL-3.0-only
"""MeshLab's project files."""

from __future__ import annotations

import xml.etree.ElementTree as xml
from pathlib import Path
from typing import NamedTuple, Optional, Sequence

import numpy as np

# How MeshLab shows a layer, as it writes it into projects: solid, smooth shading, vertex colours.
# First which of solid, triangle wires, edges and points; then for points, edges, wires and solid
# which of position, vertex normal, face normal, vertex colour, face colour, two kinds of texture
# and of index; then 17 + 15 switches, of which: visible, lit from one side; fixed colours for boxes
# and wires, wires without shading, points smaller with distance. Points have no position: with one
# MeshLab 2025.07 draws them after the first filter.
SHOWN = (
    "1000"
    + "010100000"
    + "000000000"
    + "000000000"
    + "110100010"
    + "10000000000100000"
    + "010100000001001"
)


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
        mesh = xml.SubElement(
            group, "MLMesh", label=layer.label, filename=filename, visible=str(int(layer.visible))
        )
        matrix = np.eye(4) if layer.matrix is None else layer.matrix
        rows = "".join(" ".join(f"{value:.9g}" for value in row) + " \n" for row in matrix)
        xml.SubElement(mesh, "MLMatrix44").text = "\n" + rows
        xml.SubElement(
            mesh,
            "RenderingOption",
            pointSize="3",
            wireWidth="1",
            boxColor="234 234 234 255",
            pointColor="131 149 69 255",
            wireColor="64 64 64 255",
            solidColor="192 192 192 255",
        ).text = SHOWN
    xml.SubElement(root, "RasterGroup")
    text = (
        xml.tostring(root, encoding="unicode")
        .replace("<MLMesh", "\n <MLMesh")
        .replace("</MeshGroup>", "\n</MeshGroup>")
    )
    path.write_text("<!DOCTYPE MeshLabDocument>\n" + text + "\n", encoding="utf-8")
