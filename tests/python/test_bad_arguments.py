# SPDX-License-Identifier: GPL-3.0-only
"""Whatever an argument is, an error of this package says so, not one of Python's, NumPy's or
PyMeshLab's."""

import inspect
import warnings
from functools import partial

import numpy as np
import pymeshlab
import pytest
import sphere_propagation as sp
from sphere_propagation import plugin
from sphere_propagation.parameters import FLAGS

VALUES = ["x", None, [1, 2], float("nan"), -1, 1.5, 10**30, object(), {}, np.array([1, 2]), [[1]]]


@pytest.fixture(scope="module")
def job():
    return sp.correspond(sp.make_phantom(phases=2, voxel_size=4), frequency=1)


FUNCTIONS = {
    sp.correspond: lambda job: (job.surfaces,),
    sp.parameterise_root: lambda job: (job.surfaces[0],),
    sp.propagate: lambda job: (job.surfaces, job.root_map),
    partial(sp.optimise_groupwise, iterations=1, frequency=3): lambda job: (
        job.surfaces,
        job.maps,
    ),
    sp.remesh: lambda job: (job.surfaces, job.maps),
    sp.prepare: lambda job: (job.surfaces[0],),
    sp.evaluate: lambda job: (job.surfaces, job.maps),
    sp.shape_model: lambda job: (job.landmarks, job.landmark_faces, ["a", "b"]),
    sp.map_colors: lambda job: (job.surfaces, job.maps),
    partial(sp.make_phantom, phases=1, voxel_size=4): lambda job: (),
    sp.read_label_volume: lambda job: ((np.pad(np.ones((3, 3, 3)), 2), np.eye(4)),),
    sp.read_mesh: lambda job: ("nowhere",),
    sp.read_map: lambda job: ("nowhere",),
    sp.read_meshes: lambda job: ("nowhere",),
    sp.mesh_files: lambda job: ("nowhere",),
    sp.write_ply: lambda job: ("a.ply", job.surfaces[0].vertices, job.surfaces[0].faces),
    sp.write_nifti: lambda job: ("a.nii", np.ones((3, 3, 3)), np.eye(4)),
    sp.write_layers: lambda job: ("folder", "name", job),
    sp.Surface: lambda job: (job.surfaces[0].vertices, job.surfaces[0].faces, "name"),
    sp.SphereMap: lambda job: (job.root_map.positions, job.root_map.texture),
    sp.Ventricle: lambda job: ("Cavity", 3),
    sp.Ventricle("Cavity", 2).errors: lambda job: (job.landmarks, 0),
}


def only_this_packages_errors(call):
    try:
        call()
    except (sp.SpherePropagationError, FileNotFoundError):
        pass
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return None


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("function", FUNCTIONS, ids=lambda f: getattr(f, "__qualname__", "phantom"))
def test_errors_are_this_packages(function, job, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    given, wrong = FUNCTIONS[function](job), {}
    for value in VALUES:
        for i in range(len(given)):
            arguments = [*given[:i], value, *given[i + 1 :]]
            wrong[f"argument {i}: {value!r}"] = only_this_packages_errors(
                lambda arguments=arguments: function(*arguments)
            )
        for name, parameter in inspect.signature(function).parameters.items():
            if parameter.kind is inspect.Parameter.KEYWORD_ONLY and name != "progress":
                wrong[f"{name}={value!r}"] = only_this_packages_errors(
                    lambda name=name, value=value: function(*given, **{name: value})
                )
    assert not {call: error for call, error in wrong.items() if error}


@pytest.mark.parametrize(
    "value", VALUES, ids=[f"{type(v).__name__}{i}" for i, v in enumerate(VALUES)]
)
def test_a_models_shapes(value, job):
    model = sp.shape_model(job.landmarks, job.landmark_faces)
    for call in (
        lambda: model.shape(value),
        lambda: model.along(value, 1),
        lambda: model.along(0, value),
    ):
        assert only_this_packages_errors(call) is None


def test_a_choice_that_is_none_is_named_with_its_parameter(job):
    with pytest.raises(sp.FilterError, match="lid must be one of 'Curved', 'Flat', not 'foo'"):
        sp.prepare(job.surfaces[0], lid="foo")
    with pytest.raises(sp.FilterError, match="alignment must be one of .*, not 'foo'"):
        sp.shape_model(job.landmarks, job.landmark_faces, alignment="foo")


def test_a_surface_without_vertices_is_named():
    with pytest.raises(sp.InputError, match="has no vertices"):
        sp.prepare((np.zeros((0, 3)), np.zeros((0, 3), int)))


def test_true_is_no_number(job):
    first, *_ = surfaces = job.surfaces
    for call in (
        lambda: sp.correspond(surfaces, frequency=True),
        lambda: sp.correspond(surfaces, area_weight=np.True_),
        lambda: sp.correspond(surfaces, root=False),
        lambda: sp.remesh(surfaces, job.maps, frequency=True),
        lambda: sp.remesh(surfaces, job.maps, threads=True),
        lambda: sp.propagate(surfaces, job.root_map, parents=[True, -1], order="Given"),
        lambda: sp.shape_model(job.landmarks, job.landmark_faces, modes=True),
        lambda: sp.parameterise_root(first, area_weight=True),
        lambda: sp.make_phantom(phases=True),
    ):
        with pytest.raises(sp.InputError, match="True|False"):
            call()


def test_flags_are_those_of_the_filters():
    meshes = pymeshlab.MeshSet()
    meshes.create_cube()
    for name in plugin.filters():
        for key, value in meshes.filter_parameter_values(name).items():
            assert isinstance(value, bool) == (key in FLAGS) or key not in FLAGS, (name, key)


def test_the_advice_is_for_python(job):
    with pytest.raises(sp.InputError, match="takes two or more"):
        sp.correspond(job.surfaces[:1])
    with pytest.raises(sp.FilterError, match='^Surface ".*Give two surfaces or more.$'):
        sp.propagate(job.surfaces[:1], job.root_map)
    flipped = [m.positions[::-1] for m in job.maps]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with pytest.raises(sp.FilterError, match="^No surface has a valid map") as refused:
            sp.remesh(job.surfaces, flipped)
    assert "Run" not in str(refused.value)
    with pytest.raises(sp.FilterError, match=r"parameterise_root\(surface\) makes one.$"):
        sp.propagate(job.surfaces, flipped[0])
