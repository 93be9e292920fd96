# SPDX-License-Identifier: GPL-3.0-only
"""What the filters warn of, as warnings of Python's: in their words, with the layer's name, once,
at the line of the caller."""

import pickle
import warnings

import numpy as np
import pymeshlab
import pytest
import sphere_propagation as sp
from sphere_propagation import attention, page, report


@pytest.fixture
def away(cycle):
    """Of three surfaces the second in another place."""
    moved = sp.Surface(cycle.surfaces[1].vertices + [500, 0, 0], cycle.surfaces[1].faces, "away")
    return [cycle.surfaces[0], moved, cycle.surfaces[2]]


def test_a_warning_says_whose_it_is(cycle, away):
    with pytest.warns(sp.SpherePropagationWarning) as warned:
        sp.propagate(away, cycle.root_map)
    (warning,) = (w.message for w in warned)
    assert (warning.layer, warning.message, warning.kind) == ("away", "anotherPose", "Warning")
    assert str(warning).startswith("away: it lies in another pose")
    assert warned[0].filename == __file__


def test_figures_have_no_warnings(cycle, away):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", sp.SpherePropagationWarning)
        found = sp.propagate(away, cycle.root_map)
        assert "warnings" not in found.figures
        unit = cycle.root_map.positions
        assert "warnings" not in sp.parameterise_root((unit, cycle.surfaces[0].faces)).figures


def test_the_whole_job_keeps_them_whatever_is_shown(away):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = sp.correspond(away, root=0, frequency=2)
    assert [(w.layer, w.message) for w in found.warnings] == [("away", "anotherPose")]
    assert attention._collecting.get() == ()


def test_they_can_be_errors(cycle, away):
    with warnings.catch_warnings():
        warnings.simplefilter("error", sp.SpherePropagationWarning)
        with pytest.raises(sp.SpherePropagationWarning, match="^away: "):
            sp.propagate(away, cycle.root_map)
        sp.propagate(cycle.surfaces[:2], cycle.root_map)  # nothing to say


def test_warnings_of_what_pymeshlab_returns(cycle, away):
    ms = pymeshlab.MeshSet()
    for surface in away:
        ms.add_mesh(pymeshlab.Mesh(surface.vertices, surface.faces), surface.name)
    ms.set_current_mesh(1)
    returned = ms.compute_spherical_parameterisation_root()
    assert sp.warnings_of(returned) == []
    (note,) = sp.warnings_of(returned, notes=True)
    assert (note.kind, note.message) == ("Note", "betterRoot")
    returned = ms.transfer_spherical_parameterisation_to_layers()
    assert {w.message for w in sp.warnings_of(returned)} == {"anotherPose"}
    assert sp.warnings_of({}) == sp.warnings_of({"warnings": np.zeros(0)}) == []


def test_a_warning_survives_pickling():
    warning = sp.SpherePropagationWarning("a: b", "a", "c")
    copy = pickle.loads(pickle.dumps(warning))
    assert (str(copy), copy.layer, copy.message, copy.kind) == ("a: b", "a", "c", "Warning")


def test_reports_list_them(away, tmp_path):
    with pytest.warns(sp.SpherePropagationWarning):
        result = sp.correspond(away, root=0, frequency=2)
    run = report.Run("heart", result, warnings=result.warnings)
    assert [row["warnings"] for row in report.rows(run)] == ["", "anotherPose", ""]
    (row,) = report.warning_rows([run])
    assert row[:4] == ["heart", "Robust", "away", "anotherPose"]
    assert row[4].startswith("it lies in another pose")
    (table,) = page.warning_tables([run])
    assert table.rows == [["heart", "Robust", "away", row[4]]]
    assert page.warning_tables([report.Run("heart", result)]) == []


def test_a_warning_of_several_surfaces_names_them():
    names = ["a phase 0", "a phase 1"]
    warning = sp.SpherePropagationWarning.of("a phases 0, 1", "they touch.", names, "touch")
    assert str(warning) == "a phases 0, 1: they touch."
    assert (warning.layer, warning.layers) == ("", tuple(names))
    assert (warning.subject, warning.said) == ("a phases 0, 1", "they touch.")
    copy = pickle.loads(pickle.dumps(warning))
    assert (str(copy), copy.layers, copy.said) == (str(warning), warning.layers, warning.said)
    one = sp.SpherePropagationWarning("b: it is flat.", "b")
    assert (one.layers, one.subject, one.said) == (("b",), "b", "it is flat.")


@pytest.fixture
def in_two_units(cycle):
    """The second half of six surfaces in cm; six are needed for a model to tell."""
    surfaces = [
        sp.Surface(s.vertices * (0.1 if i > 2 else 1) * (1 - 0.01 * i), s.faces, f"s{i}")
        for i, s in enumerate([cycle.surfaces[i % 3] for i in range(6)])
    ]
    return surfaces


def test_halves_of_two_units_are_named_alike_and_none_accused(in_two_units):
    with pytest.warns(sp.SpherePropagationWarning) as warned:
        found = sp.correspond(in_two_units, root=0, frequency=4)
        sp.shape_model(found.landmarks, found.landmark_faces, [s.name for s in in_two_units])
    of_sizes = [w.message for w in warned if w.message.message.startswith("halfOf")]
    assert [w.message for w in of_sizes] == ["halfOfLayersLarger", "halfOfShapesLarger"]
    assert {w.layers for w in of_sizes} == {("s0", "s1", "s2")}
    assert "(mm beside cm?)" in str(of_sizes[0]) and "(mm beside cm?)" in str(of_sizes[1])
    turned = in_two_units[::-1]
    with pytest.warns(sp.SpherePropagationWarning) as warned:
        sp.correspond(turned, root=0, frequency=4)
    (half,) = (w.message for w in warned if w.message.message.startswith("halfOf"))
    assert set(half.layers) == {"s0", "s1", "s2"}


def test_a_model_says_of_sizes_only_what_is_new(in_two_units):
    with pytest.warns(sp.SpherePropagationWarning):
        found = sp.correspond(in_two_units, root=0, frequency=4)
    names = [s.name for s in in_two_units]

    def said(before):
        with attention.collected() as told, attention.after(before), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            sp.shape_model(found.landmarks, found.landmark_faces, names)
        return [w.message for w in told]

    assert said(found.warnings) == []
    assert said([]) == ["halfOfShapesLarger"]
    assert said([w for w in found.warnings if w.message == "farOff"]) == ["halfOfShapesLarger"]


def test_every_layer_gets_its_mark_in_tables(in_two_units):
    with pytest.warns(sp.SpherePropagationWarning):
        result = sp.correspond(in_two_units, root=0, frequency=4)
    run = report.Run("heart", result, warnings=result.warnings)
    marked = [row["warnings"] for row in report.rows(run)]
    assert ["halfOfLayersLarger" in mark for mark in marked] == [True] * 3 + [False] * 3
    (row,) = (r for r in report.warning_rows([run]) if r[3] == "halfOfLayersLarger")
    assert row[2] == "s0; s1; s2"
    (table,) = page.warning_tables([run])
    assert ["heart", "Robust", "", row[4]] in table.rows


def test_the_truth_has_a_column_where_it_is_known(away, tmp_path):
    with pytest.warns(sp.SpherePropagationWarning):
        result = sp.correspond(away, root=0, frequency=2)
    for errors in (None, np.zeros(3)):
        report.write_csv(tmp_path / "f.csv", [report.Run("heart", result, errors)])
        header = (tmp_path / "f.csv").read_text().splitlines()[0].split(",")
        assert ("error_mm" in header) == (errors is not None)
