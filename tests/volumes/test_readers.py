# SPDX-License-Identifier: GPL-3.0-only
"""No reader is believed: every space, unit, handedness, type and scaling that the formats have, of
a body whose volume, middle and box are known from its voxels."""

import bz2
import gzip
import itertools
import json
import struct

import numpy as np
import pytest
import volume_files as files
from test_import import NAN, imported, refused, written

EGG = files.egg((14, 12, 10))
TYPES = ["u1", "i1", "i2", "u2", "i4", "u4", "i8", "u8", "f4", "f8"]
MATRIX = np.array([[1.5, -0.24, 0, -40], [0.2, 1.8, 0, 25], [0, 0, 2, 110], [0, 0, 0, 1]])
SHEARED = MATRIX + np.array([[0, 0.5, 0, 0], [0, 0, 0.3, 0], [0, 0, 0, 0], [0, 0, 0, 0]])
UNSCALED = [(0, 1), (0, np.nan), (np.nan, np.nan), (np.nan, 1), (np.inf, 2), (-np.inf, 0), (1, 0)]


def truth(matrix, labels=EGG):
    """Volume, middle and box of the voxels."""
    indices = np.argwhere(labels)
    corners = np.concatenate([indices + d for d in itertools.product([-0.5, 0.5], repeat=3)])
    world = corners @ matrix[:3, :3].T + matrix[:3, 3]
    volume = len(indices) * abs(np.linalg.det(matrix[:3, :3]))
    return volume, world.mean(0), world.min(0), world.max(0)


def solid(mesh):
    """Volume and middle of what a surface encloses."""
    v, f = mesh.vertex_matrix(), mesh.face_matrix()
    a, b, c = v[f[:, 0]], v[f[:, 1]], v[f[:, 2]]
    parts = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6
    return parts.sum(), (parts[:, None] * (a + b + c) / 4).sum(0) / parts.sum()


def require_place(ms, returned, matrix, phase=0, labels=EGG):
    """To a fraction of a voxel; the egg's middle is not that of its box, so none is turned."""
    volume, middle, low, high = truth(matrix, labels)
    voxel = np.linalg.norm(matrix[:3, :3], axis=0).max()
    assert returned["label_volume"][phase] == pytest.approx(volume, rel=1e-4)
    enclosed, centre = solid(ms.mesh(phase))
    assert enclosed == pytest.approx(volume, rel=0.03)
    assert np.abs(centre - middle).max() < 0.05 * voxel
    vertices = ms.mesh(phase).vertex_matrix()
    assert np.abs(vertices.min(0) - low).max() < voxel
    assert np.abs(vertices.max(0) - high).max() < voxel


def require_read(path, matrix, **parameters):
    ms, returned = imported(path, **parameters)
    assert returned["layers"] == 1
    require_place(ms, returned, matrix)


def require_phases(path, matrix=files.IDENTITY):
    """Of `moving()`."""
    ms, returned = imported(path)
    assert returned["layers"] == 3
    for phase in range(3):
        require_place(ms, returned, matrix, phase, np.roll(EGG, phase, 0))


def moving():
    """Three phases, the last axis."""
    return np.stack([np.roll(EGG, t, 0) for t in range(3)], -1)


# ---------------------------------------------------------------- NIfTI


@pytest.mark.parametrize("version", [1, 2])
@pytest.mark.parametrize("type_", TYPES)
def test_voxels_are_scaled_by_a_slope_that_is_a_number_only(tmp_path, type_, version):
    for slope, inter in UNSCALED:
        for matrix in (MATRIX, SHEARED):
            data = files.nifti(EGG.astype(type_), matrix, slope=slope, inter=inter, version=version)
            require_read(written(tmp_path, "egg.nii", data), matrix)


@pytest.mark.parametrize("version", [1, 2])
@pytest.mark.parametrize("type_", TYPES)
def test_scaled_voxels_of_any_place(tmp_path, type_, version):
    """Thirds, a shift, an intercept that is no number; sheared, turned, or with another pixdim."""
    for matrix in (MATRIX, SHEARED):
        for stored, slope, inter in ((3 * EGG, 1 / 3, 0), (EGG, 1, 0), (2 * EGG + 1, 0.5, -0.5)):
            spacing = np.linalg.norm(matrix[:3, :3], axis=0) * (1 + 1e-5)
            data = files.nifti(
                stored.astype(type_),
                matrix,
                slope=slope,
                inter=inter,
                pixdim=spacing,
                version=version,
            )
            require_read(written(tmp_path, "egg.nii", data), matrix)
    data = files.nifti(EGG.astype(type_), MATRIX, slope=2, inter=np.nan, version=version)
    require_read(written(tmp_path, "egg.nii", data), MATRIX, labels="2")


@pytest.mark.parametrize("version", [1, 2])
@pytest.mark.parametrize("big", [False, True])
@pytest.mark.parametrize("unit, length", [(0, 1), (1, 1000), (2, 1), (3, 1e-3), (8 | 3, 1e-3)])
def test_units_and_orders_of_bytes_in_nifti(tmp_path, unit, length, big, version):
    matrix = np.diag([1 / length] * 3 + [1]) @ MATRIX
    data = files.nifti(EGG.astype("i2"), matrix, unit=unit, big=big, version=version)
    require_read(written(tmp_path, "egg.nii", data), MATRIX)


@pytest.mark.parametrize("version", [1, 2])
@pytest.mark.parametrize("qfac", [1, -1])
def test_quaternions(tmp_path, qfac, version):
    half = np.sqrt(0.5)
    data = files.nifti(
        EGG, sform=0, qform=(0, 0, half, (5, 6, 7), qfac), pixdim=(1, 2, 1.5), version=version
    )
    matrix = np.array([[0, -2, 0, 5], [1, 0, 0, 6], [0, 0, 1.5 * qfac, 7], [0, 0, 0, 1.0]])
    require_read(written(tmp_path, "egg.nii", data), matrix)


def test_compression_is_told_by_the_bytes(tmp_path):
    plain = files.nifti(EGG, MATRIX)
    for name, data in (("packed.nii", gzip.compress(plain)), ("plain.nii.gz", plain)):
        require_read(written(tmp_path, name, data), MATRIX)
    refused(written(tmp_path, "packed.nii", gzip.compress(plain)[:-60]), "truncated")


@pytest.mark.parametrize("at", [-8, -40])
def test_packed_data_that_are_damaged(tmp_path, at):
    """The checksum, and what it is of."""
    packed = bytearray(gzip.compress(files.nifti(EGG, MATRIX)))
    packed[at] ^= 255
    refused(written(tmp_path, "packed.nii.gz", bytes(packed)), "its packed data are damaged")


@pytest.mark.parametrize("version", [1, 2])
def test_where_voxels_begin(tmp_path, version):
    data = files.nifti(EGG, MATRIX, version=version)
    at, kind = ((108, "<f"), (168, "<q"))[version - 1]
    header = bytearray(data[: len(data) - EGG.size])
    struct.pack_into(kind, header, at, 0)
    require_read(written(tmp_path, "egg.nii", bytes(header) + files.data(EGG)), MATRIX)
    struct.pack_into(kind, header, at, 1000)
    later = bytes(header).ljust(1000, b"x") + files.data(EGG)
    require_read(written(tmp_path, "egg.nii", later), MATRIX)


@pytest.mark.parametrize("version", [1, 2])
def test_phases_along_a_later_axis(tmp_path, version):
    for extra in (0, 1, 2, 3):
        array = moving().reshape(*EGG.shape, *[1] * extra, 3)
        path = written(tmp_path, "time.nii", files.nifti(array, MATRIX, version=version))
        require_phases(path, MATRIX)
    unused = files.nifti(EGG, MATRIX, size=(*EGG.shape, 0), version=version)
    require_read(written(tmp_path, "unused.nii", unused), MATRIX)
    for axes in ((2, 3), (2, 1, 3)):
        array = np.zeros((*EGG.shape, *axes), "u1")
        path = written(tmp_path, "two.nii", files.nifti(array, MATRIX, version=version))
        refused(path, "5 dimensions")
    for intent in (1006, 1007, 2003):
        array = moving().reshape(*EGG.shape, 1, 3)
        path = written(tmp_path, "v.nii", files.nifti(array, version=version, intent=intent))
        refused(path, "3 numbers per voxel")


@pytest.mark.parametrize("version", [1, 2])
@pytest.mark.parametrize("packed", [(), (".hdr", ".img"), (".img",)])
def test_pairs(tmp_path, version, packed):
    header, voxels = files.nifti_pair(
        3 * EGG, SHEARED, slope=1 / 3, version=version, big=version == 1
    )
    paths = [
        written(
            tmp_path,
            "egg" + end + ".gz" * (end in packed),
            gzip.compress(bytes(data)) if end in packed else bytes(data),
        )
        for end, data in ((".hdr", header), (".img", voxels))
    ]
    for path in paths:
        ms, _ = imported(path)
        assert ms.mesh(0).label() == "egg label 1"
        require_read(path, SHEARED)
    paths[1].unlink()
    refused(paths[0], "egg.img")


def test_a_whole_file_called_img(tmp_path):
    require_read(written(tmp_path, "egg.img", files.nifti(EGG, MATRIX)), MATRIX)


@pytest.mark.parametrize("origin", [None, (3, 5, 2)])
def test_analyze(tmp_path, origin):
    """As SPM, FSL and nibabel have it: the first axis runs to the left, and the origin, counted
    from 1, is SPM's or the middle."""
    header, voxels = files.nifti_pair(EGG, sform=0, pixdim=(1.5, 2, 2.5), slope=np.nan)
    header[344:348] = bytes(4)
    middle = (np.array(EGG.shape) - 1) / 2
    if origin:
        struct.pack_into("<3h", header, 253, *origin)
        middle = np.array(origin) - 1
    matrix = np.diag([-1.5, 2, 2.5, 1])
    matrix[:3, 3] = -matrix[:3, :3] @ middle
    written(tmp_path, "egg.hdr", bytes(header))
    require_read(written(tmp_path, "egg.img", voxels), matrix)


@pytest.mark.parametrize("name", ["egg.nii", "egg.nrrd", "egg.mha"])
@pytest.mark.parametrize("type_", ["f4", "f8"])
def test_nan_is_background(tmp_path, name, type_):
    array = np.where(EGG, 1, np.nan).astype(type_)
    array[0, 0] = 0
    write = {"nii": files.nifti, "nrrd": files.nrrd, "mha": files.meta}[name[4:]]
    require_read(written(tmp_path, name, write(array)), np.eye(4) if "nii" in name else LPS)
    require_read(written(tmp_path, "s.nii", files.nifti(2 * array, slope=0.5)), np.eye(4))
    empty = np.stack([array, np.full_like(array, np.nan)], -1)
    path = written(tmp_path, "gap.nii", files.nifti(empty))
    refused(path, "phase 1", "0 or NaN")
    assert imported(path, skip_incomplete_phases=True)[1]["layers"] == 1


LPS = np.diag([-1.0, -1, 1, 1])


@pytest.mark.parametrize("type_, other", [("i8", -(2**40)), ("u8", 2**63 + 5), ("f8", 1e15)])
@pytest.mark.parametrize("name", ["egg.nii", "egg.nrrd", "egg.mha"])
def test_labels_beyond_32_bits_beside_the_one_that_is_asked_for(tmp_path, name, type_, other):
    array = EGG.astype(type_)
    array[0, 0, :3] = other
    array[1, 0, 0] = np.array(2**32 + 1, type_)  # not 1
    write = {"nii": files.nifti, "nrrd": files.nrrd, "mha": files.meta}[name[4:]]
    path = written(tmp_path, name, write(array))
    require_read(path, np.eye(4) if "nii" in name else LPS)
    refused(path, "occur are", "beyond 32 bits", labels="7")


def test_the_largest_labels(tmp_path):
    array = EGG.astype("i8") * (2**31 - 1)
    require_read(
        written(tmp_path, "egg.nii", files.nifti(array, MATRIX)), MATRIX, labels=str(2**31 - 1)
    )
    refused(tmp_path / "egg.nii", "32 bits", labels=str(2**31))


# ---------------------------------------------------------------- NRRD

DIRECTIONS = "space directions: (1.5,0.2,0) (-0.24,1.8,0) (0,0,2)"
ORIGIN = "space origin: (-40,25,110)"
SPACES = {
    "right-anterior-superior": (1, 1),
    "left-anterior-superior": (-1, 1),
    "left-posterior-superior": (-1, -1),
    "RAS": (1, 1),
    "LAS": (-1, 1),
    "LPS": (-1, -1),
    "scanner-xyz": (-1, -1),  # these name no side of the patient: as ITK has them
    "3D-right-handed": (-1, -1),
    "3D-left-handed": (-1, -1),
}


@pytest.mark.parametrize("space", SPACES)
def test_spaces_of_nrrd(tmp_path, space):
    matrix = np.diag([*SPACES[space], 1, 1]) @ MATRIX
    data = files.nrrd_of(EGG, f"space: {space}", DIRECTIONS, ORIGIN)
    require_read(written(tmp_path, "egg.nrrd", data), matrix)
    in_lps, _ = imported(tmp_path / "egg.nrrd", coordinates="LPS")
    assert np.abs(solid(in_lps.mesh(0))[1] - truth(LPS @ matrix)[1]).max() < 0.1


@pytest.mark.parametrize("space", SPACES)
@pytest.mark.parametrize("kind", ["time", "domain", "space", "list", "???"])
@pytest.mark.parametrize("axis", range(4))
def test_spaces_of_nrrd_with_time(tmp_path, space, kind, axis):
    long = space + ("T" if space.isupper() else "-time")
    vectors = ["(1.5,0.2,0,0)", "(-0.24,1.8,0,0)", "(0,0,2,0)"]
    vectors.insert(axis, "(0,0,0,40)")
    kinds = ["domain"] * 3
    kinds.insert(axis, kind)
    data = files.nrrd_of(
        np.moveaxis(moving(), 3, axis),
        f"space: {long}",
        "space directions: " + " ".join(vectors),
        "space origin: (-40,25,110,0)",
        "kinds: " + " ".join(kinds),
        'space units: "mm" "mm" "mm" "ms"',
    )
    matrix = np.diag([*SPACES[space], 1, 1]) @ MATRIX
    require_phases(written(tmp_path, "time.nrrd", data), matrix)


@pytest.mark.parametrize("kind", ["time", "list", "domain", "???", None])
@pytest.mark.parametrize("axis", range(4))
def test_the_axis_of_the_phases_in_nrrd(tmp_path, kind, axis):
    """Which it is, says its kind, or that it has no direction in space."""
    vectors = ["(1.5,0.2,0)", "(-0.24,1.8,0)", "(0,0,2)"]
    vectors.insert(axis, "none")
    fields = ["space: RAS", "space directions: " + " ".join(vectors), ORIGIN]
    if kind is not None:
        kinds = ["domain"] * 3
        kinds.insert(axis, kind)
        fields.append("kinds: " + " ".join(kinds))
    array = np.moveaxis(moving(), 3, axis)
    require_phases(written(tmp_path, "time.nrrd", files.nrrd_of(array, *fields)), MATRIX)
    if kind in ("time", "list"):  # without a space
        fields = ["spacings: " + " ".join("nan" if v == "none" else "2" for v in vectors)]
        fields.append("kinds: " + " ".join(kinds))
        data = files.nrrd_of(array, *fields)
        require_phases(written(tmp_path, "time.nrrd", data), np.diag([-2.0, -2, 2, 1]))


def test_what_is_no_phase_in_nrrd(tmp_path):
    for kind in ("vector", "RGB-color", "3-vector", "covariant-vector"):
        fields = ["space: RAS", f"kinds: {kind} domain domain domain"]
        fields += ["space directions: none (1,0,0) (0,1,0) (0,0,1)"]
        array = np.moveaxis(moving(), 3, 0)
        refused(written(tmp_path, "v.nrrd", files.nrrd_of(array, *fields)), kind.lower())
    fields[1:2] = ["kinds: list domain domain domain", "Segment0_ID:=Segment_1"]
    refused(written(tmp_path, "s.nrrd", files.nrrd_of(array, *fields)), "overlapping")
    one = array[:1].copy()
    fields[1:3] = ["kinds: vector domain domain domain"]
    require_read(written(tmp_path, "one.nrrd", files.nrrd_of(np.roll(one, 0), *fields)), np.eye(4))


UNITS = {
    "mm": 1,
    "MM": 1,
    "millimeters": 1,
    "millimetre": 1,
    "um": 1e-3,
    "\u00b5m": 1e-3,
    "\u03bcm": 1e-3,
    "micron": 1e-3,
    "microns": 1e-3,
    "micrometer": 1e-3,
    "nm": 1e-6,
    "cm": 10,
    "centimeters": 10,
    "dm": 100,
    "m": 1000,
    "meters": 1000,
    "": 1,
    "parsec": 1,  # which is warned of
}


@pytest.mark.parametrize("unit", UNITS)
def test_units_of_nrrd(tmp_path, unit):
    scale = np.diag([1 / UNITS[unit]] * 3 + [1])
    matrix = scale @ MATRIX
    fields = [
        "space: RAS",
        "space directions: "
        + " ".join(f"({','.join(map(repr, column.tolist()))})" for column in matrix[:3, :3].T),
        f"space origin: ({','.join(map(repr, matrix[:3, 3].tolist()))})",
    ]
    data = files.nrrd_of(EGG, *fields, "space units: " + " ".join([f'"{unit}"'] * 3))
    require_read(written(tmp_path, "egg.nrrd", data), MATRIX)
    spacing = " ".join([repr(2 / UNITS[unit])] * 3)
    data = files.nrrd_of(EGG, "spacings: " + spacing, "units: " + " ".join([f'"{unit}"'] * 3))
    require_read(written(tmp_path, "egg.nrrd", data), np.diag([-2.0, -2, 2, 1]))


def test_a_unit_per_axis_of_the_space(tmp_path):
    data = files.nrrd_of(
        EGG,
        "space: RAS",
        "space directions: (0.15,200,0) (-0.024,1800,0) (0,0,2)",
        "space origin: (-4,25000,110)",
        'space units: "cm" "um" "mm"',
    )
    require_read(written(tmp_path, "egg.nrrd", data), MATRIX)


@pytest.mark.parametrize(
    "fields, matrix",
    [
        ([], np.diag([-1.0, -1, 1, 1])),
        (["spacings: 2 1.5 1"], np.diag([-2, -1.5, 1, 1])),
        (["space dimension: 3", DIRECTIONS, ORIGIN], LPS @ MATRIX),
        (["space: RAS", DIRECTIONS], MATRIX * [1, 1, 1, 0] + np.diag([0, 0, 0, 1])),
        (
            ["spacings: 2 2 2", "axis mins: 10 20 30", "centers: node node node"],
            LPS @ [[2, 0, 0, 10], [0, 2, 0, 20], [0, 0, 2, 30], [0, 0, 0, 1]],
        ),
        (
            ["spacings: 2 2 2", "axis mins: 10 20 30", "centers: cell cell cell"],
            LPS @ [[2, 0, 0, 11], [0, 2, 0, 21], [0, 0, 2, 31], [0, 0, 0, 1]],
        ),
        (
            ["axis mins: 10 20 30", "axis maxs: 38 44 50"],
            LPS @ [[2, 0, 0, 11], [0, 2, 0, 21], [0, 0, 2, 31], [0, 0, 0, 1]],
        ),
        (
            ["axismins: 10 20 30", "axismaxs: 36 42 48", "centerings: node node node"],
            LPS @ [[2, 0, 0, 10], [0, 2, 0, 20], [0, 0, 2, 30], [0, 0, 0, 1]],
        ),
    ],
)
def test_nrrd_without_a_space_or_directions(tmp_path, fields, matrix):
    require_read(written(tmp_path, "egg.nrrd", files.nrrd_of(EGG, *fields)), np.array(matrix))


def test_keys_of_nrrd_are_no_fields(tmp_path):
    data = files.nrrd_of(
        EGG, "space: LAS", DIRECTIONS, ORIGIN, "space:=RAS", "space units:=um", "# space: RAS"
    )
    require_read(written(tmp_path, "egg.nrrd", data), np.diag([-1.0, 1, 1, 1]) @ MATRIX)


@pytest.mark.parametrize("type_", TYPES)
def test_types_of_text_headers(tmp_path, type_):
    array = (100 * EGG).astype(type_)
    for name, data in (
        ("egg.nrrd", files.nrrd_of(array, "space: LAS", DIRECTIONS, ORIGIN)),
        ("egg.mha", files.meta(array, LPS @ np.diag([-1.0, 1, 1, 1]) @ MATRIX)),
        ("packed.mha", files.meta(array, LPS @ np.diag([-1.0, 1, 1, 1]) @ MATRIX, True)),
    ):
        require_read(written(tmp_path, name, data), np.diag([-1.0, 1, 1, 1]) @ MATRIX, labels="100")


@pytest.mark.parametrize("inside", [True, False])
@pytest.mark.parametrize(
    "encoding, encode, extra",
    [
        ("raw", bytes, ()),
        ("raw", lambda d: b"x" * 100 + d, ("byte skip: 100",)),
        ("raw", lambda d: b"x" * 100 + d, ("byte skip: -1",)),
        ("gzip", gzip.compress, ()),
        ("gz", lambda d: b"one\ntwo\n" + gzip.compress(d), ("line skip: 2",)),
        ("hex", lambda d: d.hex().encode(), ()),
        (
            "ascii",
            lambda d: " ".join(map(str, np.frombuffer(d, ">i2").tolist())).encode(),
            (),
        ),
    ],
)
def test_encodings_of_nrrd(tmp_path, encoding, encode, extra, inside):
    """Attached, and in a file beside the header."""
    array = EGG.astype(">i2")
    voxels = encode(array.tobytes(order="F"))
    header = files.nrrd_of(EGG.astype("i2"), "space: RAS", DIRECTIONS, ORIGIN, *extra)
    header = header[: -2 * EGG.size].replace(b"endian: little", b"endian: big")
    header = header.replace(b"encoding: raw", f"encoding: {encoding}".encode())
    if inside:
        path = written(tmp_path, "egg.nrrd", header + voxels)
    else:
        (tmp_path / "data").mkdir()
        written(tmp_path / "data", "egg voxels.bin", voxels)
        path = written(tmp_path, "egg.nhdr", header[:-1] + b"data file: data/egg voxels.bin\n")
    require_read(path, MATRIX)


@pytest.mark.parametrize("word", ["bzip2", "BZ2"])
def test_what_packs_nrrd_and_is_not_read(tmp_path, word):
    for name, field in (("egg.nrrd", b""), ("egg.nhdr", b"data file: egg.bz2\n")):
        written(tmp_path, "egg.bz2", bz2.compress(EGG.tobytes(order="F")))
        header = files.nrrd_of(EGG, "space: RAS", DIRECTIONS, ORIGIN)[: -EGG.size]
        data = header.replace(b"encoding: raw\n", f"encoding: {word}\n".encode() + field)
        refused(written(tmp_path, name, data + bz2.compress(EGG.tobytes(order="F"))), "gzip")


def test_fields_of_nrrd_that_do_not_move_it(tmp_path):
    """A measurement frame is of vectors, thicknesses are of slices; centres without axis mins."""
    for field in (
        "measurement frame: (0,1,0) (1,0,0) (0,0,1)",
        "thicknesses: nan nan 1",
        "centers: node node node",
        "kinds: space space space",
        "old min: 0",
    ):
        data = files.nrrd_of(EGG, "space: RAS", DIRECTIONS, ORIGIN, field)
        require_read(written(tmp_path, "egg.nrrd", data), MATRIX)


# ---------------------------------------------------------------- MetaImage

TURN = "TransformMatrix = 0 1 0 -1 0 0 0 0 1"
TURNED = np.array([[0, -1.8, 0, -40], [1.5, 0, 0, 25], [0, 0, 2, 110], [0, 0, 0, 1]])
SPACING = "ElementSpacing = 1.5 1.8 2"
OFFSET = "Offset = -40 25 110"


@pytest.mark.parametrize(
    "fields",
    [
        [TURN, SPACING, OFFSET],
        [TURN, "ElementSize = 1.5 1.8 2", OFFSET],
        [TURN, "ElementSize = 9 9 9", SPACING, OFFSET],
        [TURN, SPACING, OFFSET.replace("Offset", "Position")],
        [TURN, SPACING, OFFSET.replace("Offset", "Origin")],
        [TURN, SPACING, OFFSET, "Position = 0 0 0"],
        [TURN.replace("TransformMatrix", "Rotation"), SPACING, OFFSET],
        [TURN.replace("TransformMatrix", "Orientation"), SPACING, OFFSET],
        [TURN, SPACING, OFFSET, "CenterOfRotation = 5 6 7"],
        [TURN, SPACING, OFFSET, "ElementNumberOfChannels = 1", "ElementSize = 9 9 9"],
        [TURN, SPACING, OFFSET, "AnatomicalOrientation = RAI"],
        [TURN, SPACING, OFFSET, "AnatomicalOrientation = LPS"],
        [TURN, SPACING, OFFSET, "AnatomicalOrientation = ???"],
        [TURN, SPACING, OFFSET, "AnatomicalOrientation = SLA"],
    ],
)
def test_places_in_meta_image(tmp_path, fields):
    for compressed in (False, True):
        data = files.meta_of(EGG, *fields, compressed=compressed)
        require_read(written(tmp_path, "egg.mha", data), LPS @ TURNED)


@pytest.mark.parametrize("unit", ["mm", "um", "cm", "m", "?", "parsec"])
def test_units_of_meta_image(tmp_path, unit):
    length = UNITS.get(unit, 1)
    spacing = "ElementSpacing = " + " ".join(repr(s / length) for s in (1.5, 1.8, 2))
    offset = "Offset = " + " ".join(repr(s / length) for s in (-40, 25, 110))
    data = files.meta_of(EGG, f"DistanceUnits = {unit}", TURN, spacing, offset)
    require_read(written(tmp_path, "egg.mha", data), LPS @ TURNED)


@pytest.mark.parametrize("field", ["ElementByteOrderMSB", "BinaryDataByteOrderMSB"])
@pytest.mark.parametrize("big", [True, False])
@pytest.mark.parametrize("compressed", [False, True])
def test_orders_of_bytes_in_meta_image(tmp_path, field, big, compressed):
    swapped = EGG.astype("i2").byteswap() if big else EGG.astype("i2")
    data = files.meta_of(swapped, f"{field} = {big}", TURN, SPACING, OFFSET, compressed=compressed)
    require_read(written(tmp_path, "egg.mha", data), LPS @ TURNED)


@pytest.mark.parametrize("extra", [0, 1])
def test_time_in_meta_image(tmp_path, extra):
    n = 4 + extra
    turn, spacing, offset = np.eye(n), np.ones(n), np.zeros(n)
    turn[:3, :3] = [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]
    spacing[:3], offset[:3] = (1.5, 1.8, 2), (-40, 25, 110)
    fields = [
        f"{name} = " + " ".join(map(repr, values.ravel().tolist()))
        for name, values in zip(
            ("TransformMatrix", "ElementSpacing", "Offset"), (turn, spacing, offset)
        )
    ]
    array = moving().reshape(*EGG.shape, *[1] * extra, 3)
    require_phases(written(tmp_path, "time.mha", files.meta_of(array, *fields)), LPS @ TURNED)


@pytest.mark.parametrize("word, text", [("F", True), ("False", True), ("0", True), ("T", False)])
def test_numbers_in_digits(tmp_path, word, text):
    data = files.meta_of(EGG, SPACING, OFFSET, TURN)
    data = data.replace(b"BinaryData = True", f"BinaryData = {word}".encode())
    if text:
        data = data[: -EGG.size] + " ".join(map(str, EGG.ravel(order="F"))).encode()
    require_read(written(tmp_path, "egg.mha", data), LPS @ TURNED)


# ---------------------------------------------------------------- what a file leaves open


def unsure(returned):
    """What the filter says of the file, as (kind, message, subject)."""
    if "warnings" not in returned:
        return []
    remarks = json.loads(bytes(returned["warnings"].astype(int).tolist()).decode())
    return [(r["kind"], r["message"], r["subject"]) for r in remarks]


def analyze(folder):
    header, voxels = files.nifti_pair(EGG)
    header[344:348] = bytes(4)
    written(folder, "egg.img", voxels)
    return written(folder, "egg.hdr", bytes(header))


UNSURE = {
    "a.nii": (lambda: files.nifti(EGG, sform=0, pixdim=(1, 1, 1)), "Note", "noPlaceRas"),
    "b.nii": (lambda: files.nifti(np.where(EGG, 1, np.nan)), "Note", "nanIsBackground"),
    "c.nrrd": (lambda: files.nrrd_of(EGG, "spacings: 1 1 1"), "Note", "noPlaceLps"),
    "d.nrrd": (lambda: files.nrrd_of(EGG, "space: scanner-xyz", DIRECTIONS), "Warning", "noSides"),
    "e.nrrd": (lambda: files.nrrd_of(EGG, "space dimension: 3", DIRECTIONS), "Note", "noPlaceLps"),
    "f.nrrd": (
        lambda: files.nrrd_of(EGG, "space: 3D-left-handed", DIRECTIONS),
        "Warning",
        "leftHanded",
    ),
    "g.nrrd": (
        lambda: files.nrrd_of(EGG, "space: RAS", DIRECTIONS, 'space units: "ell" "ell" "ell"'),
        "Warning",
        "unknownUnit",
    ),
    "h.mha": (lambda: files.meta_of(EGG, SPACING, "DistanceUnits = ell"), "Warning", "unknownUnit"),
    "j.nii": (
        lambda: files.nifti(EGG, np.diag([-2, 2, 2, 1]), qform=(0, 0, 0, (0, 0, 0), 1)),
        "Warning",
        "formsMirror",
    ),
    "k.nii": (
        lambda: files.nifti(EGG, 2 * np.eye(4), qform=(0, 0, 0, (0, 0, 0), 1), pixdim=[1.5] * 3),
        "Warning",
        "formsDifferInSize",
    ),
    "l.nii": (
        lambda: files.nifti(EGG, 2 * np.eye(4), qform=(0, 0, 1, (0, 0, 0), 1)),
        "Note",
        "formsDiffer",
    ),
    "i.mha": (
        lambda: files.meta_of(EGG, SPACING, "AnatomicalOrientation = SLA"),
        "Note",
        "orientationContradicts",
    ),
    "m.mha": (lambda: files.meta_of(EGG), "Warning", "noSpacing"),
}


@pytest.mark.parametrize("name", UNSURE)
def test_what_is_assumed_is_said(tmp_path, name):
    make, kind, message = UNSURE[name]
    _, returned = imported(written(tmp_path, name, make()))
    assert unsure(returned) == [(kind, message, name[0])]


@pytest.mark.parametrize("spacings, missing", [("nan 2 3", 1), ("nan nan 2", 2), ("", 3)])
def test_a_size_of_voxels_that_is_not_said_is_warned_of(tmp_path, spacings, missing):
    fields = [f"spacings: {spacings}"] if spacings else []
    _, returned = imported(written(tmp_path, "odd.nrrd", files.nrrd_of(EGG, *fields)))
    assert [message for _, message, _ in unsure(returned)] == ["noSpacing", "noPlaceLps"]
    text = json.loads(bytes(returned["warnings"].astype(int).tolist()).decode())[0]["text"]
    assert f"({missing} ax" in text and "1 mm is taken" in text


@pytest.mark.parametrize("spacing, odd", [(0.002, True), (1, False), (400, True)])
def test_a_surface_of_no_organs_size_is_warned_of(tmp_path, spacing, odd):
    """As from voxels in metres whose unit the header calls mm."""
    path = written(tmp_path, "odd.nii", files.nifti(EGG, np.diag([*[spacing] * 3, 1])))
    _, returned = imported(path)
    assert [message for _, message, _ in unsure(returned)] == ["oddExtent"] * odd


@pytest.mark.parametrize("time", [False, True])
@pytest.mark.parametrize("space", ["scanner-xyz", "3D-right-handed", "3D-left-handed"])
def test_spaces_that_name_no_side_are_warned_of(tmp_path, space, time):
    """With the file, the space, and what was assumed; the body lies where that puts it."""
    space += "-time" if time else ""
    directions = DIRECTIONS if not time else DIRECTIONS.replace(")", ",0)") + " (0,0,0,40)"
    origin = ORIGIN if not time else ORIGIN.replace(")", ",0)")
    array = EGG if not time else moving()
    path = written(
        tmp_path, "odd.nrrd", files.nrrd_of(array, f"space: {space}", directions, origin)
    )
    ms, returned = imported(path)
    remark = json.loads(bytes(returned["warnings"].astype(int).tolist()).decode())[0]
    assert remark["kind"] == "Warning" and remark["subject"] == "odd"
    assert space.lower() in remark["text"] and "left, posterior and superior" in remark["text"]
    if not time:
        require_read(path, np.diag([-1, -1, 1, 1]) @ MATRIX)


def test_nothing_is_said_of_files_that_say_it_all(tmp_path):
    for name, data in (
        ("a.nii", files.nifti(EGG, MATRIX)),
        ("b.nrrd", files.nrrd_of(EGG, "space: LAS", DIRECTIONS, 'space units: "cm" "cm" "cm"')),
        ("c.mha", files.meta_of(EGG, SPACING, "DistanceUnits = mm", "AnatomicalOrientation = RAI")),
    ):
        assert unsure(imported(written(tmp_path, name, data))[1]) == []
    assert unsure(imported(analyze(tmp_path))[1]) == [("Warning", "analyzeSides", "egg")]


# ---------------------------------------------------------------- names


def test_companions_of_macos(tmp_path):
    """They lie beside every file on a foreign disk, under the names of volumes."""
    double = struct.pack(">II16xH", 0x00051607, 0x00020000, 2) + bytes(4000)
    for number in (1, 2, 3):
        written(tmp_path, f"{number}.nii", files.nifti(np.roll(EGG, number - 1, 0)))
        written(tmp_path, f"._{number}.nii", double)
    assert imported(tmp_path / "1.nii", file_series=True)[1]["layers"] == 3
    refused(tmp_path / "._1.nii", 'choose "1.nii"')
    require_read(written(tmp_path, "._own.nii", files.nifti(EGG)), np.eye(4))


def test_a_place_that_is_no_number(tmp_path):
    for version in (1, 2):
        data = files.nifti(EGG, NAN, pixdim=(1, 1, 1), version=version)
        refused(written(tmp_path, "nan.nii", data), "NaN")
    for field in ("space origin: (nan,nan,nan)", "space origin: (1,2,inf)"):
        path = written(tmp_path, "o.nrrd", files.nrrd_of(EGG, "space: RAS", DIRECTIONS, field))
        if "inf" in field:
            refused(path, "not finite")
        else:  # which is how NRRD says that there is none
            assert imported(path)[1]["layers"] == 1
    refused(written(tmp_path, "w.mha", files.meta_of(EGG, "Offset = 1 two 3")), "two")
