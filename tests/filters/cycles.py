# SPDX-License-Identifier: GPL-3.0-only
"""Whole heart cycles, and the pipeline over them: root map, propagation, evaluation, remeshing."""

import dataclasses
import functools

import documents
import pymeshlab
from documents import EVALUATE, PHANTOM, PROPAGATE, REMESH, ROOT
from environment import files_of, yardstick

METHODS = ["Robust", "As published"]
ORDERS = ["Time", "Cyclic time"]
SEQUENCES = ["phantom cavity", "phantom wall", "heart_cine", "heart_truth"]
VOXEL = {"cavity": 2.0, "wall": 2.6}  # mm
OTHER_SEED = 5  # of the phantoms that the yardstick makes; the filter's own default is 0


def project_of(sequence):
    """A new project with the surfaces of one cycle; phase 0 is the current layer and has the number
    0.

    sequence: one of SEQUENCES, or "yardstick cavity" or "yardstick wall" for meshes made by the
    yardstick's phantom.
    """
    ms = pymeshlab.MeshSet()
    kind, _, part = sequence.partition(" ")
    if kind == "phantom":
        ms.apply_filter(PHANTOM, part=part.capitalize(), voxel_size=VOXEL[part])
    elif kind == "yardstick":
        for t, (v, f) in enumerate(yardstick_phantom(part)):
            documents.add(ms, v, f, f"{part} {t:02d}")
    else:
        for path in files_of(
            {"heart_cine": "heart_cine", "heart_truth": "heart_truth/mc"}[sequence]
        ):
            ms.load_new_mesh(str(path))
    ms.set_current_mesh(0)
    return ms


@functools.lru_cache(maxsize=None)
def yardstick_phantom(part):
    return [yardstick("phantom").Ventricle(part, OTHER_SEED).mesh(t) for t in range(25)]


@dataclasses.dataclass
class Run:
    """The pipeline over one cycle: what came back, and what the layers hold."""

    root: dict
    propagation: dict
    evaluation: dict
    remeshing: dict
    surfaces: list  # (vertices, faces) per layer
    maps: list  # the attribute, n x 3 per layer
    texture_maps: list  # what the texture coordinates stand for, n x 3 per layer
    figures: list  # the yardstick's, from the attribute, per layer
    landmarks: list  # 1002 x 3 per layer
    landmark_faces: list
    landmark_colours: list


@functools.lru_cache(maxsize=None)
def run_pipeline(sequence, method, order):
    """Root map of phase 0, propagation, evaluation and remeshing; computed once per test
    session."""
    measure = yardstick("measure")
    ms = project_of(sequence)
    surfaces = documents.layers(ms)
    root = ms.apply_filter(ROOT)
    propagation = ms.apply_filter(PROPAGATE, method=method, order=order)
    evaluation = ms.apply_filter(EVALUATE)
    remeshing = ms.apply_filter(REMESH)
    made = documents.layers(ms)[len(surfaces) :]
    geometry = [(m.vertex_matrix(), m.face_matrix()) for m in surfaces]
    maps = [documents.positions(m) for m in surfaces]
    return Run(
        root,
        propagation,
        evaluation,
        remeshing,
        surfaces=geometry,
        maps=maps,
        texture_maps=[documents.texture_positions(m) for m in surfaces],
        figures=[measure.map_figures(v, f, s) for (v, f), s in zip(geometry, maps)],
        landmarks=[m.vertex_matrix() for m in made],
        landmark_faces=[m.face_matrix() for m in made],
        landmark_colours=[m.vertex_color_matrix() for m in made],
    )
