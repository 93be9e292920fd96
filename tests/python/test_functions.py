# SPDX-License-Identifier: GPL-3.0-only
"""The filters as functions on arrays: the same parameters, the same results, refusals that name
what is wrong."""

import inspect
import warnings
from dataclasses import replace

import numpy as np
import pymeshlab
import pytest
import sphere_propagation as sp
from sphere_propagation import filters, parameters, preparation
from sphere_propagation.surface import distinct_names, largest

# Function -> its filter, and the parameters of the filter that it does not have, with the reason.
FUNCTIONS = {
    sp.read_label_volume: (filters.IMPORT, {"file_name"}),  # which comes first
    sp.parameterise_root: (filters.ROOT, {"most_central"}),  # of one surface
    sp.propagate: (
        filters.PROPAGATE,
        {"anchors", "anchor_files"},
    ),  # of the same names, but with other values (test_python_anchors.py)
    sp.remesh: (
        filters.REMESH,
        {"color_landmarks", "landmark_colors", "beside_surfaces"},
    ),  # arrays of points have no colours and are nowhere shown
    sp.evaluate: (filters.EVALUATE, set()),
    sp.shape_model: (
        filters.MODEL,
        {"standard_deviations", "mode_layers", "beside_shapes", "surface_measures"},
    ),  # of the layers that show modes; and what is on where surfaces are given
    sp.map_colors: (
        filters.COLOR,
        {"store_area_ratio", "landmark_layers"},
    ),  # nor is there quality, nor landmark layers
    sp.optimise_groupwise: (filters.GROUPWISE, {"anchors"}),  # as of propagate
    sp.make_phantom: (filters.PHANTOM, set()),
    sp.prepare: (preparation.PREPARE, {"all_visible"}),  # there is one
}
CHOICES = {
    "initial_map": parameters.INITIAL_MAPS,
    "method": parameters.METHODS,
    "order": parameters.ORDERS,
    "part": filters.PARTS,
    "pattern": filters.PATTERNS,
    "alignment": filters.ALIGNMENTS,
    "coordinates": filters.COORDINATES,
    "lid": preparation.LIDS,
    "handle_repair": filters.HANDLE_REPAIRS,
}


def tetrahedron(scale=1.0):
    return np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]) * scale, np.array(
        [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]
    )


def keywords(function):
    return {
        name: parameter.default
        for name, parameter in inspect.signature(function).parameters.items()
        if parameter.kind is inspect.Parameter.KEYWORD_ONLY
    }


@pytest.mark.parametrize("function", FUNCTIONS, ids=lambda function: function.__name__)
def test_parameters_are_the_filters(function):
    name, left_out = FUNCTIONS[function]
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(*tetrahedron()))
    meant = meshes.filter_parameter_values(name)
    found = keywords(function)
    if function is sp.shape_model:
        del found["lid"]  # marks, which layers carry themselves
        del found["anchors"]  # the same
        del found["surfaces"]  # which are layers, too
        del found["landmark_names"]  # which are written into the file afterwards
    if function is sp.parameterise_root:
        del found["anchors"]  # which layers carry themselves
        assert found.pop("anchor_positions") is None and not meant.pop("anchor_positions")
    if function is sp.propagate:
        del found["anchors"], found["exact"]  # which are one there
    if function is sp.optimise_groupwise:
        del found["anchors"]
        # Which has fewer choices than that of a model, and another default.
        assert found.pop("alignment") == "Rigid" and meant.pop("alignment") == 0
        assert found.pop("objective") == "Population model" and meant.pop("objective") == 0
    assert set(found) == set(meant) - left_out
    for parameter, default in found.items():
        value = default
        if parameter in CHOICES:
            value = CHOICES[parameter].index(default)
        elif parameter == "leave_out_lids":
            value = list(filters.LID_RULES).index(default)
        assert (
            value == pytest.approx(meant[parameter], rel=1e-6)
            if isinstance(value, float)
            else value == meant[parameter]
        )
        assert type(value) is type(meant[parameter])
        # Which speak for themselves.
        assert parameter in function.__doc__ or parameter in ("seed", "phases")


@pytest.mark.parametrize("parameter", CHOICES)
def test_choices_are_the_filters(parameter, cycle, egg_file):
    """Every choice is accepted, and the filter knows no more: the number behind the last one is
    refused."""
    call = {
        "initial_map": lambda value: sp.parameterise_root(cycle.surfaces[0], initial_map=value),
        "method": lambda value: sp.propagate(cycle.surfaces[:2], cycle.root_map, method=value),
        "order": lambda value: sp.propagate(
            cycle.surfaces[:2],
            cycle.root_map,
            order=value,
            parents="-1, 0" if value == "Given" else "",
        ),
        "pattern": lambda value: sp.map_colors(cycle.surfaces[:1], cycle.maps[:1], pattern=value),
        "alignment": lambda value: sp.shape_model(
            cycle.landmarks,
            cycle.landmark_faces,
            alignment=value,
            anchors=[dict(zip("abc", shape)) for shape in cycle.landmarks],
        ),
        "coordinates": lambda value: sp.read_label_volume(egg_file, coordinates=value),
        "lid": lambda value: sp.prepare(cycle.surfaces[0], lid=value),
        "handle_repair": lambda value: sp.read_label_volume(egg_file, handle_repair=value),
        "part": lambda value: sp.make_phantom(part=value, phases=1, voxel_size=4),
    }[parameter]
    for choice in CHOICES[parameter]:
        call(choice)
    with pytest.raises(sp.FilterError):
        call("None of these")


def test_the_job_is_correspondence(cycle):
    assert cycle.landmarks.shape == (6, 162, 3) and cycle.landmark_faces.shape == (320, 3)
    assert cycle.figures["flipped_faces"].sum() == 0
    assert all(np.allclose(np.linalg.norm(sphere.positions, axis=1), 1) for sphere in cycle.maps)
    assert all(sphere.texture is not None for sphere in cycle.maps)
    errors = sp.Ventricle("Cavity", 6).errors(cycle.landmarks)
    assert errors[0] < 0.6 and errors.max() < 2.5  # mm; voxels are 4 mm


def test_the_functions_are_the_filters(cycle):
    """Layer by layer the same bits as a project in which the three filters run one after
    another."""
    meshes = pymeshlab.MeshSet()
    meshes.apply_filter(filters.PHANTOM, phases=6, voxel_size=4.0)
    meshes.apply_filter(filters.ROOT)
    meshes.apply_filter(filters.PROPAGATE, order="Cyclic time")
    meshes.apply_filter(filters.REMESH, frequency=4)
    for i, sphere in enumerate(cycle.maps):
        assert np.array_equal(
            sphere.positions, meshes.mesh(i).vertex_custom_point_attribute_matrix("sphere_position")
        )
        assert np.array_equal(sphere.texture, meshes.mesh(i).vertex_tex_coord_matrix())
        assert np.array_equal(cycle.landmarks[i], meshes.mesh(6 + i).vertex_matrix())


def test_arrays_will_do(cycle):
    """(vertices, faces), positions alone, lists, other types of numbers."""
    surfaces = [
        (surface.vertices.astype(np.float32).tolist(), surface.faces.astype(np.uint16))
        for surface in cycle.surfaces[:2]
    ]
    root = sp.parameterise_root(surfaces[0])
    assert set(root.figures) >= {"flipped_faces", "area_ratio_sd", "seconds"}
    found = sp.propagate(surfaces, root.positions.tolist())
    measures = sp.evaluate(surfaces, [sphere.positions for sphere in found.maps])
    assert measures["valid"].tolist() == [1, 1] and measures["degree"] == pytest.approx([1, 1])
    assert found.maps[1].figures["area_ratio_sd"] == pytest.approx(measures["area_ratio_sd"][1])
    assert sp.remesh(surfaces, found.maps, frequency=2).points.shape == (2, 42, 3)


def test_the_whole_jobs_parameters_are_its_functions():
    """correspond() has those of the three functions that it has a say in, with their defaults."""
    found = keywords(sp.correspond)
    assert set(found) - {"root_map", "progress", "unit"} == set(vars(parameters.DEFAULTS))
    for function in (sp.parameterise_root, sp.propagate, sp.remesh):
        for name, default in keywords(function).items():
            assert found.get(name, default) == default
    assert found["root"] is None and parameters.DEFAULTS.root is None


@pytest.mark.parametrize("parents", [[-1, 0, 0, 2], np.array([-1, 0, 0, 2]), (-1.0, 0, 0, 2)])
def test_parents_are_a_list(cycle, parents):
    found = sp.propagate(cycle.surfaces[:4], cycle.root_map, order="Given", parents=parents)
    assert found.figures["parent"].tolist() == [-1, 0, 0, 2]
    assert sp.correspond(cycle.surfaces[:4], order="Given", parents=parents, frequency=2).root == 0


@pytest.mark.parametrize(
    "text, numbers",
    [
        ("1,-1,1", [1, -1, 1]),
        ("1 -1 1", [1, -1, 1]),
        (" 1; -1;\t+1 ,", [1, -1, 1]),
        ("1,,-1,\n1", [1, -1, 1]),
        ("1,-1,1.0", None),
        ("1,-1,1_0", None),
        ("1,-1,a", None),
        ("1,-1,\N{ARABIC-INDIC DIGIT ONE}", None),
        ("1,-", None),
        ("", None),
    ],
)
def test_a_text_of_parents_is_read_as_the_filter_reads_it(cycle, text, numbers):
    three = cycle.surfaces[:3]

    def found(function, *arguments, **more):
        try:
            return function(*arguments, order="Given", parents=text, **more).figures["parent"]
        except (sp.InputError, sp.FilterError):
            return None

    by_filter = found(sp.propagate, three, cycle.maps[1], root_layer=1)
    by_package = found(sp.correspond, three, root_map=cycle.maps[1], frequency=1)
    for parents in (by_filter, by_package):
        assert (None if parents is None else parents.tolist()) == numbers


def test_parents_that_are_not_looked_at_are_warned_of(cycle):
    """Once, at the line of the caller."""
    two = cycle.surfaces[:2]
    for call in (
        lambda: sp.propagate(two, cycle.root_map, parents="-1, 0"),
        lambda: sp.propagate(two, cycle.root_map, order="Star", parents=[-1, 0]),
        lambda: sp.correspond(two, root_map=cycle.root_map, root=0, parents=[-1, 0], frequency=1),
    ):
        with pytest.warns(sp.SpherePropagationWarning, match="parents is not looked at") as warned:
            call()
        assert len(warned) == 1 and warned[0].filename == __file__


def test_a_map_of_another_surface_is_refused(cycle):
    """With and without texture coordinates, which PyMeshLab would refuse in words of its own."""
    other = next(
        i for i in range(1, 6) if len(cycle.maps[i].positions) != len(cycle.maps[0].positions)
    )
    for wrong in (cycle.maps[other], cycle.maps[other].positions):
        with pytest.raises(sp.InputError, match="vertices, its map"):
            sp.propagate(cycle.surfaces, wrong, root_layer=0)
        with pytest.raises(sp.InputError, match="vertices, its map"):
            sp.remesh(cycle.surfaces[:1], [wrong])


def test_the_most_landmarks_are_the_filters(cycle):
    """correspond() refuses too many before any work, the filter when the maps are there."""
    refused = 1000  # on two surfaces: four landmarks too many
    with pytest.raises(sp.FilterError, match=f"more than {filters.MAX_LANDMARKS}\\."):
        sp.remesh(cycle.surfaces[:2], cycle.maps[:2], frequency=refused)
    with pytest.raises(sp.InputError, match=f"between 1 and {refused - 1} for 2 surfaces"):
        sp.correspond(cycle.surfaces[:2], frequency=refused)


def test_a_surface_in_another_unit_is_warned_of(cycle):
    away = sp.Surface(cycle.surfaces[2].vertices * 10, cycle.surfaces[2].faces, "in tenths of mm")
    for function in (sp.propagate, sp.correspond):
        with pytest.warns(sp.SpherePropagationWarning) as warned:
            found = (
                function([*cycle.surfaces[:2], away], cycle.root_map)
                if function is sp.propagate
                else function([*cycle.surfaces[:2], away], root=0, frequency=1)
            )
        assert {w.message.layer for w in warned} == {away.name}
        said = [w.message.message for w in warned]
        assert said == ["anotherUnit"]
        assert all(w.filename == __file__ for w in warned)
        assert found.figures["distant"].tolist() == [0, 0, 0]


def test_the_largest_is_the_root(cycle):
    mixed = [cycle.surfaces[i] for i in (2, 0, 3)]
    assert sp.correspond(mixed, frequency=2).root == 1
    assert sp.correspond(mixed, frequency=2, root=2).root == 2


def test_a_root_of_another_size_is_not_chosen(cycle):
    surfaces = cycle.surfaces[:5]
    for k, factor in ((1, 1.6), (2, 10), (4, 1000)):
        odd = [
            replace(s, vertices=s.vertices * factor) if i == k else s
            for i, s in enumerate(surfaces)
        ]
        assert largest(odd) == largest(surfaces) == 0
    # Of three nobody can tell, and a large heart among small ones is one.
    few = [surfaces[0], replace(surfaces[1], vertices=surfaces[1].vertices * 10), surfaces[2]]
    assert largest(few) == 1
    grown = [
        replace(surfaces[0], vertices=surfaces[0].vertices * f) for f in (0.6, 0.7, 0.8, 1, 1.2)
    ]
    assert largest(grown) == 4


def family(steps):
    """Tetrahedra that are longer by step."""
    vertices, faces = tetrahedron()
    return [
        sp.Surface(vertices * [2 + 0.1 * step, 1.3, 1], faces, f"long {step}") for step in steps
    ]


def test_the_most_central_is_the_root_where_it_is_asked_for():
    surfaces = family([9, 0, 5, 8, 1])  # the largest first
    root, its_map = sp.parameterise_most_central(surfaces)
    assert root == 2
    assert np.array_equal(its_map.positions, sp.parameterise_root(surfaces[2]).positions)
    found = sp.correspond(surfaces, root="Most-central", order="Star", frequency=2)
    assert found.root == 2 and found.figures["parent"].tolist() == [2, 2, -1, 2, 2]
    assert sp.correspond(surfaces, order="Star", frequency=2).root == 0


def test_the_most_central_is_the_root_of_what_follows():
    meshes = pymeshlab.MeshSet()
    for surface in family([9, 0, 5, 8, 1]):
        meshes.add_mesh(pymeshlab.Mesh(surface.vertices, surface.faces))
    meshes.set_current_mesh(0)
    meshes.apply_filter(filters.ROOT)  # has a map, too
    meshes.apply_filter(filters.ROOT, most_central=True)
    assert meshes.current_mesh_id() == 2
    assert meshes.apply_filter(filters.PROPAGATE, order="Star")["parent"].tolist() == [
        *(2, 2, -1, 2, 2)
    ]


def test_models_are_measured_between_surfaces_in_the_order_of_the_shapes(cycle):
    landmarks = sp.remesh(cycle.surfaces, cycle.maps, frequency=5)
    plain = sp.shape_model(landmarks.points, landmarks.faces)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        model = sp.shape_model(landmarks.points, landmarks.faces, surfaces=cycle.surfaces)
    assert np.array_equal(model.scores, plain.scores) and not plain.surface_figures
    assert len(model.surface_figures["off_surface"]) == len(cycle.surfaces)
    with pytest.raises(sp.FilterError, match="in the order of the shapes"):
        sp.shape_model(landmarks.points, landmarks.faces, surfaces=cycle.surfaces[::-1])
    with pytest.raises(sp.InputError, match="must be one per shape"):
        sp.shape_model(landmarks.points, landmarks.faces, surfaces=cycle.surfaces[1:])


def test_the_most_central_has_the_map_and_the_parents_no_other_root():
    surfaces = family([0, 1, 2])
    with pytest.raises(sp.InputError, match="must be a number or 'most central'"):
        sp.correspond(surfaces, root="central")
    with pytest.raises(sp.InputError, match="Which surface has root_map"):
        sp.correspond(surfaces, root="most central", root_map=surfaces[0].vertices)
    with pytest.raises(sp.InputError, match="parents say that layer 0 is"):
        sp.correspond(surfaces, root="most central", order="Given", parents=[-1, 0, 1])


def test_a_map_that_is_not_valid_is_reported(cycle):
    flipped = cycle.maps[0].positions * [1, 1, -1]
    measures = sp.evaluate(cycle.surfaces[:2], [flipped, cycle.maps[1]])
    assert measures["valid"].tolist() == [0, 1] and measures["flipped_faces"][0] == len(
        cycle.surfaces[0].faces
    )


def test_the_same_place_has_the_same_colour(cycle):
    direction = sp.map_colors(cycle.surfaces[:2], cycle.maps[:2], pattern="Direction")
    assert [colors.shape for colors in direction] == [
        surface.vertices.shape for surface in cycle.surfaces[:2]
    ]
    near = (cycle.maps[0].positions @ cycle.maps[1].positions.T).argmax(1)
    assert (
        np.abs(direction[0] - direction[1][near]).max() < 0.2
        and np.ptp(direction[0], 0).min() > 0.5
    )


def test_names_are_told_apart():
    surfaces = [sp.Surface(*tetrahedron(), name) for name in ("a", "b", "a")]
    assert distinct_names(surfaces) == ["a (0)", "b", "a (2)"]


def test_volume_and_edges():
    surface = sp.Surface(*tetrahedron(3))
    assert surface.volume == pytest.approx(27 / 6)
    assert surface.mean_edge_length == pytest.approx((1 + 2**0.5) / 2 * 3)


V, F = tetrahedron()
REFUSED = {
    "shape (n, 3)": lambda c: sp.parameterise_root((V[:, :2], F)),
    "integers of shape": lambda c: sp.parameterise_root((V, F.astype(float))),
    "1 faces name a vertex that is not there (first: face 2": lambda c: sp.parameterise_root(
        (V, F + [[0], [0], [1], [0]])
    ),
    "not int": lambda c: sp.parameterise_root(7),
    "no surface": lambda c: sp.propagate([], c.root_map),
    "Layer 6 cannot be the root": lambda c: sp.propagate(c.surfaces, c.root_map, root_layer=6),
    "Layer -1 cannot": lambda c: sp.correspond(c.surfaces, root=-1),
    "method must be one of 'Robust'": lambda c: sp.correspond(c.surfaces, method="rigid"),
    "initial_map must be one of": lambda c: sp.correspond(c.surfaces, initial_map=""),
    "order must be one of": lambda c: sp.correspond(c.surfaces, order="cycle"),
    "area_weight must lie between": lambda c: sp.correspond(c.surfaces, area_weight=1.5),
    "area_restoration must lie between": lambda c: sp.correspond(
        c.surfaces, area_restoration=float("nan")
    ),
    "frequency must lie between 1 and 577": lambda c: sp.correspond(c.surfaces, frequency=0),
    "parents say that layer 0 is": lambda c: sp.correspond(
        c.surfaces[:2], root=1, order="Given", parents=[-1, 0]
    ),
    "positions": lambda c: sp.propagate(c.surfaces, c.maps[0].positions[1:]),
    "need as many maps, not 1": lambda c: sp.remesh(c.surfaces, c.maps[:1]),
    "Positions of a map": lambda c: sp.SphereMap(V[:, 0]),
}


@pytest.mark.parametrize("words", REFUSED)
def test_input_that_cannot_be_meant(words, cycle):
    with pytest.raises(sp.InputError) as refused:
        REFUSED[words](cycle)
    assert words in str(refused.value) and isinstance(refused.value, ValueError)


def test_filters_refuse_in_their_own_words(cycle):
    opened = sp.Surface(cycle.surfaces[0].vertices, cycle.surfaces[0].faces[1:], "my heart")
    with pytest.raises(sp.FilterError, match="my heart") as refused:
        sp.parameterise_root(opened)
    assert refused.value.filter == filters.ROOT and "Failed to apply" not in str(refused.value)
    with pytest.raises(sp.FilterError, match="area_weight|[Aa]rea weight"):
        sp.parameterise_root(cycle.surfaces[0], area_weight=2.0)
    with pytest.raises(sp.FilterError, match="wrong type: frequency='ten'"):
        sp.remesh(cycle.surfaces, cycle.maps, frequency="ten")
    with pytest.raises(sp.FilterError, match=r"^Not taken for surfaces: .*\. .* leave out"):
        sp.propagate(
            [*cycle.surfaces[:2], (cycle.landmarks[2], cycle.landmark_faces)], cycle.root_map
        )
    for error in (sp.FilterError, sp.InputError, sp.FileError, sp.PluginError):
        assert issubclass(error, sp.SpherePropagationError)


def test_a_mirrored_surface_is_reflected_and_returned(cycle):
    """The maps and landmarks are those of the reflected surface, which is what the result holds."""
    shapes = []
    for i, surface in enumerate(cycle.surfaces[:3]):
        v = surface.vertices - surface.vertices.mean(0)
        d = v / np.linalg.norm(v, axis=1, keepdims=True)
        bump = (
            1
            + 0.5 * np.exp(-4 * ((d - [0.6, 0.64, 0.48]) ** 2).sum(1))
            + 0.4 * np.exp(-6 * ((d - [-0.48, 0.6, 0.64]) ** 2).sum(1))
        )
        v, f = d * bump[:, None] * [40, 30, 22], surface.faces
        shapes.append(
            sp.Surface(v * [-1, 1, 1], f[:, [0, 2, 1]], "left")
            if i == 1
            else sp.Surface(v, f, f"right {i}")
        )
    made = sp.correspond(shapes, root=0, frequency=4, mirror_layers=True)
    assert made.figures["mirrored"].tolist() == [0, 1, 0]
    assert made.surfaces[0] is shapes[0] and made.surfaces[1].name == "left"
    was, now = shapes[1].vertices, made.surfaces[1].vertices
    assert (
        np.ptp(now[:, 0] + was[:, 0]) < 1e-9
        and np.array_equal(now[:, 1:], was[:, 1:])
        and made.surfaces[1].volume > 0
    )
    assert sp.evaluate(made.surfaces, made.maps)["valid"].all()
    assert not sp.propagate(shapes, made.root_map).figures["mirrored"].any()


def test_groupwise_moves_the_maps_of_a_population(cycle):
    surfaces = cycle.surfaces[:4]
    plain = sp.correspond(surfaces, order="Star", frequency=3)
    found = sp.correspond(surfaces, order="Star", frequency=3, groupwise=True)
    assert not np.allclose(plain.landmarks, found.landmarks, atol=1e-3)
    assert found.figures["flipped_faces"].sum() == 0
    assert (found.figures["tangential_move"] > 0).all()
    assert "tangential_move" not in plain.figures
    again = sp.optimise_groupwise(surfaces, plain.maps)
    assert all(np.array_equal(a.positions, b.positions) for a, b in zip(again.maps, found.maps))
    assert "Optimisation(4 maps, 0 flipped faces" in repr(again)
    measures = sp.evaluate(surfaces, again.maps)
    assert measures["valid"].all()


def test_groupwise_heeds_anchors(cycle, tmp_path):
    surfaces, maps = cycle.surfaces[:3], cycle.maps[:3]
    anchors = [dict(zip("abcd", shape[[0, 50, 100, 161]])) for shape in cycle.landmarks[:3]]
    anchors[1]["a"] = anchors[1]["a"] + 8 * (anchors[1]["b"] - anchors[1]["a"]) / np.linalg.norm(
        anchors[1]["b"] - anchors[1]["a"]
    )
    plain = sp.optimise_groupwise(surfaces, maps, iterations=2)
    found = sp.optimise_groupwise(surfaces, maps, iterations=2, anchors=anchors, anchor_sd=0.1)
    assert "anchor_distance_mean" not in plain.figures
    assert (found.figures["anchor_distance_mean"] < 4).all()
    assert not np.allclose(found.maps[1].positions, plain.maps[1].positions, atol=1e-3)
    for k, its in enumerate(anchors):
        rows = ["name,x,y,z", *(f"{name},{x},{y},{z}" for name, (x, y, z) in its.items())]
        (tmp_path / f"{k}.csv").write_text("\n".join(rows))
    named = [sp.Surface(s.vertices, s.faces, str(k)) for k, s in enumerate(surfaces)]
    again = sp.optimise_groupwise(named, maps, iterations=2, anchors=tmp_path, anchor_sd=0.1)
    assert all(
        np.allclose(a.positions, b.positions, atol=1e-5) for a, b in zip(found.maps, again.maps)
    )


def test_groupwise_says_that_it_is_not_for_motion(cycle):
    class Listener(sp.progress.Silent):
        notes = []

        def note(self, text):
            self.notes.append(text)

    sp.correspond(cycle.surfaces[:3], frequency=2, groupwise=True, progress=Listener())
    assert any("for shapes in no order" in text for text in Listener.notes)


def test_groupwise_refuses_in_the_filters_words(cycle):
    with pytest.raises(sp.FilterError, match="iterations"):
        sp.optimise_groupwise(cycle.surfaces[:2], cycle.maps[:2], iterations=0)
    with pytest.raises(sp.FilterError, match="only"):
        sp.optimise_groupwise(cycle.surfaces[:1], cycle.maps[:1])
