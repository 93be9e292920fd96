# SPDX-License-Identifier: GPL-3.0-only
"""Bad input: each case is refused with an error that says what is wrong and what mends it, and
changes nothing; or it works."""

import re
import resource

import numpy as np
import pymeshlab
import pytest
import surfaces
from documents import (
    ATTRIBUTE,
    COLOR,
    EVALUATE,
    MODEL,
    PHANTOM,
    PROPAGATE,
    REMESH,
    ROOT,
    SPHERES,
    add,
    apply_by_menu_name,
    layers,
    mapped_cycle,
    positions,
    refused,
    small_cycle,
    snapshot,
    written_script,
)
from surfaces import egg

NAN, INF = float("nan"), float("inf")

# Name: the mesh, what the error says (cause, count, first index), and the menu's filters that mend
# it with their texts. None where nothing can be mended in MeshLab without rebuilding the surface.
SELECT_NAN = ("Conditional Vertex Selection", {"condSelect": "x-x+y-y+z-z != 0"})
DEFECTS = {
    "not closed": (
        surfaces.open_egg,
        [
            "it is not closed",
            "3 edges have a face on one side only",
            "the first at face",
            "1 opening, the largest of 3 edges",
            "must be 4 or more",
        ],
        ["Close Holes"],
    ),
    "two parts": (surfaces.two_parts, ["2 separate parts", "vertex 142"], None),
    "small second part": (
        surfaces.small_second_part,
        ["2 separate parts", "vertex 142"],
        ["Remove Isolated pieces (wrt Face Num.)"],
    ),
    "handle": (surfaces.torus, ["1 handle (genus 1)"], None),
    "non-manifold edge": (
        surfaces.fin_on_an_edge,
        ["1 edge has more than two faces", "the first at face"],
        ["Prepare surface"],
    ),
    "non-manifold vertex": (
        surfaces.pinched_at_a_vertex,
        ["at 1 vertex sheets touch", "the first is vertex 0"],
        ["Repair non Manifold Vertices by splitting", "Remove Isolated pieces (wrt Face Num.)"],
    ),
    "one face turned": (
        surfaces.one_face_turned,
        ["not oriented alike", "3 edges lie between", "the first at face"],
        ["Re-Orient all faces coherently"],
    ),
    "half the faces turned": (
        surfaces.half_the_faces_turned,
        ["not oriented alike", "edges lie between", "the first at face"],
        ["Re-Orient all faces coherently"],
    ),
    "inward": (surfaces.inside_out, ["oriented inwards"], ["Invert Faces Orientation"]),
    "nan": (
        lambda: surfaces.with_coordinate(NAN),
        ["1 vertex has coordinates that are not finite", "vertex 17"],
        [SELECT_NAN, "Delete Selected Vertices", "Close Holes"],
    ),
    "infinite": (
        lambda: surfaces.with_coordinate(-INF),
        ["1 vertex has coordinates that are not finite", "vertex 17"],
        [SELECT_NAN, "Delete Selected Vertices", "Close Holes"],
    ),
    "empty": (surfaces.empty, ["it is empty"], None),
    "points only": (surfaces.points_only, ["it has vertices but no faces"], None),
    "three vertices": (surfaces.three_vertices, ["it has 3 vertices", "at least four"], None),
    "unreferenced vertices": (
        surfaces.unreferenced_vertices,
        ["2 vertices belong to no face", "the first is vertex 142"],
        ["Remove Unreferenced Vertices"],
    ),
    "duplicated vertices": (
        surfaces.unwelded,
        ["it is not closed", "840 edges", "698 vertices lie exactly where another one lies"],
        ["Remove Duplicate Vertices"],
    ),
    "a vertex twice in a face": (
        surfaces.face_with_a_vertex_twice,
        ["1 face uses one vertex twice", "the first is face 280"],
        ["Remove Zero Area Faces"],
    ),
    "flat": (surfaces.flat, ["all its faces have zero area"], None),
}
LABEL = "bad layer.ply"


@pytest.fixture(params=DEFECTS, ids=str)
def defect(request):
    return DEFECTS[request.param]


def name_of(step):
    return step if isinstance(step, str) else step[0]


def says(defect):
    """Words that the error must contain: the layer, the cause, and the menu names of the filters
    that mend it."""
    _, words, remedy = defect
    return [f'"{LABEL}"', *words] + [f'"{name_of(step)}"' for step in remedy or []]


def add_empty(ms, label):
    """PyMeshLab takes no empty mesh, so one is emptied."""
    add(ms, *egg(), label)
    ms.apply_filter("set_selection_all")
    ms.apply_filter("meshing_remove_selected_vertices_and_faces")
    assert ms.current_mesh().vertex_number() == 0
    return ms.current_mesh()


def add_decorated(ms, v, f, label):
    """A layer with everything a user may have put on it, all of which must survive a failure."""
    if len(v) == 0:
        return add_empty(ms, label)
    random = np.random.default_rng(len(v))
    colours = random.integers(0, 256, (len(v), 4)) / 255
    add(
        ms,
        v,
        f,
        label,
        v_color_matrix=colours,
        v_scalar_array=random.random(len(v)),
        f_scalar_array=random.random(len(f)),
        v_tex_coords_matrix=random.random((len(v), 2)),
        v_normals_matrix=random.random((len(v), 3)),
    )
    mesh = ms.current_mesh()
    mesh.add_vertex_custom_point_attribute(random.random((len(v), 3)), "of_the_user")
    mesh.add_vertex_custom_scalar_attribute(random.random(len(v)), "number_of_the_user")
    ms.apply_filter("compute_selection_by_condition_per_vertex", condselect="x > 0")
    return mesh


def test_the_size_that_is_named_closes_the_holes():
    """Larger than MeshLab's default, and no larger than need be."""
    vertices, faces = egg(10, 91)
    fans = [0, len(vertices) - 1]
    faces = faces[~np.isin(faces, fans).any(1)]
    ms = pymeshlab.MeshSet()
    add(ms, vertices[1:-1], faces - 1, "open at both ends")
    with pytest.raises(pymeshlab.PyMeshLabException, match="2 openings, the largest of 91") as e:
        ms.apply_filter(ROOT)
    size = int(re.search(r"must be (\d+) or more", str(e.value))[1])
    ms.meshing_close_holes(maxholesize=size - 1)
    assert ms.current_mesh().face_number() == len(faces)
    ms.meshing_close_holes(maxholesize=size)
    assert ms.apply_filter(ROOT)["flipped_faces"] == 0


# ------------------------------------------------ meshes that are not closed surfaces


def test_the_root(defect):
    ms = mapped_cycle(1)
    add_decorated(ms, *defect[0](), LABEL)
    with refused(ms, *says(defect)):
        ms.apply_filter(ROOT)


def test_a_layer_to_propagate_to(defect):
    ms = mapped_cycle(2)
    add_decorated(ms, *defect[0](), LABEL)
    add(ms, *egg(), "after it")
    ms.set_current_mesh(0)
    for method in ("Robust", "As published"):
        with refused(ms, *says(defect)):
            ms.apply_filter(PROPAGATE, method=method)


@pytest.mark.parametrize("case", [name for name in DEFECTS if name != "empty"])
@pytest.mark.parametrize("name", [REMESH, EVALUATE, SPHERES])
def test_a_layer_that_carries_positions(case, name):
    """A bad layer that seems to have a map is named, whichever filter meets it."""
    ms = mapped_cycle(1)
    mesh = add_decorated(ms, *DEFECTS[case][0](), LABEL)
    anything = np.random.default_rng(1).normal(size=(mesh.vertex_number(), 3))
    mesh.add_vertex_custom_point_attribute(
        anything / np.linalg.norm(anything, axis=1, keepdims=True), ATTRIBUTE
    )
    with refused(ms, *says(DEFECTS[case])):
        ms.apply_filter(name)


@pytest.mark.parametrize("name", [n for n in DEFECTS if DEFECTS[n][2]])
def test_what_the_error_names_mends_it(name, tmp_path):
    """The filters that the error names exist in MeshLab's menu, and after them the root's map can
    be made."""
    make, _, remedy = DEFECTS[name]
    ms = pymeshlab.MeshSet()
    add(ms, *make(), LABEL)
    for step in remedy:
        step, texts = (step, {}) if isinstance(step, str) else step
        apply_by_menu_name(ms, tmp_path / "mend.mlx", step, **texts)
    returned = ms.apply_filter(ROOT)
    assert returned["flipped_faces"] == 0
    assert ms.current_mesh().vertex_number() > 100


@pytest.mark.parametrize(
    "name", [name for name, defect in DEFECTS.items() if defect[2] or "parts" in name]
)
def test_prepare_surface_is_named_first_and_mends_it(name, tmp_path):
    ms = pymeshlab.MeshSet()
    add(ms, *DEFECTS[name][0](), LABEL)
    with refused(ms, '"Prepare surface"') as refusal:
        ms.apply_filter(ROOT)
    named = re.findall(r'"[A-Z][A-Za-z :]+ [A-Za-z :]+"', str(refusal.value))
    assert named[0] == '"Prepare surface"'
    apply_by_menu_name(ms, tmp_path / "mend.mlx", "Prepare surface")
    assert ms.apply_filter(ROOT)["flipped_faces"] == 0


@pytest.mark.parametrize(
    "menu_name, python_name, parameters",
    [
        (
            "Surface Reconstruction: Screened Poisson",
            "generate_surface_reconstruction_screened_poisson",
            {"depth": 3},
        ),
        (
            "Remeshing: Isotropic Explicit Remeshing",
            "meshing_isotropic_explicit_remeshing",
            {"iterations": 1},
        ),
    ],
)
def test_other_filters_that_errors_name_exist(menu_name, python_name, parameters, tmp_path):
    ms = pymeshlab.MeshSet()
    add(ms, *egg(), "egg")
    ms.apply_filter(python_name, **parameters)
    assert written_script(ms, tmp_path / "script.mlx")[0][0] == menu_name


def test_menu_names_that_do_not_exist_would_be_found(tmp_path):
    with pytest.raises(pymeshlab.PyMeshLabException):
        apply_by_menu_name(small_cycle(1), tmp_path / "script.mlx", "Close the Holes")


def test_zero_area_faces_work(measure):
    ms = pymeshlab.MeshSet()
    v, f = surfaces.zero_area_faces()
    assert (measure.triangle_areas(v, f) == 0).sum() >= 6
    for label in ("one", "two"):
        add(ms, v, f, label)
    returned = ms.apply_filter(ROOT)
    assert returned["flipped_faces"] == 0 and returned["area_ratio_sd"] < 0.05
    for method in ("Robust", "As published"):
        returned = ms.apply_filter(PROPAGATE, method=method)
        for mesh in ms:
            figures = measure.map_figures(v, f, positions(mesh))
            assert figures["flips"] == 0 and figures["degree"] == pytest.approx(1)
    ms.apply_filter(REMESH)
    assert np.isfinite(layers(ms)[2].vertex_matrix()).all()


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_any_unit_of_length_works(scale):
    v, f = egg()
    ms = pymeshlab.MeshSet()
    add(ms, v * scale + 3 * scale, f, "egg")
    returned = ms.apply_filter(ROOT)
    assert returned["flipped_faces"] == 0
    add(ms, v, f, "egg in mm")
    assert returned["area_ratio_sd"] == pytest.approx(
        ms.apply_filter(ROOT)["area_ratio_sd"], rel=0.01
    )


def flattened(ms, number):
    """Gives a layer a matrix that maps it into an oblique plane."""
    axis = np.array([1.0, 2, 3]) / np.sqrt(14)
    m = np.eye(4)
    m[:3, :3] -= np.outer(axis, axis)
    ms.set_current_mesh(number)
    ms.apply_filter("set_matrix", transformmatrix=m, freeze=False)


def scaled(ms, number, scale):
    ms.set_current_mesh(number)
    ms.apply_filter("set_matrix", transformmatrix=np.diag([scale, scale, scale, 1]), freeze=False)


NOT_COMPUTABLE = {
    "flattened by its matrix": (
        flattened,
        "it is flat: all its vertices lie in one plane",
        "Matrix: Reset Current Matrix",
    ),
    "too large": (
        lambda ms, n: scaled(ms, n, 1e160),
        "its coordinates reach",
        "Transform: Scale, Normalize",
    ),
    "a little too large": (
        lambda ms, n: scaled(ms, n, 1e52),
        "beyond 1e+50 nothing can be computed",
        "Transform: Scale, Normalize",
    ),
    "too small": (
        lambda ms, n: scaled(ms, n, 1e-160),
        "below 1e-50 nothing can be computed",
        "Transform: Scale, Normalize",
    ),
}


@pytest.mark.parametrize("case", NOT_COMPUTABLE)
@pytest.mark.parametrize("name", [ROOT, PROPAGATE, REMESH, EVALUATE, SPHERES, COLOR, MODEL])
def test_what_cannot_be_computed_with_is_refused(name, case):
    """Topologically all is well, and there are maps."""
    spoil, *words = NOT_COMPUTABLE[case]
    ms = mapped_cycle(3)
    if name == MODEL:
        ms.apply_filter(REMESH)
    bad = 4 if name == MODEL else 1
    spoil(ms, bad)
    with refused(ms, f'"{ms.mesh(bad).label()}"', *words):
        ms.apply_filter(name)


@pytest.mark.parametrize("scale", [1e-45, 1e45])
def test_the_figures_are_right_up_to_these_bounds(scale):
    found = []
    for unit in (1, scale):
        ms = pymeshlab.MeshSet()
        for widening in (1, 1.1, 1.15):
            v, f = egg()
            add(ms, v * [widening, 1, 1] / 35 * unit, f, str(widening))
        ms.set_current_mesh(0)
        ms.apply_filter(ROOT)
        propagated = ms.apply_filter(PROPAGATE)
        remeshed = ms.apply_filter(REMESH)
        model = ms.apply_filter(MODEL)
        found.append(
            np.concatenate(
                [
                    propagated["area_ratio_sd"],
                    propagated["residual_mean"] / unit,
                    remeshed["surface_distance_mean"] / unit,
                    model["eigenvalues"] / unit / unit,
                ]
            )
        )
    assert found[1] == pytest.approx(found[0], rel=1e-3, abs=1e-6)


def test_the_smallest_surface_works():
    ms = pymeshlab.MeshSet()
    v, f = surfaces.tetrahedron([0, 0, 0], [10, 0, 0], [0, 10, 0], [0, 0, -10])
    add(ms, v, f, "tetrahedron")
    assert ms.apply_filter(ROOT)["flipped_faces"] == 0
    ms.apply_filter(REMESH)


# ---------------------------------------------------------------- layers


@pytest.mark.parametrize("name", [ROOT, PROPAGATE, REMESH, EVALUATE, SPHERES])
def test_no_layer_at_all(name):
    ms = pymeshlab.MeshSet()
    with refused(ms):
        ms.apply_filter(name)


@pytest.mark.parametrize("name", [PROPAGATE, REMESH, EVALUATE, SPHERES])
def test_no_visible_layer(name):
    ms = mapped_cycle(2)
    for mesh in layers(ms):
        ms.set_mesh_visibility(mesh.id(), False)
    with refused(ms, "No surface layer is visible", "show them"):
        ms.apply_filter(name)


@pytest.mark.parametrize("name", [REMESH, EVALUATE, SPHERES])
def test_no_layer_with_a_map(name):
    ms = small_cycle(2)
    with refused(ms, "No visible surface layer", "Spherical parameterise root"):
        ms.apply_filter(name)


def test_a_root_without_a_map():
    ms = small_cycle(3)
    with refused(ms, '"phantom cavity 00"', "has no map", "Spherical parameterise root"):
        ms.apply_filter(PROPAGATE)
    ms.apply_filter(ROOT)
    with refused(ms, '"phantom cavity 02"', "has no map"):
        ms.apply_filter(PROPAGATE, root_layer=2)


def test_one_layer_only():
    ms = mapped_cycle(3)
    for hidden in (1, 2):
        ms.set_mesh_visibility(hidden, False)
    with refused(ms, '"phantom cavity 00"', "only visible surface"):
        ms.apply_filter(PROPAGATE)
    assert len(ms.apply_filter(EVALUATE)["valid"]) == 1
    assert len(ms.apply_filter(REMESH)["seconds"]) == 1


def test_a_hidden_root():
    ms = mapped_cycle(3)
    ms.set_mesh_visibility(0, False)
    with refused(ms, '"phantom cavity 00" cannot be the root', "hidden"):
        ms.apply_filter(PROPAGATE, root_layer=0)


def test_a_landmark_layer_as_root():
    ms = mapped_cycle(2)
    ms.apply_filter(REMESH)
    with refused(ms, '"phantom cavity 00 landmarks" cannot be the root', "landmarks"):
        ms.apply_filter(PROPAGATE, root_layer=2)


@pytest.mark.parametrize("number", [77, -1])
def test_a_root_that_does_not_exist(number):
    ms = mapped_cycle(2)
    with refused(ms):
        ms.apply_filter(PROPAGATE, root_layer=number)


# ---------------------------------------------------------------- parameters


@pytest.mark.parametrize("weight", [-1, -0.01, 1.01, 2, NAN, INF])
def test_area_weight_out_of_range(weight):
    ms = small_cycle(1)
    with refused(ms, "area weight must lie between 0 and 1"):
        ms.apply_filter(ROOT, area_weight=weight)


@pytest.mark.parametrize("amount", [-1, 1.01, NAN])
def test_area_restoration_out_of_range(amount):
    ms = mapped_cycle(2)
    with refused(ms, "area restoration must lie between 0 and 1"):
        ms.apply_filter(PROPAGATE, area_restoration=amount)


@pytest.mark.parametrize(
    "choice", [{"method": "Best"}, {"order": "Random"}, {"method": 2}, {"order": -1}]
)
def test_choices_that_do_not_exist(choice):
    ms = mapped_cycle(2)
    before = snapshot(ms)
    with pytest.raises(pymeshlab.InvalidEnumException):
        ms.apply_filter(PROPAGATE, **choice)
    assert snapshot(ms) == before


@pytest.mark.parametrize(
    "text, words",
    [
        ("", ["0 numbers for 3 surface layers"]),
        ("-1 0", ["2 numbers for 3 surface layers"]),
        ("-1 0 1 2", ["4 numbers for 3 surface layers"]),
        ("-1 0 one", ['"one" is not a layer number']),
        ("-1 0 1.5", ['"1.5" is not a layer number']),
        ("-1 0 99999999999999999999", ["is not a layer number"]),
        ("-1 0 7", ['layer "phantom cavity 02"', "layer 7", "not a visible surface layer"]),
        ("-1 -1 0", ["the root (-1)"]),
        ("1 2 1", ["root"]),
        ("-1 2 1", ["from itself"]),
        ("-1 1 1", ["from itself"]),
        ("1 -1 0", ['the root (-1) is layer "phantom cavity 01"', '"phantom cavity 00"']),
        ("-1 0 -2", ["-2"]),
    ],
)
def test_bad_parents(text, words):
    ms = mapped_cycle(3)
    with refused(ms, *words):
        ms.apply_filter(PROPAGATE, order="Given", parents=text, root_layer=0)


@pytest.mark.parametrize(
    "name, words",
    [
        ("smoothing_sweeps", "smoothing sweeps must be 0 or more; it is -1"),
        ("icp_iterations", "-1"),
    ],
)
def test_negative_numbers_of_steps(name, words):
    ms = mapped_cycle(2)
    with refused(ms, words):
        ms.apply_filter(PROPAGATE, method="As published", **{name: -1})


@pytest.mark.parametrize(
    "parameters, words",
    [
        ({"phases": 0}, "phases"),
        ({"phases": -3}, "phases"),
        ({"phases": 10001}, "phases"),
        ({"voxel_size": 0}, "voxel size"),
        ({"voxel_size": -2}, "voxel size"),
        ({"voxel_size": 0.01}, "voxel size"),
        ({"voxel_size": 100}, "voxel size"),
        ({"voxel_size": NAN}, "voxel size"),
        ({"twist": 361}, "twist"),
        ({"twist": NAN}, "twist"),
        ({"seed": -1}, "seed"),
    ],
)
def test_bad_phantoms(parameters, words):
    ms = mapped_cycle(1)
    with refused(ms, words, "must"):
        ms.apply_filter(PHANTOM, **parameters)


def peak_memory():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024  # MB


@pytest.mark.parametrize(
    "frequency, words",
    [
        (0, "1 or more; it is 0"),
        (-1, "1 or more; it is -1"),
        (1001, "the largest frequency is 1000"),
        (100000, "the largest frequency is 1000"),
        (2**31 - 1, "the largest frequency is 1000"),
        (-(2**31), "1 or more"),
        (1000, "30000006 landmarks"),  # in the range, but too much for three layers
    ],
)
def test_absurd_frequencies(frequency, words):
    """They are refused before anything is allocated."""
    ms = mapped_cycle(3)
    before = peak_memory()
    with refused(ms, words):
        ms.apply_filter(REMESH, frequency=frequency)
    assert peak_memory() - before < 50
