# SPDX-License-Identifier: GPL-3.0-only
"""Spherical maps of closed anatomical surfaces, propagated over layers and resampled by an
icosphere.

Importing this package makes PyMeshLab know the plugin's filters, and offers them as functions on
arrays:

    import sphere_propagation as sp

    surfaces = sp.read_meshes("phases")  # closed meshes in order of time, without correspondence
    result = sp.correspond(surfaces, order="Cyclic time")
    result.landmarks[t, j]               # landmark j at phase t: the same place for all t
    model = sp.shape_model(result.landmarks, result.landmark_faces)
"""

from . import plugin as _plugin
from .attention import warnings_of
from .correspondence import Correspondence, correspond
from .errors import (
    FileError,
    FilterError,
    InputError,
    PluginError,
    SpherePropagationError,
    SpherePropagationWarning,
)
from .explorer import Explorer, explore
from .files import mesh_files, read_map, read_mesh, read_meshes, write_ply
from .filters import (
    LabelSurfaces,
    Landmarks,
    Optimisation,
    Propagation,
    evaluate,
    make_phantom,
    map_colors,
    optimise_groupwise,
    parameterise_most_central,
    parameterise_root,
    propagate,
    read_label_volume,
    remesh,
    shape_model,
)
from .fitting import Fit, fit
from .leaving_out import RebuiltGeneralisation, rebuilt_generalisation
from .model import ShapeModel
from .model_files import name_landmarks, read_model
from .morphing import Morph, morph
from .nifti import write_nifti
from .phantom import Ventricle
from .preparation import PreparedSurface, prepare
from .projects import write_landmarks, write_layers
from .sphere_map import SphereMap
from .surface import Surface
from .version import version as _version

__all__ = [
    "Correspondence",
    "Explorer",
    "FileError",
    "FilterError",
    "Fit",
    "InputError",
    "LabelSurfaces",
    "Landmarks",
    "Morph",
    "Optimisation",
    "PluginError",
    "PreparedSurface",
    "Propagation",
    "RebuiltGeneralisation",
    "ShapeModel",
    "SpherePropagationError",
    "SpherePropagationWarning",
    "SphereMap",
    "Surface",
    "Ventricle",
    "correspond",
    "evaluate",
    "explore",
    "fit",
    "make_phantom",
    "map_colors",
    "mesh_files",
    "morph",
    "name_landmarks",
    "optimise_groupwise",
    "parameterise_most_central",
    "parameterise_root",
    "prepare",
    "propagate",
    "read_label_volume",
    "read_map",
    "read_mesh",
    "read_meshes",
    "read_model",
    "rebuilt_generalisation",
    "remesh",
    "shape_model",
    "warnings_of",
    "write_landmarks",
    "write_layers",
    "write_nifti",
    "write_ply",
]
__version__ = _version()

_plugin.register()
