# SPDX-License-Identifier: GPL-3.0-only
"""sp.morph and `sphere-propagation morph`: shapes between shapes, also as GIF."""

import re

import numpy as np
import pytest
import sphere_propagation as sp
from sphere_propagation import command, pictures


def test_ends_are_the_surfaces_and_the_middle_is_the_mean(cycle):
    surfaces, maps = cycle.surfaces[:2], cycle.maps[:2]
    by_landmarks = sp.morph(surfaces, maps, steps=1, frequency=4)
    points = sp.remesh(surfaces, maps, frequency=4).points
    got = np.stack([surface.vertices for surface in by_landmarks.surfaces])
    np.testing.assert_allclose(got, [points[0], points.mean(0), points[1]], atol=1e-10)
    assert by_landmarks.share.tolist() == [0, 0.5, 1] and by_landmarks.between == [(0, 1)] * 3
    by_union = sp.morph(surfaces, maps, steps=1, connectivity="union")
    for end, surface in ((0, surfaces[0]), (-1, surfaces[1])):
        assert by_union.surfaces[end].volume == pytest.approx(surface.volume, rel=1e-9)
    counts = [len(surface.vertices) for surface in surfaces]
    assert len(by_union.surfaces[0].vertices) == sum(counts) + by_union.crossings
    assert by_union.surfaces[1].name == f"{surfaces[0].name} to {surfaces[1].name} 50 %"
    assert "3 shapes" in repr(by_union)
    figures = sp.evaluate([sp.Surface(*_of(by_union, 1), "half")], [by_union.maps[1]])
    assert figures["flipped_faces"][0] == 0


def _of(made, i):
    return made.surfaces[i].vertices, made.surfaces[i].faces


@pytest.mark.skipif(bool(pictures.what_is_missing()), reason="no pictures here")
def test_a_gif_goes_round_or_there_and_back(cycle, tmp_path):
    from PIL import Image

    for closed, frames in ((True, 2 * len(cycle.surfaces)), (False, 4 * (len(cycle.surfaces) - 1))):
        made = sp.morph(cycle.surfaces, cycle.maps, steps=1, frequency=4, closed=closed)
        with Image.open(made.write_gif(tmp_path / "a.gif", size=64, seconds=2)) as picture:
            assert picture.n_frames == frames and picture.size == (64, 64)
            assert picture.info["loop"] == 0
            first = np.asarray(picture.convert("RGB")).astype(int)
            picture.seek(2)
            assert np.abs(np.asarray(picture.convert("RGB")) - first).max() > 50
    with pytest.raises(sp.InputError, match="size must be"):
        made.write_gif(tmp_path / "a.gif", size=2)
    with pytest.raises(sp.FileError, match="cannot be written"):
        made.write_gif(tmp_path / "no folder/a.gif", size=32)


def test_the_command_leaves_shapes_and_a_gif(cycle, tmp_path, capsys):
    for surface, name in zip(cycle.surfaces[:2], "AB"):
        sp.write_ply(tmp_path / f"{name}.ply", surface.vertices, surface.faces)
    words = ["morph", tmp_path / "A.ply", tmp_path / "B.ply", "-o", tmp_path / "out"]
    assert command.main([*words, "--steps", "2", "--connectivity", "union"]) == 0
    found = sorted(path.name for path in (tmp_path / "out").glob("*.ply"))
    assert found == [
        "000_A_to_B_0.ply",
        "001_A_to_B_33.33.ply",
        "002_A_to_B_66.67.ply",
        "003_A_to_B_100.ply",
    ]
    assert (tmp_path / "out/morph.gif").exists() == (not pictures.what_is_missing())
    assert re.search(r"4 shapes, volume [\d.]+ to [\d.]+ ml\n", capsys.readouterr().out)
    assert command.main([*words, "--steps", "1", "--unit", "px"]) == 0
    assert re.search(r"volume \S+ to \S+ px³\n", capsys.readouterr().out)
    assert command.main([*words, "--unit", "two words"]) == 2
    assert "unit must be a short word" in capsys.readouterr().err
    assert command.main(["morph", str(tmp_path / "A.ply"), "-o", str(tmp_path / "out")]) == 2
    assert "two surfaces at least" in capsys.readouterr().err


def test_wrong_arguments_are_named(cycle):
    with pytest.raises(sp.InputError, match="as many maps"):
        sp.morph(cycle.surfaces[:2], cycle.maps[:1])
    with pytest.raises(sp.FilterError, match="connectivity must be one of"):
        sp.morph(cycle.surfaces[:2], cycle.maps[:2], connectivity="both")
    with pytest.raises(sp.FilterError, match="only visible surface with a map"):
        sp.morph(cycle.surfaces[:1], cycle.maps[:1])
