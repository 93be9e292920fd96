# SPDX-License-Identifier: GPL-3.0-only
"""docs/filters.md is what the plugins say of themselves, and what they say is so."""

import sys

import pymeshlab
import pytest
import reference
from pages import PROJECT

sys.path.insert(0, str(PROJECT / "tests/volumes"))
import volume_files

ARGUMENTS = {  # of a small run, by python name; filters that are not named are called without
    "create_ventricle_phantom": {"phases": 4, "voxel_size": 4.0},
    "transfer_spherical_parameterisation_to_layers": {"order": "Cyclic time"},
    "generate_icosphere_remeshing": {"frequency": 3},
}


@pytest.fixture(scope="module")
def filters(plugin):
    return reference.descriptions(plugin)


@pytest.fixture(scope="module")
def label_volume(tmp_path_factory):
    """A file to import."""
    path = tmp_path_factory.mktemp("labels") / "egg.nii"
    path.write_bytes(volume_files.nifti(volume_files.egg()))
    return path


def test_the_page_is_what_the_plugins_say(plugins):
    page = (PROJECT / "docs/filters.md").read_text()
    assert page == reference.page(plugins), "run scripts/make-reference"


def test_the_page_has_every_filter_of_the_plugins(filters, plugins):
    assert len(filters) >= 8
    every = filters + reference.descriptions(plugins / "libfilter_label_volume.so")
    assert {f.get("python_name") for f in every} <= set(pymeshlab.filter_list())


def require_what_is_said(element, returned):
    """Every key that comes back is explained, and no other is."""
    assert sorted(returned) == sorted(reference.returned_keys(element)), element.get("name")


def test_what_filters_return_is_what_they_say(filters, tmp_path):
    meshes = pymeshlab.MeshSet()
    for element in filters:  # in the order of the job
        name = element.get("python_name")
        arguments = dict(ARGUMENTS.get(name, {}))
        if name == "compute_statistical_shape_model":
            arguments.update(export_file=str(tmp_path / "model.npz"), surface_measures=True)
        if name == "compute_shape_model_fit":
            arguments.update(model_file=str(tmp_path / "model.npz"), target_layer=0)
        require_what_is_said(element, meshes.apply_filter(name, **arguments))


def test_what_the_import_returns_is_what_it_says(plugins, label_volume):
    (element,) = reference.descriptions(plugins / "libfilter_label_volume.so")
    require_what_is_said(
        element,
        pymeshlab.MeshSet().apply_filter(element.get("python_name"), file_name=str(label_volume)),
    )
