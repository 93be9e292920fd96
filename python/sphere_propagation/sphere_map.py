# SPDX-License-Identifier: GPL-3.0-only
"""Maps of surfaces to the unit sphere as arrays."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Dict, Optional, Union

import numpy as np

from .errors import InputError
from .surface import array_of


@dataclass(frozen=True, eq=False)
class SphereMap:
    """A spherical parameterisation: where each vertex of a surface lies on the unit sphere.

    positions: unit vectors (n, 3); texture: the same as texture coordinates (n, 2), u = longitude /
    2 pi, v = colatitude / pi, which files keep, None where there are none or rounding them to
    floats would make the map invalid; figures: what the filter that made it
    measured: flipped_faces, area_ratio_sd, area_log_mean, angle_error_mean (degrees), seconds.
    """

    positions: np.ndarray
    texture: Optional[np.ndarray] = None
    figures: Dict[str, float] = field(default_factory=dict)

    def __post_init__(self):
        positions = array_of("Positions of a map", self.positions)
        if positions.ndim != 2 or positions.shape[1] != 3 or positions.dtype.kind not in "fiu":
            raise InputError(
                f"Positions of a map must be numbers of shape (n, 3), not {positions.dtype} of "
                f"shape {positions.shape}."
            )
        object.__setattr__(self, "positions", np.ascontiguousarray(positions, np.float64))
        if self.texture is not None:
            texture = array_of("Texture coordinates of a map", self.texture)
            if texture.shape != (len(positions), 2) or texture.dtype.kind not in "fiu":
                raise InputError(
                    f"Texture coordinates of this map must have the shape ({len(positions)}, 2), "
                    f"not {texture.shape}."
                )
            object.__setattr__(self, "texture", np.ascontiguousarray(texture, np.float64))

    def __repr__(self) -> str:
        known = {"flipped_faces": "{:.0f} flipped faces", "area_ratio_sd": "area ratio sd {:.4f}"}
        said = [
            text.format(self.figures[name]) for name, text in known.items() if name in self.figures
        ]
        return f"SphereMap({', '.join([f'{len(self.positions)} positions', *said])})"


MapLike = Union[SphereMap, np.ndarray]  # the array: positions


def as_map(positions: MapLike) -> SphereMap:
    """A SphereMap, also from its positions alone."""
    return positions if isinstance(positions, SphereMap) else SphereMap(positions)
