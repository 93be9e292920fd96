# SPDX-License-Identifier: GPL-3.0-only
"""import sphere_propagation makes PyMeshLab know the filters, whoever came first, and says what to
do where it cannot."""

import pytest
from sphere_propagation import errors, plugin

MAP = (
    "m.apply_filter('create_ventricle_phantom', phases=1, voxel_size=4); "
    "m.apply_filter('compute_spherical_parameterisation_root')"
)
ORDERS = {
    "package alone": f"import sphere_propagation, pymeshlab; m = pymeshlab.MeshSet(); {MAP}",
    "package first": f"import sphere_propagation; import pymeshlab; m = pymeshlab.MeshSet(); {MAP}",
    "PyMeshLab and a MeshSet first": "import pymeshlab; m = pymeshlab.MeshSet(); "
    f"import sphere_propagation; {MAP}",
    "loaded by hand before": "import os, pymeshlab\n"
    "for name in ('LIBRARY', 'VOLUMES'): pymeshlab.load_plugin(os.environ[name])\n"
    "n = pymeshlab.plugin_number(); import sphere_propagation; m = pymeshlab.MeshSet(); "
    "assert pymeshlab.plugin_number() == n; " + MAP,
    "imported twice": "import sphere_propagation, importlib, pymeshlab; "
    "n = pymeshlab.plugin_number(); importlib.reload(sphere_propagation.plugin); "
    "importlib.reload(sphere_propagation); assert pymeshlab.plugin_number() == n; "
    "m = pymeshlab.MeshSet(); " + MAP,
    "in a child process": "import multiprocessing as mp, sphere_propagation as sp\n"
    "if __name__ == '__main__':\n"
    "    for way in ('fork', 'spawn'):\n"
    "        with mp.get_context(way).Pool(1) as pool:\n"
    "            assert len(pool.apply(sp.make_phantom, kwds={'phases': 2, 'voxel_size': 4})) == 2",
    "as a method of MeshSet": "import sphere_propagation, pymeshlab; m = pymeshlab.MeshSet(); "
    "m.create_ventricle_phantom(phases=1, voxel_size=4); assert m.mesh_number() == 1",
}


@pytest.mark.parametrize("order", ORDERS)
def test_filters_are_known(order, run_python):
    found = run_python(
        ORDERS[order], LIBRARY=str(plugin.find()), VOLUMES=str(plugin.find(plugin.VOLUME_LIBRARY))
    )
    assert found.returncode == 0, found.stderr


# What is broken before the import, and what the error then says.
BROKEN = {
    "another PyMeshLab": (
        "import importlib.metadata as m; m.version = lambda name: '2023.12.post3'",
        [
            "PyMeshLab 2023.12.post3 is installed",
            "built for 2025.7",
            "pip install 'pymeshlab==2025.7.*'",
        ],
    ),
    "no PyMeshLab": (
        "import sys, importlib.metadata as m; sys.modules['pymeshlab'] = None\n"
        "def version(name): raise m.PackageNotFoundError(name)\nm.version = version",
        ["PyMeshLab is not installed", "pip install 'pymeshlab==2025.7.*'"],
    ),
    "no libOpenGL": (
        "import ctypes, pymeshlab; pymeshlab.plugin_number = lambda: 44\nCDLL = ctypes.CDLL\n"
        "def load(name, *more, **settings):\n"
        "    if name == 'libOpenGL.so.0': raise OSError(name)\n"
        "    return CDLL(name, *more, **settings)\nctypes.CDLL = load",
        ["only 44 of its 58 plugins", "libOpenGL.so.0", "apt-get install libopengl0"],
    ),
    "no plugin": (
        "import os; os.environ['SPHERE_PROPAGATION_PLUGIN'] = '/nowhere/x.so'",
        ["There is no plugin at /nowhere/x.so"],
    ),
    "not a plugin": (
        "import os, pymeshlab; os.environ['SPHERE_PROPAGATION_PLUGIN'] = pymeshlab.__file__",
        ["does not load", "__init__.py"],
    ),
}


@pytest.mark.parametrize("what", BROKEN)
def test_what_does_not_fit_is_said(what, run_python):
    breaking, words = BROKEN[what]
    found = run_python(
        breaking + "\ntry:\n    import sphere_propagation\n"
        "except ImportError as error:\n    print(type(error).__name__, error)\n"
        "else:\n    print('imported')"
    )
    assert found.returncode == 0, found.stderr
    assert found.stdout.startswith("PluginError")
    for word in words:
        assert word in found.stdout


def test_a_plugin_error_is_an_import_error():
    assert issubclass(errors.PluginError, ImportError) and issubclass(
        errors.PluginError, errors.SpherePropagationError
    )
