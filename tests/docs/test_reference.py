"""docs/filters.md is what the plugin says of itself, and what it says is so."""
import pymeshlab
import pytest

import reference
from pages import PROJECT

ARGUMENTS = {  # of a small run, by python name; filters that are not named are called without
    "create_ventricle_phantom": {"phases": 4, "voxel_size": 4.0},
    "generate_icosphere_remeshing": {"frequency": 3},
}


@pytest.fixture(scope="module")
def filters(plugin):
    return reference.descriptions(plugin)


def test_the_page_is_what_the_plugin_says(plugin):
    page = (PROJECT / "docs/filters.md").read_text()
    assert page == reference.page(plugin), "run scripts/make-reference"


def test_the_page_has_every_filter_of_the_plugin(filters):
    of_the_plugin = {f.get("python_name") for f in filters}
    assert len(of_the_plugin) >= 8
    assert of_the_plugin <= set(pymeshlab.filter_list())


def test_what_filters_return_is_what_they_say(filters):
    """Every key that comes back is explained, and no other is."""
    meshes = pymeshlab.MeshSet()
    for element in filters:  # in the order of the job
        name = element.get("python_name")
        returned = meshes.apply_filter(name, **ARGUMENTS.get(name, {}))
        assert sorted(returned) == sorted(reference.returned_keys(element)), name
