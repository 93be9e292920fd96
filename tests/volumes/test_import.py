# SPDX-License-Identifier: GPL-3.0-only
"""The filter "Import label volume as layers": formats, places in space, parameters, real hearts,
bad files."""

import gzip
import json
import re
import resource
import time

import numpy as np
import pymeshlab
import pytest
import volume_files as files
from documents import content, failed, snapshot
from environment import DATA, require
from filter_log import lines_of
from scipy.spatial import cKDTree

IMPORT = "create_layers_from_label_volume"
OBLIQUE = np.array(
    [[1.2, 0.5, 0.1, 12], [-0.5, 1.1, 0.3, -40], [0.02, -0.4, 1.4, 80], [0, 0, 0, 1]]
)
TO_LPS = np.diag([-1.0, -1, 1, 1])


def imported(path, **parameters):
    ms = pymeshlab.MeshSet()
    return ms, ms.apply_filter(IMPORT, file_name=str(path), **parameters)


def remarks_called(message, returned):
    remarks = json.loads(bytes(map(int, returned.get("warnings", b"[]"))).decode())
    return [remark for remark in remarks if remark["message"] == message]


def written(folder, name, data):
    path = folder / name
    path.write_bytes(data)
    return path


def centre_of(labels, matrix):
    """Where the middle of the labelled voxels lies."""
    return matrix[:3, :3] @ np.argwhere(labels).mean(0) + matrix[:3, 3]


def require_sphere(mesh):
    measures = pymeshlab.MeshSet()
    measures.add_mesh(mesh)
    topology = measures.apply_filter("get_topological_measures")
    assert topology["is_mesh_two_manifold"] and topology["boundary_edges"] == 0
    assert topology["connected_components_number"] == 1 and topology["genus"] == 0
    assert measures.apply_filter("get_geometric_measures")["mesh_volume"] > 0


# ---------------------------------------------------------------- the contract


def test_parameters_and_their_defaults():
    ms = pymeshlab.MeshSet()
    assert ms.filter_parameter_values(IMPORT) == {
        "file_name": "",
        "labels": "1",
        "voxel_size": 0.0,
        "smoothing": 1.0,
        "coordinates": 0,
        "fill_holes": True,
        "keep_largest_component": True,
        "cut_handles": True,
        "handle_repair": 0,
        "align_slices": False,
        "file_series": False,
        "skip_incomplete_phases": False,
        "longest_gap": 10,
    }


def test_one_entry_per_layer(tmp_path):
    _, returned = imported(
        written(tmp_path, "two.nii", files.nifti(np.stack([files.egg()] * 2, -1)))
    )
    assert returned.pop("layers") == 2
    assert all(len(values) == 2 for values in returned.values())
    assert set(returned) == {
        "phase",
        "label_volume",
        "volume",
        "vertices",
        "interpolated_slices",
        "dropped_share",
        "filled_voxels",
        "handles",
        "changed_voxels",
        "thin",
        "seconds",
    }


def test_a_second_run_replaces_the_layers(tmp_path):
    path = written(tmp_path, "egg.nii", files.nifti(files.egg()))
    ms, _ = imported(path)
    ms.apply_filter(IMPORT, file_name=str(path), voxel_size=2)
    assert [m.label() for m in ms] == ["egg label 1"]
    two = files.egg() + files.egg(value=0)
    two[:10] *= 2
    path.write_bytes(files.nifti(two))
    ms.apply_filter(IMPORT, file_name=str(path), labels="2")
    assert [m.label() for m in ms] == ["egg label 1", "egg label 2"]


# ------------------------------------------------ imports into one project, one after another


def labels_of(ms):
    return [m.label() for m in ms]


def phases_of(count, shift=0):
    """A 4D file of eggs."""
    return files.nifti(np.stack([np.roll(files.egg(), t + shift, 0) for t in range(count)], -1))


def patients(folder, data_a, data_b, name="seg.nii"):
    """Two files of one name: patient a's and patient b's."""
    paths = []
    for patient, data in (("a", data_a), ("b", data_b)):
        (folder / patient).mkdir()
        paths.append(written(folder / patient, name, data))
    return paths


def test_another_patients_file_of_the_same_name_gets_layers_of_its_own(tmp_path):
    a, b = patients(tmp_path, phases_of(3), phases_of(2, shift=4))
    ms, _ = imported(a)
    held = [content(m) for m in ms]
    ms.apply_filter(IMPORT, file_name=str(b))
    of_a, of_b = (
        [f"seg label 1 phase {t:02d}" for t in range(3)],
        [f"seg (b) label 1 phase {t:02d}" for t in range(2)],
    )
    assert labels_of(ms) == of_a + of_b
    assert [content(m) for m in ms][:3] == held
    for path in (b, a, b):  # again: each replaces its own
        ms.apply_filter(IMPORT, file_name=str(path), voxel_size=2)
        assert labels_of(ms) == of_a + of_b
    assert np.allclose(
        ms.mesh(3).vertex_matrix().mean(0) - ms.mesh(0).vertex_matrix().mean(0), [4, 0, 0], atol=0.3
    )


def test_a_third_folder_of_the_same_name(tmp_path):
    """The folder's name does not tell them apart either."""
    ms = pymeshlab.MeshSet()
    for parent in ("x", "y", "z"):
        (tmp_path / parent / "scan").mkdir(parents=True)
        ms.apply_filter(
            IMPORT,
            file_name=str(written(tmp_path / parent / "scan", "seg.nii", files.nifti(files.egg()))),
        )
    assert labels_of(ms) == ["seg label 1", "seg (scan) label 1", "seg (scan 2) label 1"]


def test_a_name_of_its_own_is_kept_when_the_other_file_is_gone(tmp_path):
    a, b = patients(tmp_path, files.nifti(files.egg()), files.nifti(files.egg()))
    ms, _ = imported(a)
    ms.apply_filter(IMPORT, file_name=str(b))
    ms.set_current_mesh(0)
    ms.delete_current_mesh()
    ms.apply_filter(IMPORT, file_name=str(b))
    assert labels_of(ms) == ["seg (b) label 1"]


def test_a_file_is_the_same_however_it_is_named(tmp_path, monkeypatch):
    path = written(tmp_path, "egg.nii", files.nifti(files.egg()))
    (tmp_path / "sub").mkdir()
    ms, _ = imported(path)
    ms.apply_filter(IMPORT, file_name=str(tmp_path / "sub" / ".." / "egg.nii"))
    monkeypatch.chdir(tmp_path)
    ms.apply_filter(IMPORT, file_name="egg.nii")
    assert labels_of(ms) == ["egg label 1"]


def test_phases_that_the_file_no_longer_has_are_removed(tmp_path):
    path = written(tmp_path, "seg.nii", phases_of(4))
    other = written(tmp_path, "other.nii", phases_of(4))
    ms, _ = imported(path)
    ms.apply_filter(IMPORT, file_name=str(other))
    ms.set_current_mesh(3)
    ms.apply_filter("generate_copy_of_current_mesh")
    ms.current_mesh().set_label("kept by hand")
    path.write_bytes(phases_of(2))
    ms.apply_filter(IMPORT, file_name=str(path))
    of_other = [f"other label 1 phase {t:02d}" for t in range(4)]
    assert sorted(labels_of(ms)) == sorted(
        ["seg label 1 phase 00", "seg label 1 phase 01", "kept by hand", *of_other]
    )


def test_other_labels_of_the_file_stay(tmp_path):
    def two_labels(phases):
        one = files.egg()
        one[:10] *= 2
        return files.nifti(np.stack([one] * phases, -1))

    path = written(tmp_path, "seg.nii", two_labels(3))
    ms, _ = imported(path)
    ms.apply_filter(IMPORT, file_name=str(path), labels="2")
    path.write_bytes(two_labels(2))
    ms.apply_filter(IMPORT, file_name=str(path), labels="2")
    assert labels_of(ms) == [f"seg label 1 phase {t:02d}" for t in range(3)] + [
        f"seg label 2 phase {t:02d}" for t in range(2)
    ]


def test_files_that_a_series_no_longer_has_are_removed(tmp_path):
    for patient in ("a", "b"):
        (tmp_path / patient).mkdir()
        for t in (8, 9, 10):
            written(tmp_path / patient, f"ph_{t}.nii", files.nifti(files.egg()))
    a, b = tmp_path / "a" / "ph_9.nii", tmp_path / "b" / "ph_9.nii"
    ms, _ = imported(a, file_series=True)
    ms.apply_filter(IMPORT, file_name=str(b), file_series=True)
    of_a, of_b = ([f"ph_{t}{suffix} label 1" for t in (8, 9, 10)] for suffix in ("", " (b)"))
    assert labels_of(ms) == of_a + of_b
    (tmp_path / "b" / "ph_10.nii").unlink()
    ms.apply_filter(IMPORT, file_name=str(b))  # this file alone: the others are not asked for
    assert labels_of(ms) == of_a + of_b
    ms.apply_filter(IMPORT, file_name=str(b), file_series=True)
    assert labels_of(ms) == of_a + of_b[:2]


def test_layers_of_an_unknown_file_are_replaced(tmp_path):
    """Files do not keep where a layer came from; layers loaded again are taken for the same
    import's."""
    path = written(tmp_path, "egg.nii", files.nifti(files.egg()))
    ms, _ = imported(path)
    ms.save_current_mesh(str(tmp_path / "egg label 1.ply"))
    again = pymeshlab.MeshSet()
    again.load_new_mesh(str(tmp_path / "egg label 1.ply"))
    again.apply_filter(IMPORT, file_name=str(path), voxel_size=2)
    assert again.mesh_number() == 1


def test_a_refused_import_removes_nothing(tmp_path):
    path = written(tmp_path, "seg.nii", phases_of(3))
    ms, _ = imported(path)
    empty = np.stack([files.egg(), files.egg(value=0)], -1)
    path.write_bytes(files.nifti(empty))
    before = snapshot(ms)
    failed.append(ms)
    with pytest.raises(pymeshlab.PyMeshLabException):
        ms.apply_filter(IMPORT, file_name=str(path))
    assert snapshot(ms) == before


# ---------------------------------------------------------------- formats


FORMATS = {
    "egg.nii": lambda a, m: files.nifti(a, TO_LPS @ m),
    "egg.nii.gz": lambda a, m: gzip.compress(files.nifti(a, TO_LPS @ m)),
    "big endian.nii": lambda a, m: files.nifti(a, TO_LPS @ m, big=True),
    "egg.mha": files.meta,
    "compressed.mha": lambda a, m: files.meta(a, m, compressed=True),
    "egg.nrrd": files.nrrd,
    "compressed.nrrd": lambda a, m: files.nrrd(a, m, encoding="gzip"),
}


def rigid():
    q, _ = np.linalg.qr(OBLIQUE[:3, :3])
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = q * [1.5, 1.0, 2.0], [10, -20, 30]
    return matrix


@pytest.mark.parametrize("name", FORMATS)
@pytest.mark.parametrize("phases", [1, 3])
def test_formats_agree(tmp_path, name, phases):
    """The matrices are to LPS; the surface lies in RAS, or in LPS on request."""
    labels, matrix = files.egg(), rigid()
    array = (
        labels
        if phases == 1
        else np.stack([labels, np.roll(labels, 1, 0), np.roll(labels, 2, 0)], -1)
    )
    path = written(tmp_path, name, FORMATS[name](array, matrix))
    ms, returned = imported(path)
    assert returned["layers"] == phases
    volume = labels.sum() * abs(np.linalg.det(matrix[:3, :3]))
    for phase, mesh in enumerate(ms):
        require_sphere(mesh)
        middle = centre_of(array if phases == 1 else array[..., phase], TO_LPS @ matrix)
        assert np.linalg.norm(mesh.vertex_matrix().mean(0) - middle) < 1
        assert returned["volume"][phase] == pytest.approx(volume, rel=0.03)
        assert returned["label_volume"][phase] == pytest.approx(volume, rel=1e-5)
    lps, _ = imported(path, coordinates="LPS")
    assert np.allclose(
        lps.mesh(0).vertex_matrix() * [-1, -1, 1], ms.mesh(0).vertex_matrix(), atol=1e-9
    )


@pytest.mark.parametrize("dtype", ["u1", "i1", "i2", "u2", "i4", "u4", "i8", "u8", "f4", "f8"])
def test_types(tmp_path, dtype):
    ms, _ = imported(
        written(tmp_path, "egg.nii", files.nifti(files.egg(dtype=dtype, value=100))), labels="100"
    )
    require_sphere(ms.mesh(0))


@pytest.mark.parametrize("mirror", [1, -1])
def test_sheared_and_mirrored_matrices(tmp_path, mirror):
    labels, matrix = files.egg(), OBLIQUE @ np.diag([mirror, 1, 1, 1])
    ms, returned = imported(written(tmp_path, "egg.nii", files.nifti(labels, matrix)))
    require_sphere(ms.mesh(0))
    assert np.linalg.norm(ms.mesh(0).vertex_matrix().mean(0) - centre_of(labels, matrix)) < 1
    assert returned["volume"][0] == pytest.approx(
        labels.sum() * abs(np.linalg.det(matrix[:3, :3])), rel=0.03
    )


@pytest.mark.parametrize("spacing", [(1, 1, 1), (0, 0, 0), (2, 2, 5)])
def test_the_sform_holds_where_pixdim_disagrees(tmp_path, spacing):
    """Some programs leave pixdim as it was; ITK refuses such files."""
    matrix = rigid()
    as_said, _ = imported(written(tmp_path, "egg.nii", files.nifti(files.egg(), matrix)))
    ms, returned = imported(
        written(tmp_path, "egg.nii", files.nifti(files.egg(), matrix, pixdim=spacing))
    )
    assert returned["label_volume"][0] == pytest.approx(
        files.egg().sum() * abs(np.linalg.det(matrix[:3, :3])), rel=1e-5
    )
    assert np.abs(ms.mesh(0).vertex_matrix() - as_said.mesh(0).vertex_matrix()).max() < 1e-4


def test_qform(tmp_path):
    half = np.sqrt(0.5)  # a quarter turn round z, z mirrored
    path = written(
        tmp_path,
        "egg.nii",
        files.nifti(files.egg(), sform=0, qform=(0, 0, half, (5, 6, 7), -1), pixdim=(1, 2, 1.5)),
    )
    matrix = np.array([[0, -2, 0, 5], [1, 0, 0, 6], [0, 0, -1.5, 7], [0, 0, 0, 1.0]])
    ms, _ = imported(path)
    assert np.linalg.norm(ms.mesh(0).vertex_matrix().mean(0) - centre_of(files.egg(), matrix)) < 1


def test_a_list_in_nrrd_is_phases(tmp_path):
    array = np.stack([files.egg(), np.roll(files.egg(), 2, 0)])
    ms, returned = imported(
        written(tmp_path, "list.nrrd", files.nrrd(array, TO_LPS, kinds=["list"] + ["domain"] * 3))
    )
    assert returned["layers"] == 2
    assert ms.mesh(1).vertex_matrix().mean(0) - ms.mesh(0).vertex_matrix().mean(0) == pytest.approx(
        [2, 0, 0], abs=0.1
    )


def test_numbered_series(tmp_path):
    for number in (2, 10, 1):
        written(tmp_path, f"t{number}_seg.mha", files.meta(np.roll(files.egg(), number // 5, 0)))
    written(tmp_path, "t3_image.mha", b"something else")
    ms, returned = imported(tmp_path / "t2_seg.mha", file_series=True)
    assert [m.label() for m in ms] == ["t1_seg label 1", "t2_seg label 1", "t10_seg label 1"]
    assert returned["phase"].tolist() == [0, 1, 2]
    assert imported(tmp_path / "t2_seg.mha")[1]["layers"] == 1


@pytest.mark.parametrize("type_", ["f4", "f8", "i2"])
def test_scaled_voxels(tmp_path, type_):
    """Stored as halves of the labels, or so, and scaled by the header."""
    plain, _ = imported(written(tmp_path, "plain.nii", files.nifti(2 * files.egg())), labels="2")
    scaled, _ = imported(
        written(tmp_path, "scaled.nii", files.nifti(files.egg().astype(type_), slope=2.0)),
        labels="2",
    )
    assert np.array_equal(scaled.mesh(0).vertex_matrix(), plain.mesh(0).vertex_matrix())


def test_a_series_of_compressed_and_plain_files(tmp_path):
    for number in (1, 2, 3):
        data = files.nifti(np.roll(files.egg(), number // 2, 0))
        written(
            tmp_path,
            f"t{number}.nii" + ".gz" * (number == 2),
            gzip.compress(data) if number == 2 else data,
        )
    for name in ("t1.nii", "t2.nii.gz"):
        assert [m.label() for m in imported(tmp_path / name, file_series=True)[0]] == [
            "t1 label 1",
            "t2 label 1",
            "t3 label 1",
        ]
    # Another form of one of them: as the file that was named.
    written(tmp_path, "t2.nii", files.nifti(np.roll(files.egg(), 5, 1)))
    projects = [imported(tmp_path / name, file_series=True)[0] for name in ("t1.nii", "t2.nii.gz")]
    plain, packed = (ms.mesh(1).vertex_matrix() for ms in projects)
    assert abs(plain.mean(0) - packed.mean(0))[1] > 1


# ---------------------------------------------------------------- bad files


def refused(path, *words, **parameters):
    """The filter throws, its text has these words, the document stays as it was, memory does not
    grow by much."""
    ms = pymeshlab.MeshSet()
    failed.append(ms)
    ms.create_cube()
    before, memory = snapshot(ms), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(pymeshlab.PyMeshLabException) as error:
        ms.apply_filter(IMPORT, file_name=str(path), **parameters)
    for word in words:
        assert word in str(error.value), str(error.value)
    assert "0x" not in str(error.value)  # no pointers of ITK's
    assert snapshot(ms) == before
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - memory < 200_000  # kB


NAN = np.array([[np.nan, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
BAD = {
    "truncated.nii": (lambda: files.nifti(files.egg())[:-100], "truncated"),
    "truncated.nii.gz": (
        lambda: gzip.compress(
            files.nifti(np.random.default_rng(0).integers(0, 2, (30, 30, 30), "u1"))
        )[:-2000],
        "truncated",
    ),
    "truncated.mha": (lambda: files.meta(files.egg())[:-100], "truncated"),
    "truncated compressed.mha": (
        lambda: files.meta(
            np.random.default_rng(0).integers(0, 2, (30, 30, 30), "u1"), compressed=True
        )[:-2000],
        "truncated",
    ),
    "truncated compressed.nrrd": (
        lambda: files.nrrd(
            np.random.default_rng(0).integers(0, 2, (30, 30, 30), "u1"), encoding="gzip"
        )[:-2000],
        "ITK",
    ),
    "truncated.nrrd": (lambda: files.nrrd(files.egg())[:-100], "truncated"),
    "only a header.nii": (lambda: files.nifti(files.egg())[:200], "ends within its header"),
    "huge.nii": (
        lambda: files.nifti(files.egg((8, 8, 8)), size=(1500, 1500, 1400)),
        "header claims",
    ),
    "huge.nii.gz": (
        lambda: gzip.compress(files.nifti(files.egg((8, 8, 8)), size=(1500, 1500, 1400))),
        "header claims",
    ),
    "huge.mha": (
        lambda: files.meta(files.egg((8, 8, 8)), compressed=True, size=(1500, 1500, 1400)),
        "header claims",
    ),
    "huge.nrrd": (
        lambda: files.nrrd(files.egg((8, 8, 8)), encoding="gzip", size=(1500, 1500, 1400)),
        "header claims",
    ),
    "beyond.nrrd": (lambda: files.nrrd(files.egg((8, 8, 8)), size=(30000, 30000, 30000)), "4 GB"),
    "no slices.nii": (lambda: files.nifti(files.egg(), size=(20, 18, 0)), "20 x 18 x 0"),
    "no slices.mha": (lambda: files.meta(files.egg(), size=(20, 18, 0)), "20 x 18 x 0"),
    "no slices.nrrd": (lambda: files.nrrd(files.egg(), size=(20, 18, 0)), "20 x 18 x 0"),
    "negative.nii": (lambda: files.nifti(files.egg(), size=(20, -18, 16)), "20 x -18 x 16"),
    "five.nii": (lambda: files.nifti(np.zeros((4, 4, 4, 2, 2), "u1")), "5 dimensions"),
    "flat.nii": (lambda: files.nifti(np.ones((8, 8), "u1")), "2 dimensions"),
    "nan.nii": (lambda: files.nifti(files.egg(), NAN, pixdim=(1, 1, 1)), "NaN"),
    "flat matrix.nii": (lambda: files.nifti(files.egg(), np.diag([1.0, 1, 0, 1])), "into a plane"),
    "image.nii": (
        lambda: files.nifti(files.egg(dtype="f4") * np.float32(0.37)),
        "first voxel",
        "whole numbers",
    ),
    "nan voxels.nrrd": (lambda: files.nrrd(np.full((5, 5, 5), np.nan, "f4")), "0 or NaN"),
    "nan in scaled voxels.nii": (
        lambda: files.nifti(np.where(files.egg() > 0, np.nan, 0).astype("f4"), slope=2.0),
        "0 or NaN",
    ),
    "nan voxels.nii": (
        lambda: files.nifti(np.full((5, 5, 5), np.nan, "f4")),
        "0 or NaN",
    ),
    "infinite.nii.gz": (
        lambda: gzip.compress(files.nifti(np.full((5, 5, 5), np.inf, "f8"))),
        "whole numbers",
        "inf",
    ),
    "too large.nii": (lambda: files.nifti(np.full((5, 5, 5), 2**40, "i8")), "32 bits"),
    "nothing.nii": (lambda: files.nifti(np.zeros((5, 5, 5), "u1")), "all voxels are 0"),
    "other labels.nii": (lambda: files.nifti(files.egg(value=7)), "occur are 7"),
    "text.nii": (lambda: b"not a volume " * 100, "not a NIfTI"),
    "text.mha": (lambda: b"not a volume " * 100, "not a MetaImage"),
    "text.nrrd": (lambda: b"not a volume " * 100, "header is broken"),
    "empty.nii.gz": (lambda: b"", "ends within its header"),
    "volume.dcm": (lambda: b"DICM", "formats that are read"),
    "spread.mhd": (
        lambda: files.meta(files.egg(), local="slice%03d.raw 1 16 1"),
        "spread over several files",
    ),
    "lost.mhd": (lambda: files.meta(files.egg(), local="lost.raw"), "lost.raw"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_files(tmp_path, name):
    make, *words = BAD[name]
    refused(written(tmp_path, name, make()), name, *words)


@pytest.mark.parametrize("value", [1, 2])
def test_the_packed_file_is_read_though_it_lies_unpacked_beside_it(tmp_path, value):
    written(tmp_path, "egg.nii", files.nifti(files.egg((10, 9, 8), value=value)))
    path = written(tmp_path, "egg.nii.gz", gzip.compress(files.nifti(files.egg())))
    ms, result = imported(path)
    assert result["label_volume"][0] == files.egg().sum()
    path = written(tmp_path, "egg.nii.gz", gzip.compress(files.nifti(files.egg(), slope=2.0)))
    assert imported(path, labels="2")[1]["label_volume"][0] == files.egg().sum()


@pytest.mark.parametrize(
    "value, shown", [(1.0003, "1.0003"), (1000000.5, "1000000.5"), (2.5, "2.5")]
)
def test_a_voxel_that_is_no_label_is_shown_with_the_digits_that_tell(tmp_path, value, shown):
    path = tmp_path / "image.nii"
    path.write_bytes(files.nifti(files.egg(dtype="f8") * value))
    with pytest.raises(pymeshlab.PyMeshLabException) as error:
        pymeshlab.MeshSet().apply_filter(IMPORT, file_name=str(path))
    assert f"which is {shown}: labels are whole numbers" in str(error.value)
    assert str(error.value).count("image.nii") == 1


def test_no_file(tmp_path):
    refused("", "file_name is empty")
    refused(tmp_path / "none.nii", "no such file")
    refused(tmp_path, "not a file")


@pytest.mark.parametrize(
    "parameters, word",
    [
        ({"labels": "one"}, "whole numbers"),
        ({"labels": ""}, "empty"),
        ({"labels": "0"}, "background"),
        ({"labels": "1,9"}, "label 9"),
        ({"voxel_size": -1}, "voxel size must be 0 or more"),
        ({"voxel_size": 0.001}, "larger voxel_size"),
        ({"voxel_size": 100}, "smaller voxel_size"),
        ({"voxel_size": 1e12}, "box of 16 x 13 x 12 mm"),
        ({"smoothing": 9}, "smoothing"),
        ({"longest_gap": -1}, "gap"),
    ],
)
def test_bad_parameters(tmp_path, parameters, word):
    refused(written(tmp_path, "egg.nii", files.nifti(files.egg())), word, **parameters)


def test_a_phase_without_the_label_is_named_or_skipped(tmp_path):
    array = np.stack([files.egg(), np.zeros_like(files.egg()), files.egg()], -1)
    path = written(tmp_path, "gap.nii", files.nifti(array))
    refused(path, "gap.nii", "phase 1", "label 1", "skip_incomplete_phases")
    ms, returned = imported(path, skip_incomplete_phases=True)
    assert [m.label() for m in ms] == ["gap label 1 phase 00", "gap label 1 phase 02"]
    assert returned["phase"].tolist() == [0, 2]
    refused(path, "all were skipped", skip_incomplete_phases=True, labels="3")


def test_the_log_ends_with_what_was_imported(tmp_path):
    array = np.stack([files.egg(), np.zeros_like(files.egg()), files.egg()], -1)
    written(tmp_path, "gap.nii", files.nifti(array))
    script = f"ms.apply_filter({IMPORT!r}, file_name='gap.nii', skip_incomplete_phases=True)"
    lines = lines_of(script, tmp_path)
    assert lines[-1] == (
        "2 surfaces imported, the first is the current layer; incomplete, left out: 1 phase. "
        "Next: Spherical parameterise root."
    )


def test_a_single_volume_has_no_phases_to_skip(tmp_path):
    path = written(tmp_path, "one.nii", files.nifti(files.egg()))
    for skip in (False, True):
        with pytest.raises(pymeshlab.PyMeshLabException, match="label 3") as caught:
            imported(path, labels="3", skip_incomplete_phases=skip)
        assert "skip" not in str(caught.value)


# ---------------------------------------------------------------- real hearts


def volumes(ms):
    found = []
    for mesh in ms:
        require_sphere(mesh)
        v, f = mesh.vertex_matrix(), mesh.face_matrix()
        found.append(np.einsum("ij,ij->", v[f[:, 0]], np.cross(v[f[:, 1]], v[f[:, 2]])) / 6000)
    return np.array(found)


@pytest.mark.parametrize("shift", [0, 14])
@pytest.mark.parametrize("hole", [0, 0.7])
def test_an_end_that_lies_off_is_named(tmp_path, shift, hole):
    """A bent cup of ten slices of 10 mm, as a cavity or a wall, whose base is of another breath;
    nothing tells a shift from a bend for sure, so it stays."""
    i, j, k = np.meshgrid(*map(np.arange, (64, 64, 14)), indexing="ij")
    radius = 8 + 10 * np.sqrt(np.clip(1 - (1 - (k - 2) / 9) ** 2, 0, 1))
    off = np.hypot(i - 28 - 0.4 * k - shift * (k == 11), j - 30 - 0.2 * k)
    cup = (off < radius) & (off >= hole * radius * (k > 3)) & (k > 1) & (k < 12)
    path = written(tmp_path, "cup.nii", files.nifti(cup.astype("u1"), np.diag([1.4, 1.4, 10, 1])))
    _, returned = imported(path)
    said = [remark["text"] for remark in remarks_called("farEnds", returned)]
    assert ["slice 11 by 19" in text for text in said] == [True] * (shift > 0)


def test_what_differs_in_millimetres_alone_is_said_once(tmp_path):
    """Three phases whose base lies off by 14, 13 and 12 voxels."""
    i, j, k = np.meshgrid(*map(np.arange, (64, 64, 14)), indexing="ij")
    radius = 8 + 10 * np.sqrt(np.clip(1 - (1 - (k - 2) / 9) ** 2, 0, 1))
    cups = [
        (np.hypot(i - 28 - 0.4 * k - shift * (k == 11), j - 30 - 0.2 * k) < radius)
        & (k > 1)
        & (k < 12)
        for shift in (14, 13, 12)
    ]
    labels = np.stack(cups, -1).astype("u1")
    path = written(tmp_path, "cup.nii", files.nifti(labels, np.diag([1.4, 1.4, 10, 1])))
    (remark,) = remarks_called("farEnds", imported(path)[1])
    assert re.search(r"slice 11 by 1\d\.\d to 19\.\d mm", remark["text"])
    assert len(remark["layers"]) == 3


def test_of_two_bodies_side_by_side_no_slice_is_lost(tmp_path):
    i, j, k = np.indices((60, 30, 30))
    balls = [(i - x) ** 2 + (j - 15) ** 2 + (k - 15) ** 2 < r for x, r in ((15, 144), (45, 140))]
    path = written(tmp_path, "two.nii", files.nifti((balls[0] | balls[1]).astype("u1"), np.eye(4)))
    _, returned = imported(path)
    assert remarks_called("partsDropped", returned) and not remarks_called("slicesLost", returned)


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("end", ["first", "last"])
@pytest.mark.parametrize("thick", [1, 5])
def test_a_label_cut_off_by_the_border_is_named(tmp_path, axis, end, thick):
    """An egg in a volume that ends at a quarter of its length, in two phases; trimmed to it, none
    is named, nor where an apex touches the border."""
    steps = np.array([1, 1, thick])
    i, j, k = np.meshgrid(*map(np.arange, 60 // steps), indexing="ij")
    egg = [
        (i - 30) ** 2 / radius**2 + (j - 30) ** 2 / 18**2 + (thick * k - 29) ** 2 / 24**2 < 1
        for radius in (20, 16)
    ]
    labels = np.stack(egg, -1).astype("u1")
    box = [slice(c.min(), c.max() + 1) for c in np.nonzero(labels.any(-1))]
    trimmed = labels[tuple(box)]
    affine = np.diag([*steps, 1.0])
    _, returned = imported(written(tmp_path, "trimmed.nii", files.nifti(trimmed, affine)))
    assert remarks_called("cutByBorder", returned) == []
    length = trimmed.shape[axis]
    quarter = round(length / 4)
    part = slice(quarter, None) if end == "first" else slice(None, length - quarter)
    cut = trimmed[(*[slice(None)] * axis, part)]
    _, returned = imported(written(tmp_path, "cut.nii", files.nifti(cut, affine)))
    (said,) = remarks_called("cutByBorder", returned)
    index = 0 if end == "first" else cut.shape[axis] - 1
    sections = cut.sum(tuple({0, 1, 2} - {axis}), dtype=int)
    shares = sorted(round(100 * one[index] / one.max()) for one in sections.T)
    shares = shares if shares[0] < shares[1] else shares[:1]
    words = f"at {'ijk'[axis]} = {index} with {' to '.join(map(str, shares))} % of its widest"
    assert words in said["text"] and len(said["layers"]) == 2


def test_cine_with_thick_slices():
    """Hand-drawn labels, 1.4 x 1.4 x 10 mm."""
    path = require(DATA / "heart_cine/labels_4d_raw.nii.gz")
    start = time.process_time()
    ms, returned = imported(path)
    print(f"{time.process_time() - start:.2f} s")
    assert len(list(ms)) == returned["layers"] == 30
    volume = volumes(ms)
    assert volume[0] == pytest.approx(212, rel=0.03) and volume.min() == pytest.approx(
        113, rel=0.05
    )
    assert volume == pytest.approx(returned["volume"] / 1000, rel=1e-6)
    for phase, mesh in enumerate(ms):
        other = pymeshlab.MeshSet()
        other.load_new_mesh(str(DATA / f"heart_cine/endo_{phase:02d}.ply"))
        a, b = mesh.vertex_matrix(), other.mesh(0).vertex_matrix()
        assert cKDTree(b).query(a)[0].mean() < 1.4 and cKDTree(a).query(b)[0].mean() < 1.4


@pytest.mark.parametrize("labels", ["1", "1,2", "2"])
def test_every_phase_is_a_sphere(labels):
    ms, returned = imported(require(DATA / "heart_truth/labels_4d_1.5mm.nii.gz"), labels=labels)
    assert returned["layers"] == 25
    assert volumes(ms) == pytest.approx(returned["label_volume"] / 1000, rel=0.01)


def test_a_wall_in_thick_slices():
    """It slips sideways between slices by more than its thickness: nothing may be lost."""
    ms, returned = imported(require(DATA / "heart_cine/labels_4d_raw.nii.gz"), labels="2")
    volume = volumes(ms)
    assert len(volume) == 30 and volume == pytest.approx(returned["label_volume"] / 1000, rel=0.055)
    assert np.median(volume / returned["label_volume"]) * 1000 == pytest.approx(1, abs=0.02)


def test_a_wall_in_thick_slices_is_that_of_thin_ones(tmp_path):
    """Every seventh slice of 1.5 mm against all of them."""
    labels, matrix = files.read_nifti(require(DATA / "heart_truth/labels_4d_1.5mm.nii.gz"))
    first = np.ascontiguousarray(labels[..., 0])
    fine, _ = imported(written(tmp_path, "fine.nii", files.nifti(first, matrix)), labels="2")
    thick, returned = imported(
        written(
            tmp_path, "thick.nii", files.nifti(first[:, :, ::7], matrix @ np.diag([1, 1, 7, 1]))
        ),
        labels="2",
    )
    require_sphere(thick.mesh(0))
    a, b = fine.mesh(0).vertex_matrix(), thick.mesh(0).vertex_matrix()
    assert cKDTree(a).query(b)[0].mean() < 0.7 and cKDTree(b).query(a)[0].mean() < 0.7  # mm
    assert returned["changed_voxels"][0] < 0.02 * returned["label_volume"][0] / 1.5**3
