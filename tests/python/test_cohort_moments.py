# SPDX-License-Identifier: GPL-3.0-only
"""Count, mean and scatter in parts are those of all rows together, and so is the model."""

import numpy as np
import pytest
from sphere_propagation.cohort import merging, moments
from sphere_propagation.cohort.moments import Moments


def shapes(count, width, seed=0):
    """Rows around a mean far from the origin, whose variance falls by mode."""
    draw = np.random.default_rng(seed)
    rank = min(count, width, 60)
    modes = np.linalg.qr(draw.normal(size=(width, rank)))[0].T
    rows = draw.normal(size=(count, rank)) * 30 * 0.8 ** np.arange(rank)
    noise = 1e-3 * draw.normal(size=(count, width))
    return 100 + draw.normal(size=width) + rows @ modes + noise


def in_parts(rows, sizes, **limits):
    ends = np.cumsum([0, *sizes])
    whole = Moments.of(rows[:0], **limits)
    for begin, end in zip(ends, ends[1:]):
        whole = whole.plus(Moments.of(rows[begin:end], **limits), **limits)
    return whole


@pytest.mark.parametrize("limits", [{}, {"rank": 40}], ids=["factor", "matrix"])
def test_parts_make_the_whole(limits):
    rows = shapes(200, 300)
    whole = in_parts(rows, [1, 49, 0, 100, 50], **limits)
    assert (whole.factor is None) == bool(limits)
    assert whole.count == 200 and whole.lost == 0
    assert np.allclose(whole.mean, rows.mean(0), rtol=1e-13)
    away = rows - rows.mean(0)
    assert np.allclose(whole.as_matrix(), away.T @ away, rtol=0, atol=1e-8 * (away**2).sum())


def test_merging_is_as_good_as_one_decomposition_of_all_shapes():
    """2,000 shapes of 3006 coordinates, eigenvalues and modes to 1e-8 (here fewer coordinates, for
    time; the sums are the same)."""
    rows = shapes(2000, 606)
    whole = moments.merged(
        in_parts(rows[start : start + 500], [50] * 10) for start in range(0, 2000, 500)
    )
    values, modes, total = whole.principal(50)
    away = rows - rows.mean(0)
    _, singular, right = np.linalg.svd(away, full_matrices=False)
    direct = singular**2 / 1999
    assert np.allclose(values, direct[:50], rtol=1e-8, atol=1e-8 * direct[0])
    assert np.isclose(total, direct.sum(), rtol=1e-10)
    apart = np.abs(np.sum(modes[:20] * right[:20], 1))
    assert np.allclose(apart, 1, atol=1e-8)


def test_of_too_many_coordinates_a_factor_is_cut_down_and_says_what_went():
    rows = shapes(300, 400)
    whole = in_parts(rows, [30] * 10, rank=80, widest=100)
    assert whole.factor.shape == (80, 400)
    away = rows - rows.mean(0)
    exact = np.linalg.svd(away, compute_uv=False) ** 2
    values, _, total = whole.principal(40)
    assert 0 < whole.lost < 1e-6 * exact.sum()
    assert np.all(np.abs(values * 299 - exact[:40]) <= whole.lost)
    assert np.isclose(total * 299, exact.sum(), rtol=1e-12)


def test_what_is_merged_in_the_same_order_is_the_same_to_the_last_bit(tmp_path):
    rows = shapes(60, 30)
    for name in ("a", "b"):
        moments.write(tmp_path / f"{name}.npz", in_parts(rows, [10] * 6))
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()
    read = moments.read(tmp_path / "a.npz")
    assert np.array_equal(read.as_matrix(), in_parts(rows, [10] * 6).as_matrix())


@pytest.mark.parametrize("alignment", ["Similarity", "Rigid", "None"])
def test_shapes_are_laid_on_the_reference(alignment):
    draw = np.random.default_rng(3)
    reference = draw.normal(size=(42, 3)) * [3, 2, 1] + 10
    turn = np.linalg.qr(draw.normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    moved = 2 * (reference @ turn.T) + [5, -7, 100]
    found = merging.aligned(moved[None], reference, alignment)[0]
    if alignment == "Similarity":
        assert np.allclose(found, reference, atol=1e-9)
    elif alignment == "Rigid":
        expected = 2 * (reference - reference.mean(0)) + reference.mean(0)
        assert np.allclose(found, expected, atol=1e-9)
    else:
        assert np.array_equal(found, moved)


def test_a_mirror_image_is_not_turned_inside_out():
    reference = np.random.default_rng(4).normal(size=(42, 3)) * [3, 2, 1]
    found = merging.aligned((reference * [1, 1, -1])[None], reference, "Rigid")[0]
    assert not np.allclose(found, reference, atol=0.1)
    before, after = (np.linalg.det(one[:3] - one[3:6]) for one in (reference * [1, 1, -1], found))
    assert np.isclose(before, after)
