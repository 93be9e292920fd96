# SPDX-License-Identifier: GPL-3.0-only
"""Pictures of maps, landmarks and errors, rendered off screen with VTK.

All surfaces of one picture are seen from one side and at one scale, so that what moves is the heart
and not the camera.
"""

from __future__ import annotations

import ctypes
import os
import sys
from functools import lru_cache
from importlib.util import find_spec
from typing import List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from .colors import map_colors, place_colors, sphere_coordinates
from .correspondence import Correspondence
from .drawing import GREY, Drawing, extent_of
from .filters import landmark_places
from .plots import panels
from .surface import Surface
from .views import Row, chosen_phases, sphere_rotation, upright

if sys.platform.startswith("linux") and not os.environ.get("DISPLAY"):
    # No display: say so instead of trying one.
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")

# Pixels: of all surfaces in a line of a picture, which the report shows 1124 wide with what is
# between and beside them; and of one surface.
WIDTH, MAX_HEIGHT = 1060, 440
COLUMNS = 6  # of surfaces in a picture
# Pictures are rendered so many times as wide and high, and reduced: without a graphics card that
# takes half the time of the renderer's own anti-aliasing.
FINER = 2
Place = Tuple[int, int, int, int]  # of a panel in its picture, in pixels: left, top, width, height
NEEDED = ("matplotlib", "vtk")  # the extra `pictures`
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


def landmarks_on_surfaces(rows: Sequence[Row], path, columns: int = COLUMNS) -> None:
    """The landmarks of some surfaces: same colour, same landmark (figure 2 of the paper)."""

    def draw(panel, result, i):
        surface, points, faces = result.surfaces[i], result.landmarks[i], result.landmark_faces
        grey = np.full((len(surface.vertices), 3), [0.93, 0.93, 0.95])
        panel.surface(surface.vertices, surface.faces, grey, _normals_of(surface))
        panel.balls(points, colors_of_landmarks(result), 0.27 * _spacing(result), faces)

    count = rows[0].result.landmarks.shape[1]
    _surfaces(
        rows,
        path,
        columns,
        draw,
        f"{count} landmarks on every {rows[0].noun}: the same colour is the same landmark",
        key=True,
    )


def maps_on_surfaces(rows: Sequence[Row], path, columns: int = COLUMNS) -> None:
    """One checkerboard of the sphere, drawn on some surfaces through their maps: same field, same
    place."""

    def draw(panel, result, i):
        surface, positions = result.surfaces[i], result.maps[i].positions
        panel.checkerboard(surface.vertices, surface.faces, positions, _normals_of(surface))

    _surfaces(
        rows,
        path,
        columns,
        draw,
        f"Latitude and longitude of the sphere on every {rows[0].noun}: the same field is the same "
        "place",
    )


def root_and_sphere(rows: Sequence[Row], path) -> None:
    """Each root beside its sphere, both with the sphere's latitudes and longitudes."""
    size = 340  # of which two are about as wide as the report shows them
    scene, places = Scene(size * 2 * len(rows), size), []
    for row in rows:
        result = row.result
        surface, positions = result.surfaces[result.root], result.maps[result.root].positions
        rotation = upright(surface.vertices, row.up)
        seen = surface.vertices @ rotation.T
        center = (seen.min(0) + seen.max(0)) / 2
        half = np.abs(seen - center)[:, :2].max()
        turn = sphere_rotation(seen, positions)
        for vertices, normals, way, middle, extent in (
            (surface.vertices, _normals_of(surface), rotation, center, half),
            (positions, positions, turn, np.zeros(3), 1.0),
        ):
            places.append((size * len(places), 0, size, size))
            panel = scene.panel(places[-1], way, middle, size / (2.12 * extent))
            panel.checkerboard(vertices, surface.faces, positions, normals)
    captions = []
    for row in rows:
        figures, root = row.result.figures, row.result.root
        surface = row.result.surfaces[root]
        captions += [
            f"{row.title if len(rows) > 1 else surface.name}, {len(surface.faces)} triangles",
            f"{figures['flipped_faces'][root]:.0f} flips, area ratio sd "
            f"{figures['area_ratio_sd'][root]:.4f}",
        ]
    _set(
        [scene.parts(places)],
        [captions],
        path,
        "A surface and its area-preserving map to the sphere",
    )


def errors_over_phase(rows: Sequence[Row], errors: Sequence[dict], path) -> None:
    """Error against known material points, one panel per row; `errors`: method -> mm per phase, one
    dict per row."""
    drawing, plots = panels(590 * len(rows) + 60, 440, (1,) * len(rows))
    top = max(values.max() for found in errors for values in found.values())
    for plot, row, found in zip(plots, rows, errors):
        count = len(next(iter(found.values())))
        plot.x, plot.y = (-0.5, count - 0.5), (0, 1.3 * top)
        for (method, values), color in zip(found.items(), (ROBUST, PUBLISHED)):
            label = f"{method}: {values.max():.1f} mm worst, {values.mean():.1f} mm mean"
            plot.curve(range(count), values, color, 3.3, label, dots=3.3)
        # No number behind the legend.
        distance = "mean distance of landmarks\nfrom their material points, mm"
        first = plot is plots[0]
        plot.finish(row.title, "phase", distance if first else "", whole=True, highest=1.05 * top)
        plot.legend(plot.left + 10, plot.top + 8)
    drawing.save(path)


# ---------------------------------------------------------------- what they share


def _surfaces(rows, path, columns, draw, title, key=False):
    lines = []  # of the picture: row and which of its surfaces
    for row in rows:
        shown = chosen_phases(len(row.result.surfaces), columns, 2 if len(rows) == 1 else 1)
        lines += [(row, shown[i : i + columns]) for i in range(0, len(shown), columns)]
    frames = []
    for row in rows:
        root = row.result.surfaces[row.result.root]
        rotation = upright(root.vertices, row.up)
        # A row per direction: numpy is slow along the short axis of an array.
        seen = [rotation @ surface.vertices.T for surface in row.result.surfaces]
        low = np.min([points.min(1) for points in seen], 0)
        high = np.max([points.max(1) for points in seen], 0)
        frames.append(
            (rotation, (low + high) / 2, (high - low)[:2] / 2 + 0.6 * _spacing(row.result))
        )
    width = max(extent[0] for _, _, extent in frames)
    most = max(len(shown) for _, shown in lines)
    scale = min(WIDTH / (2.1 * width * most), MAX_HEIGHT / (2 * max(e[1] for _, _, e in frames)))
    across = round(2 * width * scale)
    frames_of_lines = [frames[[other is row for other in rows].index(True)] for row, _ in lines]
    heights = [round(2 * extent[1] * scale) for _, _, extent in frames_of_lines]
    scene = Scene(across * most, sum(heights))
    places, captions, names, top = [], [], [], 0
    for (row, shown), (rotation, center, _), height in zip(lines, frames_of_lines, heights):
        places.append([])
        captions.append([])
        names.append(row.title)
        for k, i in enumerate(shown):
            places[-1].append((k * across, top, across, height))
            draw(scene.panel(places[-1][-1], rotation, center, scale), row.result, i)
            captions[-1].append(row.caption(i))
        top += height
    panels = [scene.parts(line) for line in places]
    _set(panels, captions, path, title, names, key)


def _set(panels, captions, path, title, names: Sequence[str] = (), key: bool = False):
    """Rows of images with captions on one white page."""
    gap, line, margin, header = 26, 54, 40, 110
    footer = 150 if key else 40
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
    page = Drawing(width, height)
    page.text(margin, 62, title, min(40, (width - 2 * margin) / (0.68 * len(title))), bold=True)

    def fitting(image, caption) -> float:
        return min(27, 1.6 * (image.shape[1] + gap) / max(len(caption), 1))

    # Captions of one size, unless one of them is much longer than others.
    common = min(fitting(*pair) for row, words in zip(panels, captions) for pair in zip(row, words))
    top = header
    for i, (row, words) in enumerate(zip(panels, captions)):
        y = top
        if named[i]:
            page.text(margin, y + line / 2, names[i], 34)
            y += line
        x = margin
        for image, caption in zip(row, words):
            h, w = image.shape[:2]
            page.image(image, x, y)
            size = max(common, 0.75 * fitting(image, caption))
            page.text(x + w / 2, y + h + line / 2, caption, size, color=GREY, across=0.5)
            x += w + gap
        top += heights[i] + gap
    if key:
        longitude, latitude = np.linspace(0, 1, round(0.32 * width)), np.linspace(1, -1, 56)
        page.image(
            _bytes(place_colors(longitude[None], latitude[:, None])), 0.34 * width, height - 116
        )
        middle, left, right = height - 88, 0.333 * width, 0.667 * width
        west = "place on the sphere: west"
        size = min(26, 26 * (left - 10) / extent_of(west, 26)[0])
        page.text(left, middle, west, size, color=GREY, across=1.0)
        page.text(right, middle, "east; light is north", size, color=GREY)
    page.save(path)


@lru_cache(maxsize=4)
def colors_of_landmarks(result: Correspondence) -> np.ndarray:
    """By their place on the sphere, as "Remesh by icosphere" colours them."""
    places = landmark_places(
        result.surfaces[result.root], result.maps[result.root], result.landmarks.shape[1]
    )
    return place_colors(*sphere_coordinates(places))


def _spacing(result: Correspondence) -> float:
    """Typical distance of neighbouring landmarks at the root."""
    points, faces = result.landmarks[result.root], result.landmark_faces
    return float(np.median(np.linalg.norm(points[faces[:, 0]] - points[faces[:, 1]], axis=1)))


class Scene:
    """One picture without text, on white, in parallel projection, of many panels: everything in it
    is rendered at once, which costs a small part of one picture per panel.

    width, height: in pixels.
    """

    def __init__(self, width: int, height: int):
        self.width, self.height = max(int(width), 2), max(int(height), 2)
        self.meshes: List[_Mesh] = []
        self.picture: Optional[np.ndarray] = None

    def panel(self, place: Place, rotation, center, scale: float) -> Panel:
        """What is drawn at this place. rotation, center: to view coordinates, and what is in the
        middle there; scale: pixels per unit."""
        return Panel(self, place, rotation, center, scale)

    def parts(self, places: Sequence[Place]) -> List[np.ndarray]:
        """The images of panels, once all is drawn."""
        if self.picture is None:
            self.picture = self._render()
        return [self.picture[y : y + h, x : x + w] for x, y, w, h in places]

    def _render(self) -> np.ndarray:
        from PIL import Image

        window = _window()
        window.renderer.RemoveAllViewProps()
        # As few actors as there are kinds: each costs time, whatever is in it.
        for kind in dict.fromkeys(mesh.kind for mesh in self.meshes):
            window.renderer.AddActor(
                _actor(kind, *_joined([m for m in self.meshes if m.kind == kind]))
            )
        image = window.picture(FINER * self.width, FINER * self.height, self.width, self.height)
        window.renderer.RemoveAllViewProps()
        return np.asarray(Image.fromarray(image).reduce(FINER))[::-1]


class _Window:
    """VTK without a window on the screen. Its modules are used as they are: PyVista's import would
    take as long as two pictures."""

    def __init__(self):
        import vtkmodules.vtkRenderingOpenGL2  # noqa: F401 (what draws)
        from vtkmodules.vtkRenderingCore import vtkLight, vtkRenderer, vtkRenderWindow

        self.renderer = vtkRenderer()
        self.renderer.SetBackground(1, 1, 1)
        self.renderer.SetAutomaticLightCreation(False)
        for position, intensity in (
            ((-1.0, 1.6, 2.2), 0.80),
            ((1.6, 0.2, 1.6), 0.34),
            ((0, -1.5, 1.0), 0.16),
        ):
            light = vtkLight()
            light.SetLightTypeToSceneLight()
            light.SetPosition(*position)
            light.SetIntensity(intensity)
            self.renderer.AddLight(light)
        self.window = vtkRenderWindow()
        self.window.SetOffScreenRendering(True)
        self.window.SetMultiSamples(0)
        self.window.AddRenderer(self.renderer)

    def picture(self, across: int, down: int, width: float, height: float) -> np.ndarray:
        """In so many pixels, of what lies from (0, 0) to (width, -height); the lowest row first."""
        far = 10.0 * max(width, height)
        camera = self.renderer.GetActiveCamera()
        camera.SetFocalPoint(width / 2, -height / 2, 0)
        camera.SetPosition(width / 2, -height / 2, far)
        camera.SetViewUp(0, 1, 0)
        camera.SetParallelProjection(True)
        camera.SetParallelScale(height / 2)
        camera.SetClippingRange(0.01 * far, 2 * far)
        return self.pixels(across, down)

    def pixels(self, across: int, down: int) -> np.ndarray:
        """What is in the window, the lowest row first."""
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkCommonCore import vtkUnsignedCharArray

        self.window.SetSize(across, down)
        self.window.Render()
        pixels = vtkUnsignedCharArray()
        self.window.GetPixelData(0, 0, across - 1, down - 1, 0, pixels, 0)
        return vtk_to_numpy(pixels).reshape(down, across, 3)


@lru_cache(maxsize=1)
def _window() -> _Window:
    """One for all pictures: a new one translates its shaders again, which takes as long as a
    picture."""
    return _Window()


def _actor(kind: _Kind, points, faces, normals, values):
    from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
    from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

    def array(numbers, kind=np.float32):
        return numpy_to_vtk(np.ascontiguousarray(numbers, kind), deep=True)

    mesh, places, triangles = vtkPolyData(), vtkPoints(), vtkCellArray()
    places.SetData(array(points))
    corners = np.ascontiguousarray(faces, np.int64).ravel()
    triangles.SetData(3, numpy_to_vtkIdTypeArray(corners, deep=True))
    mesh.SetPoints(places)
    mesh.SetPolys(triangles)
    mesh.GetPointData().SetNormals(array(normals))
    actor, mapper = vtkActor(), vtkPolyDataMapper()
    if kind.chart:
        mesh.GetPointData().SetTCoords(array(values))
        mapper.SetScalarVisibility(False)
        actor.SetTexture(_texture(kind.chart))
    else:
        mesh.GetPointData().SetScalars(array(values, np.uint8))
        mapper.SetColorModeToDirectScalars()
    mapper.SetInputData(mesh)
    actor.SetMapper(mapper)
    shine = actor.GetProperty()
    shine.SetAmbient(kind.ambient)
    shine.SetDiffuse(0.80)
    shine.SetSpecular(kind.specular)
    shine.SetSpecularPower(18)
    shine.SetInterpolationToPhong()
    return actor


class _Kind(NamedTuple):
    """What is drawn together."""

    chart: str = ""  # of the checkerboard; empty: colours per vertex
    ambient: float = 0.30
    specular: float = 0.10


class _Mesh(NamedTuple):
    kind: _Kind
    points: np.ndarray
    faces: np.ndarray
    normals: np.ndarray
    values: np.ndarray  # colours as bytes, or texture coordinates


def _joined(meshes: Sequence[_Mesh]):
    starts = np.cumsum([0, *(len(mesh.points) for mesh in meshes)])
    return (
        np.concatenate([mesh.points for mesh in meshes]),
        np.concatenate([mesh.faces + start for mesh, start in zip(meshes, starts)]),
        np.concatenate([mesh.normals for mesh in meshes]),
        np.concatenate([mesh.values for mesh in meshes]),
    )


class Panel(NamedTuple):
    """A part of a scene, with a view of its own."""

    scene: Scene
    place: Place
    rotation: np.ndarray
    center: np.ndarray
    scale: float

    def surface(self, vertices, faces, colors, normals) -> None:
        """With colours and normals per vertex."""
        placed = self._placed(vertices)
        seen = _facing(placed, faces)
        self._add(_Kind(), placed, seen, normals @ self.rotation.T, _bytes(colors))

    def checkerboard(self, vertices, faces, positions, normals) -> None:
        """A surface, or the sphere itself, with its map's latitudes and longitudes."""
        placed, normals = self._placed(vertices), normals @ self.rotation.T
        faces = _facing(placed, faces)
        # Longitudes make no sense at the poles: caps have charts of their own. Each triangle gets
        # corners of its own, since longitudes jump at the date line.
        longitude, latitude = sphere_coordinates(positions)
        height = positions[faces, 2].mean(1)
        for chart, taken in (
            (BELT, np.abs(height) < CAP),
            (NORTH, height >= CAP),
            (SOUTH, height <= -CAP),
        ):
            corners = faces[taken].ravel()
            if len(corners):
                at = _chart_coordinates(chart, longitude[corners], latitude[corners])
                alone = np.arange(len(corners)).reshape(-1, 3)
                self._add(_Kind(chart), placed[corners], alone, normals[corners], at)

    def balls(self, centers, colors, radius, faces) -> None:
        """One around each vertex of a closed surface."""
        seen = self._placed(centers)
        front = soft_normals(seen, faces)[:, 2] > -0.4  # the others lie behind it
        seen, colors = seen[front], colors[front]
        ball, faces = _ball()
        count = len(seen)
        self._add(
            _Kind(ambient=0.42, specular=0.0),
            (seen[:, None] + self.scale * radius * ball).reshape(-1, 3),
            (np.arange(count)[:, None, None] * len(ball) + faces).reshape(-1, 3),
            np.tile(ball, (count, 1)),
            np.repeat(_bytes(colors), len(ball), axis=0),
        )

    def _placed(self, points) -> np.ndarray:
        """In the coordinates of the scene: pixels, from its upper left corner."""
        x, y, width, height = self.place
        middle = np.array([x + width / 2, -(y + height / 2), 0.0])
        return points @ (self.scale * self.rotation.T) + (middle - self.scale * self.center)

    def _add(self, kind: _Kind, placed, faces, normals, values) -> None:
        self.scene.meshes.append(_Mesh(kind, placed, faces, normals, values))


def _facing(placed, faces) -> np.ndarray:
    """Of closed surfaces only the faces that look at the eye are seen."""
    x, y = (np.ascontiguousarray(placed[:, k]) for k in range(2))
    a, b, c = faces.T
    return faces[(x[b] - x[a]) * (y[c] - y[a]) > (y[b] - y[a]) * (x[c] - x[a])]


BELT, NORTH, SOUTH = "belt", "north", "south"  # charts of the checkerboard
CAP = 0.8  # height above which triangles belong to a cap
REACH = 1.3  # radians from the pole that a cap's chart covers: triangles are large in coarse meshes


def _chart_coordinates(chart: str, longitude: np.ndarray, latitude: np.ndarray) -> np.ndarray:
    """Texture coordinates of the corners of triangles, one after the other."""
    if chart == BELT:
        triple, first = longitude.reshape(-1, 3), longitude[::3, None]
        triple = first + (triple - first + 0.5) % 1 - 0.5
        return np.c_[triple.ravel(), (latitude + 1) / 2]
    sign = 1 if chart == NORTH else -1
    radius = np.clip((1 - sign * latitude) * np.pi / 2 / REACH, 0, 1) / 2
    angle = 2 * np.pi * longitude
    return np.c_[0.5 + radius * np.cos(angle), 0.5 + radius * np.sin(angle)]


@lru_cache(maxsize=1)
def _cap_places():
    """Longitudes and latitudes of the northern cap's texture; the southern one's are its mirror
    images."""
    across = ((np.arange(384, dtype=np.float32) + 0.5) / 192 - 1) * REACH
    x, y = across[None], -across[:, None]
    latitude = np.clip(1 - np.hypot(x, y) / (np.pi / 2), -1, 1)
    return np.arctan2(y, x) / (2 * np.pi) % 1, latitude


@lru_cache(maxsize=3)
def _texture(chart: str):
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkRenderingCore import vtkTexture

    if chart == BELT:
        longitude = (np.arange(896, dtype=np.float32) + 0.5) / 896
        latitude = (np.arange(448, 0, -1, dtype=np.float32) - 0.5) / 224 - 1
        colors = _bytes(map_colors(longitude[None], latitude[:, None]))
    else:
        longitude, latitude = _cap_places()
        colors = _bytes(map_colors(longitude, latitude if chart == NORTH else -latitude))
    image, texture = vtkImageData(), vtkTexture()
    image.SetDimensions(colors.shape[1], colors.shape[0], 1)
    rows = np.ascontiguousarray(colors[::-1]).reshape(-1, 3)
    image.GetPointData().SetScalars(numpy_to_vtk(rows, deep=True))
    texture.SetInputData(image)
    texture.SetColorModeToDirectScalars()
    texture.RepeatOn()  # a triangle across the date line has longitudes beyond a turn
    texture.InterpolateOn()  # and no mipmap: fields are larger in pictures than here
    return texture


@lru_cache(maxsize=1)
def _ball(corners: int = 10):
    """What is seen of a unit ball from above, roughly: its top and its rim, which are its normals
    as well, so that it is shaded as a ball."""
    angle = 2 * np.pi / corners * np.arange(corners)
    rim = np.c_[np.cos(angle), np.sin(angle), np.zeros(corners)]
    ring = np.arange(corners)
    faces = np.c_[np.zeros(corners, int), 1 + ring, 1 + (ring + 1) % corners]
    return np.r_[[[0.0, 0.0, 1.0]], rim], faces


def _bytes(colors):
    return np.round(255 * np.clip(colors, 0, 1)).astype(np.uint8)


@lru_cache(maxsize=64)
def _normals_of(surface: Surface) -> np.ndarray:
    """Of a surface that is in several pictures."""
    return soft_normals(surface.vertices, surface.faces)


def soft_normals(vertices, faces, rounds=3) -> np.ndarray:
    """Vertex normals, averaged over neighbours so that the steps of voxels do not show."""
    a, b, c = faces.T
    face = np.cross(vertices[b] - vertices[a], vertices[c] - vertices[a]).T
    corners = faces.ravel()
    for _ in range(rounds + 1):
        # A row per direction: numpy is slow along the short axis of an array.
        normals = np.stack([np.bincount(corners, np.repeat(row, 3), len(vertices)) for row in face])
        normals /= np.maximum(np.sqrt((normals**2).sum(0)), 1e-300)
        face = normals[:, a] + normals[:, b] + normals[:, c]
    return np.ascontiguousarray(normals.T)
