# SPDX-License-Identifier: GPL-3.0-only
"""Colours that make maps visible: red, green, blue in [0, 1], one row per vertex."""

from __future__ import annotations

import numpy as np


def _floats(values) -> np.ndarray:
    """Single precision stays: for pictures it does, and takes half the time."""
    values = np.asarray(values)
    return values if values.dtype == np.float32 else values.astype(float)


def place_colors(longitude, latitude, amplitude: float = 0.45) -> np.ndarray:
    """The pattern Direction of vcg_ext/display/sphere_pattern.h: the hue turns once with the
    longitude (in turns) and fades towards the poles, light in the north, dark in the south
    (latitude in quarter turns). So drift in any direction shows, round the axis as well."""
    longitude, latitude = _floats(longitude), _floats(latitude)
    near = np.abs(latitude)
    fading, pole = near * near * near, np.where(latitude > 0, 0.98, 0.40)
    shape = np.broadcast_shapes(longitude.shape, latitude.shape)
    colors = np.empty((*shape, 3), np.result_type(longitude, latitude))
    for k, start in enumerate(
        (0.02, 0.36, 0.66)
    ):  # red, green, blue: numpy is slow along short axes
        hue = 0.98 - amplitude + amplitude * np.cos(2 * np.pi * (longitude - start))
        colors[..., k] = (1 - fading) * hue + fading * pole
    return colors


def map_colors(longitude, latitude, cells: int = 8, shade: float = 0.5) -> np.ndarray:
    """The checkerboard of vcg_ext/display/sphere_pattern.h, for pictures that show it sharp:
    longitude in turns, latitude in quarter turns (-1 south pole, 1 north pole); `cells` fields from
    pole to pole, every other one darker by `shade`.

    The hue turns once with the longitude and fades towards the poles: light in the north, dark in
    the south.
    """
    longitude, latitude = _floats(longitude), _floats(latitude)
    around = 2 * ((3 * cells + 3) // 4)
    dark = (
        np.floor(longitude % 1 * around) + np.floor((1 - latitude) / 2 * cells * (1 - 1e-12))
    ) % 2
    colors, light = place_colors(longitude, latitude, 0.32), 1 - shade * dark
    for k in range(3):
        colors[..., k] *= light
    return colors


def sphere_coordinates(positions: np.ndarray):
    """Longitude in turns and latitude in quarter turns of unit vectors (n, 3), as map_colors wants
    them."""
    x, y, z = np.asarray(positions, float).T
    return np.arctan2(y, x) / (2 * np.pi) % 1, np.arcsin(np.clip(z, -1, 1)) / (np.pi / 2)
