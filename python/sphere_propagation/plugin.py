# SPDX-License-Identifier: GPL-3.0-only
"""Finding the plugins and registering their filters with PyMeshLab."""

from __future__ import annotations

import ctypes
import os
import re
from dataclasses import dataclass, field
from importlib import metadata
from pathlib import Path
from typing import Dict, List, Optional

from .errors import PluginError

LIBRARY = "libfilter_sphere_propagation.so"
VOLUME_LIBRARY = "libfilter_label_volume.so"  # lies beside the other one, and may be missing
VARIABLE = (
    "SPHERE_PROPAGATION_PLUGIN"  # for developers: the plugin to take instead of the package's own
)
FILTER = "compute_spherical_parameterisation_root"  # one of its filters
VOLUME_FILTER = "create_layers_from_label_volume"
PYMESHLAB = "2025.7"  # the series whose interface the plugin is built for
PYMESHLAB_PLUGINS = 58  # that a whole PyMeshLab of this series brings


@dataclass
class _Registered:
    """What register() has found so far."""

    libraries: Dict[str, Path] = field(default_factory=dict)  # by name
    filters: List[str] = field(default_factory=list)
    volume_failure: str = ""  # why there is no plugin for label volumes


_registered = _Registered()


def find(library: str = LIBRARY) -> Path:
    """Where a plugin is: what the environment variable names or beside it, else the package's own,
    else a checkout's build."""
    named = os.environ.get(VARIABLE)
    if named:
        if not Path(named).is_file():
            raise PluginError(f"There is no plugin at {named}, which {VARIABLE} names.")
        found = Path(named).resolve()
        if library == LIBRARY or found.with_name(library).is_file():
            return found if library == LIBRARY else found.with_name(library)
        raise PluginError(f"There is no {library} beside {named}, which {VARIABLE} names.")
    import sphere_propagation

    for folder in [
        *map(Path, sphere_propagation.__path__),
        Path(__file__).resolve().parents[2] / "build/pymeshlab/plugins",
    ]:
        if (folder / library).is_file():
            return folder / library
    raise PluginError(
        f"The plugin {library} is not in the package. In a checkout, scripts/build pymeshlab "
        f"makes it; {VARIABLE} may name one elsewhere."
    )


def register():
    """Makes PyMeshLab know the filters, unless it knows them already (as after
    pymeshlab.load_plugin); returns that module.

    Every MeshSet has them from then on, those made before included.
    """
    pymeshlab = _pymeshlab()
    known = pymeshlab.filter_list()
    if FILTER not in known:
        _check_completeness(pymeshlab.plugin_number())
        library = find()
        try:
            pymeshlab.load_plugin(str(library))
        except pymeshlab.PyMeshLabException as error:  # PyMeshLab says in words what does not fit
            raise PluginError(
                f"PyMeshLab {pymeshlab_version()} does not load {library}: {error}"
            ) from error
        _registered.libraries[LIBRARY] = library
    if VOLUME_FILTER not in known and not _registered.volume_failure:
        try:
            library = find(VOLUME_LIBRARY)
            pymeshlab.load_plugin(str(library))
            _registered.libraries[VOLUME_LIBRARY] = library
        except (PluginError, pymeshlab.PyMeshLabException) as error:
            # Everything else works without.
            _registered.volume_failure = str(_missing_itk(str(error)) or error)
    new = set(pymeshlab.filter_list()) - set(known)
    _registered.filters = sorted({*_registered.filters, *new})
    # Methods of MeshSet, as PyMeshLab makes them of its own filters.
    for name in pymeshlab.filter_list():
        if not hasattr(pymeshlab.MeshSet, name):
            setattr(pymeshlab.MeshSet, name, pymeshlab.bind_function(name))
    return pymeshlab


def require_volumes() -> None:
    """A PluginError that says what is missing, where the plugin that reads label volumes could not
    be loaded."""
    failure = volume_failure()
    if failure:
        raise PluginError(f"Label volumes cannot be read here. {failure}")


def volume_failure() -> str:
    """Why label volumes cannot be read; empty when they can."""
    return "" if VOLUME_FILTER in register().filter_list() else _registered.volume_failure


def loaded(library: str = LIBRARY) -> Optional[Path]:
    """The file that register() loaded; None when PyMeshLab knew the filters before."""
    return _registered.libraries.get(library)


def filters() -> List[str]:
    """Names of the filters that register() brought; empty when PyMeshLab knew them before."""
    return list(_registered.filters)


def pymeshlab_version() -> str:
    """Of the installed one; empty where it was installed without saying."""
    try:
        return metadata.version("pymeshlab")
    except metadata.PackageNotFoundError:
        return ""


def _pymeshlab():
    version = pymeshlab_version()
    if version and not (version + ".").startswith(PYMESHLAB + "."):
        raise PluginError(
            f"PyMeshLab {version} is installed, but this plugin is built for {PYMESHLAB}: "
            f"pip install 'pymeshlab=={PYMESHLAB}.*'"
        )
    try:
        import pymeshlab
    except ImportError as error:
        if not version:
            raise PluginError(
                f"PyMeshLab is not installed: pip install 'pymeshlab=={PYMESHLAB}.*'"
            ) from error
        raise PluginError(
            f"PyMeshLab {version} cannot be imported: {error}. {_missing_libraries()}".strip()
        ) from error
    return pymeshlab


def _check_completeness(count: int) -> None:
    if count < PYMESHLAB_PLUGINS:
        raise PluginError(
            f"PyMeshLab loaded only {count} of its {PYMESHLAB_PLUGINS} plugins, so that files may "
            "not open. "
            + (_missing_libraries() or "Install it again: pip install --force-reinstall pymeshlab")
        )


def _missing_itk(text: str) -> Optional[PluginError]:
    """Says what to do where this is what the dynamic linker says of one of ITK's libraries."""
    library = re.search(r"(libITK[^\s:]*|libitk[^\s:]*): cannot open shared object", text)
    return (
        PluginError(
            f"Missing on this system: {library[1]}, a library of ITK. On Debian 12: apt-get "
            "install libinsighttoolkit5.2. A wheel of this package has it inside."
        )
        if library
        else None
    )


def _missing_libraries() -> str:
    """Advice on the system's libraries that PyMeshLab needs and does not bring; empty when all are
    there."""
    missing = []
    for library, package in (("libGL.so.1", "libgl1"), ("libOpenGL.so.0", "libopengl0")):
        try:
            ctypes.CDLL(library)
        except OSError:
            missing.append((library, package))
    if not missing:
        return ""
    return (
        f"Missing on this system: {', '.join(library for library, _ in missing)}. On Debian and "
        f"Ubuntu: apt-get install {' '.join(package for _, package in missing)}"
    )
