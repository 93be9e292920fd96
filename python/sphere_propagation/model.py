# SPDX-License-Identifier: GPL-3.0-only
"""Statistical shape models as arrays."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Dict, List, Mapping, Optional

import numpy as np

from .errors import InputError
from .parameters import real_number, whole_number
from .surface import array_of


@dataclass(frozen=True, eq=False)
class ShapeModel:
    """A mean shape and the modes in which its training shapes vary; docs/shape_model.md has the
    formulas.

    mean: (landmarks, 3); modes: (M, landmarks, 3), orthonormal; eigenvalues: (M,), variance along
    each mode, divisor shapes - 1;
    scores: (shapes, M), so that mean + tensordot(scores, modes, 1) are the aligned shapes; faces:
    (k, 3); names: of the shapes;
    total_variance: that of all modes, kept or not.
    figures: by number of modes, (M,): compactness, variance_share, generalisation,
    generalisation_error, specificity, specificity_error.
    lid: boolean, one per landmark that there was: True for those which the model leaves out, since
    they lie on lids; landmark j of the model is the j-th False one.
    noise_variance: per coordinate, of what the modes leave out, as models of statismo have it; 0
    where that is not known.
    landmark_names: number of the model's landmark by name, of those that have one, as anchors.
    surface_figures: of a model that was measured between surfaces, by number of modes, up to ten:
    surface_generalisation and surface_specificity with their errors; per shape: off_surface and
    folded_faces.
    """

    mean: np.ndarray
    modes: np.ndarray
    eigenvalues: np.ndarray
    scores: np.ndarray
    faces: np.ndarray
    names: List[str]
    total_variance: float
    figures: Dict[str, np.ndarray]
    lid: Optional[np.ndarray] = None
    noise_variance: float = 0.0
    landmark_names: Mapping[str, int] = field(default_factory=dict)
    surface_figures: Mapping[str, np.ndarray] = field(default_factory=dict)

    @property
    def compactness(self) -> np.ndarray:
        """Sum of the first eigenvalues, by number of modes."""
        return self.figures["compactness"]

    @property
    def generalisation(self) -> np.ndarray:
        """Mean distance of a shape from its best approximation by the model of all others, by
        number of modes."""
        return self._measured("generalisation")

    @property
    def specificity(self) -> np.ndarray:
        """Mean distance of random shapes of the model from the nearest training shape, by number of
        modes."""
        return self._measured("specificity")

    def _measured(self, name: str) -> np.ndarray:
        if name not in self.figures:
            raise InputError(
                f"The model's {name} was not measured: its file does not have it. shape_model() "
                "measures it, and files of models that cohort made have it."
            )
        return self.figures[name]

    def __repr__(self) -> str:
        share = self.figures.get("variance_share", ())
        first = f", the first with {100 * share[0]:.1f} % of the variance" if len(share) else ""
        return (
            f"ShapeModel({len(self.scores)} shapes, {len(self.mean)} landmarks, "
            f"{len(self.modes)} modes{first})"
        )

    def shape(self, scores) -> np.ndarray:
        """The shape, (landmarks, 3), with these scores along the first modes."""
        scores = np.atleast_1d(array_of("scores", scores))
        if scores.ndim != 1 or scores.dtype.kind not in "biuf" or len(scores) > len(self.modes):
            raise InputError(
                f"The model has {len(self.modes)} modes: scores must be at most so many numbers, "
                f"not of shape {scores.shape}."
            )
        return self.mean + np.tensordot(scores, self.modes[: len(scores)], 1)

    def along(self, mode: int, deviations: float) -> np.ndarray:
        """The shape, (landmarks, 3), that lies so many standard deviations from the mean along one
        mode; the first mode is 0."""
        mode, deviations = whole_number("mode", mode), real_number("deviations", deviations)
        if not 0 <= mode < len(self.modes):
            raise InputError(
                f"There is no mode {mode}: the model's modes are numbered from 0 to "
                f"{len(self.modes) - 1}."
            )
        return self.mean + deviations * np.sqrt(self.eigenvalues[mode]) * self.modes[mode]
