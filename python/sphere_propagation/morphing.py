# SPDX-License-Identifier: GPL-3.0-only
"""Shapes between shapes: the filter "Morph between layers" on arrays, and as GIF."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Callable, Dict, List, Optional, Sequence, Tuple

import numpy as np

from . import layers, pictures
from .colors import place_colors, sphere_coordinates
from .correspondence import correspond
from .errors import FileError, InputError
from .files import mesh_files, read_meshes, write_ply
from .filters import _maps_of
from .parameters import NAMED, path_of, real_number, whole_number
from .results import ResultFolder, require_apart
from .sphere_map import MapLike, SphereMap
from .surface import Surface, SurfaceLike, as_surfaces, counted
from .units import DEFAULT_UNIT, unit_named, volume_unit
from .views import upright

MORPH = "generate_morph"
CONNECTIVITIES = NAMED["connectivity"]
PATHS = NAMED["along"]
AT_ONCE = 12  # frames rendered together


@dataclass(frozen=True, eq=False)
class Morph:
    """Shapes between surfaces, in order of time.

    surfaces: called "A to B 25 %"; all between the same two have one face list, and with the common
    icosphere all. maps: of each, its vertices on the sphere. between: of each the numbers of the
    two surfaces; share: 0 at the first of them, 1 at the second. crossings: of edges, with the
    union. closed: whether the last leads back to the first. figures: volume and vertices of each,
    seconds.
    """

    surfaces: List[Surface]
    maps: List[SphereMap]
    between: List[Tuple[int, int]]
    share: np.ndarray
    crossings: int
    closed: bool
    figures: Dict[str, np.ndarray]

    def __repr__(self) -> str:
        return f"Morph({counted(self.surfaces, 'shape')}{', closed' if self.closed else ''})"

    def write_gif(
        self,
        path,
        *,
        size: int = 480,
        seconds: float = 4.0,
        up: Optional[Sequence[float]] = None,
    ) -> Path:
        """An animation that repeats: round where the way is closed, else there and back. Colours
        are places of the sphere, so that what corresponds has one colour all the time. With the
        extra `pictures`.

        size: of a frame, in pixels; seconds: of one round; up: the direction that is upright, by
        default the long axis.
        """
        path = path_of(path)
        size, seconds = whole_number("size", size), real_number("seconds", seconds)
        if size < 16 or not seconds > 0:
            raise InputError("size must be 16 or more, and seconds above 0.")
        missing = pictures.what_is_missing()
        if missing:
            raise InputError(f"No GIF can be drawn: {missing}.")
        frames = self._frames(size, up)
        if not self.closed:
            frames += frames[-2:0:-1]
        elif self.share[0] == 0 and self.share[-1] == 1 and len(frames) > 1:
            frames = frames[:-1]  # which is the first
        try:
            frames[0].save(
                path,
                "GIF",
                save_all=True,
                append_images=frames[1:],
                duration=max(20, round(1000 * seconds / len(frames))),  # ms
                loop=0,
                optimize=False,  # which would give each its own again
            )
        except OSError as error:
            raise FileError(f"{path} cannot be written: {error.strerror or error}.") from error
        return path

    def _frames(self, size: int, up) -> list:
        from PIL import Image

        rotation = upright(self.surfaces[0].vertices, up)
        seen = [surface.vertices @ rotation.T for surface in self.surfaces]
        low = np.min([points.min(0) for points in seen], axis=0)
        high = np.max([points.max(0) for points in seen], axis=0)
        center, scale = (low + high) / 2, size / (1.08 * (high - low)[:2].max())
        images, palette = [], None
        for begin in range(0, len(seen), AT_ONCE):
            shown = range(begin, min(begin + AT_ONCE, len(seen)))
            scene = pictures.Scene(size * len(shown), size)
            places = [(size * k, 0, size, size) for k in range(len(shown))]
            for place, i in zip(places, shown):
                surface = self.surfaces[i]
                panel = scene.panel(place, rotation, center, scale)
                normals = pictures.soft_normals(surface.vertices, surface.faces)
                colors = _colors(self.maps[i])
                panel.surface(surface.vertices, surface.faces, colors, normals)
            frames = [Image.fromarray(part).convert("RGB") for part in scene.parts(places)]
            palette = palette or _palette_of(frames)
            images += [
                frame.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG)
                for frame in frames
            ]
        return images


def morph(
    surfaces: Sequence[SurfaceLike],
    maps: Sequence[MapLike],
    *,
    steps: int = 3,
    connectivity: str = CONNECTIVITIES[0],
    frequency: int = 10,
    along: str = PATHS[0],
    closed: bool = False,
    ends: bool = True,
    threads: int = 0,
) -> Morph:
    """Shapes from each surface to the next; docs/morph.md says how.

    surfaces, maps: two or more, as correspond and propagate give them; they move as they lie.
    steps: shapes between two neighbours.
    connectivity: "Common icosphere" (10 frequency^2 + 2 vertices), or "Union of both
    connectivities", which is both surfaces exactly at its ends.
    along: "Linear", or "Shape model": a smooth path through the scores of all.
    closed: whether the last leads back to the first.
    ends: whether the given shapes come, too, in the same connectivity.
    threads: how many work, 0 for as many as the machine runs at once.
    """
    surfaces = as_surfaces(surfaces)
    meshes = layers.mesh_set(surfaces, _maps_of(surfaces, maps))
    returned = layers.apply(
        meshes,
        MORPH,
        steps=steps,
        connectivity=connectivity,
        frequency=frequency,
        along=along,
        closed=closed,
        ends=ends,
        threads=threads,
    )
    made = [meshes.mesh(i) for i in range(len(surfaces), meshes.mesh_number())]
    return Morph(
        [layers.surface_of(mesh) for mesh in made],
        [layers.map_of(mesh) for mesh in made],
        [(int(i), int(j)) for i, j in zip(returned["from"], returned["to"])],
        returned["share"],
        int(returned["crossings"]),
        bool(closed) and len(surfaces) > 2,
        {name: np.asarray(returned[name]) for name in ("volume", "vertices", "seconds")},
    )


def morph_files(
    surfaces,
    folder,
    say: Callable[[str], None],
    order: str,
    mirror_layers: bool = False,
    unit: str = DEFAULT_UNIT,
    **choices,
) -> List[str]:
    """morph() for files, or folders of them, propagated before: the shapes as PLY files and, where
    pictures can be drawn, morph.gif. Returns what lies in the folder."""
    per_unit, cubed = volume_unit(unit_named(unit))
    paths = mesh_files(*surfaces)
    if len(paths) < 2:
        raise InputError(f"A morph takes two surfaces at least, not {len(paths)}.")
    require_apart(paths, folder)
    results = ResultFolder(folder)
    results.require_folder()
    found = read_meshes(*paths)
    results.create()
    result = correspond(found, order=order, mirror_layers=mirror_layers, unit=unit)
    between = morph(result.surfaces, result.maps, **choices)
    for number, (surface, sphere) in enumerate(zip(between.surfaces, between.maps)):
        results.write(
            f"{number:03}_{_file_name(surface.name)}.ply",
            lambda path, surface=surface, sphere=sphere: write_ply(
                path, surface.vertices, surface.faces, colors=_colors(sphere)
            ),
        )
    volumes = between.figures["volume"] / per_unit
    low, high = volumes.min(), volumes.max()
    say(f"{counted(between.surfaces, 'shape')}, volume {low:.3g} to {high:.3g} {cubed}")
    made = ["*.ply: the shapes, numbered in order of time"]
    missing = pictures.what_is_missing()
    if missing:
        say(f"Note: no GIF: {missing}.")
    else:
        results.write("morph.gif", between.write_gif)
        made.append("morph.gif: the same as an animation")
    return made


def _palette_of(frames: list):
    """The 256 colours of a GIF, for all of its frames, so that nothing flickers: colours are places
    on the sphere, which all of them show."""
    from PIL import Image

    width, height = frames[0].size
    together = Image.new("RGB", (width * len(frames), height))
    for k, frame in enumerate(frames):
        together.paste(frame, (width * k, 0))
    return together.quantize(256)


def _colors(sphere: SphereMap) -> np.ndarray:
    return place_colors(*sphere_coordinates(sphere.positions))


def _file_name(name: str) -> str:
    return "".join(
        c if c.isalnum() or c in " ._-" else "_" for c in name.replace(" %", "")
    ).replace(" ", "_")
