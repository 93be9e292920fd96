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
