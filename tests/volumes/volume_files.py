# SPDX-License-Identifier: GPL-3.0-only
"""Writes label volumes in the formats that are read, and reads NIfTI, by their specifications,
without a library."""

import gzip
import struct
import zlib

import numpy as np

NIFTI_TYPES = {
    "u1": 2,
    "i2": 4,
    "i4": 8,
    "f4": 16,
    "f8": 64,
    "i1": 256,
    "u2": 512,
    "u4": 768,
    "i8": 1024,
    "u8": 1280,
}
META_TYPES = {
    "u1": "MET_UCHAR",
    "i2": "MET_SHORT",
    "u2": "MET_USHORT",
    "i4": "MET_INT",
    "f4": "MET_FLOAT",
    "f8": "MET_DOUBLE",
    "i1": "MET_CHAR",
    "u4": "MET_UINT",
    "i8": "MET_LONG_LONG",
    "u8": "MET_ULONG_LONG",
}
NRRD_TYPES = {
    "u1": "uint8",
    "i2": "int16",
    "u2": "uint16",
    "i4": "int32",
    "f4": "float",
    "f8": "double",
    "i1": "int8",
    "u4": "unsigned int",
    "i8": "signed long long",
    "u8": "unsigned long long int",
}


def code(array):
    return array.dtype.str[1:]


IDENTITY = np.eye(4)


def data(array):
    return np.asarray(array).tobytes(order="F")


def nifti(*content, version=1, big=False, begin=None, **fields):
    """The bytes of a NIfTI file of version 1 or 2; content and fields as of nifti_pair."""
    header, voxels = nifti_pair(*content, version=version, big=big, begin=begin, **fields)
    header[344:347] = b"n+1" if version == 1 else header[344:347]
    header[4:7] = b"n+2" if version == 2 else header[4:7]
    if begin is None:
        struct.pack_into(
            (">" if big else "<") + "fq"[version - 1], header, (108, 168)[version - 1], len(header)
        )
    return bytes(header) + voxels


def nifti_pair(
    array,
    matrix=IDENTITY,
    size=None,
    sform=1,
    qform=None,
    pixdim=None,
    slope=0.0,
    inter=0.0,
    big=False,
    version=1,
    unit=2,
    intent=0,
    begin=None,
):
    """The bytes of .hdr (which may be changed) and .img. qform: (b, c, d, offset, qfac); size: what
    the header claims instead of the truth; begin: what it says of where the voxels are."""
    order = ">" if big else "<"
    size = list(array.shape if size is None else size)
    header = bytearray(352 if version == 1 else 544)

    def put(first, second, of_first, of_second, *values):
        place, kind = (first, of_first) if version == 1 else (second, of_second)
        struct.pack_into(f"{order}{len(values)}{kind}", header, place, *values)

    put(0, 0, "i", "i", 348 if version == 1 else 540)
    put(40, 16, "h", "q", len(size), *(size + [1] * (7 - len(size))))
    put(70, 12, "h", "h", NIFTI_TYPES[code(array)], 8 * array.itemsize)
    spacing = list(np.linalg.norm(np.asarray(matrix)[:3, :3], axis=0) if pixdim is None else pixdim)
    put(76, 104, "f", "d", 1 if qform is None else qform[4], *spacing, 1, 1, 1, 1)
    put(108, 168, "f", "q", begin or 0)
    put(112, 176, "f", "d", slope, inter)
    put(123, 500, "B", "i", unit)
    put(68, 504, "h", "i", intent)
    put(252, 344, "h", "i", 0 if qform is None else 1, sform)
    if qform is not None:
        put(256, 352, "f", "d", *qform[:3], *qform[3])
    if sform:
        put(280, 400, "f", "d", *np.asarray(matrix, float)[:3].ravel())
    if version == 1:
        header[344:347] = b"ni1"
    else:
        header[4:12] = b"ni2\0\r\n\x1a\n"
    return header, data(array.astype(array.dtype.newbyteorder(order)))


def read_nifti(path):
    """The voxels of a little-endian .nii.gz, and its sform."""
    content = gzip.decompress(path.read_bytes())
    size, (kind,), (begin,) = (
        struct.unpack_from(*at)
        for at in (("<8h", content, 40), ("<h", content, 70), ("<f", content, 108))
    )
    dtype = {number: name for name, number in NIFTI_TYPES.items()}[kind]
    shape = size[1 : 1 + size[0]]
    matrix = np.eye(4)
    matrix[:3] = np.reshape(struct.unpack_from("<12f", content, 280), (3, 4))
    return np.frombuffer(
        content, "<" + dtype, offset=int(begin), count=int(np.prod(shape))
    ).reshape(shape, order="F"), matrix


def meta(array, matrix=IDENTITY, compressed=False, local="LOCAL", size=None):
    """The bytes of a MetaImage file (of its header alone where the voxels are in another file);
    matrix: to LPS."""
    size = array.shape if size is None else size
    n, spacing = len(size), np.linalg.norm(matrix[:3, :3], axis=0)
    direction, offset = np.eye(n), np.zeros(n)
    direction[:3, :3], offset[:3] = (matrix[:3, :3] / spacing).T, matrix[:3, 3]
    voxels = zlib.compress(data(array)) if compressed else data(array)
    text = (
        f"ObjectType = Image\nNDims = {n}\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
        f"CompressedData = {compressed}\nCompressedDataSize = {len(voxels)}\n"
        f"TransformMatrix = {' '.join(map(repr, direction.ravel().tolist()))}\n"
        f"Offset = {' '.join(map(repr, offset.tolist()))}\n"
        f"ElementSpacing = {' '.join(map(repr, spacing.tolist() + [1.0] * (n - 3)))}\n"
        f"DimSize = {' '.join(map(str, size))}\n"
        f"ElementType = {META_TYPES[code(array)]}\nElementDataFile = {local}\n"
    ).encode()
    return text + (voxels if local == "LOCAL" else b"")


def nrrd(array, matrix=IDENTITY, encoding="raw", size=None, kinds=None):
    """The bytes of a NRRD file; matrix: to LPS."""
    size = array.shape if size is None else size
    kinds = kinds or ["domain"] * 3 + ["list"] * (len(size) - 3)
    vectors = iter(f"({','.join(map(repr, column.tolist()))})" for column in matrix[:3, :3].T)
    directions = " ".join(next(vectors) if kind == "domain" else "none" for kind in kinds)
    text = (
        f"NRRD0004\ntype: {NRRD_TYPES[code(array)]}\ndimension: {len(size)}\n"
        f"space: left-posterior-superior\nsizes: {' '.join(map(str, size))}\n"
        f"space directions: {directions}\nkinds: {' '.join(kinds)}\n"
        f"endian: little\nencoding: {encoding}\n"
        f"space origin: ({','.join(map(repr, matrix[:3, 3].tolist()))})\n\n"
    ).encode()
    return text + (gzip.compress(data(array)) if encoding == "gzip" else data(array))


def nrrd_of(array, *fields):
    """A raw NRRD file with these lines of header."""
    lines = ["NRRD0005", f"type: {NRRD_TYPES[code(array)]}", f"dimension: {array.ndim}"]
    lines += ["sizes: " + " ".join(map(str, array.shape)), *fields, "endian: little"]
    return "\n".join([*lines, "encoding: raw", "", ""]).encode() + data(array)


def meta_of(array, *fields, compressed=False):
    """A MetaImage file with these lines of header."""
    voxels = zlib.compress(data(array)) if compressed else data(array)
    lines = ["ObjectType = Image", f"NDims = {array.ndim}", "BinaryData = True"]
    lines += [f"CompressedData = {compressed}"]
    lines += [f"CompressedDataSize = {len(voxels)}"] * compressed
    lines += [*fields, "DimSize = " + " ".join(map(str, array.shape))]
    lines += [f"ElementType = {META_TYPES[code(array)]}", "ElementDataFile = LOCAL", ""]
    return "\n".join(lines).encode() + voxels


def egg(size=(20, 18, 16), dtype="u1", value=1):
    """Labels of an egg that fills its grid nearly, and is not like its mirror images."""
    x = np.stack(
        np.meshgrid(*[(np.arange(n) - (n - 1) / 2) / (n / 2 - 1.5) for n in size], indexing="ij"),
        -1,
    )
    inside = (x**2).sum(-1) * (1 + 0.25 * x[..., 0] + 0.15 * x[..., 1] - 0.2 * x[..., 2]) < 0.8
    return (value * inside).astype(dtype)
