"""Finding the plugin and loading it into PyMeshLab."""
from __future__ import annotations

import os
from pathlib import Path

LIBRARY = "libfilter_sphere_propagation.so"
VARIABLE = "SPHERE_PROPAGATION_PLUGIN"
FILTER = "compute_spherical_parameterisation_root"  # one of them


class PluginError(RuntimeError):
    """The plugin or PyMeshLab is missing, or they do not fit together."""


def find(path=None) -> Path:
    """Where the plugin is: `path`, else the environment variable, else beside this file."""
    for candidate in (path, os.environ.get(VARIABLE)):
        if candidate:
            if not Path(candidate).is_file():
                raise PluginError(f"There is no plugin at {candidate}.")
            return Path(candidate)
    inside = Path(__file__).parent / LIBRARY
    if inside.is_file():
        return inside
    raise PluginError(f"The plugin {LIBRARY} was not found: set {VARIABLE} to its path (scripts/build pymeshlab makes it).")


def load(path=None):
    """Loads the plugin, unless that was done before; returns the module pymeshlab, whose MeshSet then knows the filters."""
    try:
        import pymeshlab
    except ImportError as error:
        raise PluginError(f"PyMeshLab cannot be imported: {error}") from error
    if FILTER not in pymeshlab.filter_list():
        library = find(path)
        try:
            pymeshlab.load_plugin(str(library.resolve()))
        except Exception as error:  # PyMeshLab says in words what does not fit
            raise PluginError(f"PyMeshLab does not load {library}: {error}") from error
    return pymeshlab
