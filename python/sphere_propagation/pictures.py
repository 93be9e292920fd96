# SPDX-License-Identifier: GPL-3.0-only
"""Pictures of maps, landmarks and errors as PNG files, rendered off screen with PyVista and set
with Matplotlib.

All surfaces of one picture are seen from one side and at one scale, so that what moves is the heart
and not the camera.
"""

from __future__ import annotations

import ctypes
import os
import sys
from functools import lru_cache
from importlib.util import find_spec
from typing import Sequence

import numpy as np

from .colors import landmark_colors, map_colors, sphere_coordinates
from .correspondence import Correspondence
from .views import Row, chosen_phases, sphere_rotation, upright

if sys.platform.startswith("linux") and not os.environ.get("DISPLAY"):
    # No display: say so instead of trying one.
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")

WIDTH = 2400  # pixels
NEEDED = ("matplotlib", "pyvista")  # the extra `pictures`
INK, GREY = "#1c2530", "#5b6570"
PUBLISHED, ROBUST = "#c2410c", "#0f766e"


def what_is_missing() -> str:
    """What keeps pictures from being drawn here, and how to get it; empty when nothing does."""
    missing = [name for name in NEEDED if find_spec(name) is None]
    if missing:
        return f"{' and '.join(missing)} not installed (pip install 'sphere-propagation[pictures]')"
    if sys.platform.startswith("linux") and not os.environ.get("DISPLAY"):
        try:  # VTK would crash
            ctypes.CDLL("libEGL.so.1")
        except OSError:
            return (
                "there is no display, and libEGL.so.1 is missing (on Debian and Ubuntu: apt-get "
                "install libegl1)"
            )
    return ""


# ---------------------------------------------------------------- the pictures


def landmarks_over_cycle(rows: Sequence[Row], path, columns: int = 6) -> None:
    """The landmarks of some phases: same colour, same landmark (figure 2 of the paper)."""

    def draw(scene, result, phase):
        surface, points = result.surfaces[phase], result.landmarks[phase]
        scene.surface(
            surface.vertices, surface.faces, np.full((len(surface.vertices), 3), [0.93, 0.93, 0.95])
        )
        scene.balls(points, landmark_colors(len(points)), 0.27 * _spacing(result))

    count = rows[0].result.landmarks.shape[1]
    _phases(
        rows,
        path,
        columns,
        draw,
        f"{count} landmarks on every phase: the same colour is the same landmark",
        count,
    )


def maps_over_cycle(rows: Sequence[Row], path, columns: int = 6) -> None:
    """One checkerboard of the sphere, drawn on some phases through their maps: same field, same
    place."""

    def draw(scene, result, phase):
        surface = result.surfaces[phase]
        scene.checkerboard(surface.vertices, surface.faces, result.maps[phase].positions)

    _phases(
        rows,
        path,
        columns,
        draw,
        "Latitude and longitude of the sphere on every phase: the same field is the same place",
    )


def root_and_sphere(rows: Sequence[Row], path) -> None:
    """Each root beside its sphere, both with the sphere's latitudes and longitudes."""
    panels, size = [], 560
    for row in rows:
        result = row.result
        surface, positions = result.surfaces[result.root], result.maps[result.root].positions
        rotation = upright(surface.vertices, row.up)
        seen = surface.vertices @ rotation.T
        center = (seen.min(0) + seen.max(0)) / 2
        turned = positions @ sphere_rotation(seen, positions).T
        half = np.abs(seen - center)[:, :2].max()
        for vertices, extent in ((seen - center, half), (turned, 1.0)):
            scene = Scene(np.eye(3), np.zeros(3), np.full(2, 1.06 * extent), size / (2.12 * extent))
            scene.checkerboard(vertices, surface.faces, positions, spherical=vertices is turned)
            panels.append(scene.image())
    captions = []
    for row in rows:
        figures, root = row.result.figures, row.result.root
        whose = f"{row.title}, " if len(rows) > 1 else ""
        captions += [
            f"{whose}{len(row.result.surfaces[root].faces)} triangles",
            f"{figures['flipped_faces'][root]:.0f} flips, area ratio sd "
            f"{figures['area_ratio_sd'][root]:.4f}",
        ]
    _set([panels], [captions], path, "A surface and its area-preserving map to the sphere")


def errors_over_phase(rows: Sequence[Row], errors: Sequence[dict], path) -> None:
    """Error against known material points, one panel per row; `errors`: method -> mm per phase, one
    dict per row."""
    plt = matplotlib_pyplot()
    figure, axes = plt.subplots(
        1, len(rows), figsize=(5.2 * len(rows) + 0.6, 4.2), dpi=200, sharey=True, squeeze=False
    )
    top = max(values.max() for found in errors for values in found.values())
    for axis, row, found in zip(axes[0], rows, errors):
        for (method, values), color in zip(found.items(), (ROBUST, PUBLISHED)):
            label = f"{method}: {values.max():.1f} mm worst, {values.mean():.1f} mm mean"
            axis.plot(values, color=color, lw=2.4, marker="o", ms=4, label=label)
        axis.set_title(row.title, fontsize=13, color=INK, loc="left", weight="bold")
        axis.set_xlabel("phase", fontsize=11, color=GREY)
        axis.set_xlim(-0.5, len(values) - 0.5)
        axis.set_ylim(0, 1.3 * top)
        # None behind the legend.
        axis.set_yticks([tick for tick in axis.get_yticks() if 0 <= tick <= 1.05 * top])
        quiet_axes(axis)
        axis.legend(
            fontsize=10.5,
            loc="upper left",
            labelcolor=INK,
            frameon=True,
            framealpha=1,
            edgecolor="white",
        )
    axes[0][0].set_ylabel(
        "mean distance of landmarks\nfrom their material points, mm", fontsize=11, color=GREY
    )
    figure.tight_layout(w_pad=2.5)
    figure.savefig(path, facecolor="white")
    plt.close(figure)


# ---------------------------------------------------------------- what they share


def _phases(rows, path, columns, draw, title, landmark_count=0):
    lines = []  # of the picture: row and its phases
    for row in rows:
        phases = chosen_phases(len(row.result.surfaces), columns, 2 if len(rows) == 1 else 1)
        lines += [(row, phases[i : i + columns]) for i in range(0, len(phases), columns)]
    frames = []
    for row in rows:
        root = row.result.surfaces[row.result.root]
        rotation = upright(root.vertices, row.up)
        seen = np.concatenate([surface.vertices for surface in row.result.surfaces]) @ rotation.T
        low, high = seen.min(0), seen.max(0)
        frames.append(
            (rotation, (low + high) / 2, (high - low)[:2] / 2 + 0.6 * _spacing(row.result))
        )
    width = max(extent[0] for _, _, extent in frames)
    scale = WIDTH / (2.1 * width * max(len(phases) for _, phases in lines))
    panels, captions, names = [], [], []
    for row, phases in lines:
        rotation, center, extent = frames[[other is row for other in rows].index(True)]
        panels.append([])
        captions.append([])
        names.append(row.title)
        for phase in phases:
            scene = Scene(rotation, center, np.array([width, extent[1]]), scale)
            draw(scene, row.result, phase)
            panels[-1].append(scene.image())
            surface = row.result.surfaces[phase]
            captions[-1].append(
                f"phase {row.numbers()[phase]}, {abs(surface.volume) / 1000:.0f} ml"
                if row.unit == "mm"
                else surface.name
            )
    _set(panels, captions, path, title, names, landmark_count)


def _set(panels, captions, path, title, names: Sequence[str] = (), landmark_count: int = 0):
    """Rows of images with captions on one white page."""
    plt = matplotlib_pyplot()
    gap, line, margin, header = 26, 54, 40, 110
    footer = 120 if landmark_count else 40
    width = (
        max(sum(image.shape[1] for image in row) + gap * (len(row) - 1) for row in panels)
        + 2 * margin
    )
    named = [
        bool(names) and (i == 0 or names[i] != names[i - 1]) and len(set(names)) > 1
        for i in range(len(panels))
    ]
    heights = [row[0].shape[0] + line + (line if name else 0) for row, name in zip(panels, named)]
    height = header + sum(heights) + gap * (len(panels) - 1) + footer
    dpi = 200
    figure = plt.figure(figsize=(width / dpi, height / dpi), dpi=dpi, facecolor="white")
    points = 72 / dpi  # per pixel

    def text(x, y, words, size, **style):
        figure.text(x / width, 1 - y / height, words, fontsize=size * points, **style)

    text(
        margin,
        62,
        title,
        min(40, (width - 2 * margin) / (0.68 * len(title))),
        color=INK,
        weight="bold",
        va="center",
    )
    top = header
    for i, (row, words) in enumerate(zip(panels, captions)):
        y = top
        if named[i]:
            text(margin, y + line / 2, names[i], 34, color=INK, va="center")
            y += line
        x = margin
        for image, caption in zip(row, words):
            h, w = image.shape[:2]
            axis = figure.add_axes([x / width, 1 - (y + h) / height, w / width, h / height])
            axis.imshow(image, interpolation="none", aspect="auto")
            axis.axis("off")
            text(x + w / 2, y + h + line / 2, caption, 30, color=GREY, ha="center", va="center")
            x += w + gap
        top += heights[i] + gap
    if landmark_count:
        bar = figure.add_axes([0.36, 66 / height, 0.28, 22 / height])
        bar.imshow(landmark_colors(landmark_count)[None], aspect="auto", interpolation="none")
        bar.axis("off")
        text(0.353 * width, height - 77, "landmark 0", 26, color=GREY, ha="right", va="center")
        text(
            0.647 * width,
            height - 77,
            f"{landmark_count - 1}",
            26,
            color=GREY,
            ha="left",
            va="center",
        )
    figure.savefig(path, facecolor="white")
    plt.close(figure)


def _spacing(result: Correspondence) -> float:
    """Typical distance of neighbouring landmarks at the root."""
    points, faces = result.landmarks[result.root], result.landmark_faces
    return float(np.median(np.linalg.norm(points[faces[:, 0]] - points[faces[:, 1]], axis=1)))


def matplotlib_pyplot():
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    return plt


def quiet_axes(axis, both: bool = False) -> None:
    """A light grid, across or both ways, and no frame."""
    axis.grid(axis="both" if both else "y", color="#e5e7eb", lw=1)
    axis.set_axisbelow(True)
    axis.tick_params(colors=GREY, length=0, labelleft=True)
    for side in ("top", "right", "left"):
        axis.spines[side].set_visible(False)
    axis.spines["bottom"].set_color("#9ca3af")


class Scene:
    """One picture without text, on white, in parallel projection.

    rotation, center: to view coordinates, and what is in the middle there; extent: half width and
    height in the surfaces' unit;
    scale: pixels per unit.
    """

    def __init__(self, rotation, center, extent, scale):
        import pyvista

        self.pyvista, self.rotation, self.center = pyvista, rotation, center
        size = np.maximum(2 * np.round(extent * scale), 2).astype(int)
        self.plotter = pyvista.Plotter(
            off_screen=True, window_size=[int(n) for n in size], lighting="none"
        )
        self.plotter.set_background("white")
        for position, intensity in (
            ((-1.0, 1.6, 2.2), 0.80),
            ((1.6, 0.2, 1.6), 0.34),
            ((0, -1.5, 1.0), 0.16),
        ):
            self.plotter.add_light(
                pyvista.Light(
                    position=position,
                    focal_point=(0, 0, 0),
                    intensity=intensity,
                    light_type="scene light",
                )
            )
        far = 10 * extent.max()
        self.plotter.camera_position = [(0, 0, far), (0, 0, 0), (0, 1, 0)]
        self.plotter.camera.parallel_projection = True
        self.plotter.camera.parallel_scale = size[1] / 2 / scale
        self.plotter.camera.clipping_range = (0.01 * far, 2 * far)

    def surface(self, vertices, faces, colors, normals=None):
        seen = vertices @ self.rotation.T - self.center
        mesh = self.pyvista.PolyData(seen, np.c_[np.full(len(faces), 3), faces].ravel())
        mesh.point_data.active_normals = _soft_normals(seen, faces) if normals is None else normals
        self._add(mesh, colors)

    def checkerboard(self, vertices, faces, positions, spherical=False):
        """A surface with its map's latitudes and longitudes. spherical: the surface is the sphere
        itself."""
        seen = vertices @ self.rotation.T - self.center
        mesh = self.pyvista.PolyData(seen, np.c_[np.full(len(faces), 3), faces].ravel())
        mesh["normal"] = _soft_normals(seen, faces)
        mesh["position"] = positions
        if len(faces) < 100_000:
            mesh = mesh.subdivide(2 if len(faces) < 25_000 else 1, "linear")
        corners = mesh.faces.reshape(-1, 4)[
            :, 1:
        ].ravel()  # each triangle gets corners of its own: longitudes jump at the date line
        points, normals, positions = (
            np.asarray(values)[corners]
            for values in (mesh.points, mesh["normal"], mesh["position"])
        )
        if spherical:
            points = normals = points / np.linalg.norm(points, axis=1, keepdims=True)
        longitude, latitude = sphere_coordinates(
            positions / np.linalg.norm(positions, axis=1, keepdims=True)
        )
        triple, first = longitude.reshape(-1, 3), longitude[::3, None]
        triple = first + (triple - first + 0.5) % 1 - 0.5
        at_pole = np.abs(latitude.reshape(-1, 3)) > 1 - 1e-9
        triple = np.where(
            at_pole,
            (triple * ~at_pole).sum(1, keepdims=True)
            / np.maximum((~at_pole).sum(1, keepdims=True), 1),
            triple,
        )
        fine = self.pyvista.PolyData(
            points,
            np.c_[np.full(len(triple), 3), np.arange(3 * len(triple)).reshape(-1, 3)].ravel(),
        )
        fine.point_data.active_normals = np.asarray(normals, np.float32)
        fine.active_texture_coordinates = np.c_[
            (triple.ravel() + 1) / 3, (latitude + 1) / 2
        ].astype(np.float32)
        self._add(fine, texture=_checkerboard_texture(self.pyvista))

    def balls(self, centers, colors, radius):
        cloud = self.pyvista.PolyData(centers @ self.rotation.T - self.center)
        cloud["colors"] = _bytes(colors)
        ball = self.pyvista.Sphere(radius=radius, theta_resolution=14, phi_resolution=14)
        self._add(cloud.glyph(geom=ball, scale=False, orient=False), ambient=0.42, specular=0.0)

    def _add(self, mesh, colors=None, ambient=0.30, specular=0.10, texture=None):
        if colors is not None:
            mesh["colors"] = _bytes(colors)
        paint = {"texture": texture} if texture is not None else {"scalars": "colors", "rgb": True}
        actor = self.plotter.add_mesh(
            mesh, **paint, ambient=ambient, diffuse=0.80, specular=specular, specular_power=18
        )
        actor.prop.interpolation = "Phong"

    def image(self) -> np.ndarray:
        self.plotter.enable_anti_aliasing("ssaa")
        picture = self.plotter.screenshot(None, return_img=True)
        self.plotter.close()
        return picture


@lru_cache(maxsize=1)
def _checkerboard_texture(pyvista):
    """Three turns of longitude side by side, so that a triangle across the date line finds its
    colours."""
    longitude, latitude = (np.arange(2016) + 0.5) / 2016, (np.arange(1000, 0, -1) - 0.5) / 500 - 1
    texture = pyvista.Texture(
        np.tile(_bytes(map_colors(longitude[None], latitude[:, None])), (1, 3, 1))
    )
    texture.interpolate, texture.mipmap = True, True
    return texture


def _bytes(colors):
    return np.round(255 * np.clip(colors, 0, 1)).astype(np.uint8)


def _soft_normals(vertices, faces, rounds=3):
    """Vertex normals, averaged over neighbours so that the steps of voxels do not show."""
    a = vertices[faces]
    face = np.cross(a[:, 1] - a[:, 0], a[:, 2] - a[:, 0])
    for _ in range(rounds + 1):
        sums = np.stack(
            [np.bincount(faces.ravel(), np.repeat(face[:, k], 3), len(vertices)) for k in range(3)],
            1,
        )
        normals = sums / np.maximum(np.linalg.norm(sums, axis=1, keepdims=True), 1e-300)
        face = normals[faces].mean(1)
    return normals
