# SPDX-License-Identifier: GPL-3.0-only
"""How to cite: the program, and the paper whose method it implements, as CITATION.cff does."""

from __future__ import annotations

from .version import version

PAPER = (
    "Kirschner M, Wesarg S. Propagation of shape parameterisation for the construction of a "
    "statistical shape model of the left ventricle. Eurographics Workshop on Visual Computing for "
    "Biology and Medicine, 2010."
)
AUTHORS, YEAR = "The Sphere Propagation developers", 2026


def program() -> str:
    """This version of the program, as a reference."""
    return f"{AUTHORS}. Sphere Propagation, version {version()} [computer program]. {YEAR}."
