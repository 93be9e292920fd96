# SPDX-License-Identifier: GPL-3.0-only
"""Surface files of this field: VTK's, GIFTI, FreeSurfer's, STL, and the frames that they are in,
for the package and by the command line."""

import os
import re
import sys

import nibabel
import numpy as np
import pytest
import pyvista
import sphere_propagation as sp
import trimesh
import vtk
from sphere_propagation import command, readers

SHIFT = np.array([50.0, -20.0, 30.0])


@pytest.fixture(scope="module")
def body():
    """Not in the middle of anything, and without symmetry."""
    surface = sp.make_phantom(phases=1, voxel_size=4)[0]
    return surface.vertices * [1, 0.8, 1.2] + SHIFT, surface.faces


def polydata(vertices, faces):
    return pyvista.PolyData(vertices, np.c_[np.full(len(faces), 3), faces])


def written(writer, path, data, **settings):
    """By one of VTK's writers; settings: its methods, and what they are called with."""
    writer.SetFileName(str(path))
    writer.SetInputData(data)
    for method, argument in settings.items():
        getattr(writer, method)(*([] if argument is None else [argument]))
    assert writer.Write()
    return path


def legacy(**settings):
    return lambda path, v, f: written(vtk.vtkPolyDataWriter(), path, polydata(v, f), **settings)


def xml(**settings):
    return lambda path, v, f: written(vtk.vtkXMLPolyDataWriter(), path, polydata(v, f), **settings)


def grid(writer):
    return lambda path, v, f: written(writer(), path, polydata(v, f).cast_to_unstructured_grid())


def strips(path, v, f):
    return written(vtk.vtkPolyDataWriter(), path, polydata(v, f).strip())


def split(path, v, f):
    """As it is written for flat shading: every face with corners of its own."""
    return written(
        vtk.vtkPolyDataWriter(), path, polydata(v[f.ravel()], np.arange(f.size).reshape(-1, 3))
    )


def with_loose_points(path, v, f):
    return written(vtk.vtkPolyDataWriter(), path, polydata(np.vstack([[[0, 0, 0]], v]), f + 1))


def gifti(encoding):
    def write(path, v, f):
        system = nibabel.gifti.GiftiCoordSystem(1, 1)
        arrays = [
            nibabel.gifti.GiftiDataArray(
                v.astype(np.float32), "NIFTI_INTENT_POINTSET", coordsys=system, encoding=encoding
            ),
            nibabel.gifti.GiftiDataArray(f, "NIFTI_INTENT_TRIANGLE", encoding=encoding),
        ]
        nibabel.save(nibabel.gifti.GiftiImage(darrays=arrays), path)

    return write


def volume_info(center=(0, 0, 0), axes=((-1, 0, 0), (0, 0, -1), (0, 1, 0))):
    """Where FreeSurfer's image lies."""
    about = {"head": np.array([2, 0, 20]), "valid": "1  # volume info valid", "filename": "x.mgz"}
    about.update(volume=np.array([256] * 3), voxelsize=np.ones(3), cras=np.array(center, float))
    about.update({f"{name}ras": np.array(axis, float) for name, axis in zip("xyz", axes)})
    return about


def freesurfer(path, v, f):
    nibabel.freesurfer.write_geometry(str(path), v, f, volume_info=volume_info())


def stl(path, v, f):
    written(vtk.vtkSTLWriter(), path, polydata(v, f), SetFileTypeToBinary=None)


FILES = {
    "legacy ascii.vtk": legacy(SetFileTypeToASCII=None),
    "legacy binary.vtk": legacy(SetFileTypeToBinary=None),
    "legacy of old.VTK": legacy(SetFileTypeToBinary=None, SetFileVersion=42),
    "strips.vtk": strips,
    "split.vtk": split,
    "loose points.vtk": with_loose_points,
    "a grid of triangles.vtk": grid(vtk.vtkUnstructuredGridWriter),
    "a grid of triangles.vtu": grid(vtk.vtkXMLUnstructuredGridWriter),
    "ascii.vtp": xml(SetDataModeToAscii=None),
    "binary.vtp": xml(SetDataModeToBinary=None),
    "appended.VTP": xml(SetDataModeToAppended=None),
    "appended raw.vtp": xml(SetDataModeToAppended=None, EncodeAppendedDataOff=None),
    "not compressed.vtp": xml(SetCompressorTypeToNone=None),
    "lz4.vtp": xml(SetCompressorTypeToLZ4=None),
    "big endian, 64 bits.vtp": xml(SetByteOrderToBigEndian=None, SetHeaderTypeToUInt64=None),
    "ascii.gii": gifti("GIFTI_ENCODING_ASCII"),
    "base 64.gii": gifti("GIFTI_ENCODING_B64BIN"),
    "compressed.surf.gii": gifti("GIFTI_ENCODING_B64GZ"),
    "lh.white": freesurfer,
    "stl.STL": stl,
    "Grüße, 心臓.vtk": legacy(),
    "Grüße, 心臓.stl": stl,
}


@pytest.mark.parametrize("name", FILES)
def test_what_is_written_is_read(name, body, tmp_path):
    """Every vertex in its place, closed, outside out; STL writes vertices once per face."""
    vertices, faces = body
    FILES[name](tmp_path / name, vertices, faces)
    surface = sp.read_mesh(tmp_path / name)
    assert surface.name == re.sub(r"\.(surf\.gii|vt[kpu]|gii|stl)$", "", name, flags=re.I)
    assert surface.vertices.shape == vertices.shape and surface.faces.shape == faces.shape
    assert readers.open_edges(surface.faces) == 0 and surface.volume > 0
    order, found = (np.lexsort(np.round(v, 3).T) for v in (vertices, surface.vertices))
    assert np.abs(vertices[order] - surface.vertices[found]).max() < 1e-4
    if name not in ("strips.vtk", "split.vtk", "stl.STL", "Grüße, 心臓.stl"):
        assert np.array_equal(surface.faces, faces)


@pytest.mark.parametrize("format", ["ascii", "binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize("name", ["vertex_index", "vertex_indices"])
@pytest.mark.parametrize("real", ["float", "double"])
def test_ply_with_numbers_of_any_types(format, name, real, body, tmp_path):
    """Some of them MeshLab reads as other faces or places, without a word; edges may follow."""
    v, f = body[0].astype({"float": "f4", "double": "f8"}[real]), body[1]
    e = ">" if "big" in format else "<"
    for count, number in (("uchar", "u1"), ("uint8", "u1"), ("int", "i4"), ("uint", "u4")):
        for index, corner in (("ushort", "u2"), ("int", "i4"), ("uint", "u4"), ("uint32", "u4")):
            head = f"ply\nformat {format} 1.0\ncomment x\nelement vertex {len(v)}\n"
            head += "".join(f"property {real} {axis}\n" for axis in "xyz")
            head += f"element face {len(f)}\nproperty list {count} {index} {name}\n"
            edges = b""
            if real == "double" and "big" in format and index == "uint":
                head += "element edge 1\nproperty int vertex1\nproperty int vertex2\n"
                edges = bytes(8)
            head += "end_header\n"
            if format == "ascii":
                rows = [" ".join(map(repr, p.tolist())) for p in v]
                rows += [" ".join(map(str, (3, *face))) for face in f.tolist()]
                content = ("\n".join(rows) + "\n").encode()
            else:
                faces = np.empty(len(f), [("n", e + number), ("i", e + corner, 3)])
                faces["n"], faces["i"] = 3, f
                content = v.astype(v.dtype.newbyteorder(e)).tobytes() + faces.tobytes() + edges
            path = tmp_path / "body.ply"
            path.write_bytes(head.encode() + content)
            found = sp.read_mesh(path)
            assert np.array_equal(found.faces, f), (count, index)
            assert np.abs(found.vertices - v).max() < 1e-5


@pytest.mark.parametrize(
    "order, real, index, what",
    [
        ("little", "float", "ushort", "lists of uchar and ushort"),
        ("big", "double", "int", "big-endian doubles"),
    ],
)
def test_ply_with_types_that_are_not_known_beside_others_is_refused(
    order, real, index, what, tmp_path
):
    head = f"ply\nformat binary_{order}_endian 1.0\nelement vertex 4\n"
    head += "".join(f"property {real} {axis}\n" for axis in "xyz")
    head += f"element face 4\nproperty list uchar {index} vertex_indices\nproperty uchar flag\n"
    path = tmp_path / "flags.ply"
    path.write_bytes(head.encode() + b"end_header\n" + bytes(4 * 24 + 4 * 14))
    with pytest.raises(sp.FileError, match=f"{what} beside other things"):
        sp.read_mesh(path)


@pytest.mark.parametrize("left", [1, 500, 5000])
def test_stl_that_ends_too_early_is_refused(left, body, tmp_path):
    """MeshLab takes the triangles that are there."""
    path = tmp_path / "cut.stl"
    stl(path, *body)
    content, count = path.read_bytes(), len(body[1])
    path.write_bytes(content[:-left])
    with pytest.raises(sp.FileError, match=f"{count - -(-left // 50)} of its {count} triangles"):
        sp.read_mesh(path)
    rows = [
        f"facet normal 0 0 1\nouter loop\n{corner}endloop\nendfacet\n"
        for corner in (
            "".join("vertex " + " ".join(map(repr, p)) + "\n" for p in triangle)
            for triangle in body[0][body[1]].tolist()
        )
    ]
    text = "solid x\n" + "".join(rows) + "endsolid x\n"
    path.write_text(text)
    assert len(sp.read_mesh(path).faces) == count
    path.write_text(text[: -20 - left])
    with pytest.raises(sp.FileError, match="ends too early"):
        sp.read_mesh(path)


def test_names_that_the_locale_does_not_have(body, tmp_path, run_python):
    """PyMeshLab loses them where LC_ALL=C."""
    folder = tmp_path / "Фазы"
    folder.mkdir()
    stl(folder / "心.stl", *body)
    legacy()(folder / "heart ü.vtk", *body)
    code = (
        "import sphere_propagation as sp, sys\n"
        "print(*(len(s.faces) for s in sp.read_meshes(sys.argv[1])))"
    )
    ended = run_python(code, str(folder), LC_ALL="C")
    assert ended.stdout.split() == [str(len(body[1]))] * 2, ended.stderr


# ---------------------------------------------------------------- frames


def ply(header):
    def write(path, v, f):
        sp.write_ply(path, v, f)
        path.write_bytes(path.read_bytes().replace(b"comment SPACE=RAS", header, 1))

    return write


def ascii_ply(path, v, f):
    rows = [" ".join(map(str, row)) for row in v] + [f"3 {a} {b} {c}" for a, b, c in f]
    head = ["ply", "format ascii 1.0", "comment SPACE=LPS", f"element vertex {len(v)}"]
    head += [f"property float {axis}" for axis in "xyz"] + [f"element face {len(f)}"]
    head += ["property list uchar int vertex_indices", "end_header"]
    path.write_text("\n".join(head + rows) + "\n")


def obj(path, v, f):
    lines = ["# 3D Slicer output. SPACE=LPS", *("v {} {} {}".format(*row) for row in v)]
    path.write_text("\n".join(lines + ["f {} {} {}".format(*row) for row in f + 1]) + "\n")


def stl_of_slicer(text):
    def write(path, v, f):
        writer = vtk.vtkSTLWriter()
        method = "SetFileTypeToASCII" if text else "SetFileTypeToBinary"
        written(
            writer, path, polydata(v, f), SetHeader="3D Slicer output. SPACE=LPS", **{method: None}
        )

    return write


def field_data(writer, value):
    def write(path, v, f):
        data = polydata(v, f)
        data.field_data["SPACE"] = [value]
        written(writer(), path, data)

    return write


IN_LPS = {
    "slicer.vtk": legacy(SetHeader="3D Slicer output. SPACE=LPS"),
    "field.vtk": field_data(vtk.vtkPolyDataWriter, "LPS"),
    "field.vtp": field_data(vtk.vtkXMLPolyDataWriter, "LPS"),
    "field of slicer.vtp": field_data(vtk.vtkXMLPolyDataWriter, "SPACE=LPS"),
    "binary.ply": ply(b"comment 3D Slicer output. SPACE=LPS"),
    "ascii.ply": ascii_ply,
    "binary.stl": stl_of_slicer(text=False),
    "ascii.stl": stl_of_slicer(text=True),
    "slicer.obj": obj,
}


@pytest.mark.parametrize("name", IN_LPS)
def test_files_in_lps_are_turned_into_ras(name, body, tmp_path):
    IN_LPS[name](tmp_path / name, body[0] * [-1, -1, 1], body[1])
    surface = sp.read_mesh(tmp_path / name)
    assert surface.space == "RAS" and surface.volume > 0
    assert np.abs(surface.vertices.min(0) - body[0].min(0)).max() < 1e-4
    assert np.abs(surface.vertices.max(0) - body[0].max(0)).max() < 1e-4


def test_what_is_written_says_its_frame(body, tmp_path):
    sp.write_ply(tmp_path / "a.ply", *body)
    assert b"\ncomment SPACE=RAS\n" in (tmp_path / "a.ply").read_bytes()
    sp.write_ply(tmp_path / "b.ply", body[0] * [-1, -1, 1], body[1], space="LPS")
    a, b = sp.read_meshes(tmp_path)
    assert a.space == b.space == "RAS" and np.allclose(a.vertices, b.vertices, atol=1e-4)


def test_layers_say_the_frame_of_their_surfaces(cycle, tmp_path):
    sp.write_layers(tmp_path, "cycle", cycle)
    for path in (tmp_path / "cycle").rglob("*.ply"):
        assert b"\ncomment SPACE=RAS\n" in path.read_bytes()


def test_a_frame_that_nobody_knows_is_refused(body, tmp_path):
    for name, header in (("a", b"comment SPACE=SCANNER"), ("b", b"comment SPACE=RAS SPACE=LPS")):
        ply(header)(tmp_path / f"{name}.ply", *body)
        with pytest.raises(sp.FileError, match="one of RAS and LPS is understood"):
            sp.read_mesh(tmp_path / f"{name}.ply")


def test_frames_that_only_some_tell_are_warned_of(body, tmp_path):
    sp.write_ply(tmp_path / "a.ply", *body)
    stl(tmp_path / "b.stl", *body)
    with pytest.warns(sp.SpherePropagationWarning, match="^b does not say whether .* as a does"):
        sp.read_meshes(tmp_path)


@pytest.mark.parametrize(
    "axes", [((-1, 0, 0), (0, 0, -1), (0, 1, 0)), ((-0.8, 0.6, 0), (0, 0, -1), (0.6, 0.8, 0))]
)
def test_freesurfers_coordinates_become_the_scanners(axes, body, tmp_path):
    """Against the matrices of nibabel's MGH header."""
    center = (5.0, -17.0, 19.0)
    about = volume_info(center, axes)
    nibabel.freesurfer.write_geometry(str(tmp_path / "lh.white"), *body, volume_info=about)
    header = nibabel.freesurfer.MGHImage(np.zeros((256,) * 3, np.uint8), None).header
    header["Mdc"], header["Pxyz_c"], header["delta"] = np.array(axes), center, 1
    to_scanner = header.get_affine() @ np.linalg.inv(header.get_vox2ras_tkr())
    surface = sp.read_mesh(tmp_path / "lh.white")
    right = body[0] @ to_scanner[:3, :3].T + to_scanner[:3, 3]
    assert np.abs(surface.vertices - right).max() < 1e-3
    assert surface.space == "RAS" and surface.name == "lh.white" and surface.volume > 0


@pytest.mark.parametrize("invalid", [None, "0  # volume info invalid"])
def test_freesurfers_files_that_do_not_tell_where_are_warned_of(invalid, body, tmp_path):
    about = invalid and {**volume_info((5, 0, 0)), "valid": invalid}
    nibabel.freesurfer.write_geometry(str(tmp_path / "lh.white"), *body, volume_info=about)
    with pytest.warns(sp.SpherePropagationWarning, match="c_ras"):
        surface = sp.read_mesh(tmp_path / "lh.white")
    assert np.abs(surface.vertices - body[0]).max() < 1e-4


def ascii_of(vertices, faces):
    """As mris_convert writes them."""
    rows = [" ".join(map(repr, map(float, row))) + " 0" for row in vertices]
    rows += [" ".join(map(str, row)) + " 0" for row in faces]
    return "\n".join(["#!ascii version of lh.white", f"{len(vertices)} {len(faces)}", *rows, ""])


def test_freesurfers_in_ascii(body, tmp_path):
    path = tmp_path / "lh.white.asc"
    path.write_text(ascii_of(*body))
    with pytest.warns(sp.SpherePropagationWarning, match="c_ras"):
        surface = sp.read_mesh(path)
    assert np.array_equal(surface.vertices, body[0]) and np.array_equal(surface.faces, body[1])
    assert [found.name for found in sp.mesh_files(tmp_path)] == ["lh.white.asc"]
    lines = ascii_of(*body).splitlines()
    for broken in (
        lines[:-1],
        lines[:2],
        lines[:1],
        [*lines[:-1], "0 1 99999 0"],
        ["#!ascii", "x"],
    ):
        path.write_text("\n".join(broken))
        with pytest.raises(sp.FileError, match="cannot be read as FreeSurfer's"):
            sp.read_mesh(path)


# ---------------------------------------------------------------- what is no surface


@pytest.mark.parametrize("suffix", ["obj", "off", "ply", "stl", "vtk"])
def test_decimal_commas_are_refused(suffix, body, tmp_path):
    """Which other readers take for the end of a number."""
    path = tmp_path / f"a.{suffix}"
    mesh = pyvista.PolyData.from_regular_faces(*body)
    if suffix in ("obj", "off"):
        trimesh.Trimesh(*body, process=False).export(path)
    else:
        mesh.save(path, binary=False)
    assert len(sp.read_mesh(path).vertices) == len(body[0])
    path.write_text(re.sub(r"(\d)\.(\d)", r"\1,\2", path.read_text()))
    with pytest.raises(
        sp.FileError, match=r"writes numbers with a comma, as -?\d*,\d+: write them"
    ):
        sp.read_mesh(path)


def image(path, *_):
    written(vtk.vtkStructuredPointsWriter(), path, pyvista.ImageData(dimensions=(3, 3, 3)))


def tetrahedra(path, *_):
    data = pyvista.ImageData(dimensions=(3, 3, 3)).to_tetrahedra()
    written(vtk.vtkUnstructuredGridWriter(), path, data)


def points(path, v, _):
    written(vtk.vtkPolyDataWriter(), path, pyvista.PolyData(v))


def numbers(path, v, _):
    array = nibabel.gifti.GiftiDataArray(v[:, 0].astype(np.float32), "NIFTI_INTENT_SHAPE")
    nibabel.save(nibabel.gifti.GiftiImage(darrays=[array]), path)


def content(data):
    return lambda path, *_: path.write_bytes(data)


def cut(write, share):
    def written_in_part(path, v, f):
        write(path, v, f)
        path.write_bytes(path.read_bytes()[: int(share * path.stat().st_size)])

    return written_in_part


def lost_vertex(path, v, f):
    path.write_text(
        "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n"
        "0 0 0 1 0 0 0 1 0\nPOLYGONS 2 9\n3 0 1 7\n4 0 1 2 9\n"
    )


def with_faces_of_others(name):
    """A face that names a vertex which is not there; PyMeshLab crashes over it."""

    def write(path, v, f):
        f = f.copy()
        f[7, 1] = len(v)
        if name == "ply":
            sp.write_ply(path, v, f * 0)
            content = path.read_bytes()
            faces = np.empty(len(f), [("count", "u1"), ("indices", "<i4", 3)])
            faces["count"], faces["indices"] = 3, f
            path.write_bytes(content[: -faces.nbytes] + faces.tobytes())
        elif name == "obj":
            obj(path, v, f)
        else:
            rows = [" ".join(map(str, row)) for row in v] + [f"3 {a} {b} {c}" for a, b, c in f]
            path.write_text("\n".join(["OFF", f"{len(v)} {len(f)} 0", *rows]) + "\n")

    return write


VTK_HEAD = b"# vtk DataFile Version 3.0\nt\nBINARY\nDATASET POLYDATA\n"
NO_SURFACE = {
    "image.vtk": (image, "holds no surface, but STRUCTURED_POINTS"),
    "tetrahedra.vtk": (tetrahedra, r"holds a mesh of solids.* mesh = (.*)"),
    "points.vtk": (points, "holds no triangles"),
    "no dataset.vtk": (content(VTK_HEAD[:-18] + b"DATA\xff SET POLYDATA\n"), "no VTK header"),
    "no kind.vtk": (content(VTK_HEAD[:-9] + b"POL\xff\n"), "no surface, but POL"),
    "letters.vtk": (content(VTK_HEAD + b"POINTS \xff\xfe float\n"), "cannot be read as a mesh"),
    "empty.vtk": (content(b""), "It is empty"),
    "empty.stl": (content(b""), "It is empty"),
    "empty.gii": (content(b""), "It is empty"),
    "hello.vtk": (content(b"hello"), "no VTK header"),
    "hello.vtp": (content(b"hello"), "no VTK header"),
    "image.vtp": (content(b'<VTKFile type="ImageData">'), "no surface, but ImageData"),
    "hello.gii": (content(b"hello"), "cannot be read as GIFTI"),
    "thickness.shape.gii": (numbers, "other arrays of GIFTI"),
    "lh.curv": (content(b"\xff\xff\xff\0\0\0"), "lh.curv holds no surface"),
    "._heart.vtk": (content(b"\0\5\x16\7\0\2\0\0"), "what macOS keeps"),
    "billions.vtk": (content(VTK_HEAD + b"POINTS 99999999999 float\n"), "ends too early"),
    "cut in points.vtk": (cut(legacy(SetFileTypeToBinary=None), 0.1), "ends too early"),
    "cut in faces.vtk": (cut(legacy(SetFileTypeToBinary=None), 0.6), "ends too early"),
    "cut, of old.vtk": (
        cut(legacy(SetFileTypeToBinary=None, SetFileVersion=42), 0.6),
        "ends too early",
    ),
    "cut.vtp": (cut(xml(), 0.6), "cannot be read as a mesh"),
    "cut.gii": (cut(gifti("GIFTI_ENCODING_B64GZ"), 0.6), "cannot be read as GIFTI"),
    "lh.cut": (cut(freesurfer, 0.6), "cannot be read as FreeSurfer's"),
    "lost vertex.vtk": (lost_vertex, "name vertices that it lacks"),
    "faces of others.ply": (with_faces_of_others("ply"), "name vertices that it lacks"),
    "faces of others.obj": (with_faces_of_others("obj"), "name vertices that it lacks"),
    "faces of others.off": (with_faces_of_others("off"), "name vertices that it lacks"),
    "labels.nii": (content(b"x"), "is a label volume"),
}


@pytest.mark.parametrize("name", NO_SURFACE)
def test_what_holds_no_surface_is_named(name, body, tmp_path, capfd):
    """In one sentence, and nothing else is said anywhere."""
    write, words = NO_SURFACE[name]
    write(tmp_path / name, *body)
    with pytest.raises(sp.FileError, match=words) as refused:
        sp.read_mesh(tmp_path / name)
    assert str(tmp_path / name) in str(refused.value)
    assert capfd.readouterr() == ("", "")
    made = re.search(words, str(refused.value)).groups()
    if made:
        surface = eval(made[0], {"pyvista": pyvista})
        assert abs(sp.Surface(surface.points, surface.regular_faces).volume) > 0


def test_the_extra_is_named_where_it_is_missing(body, tmp_path, monkeypatch):
    legacy()(tmp_path / "a.vtk", *body)
    gifti("GIFTI_ENCODING_ASCII")(tmp_path / "b.gii", *body)
    freesurfer(tmp_path / "lh.white", *body)
    for module in ("vtkmodules.vtkCommonCore", "nibabel", "nibabel.freesurfer"):
        monkeypatch.setitem(sys.modules, module, None)
    for name in ("a.vtk", "b.gii", "lh.white"):
        with pytest.raises(sp.FileError, match=r"pip install 'sphere-propagation\[surfaces\]'"):
            sp.read_mesh(tmp_path / name)


# ---------------------------------------------------------------- folders


def test_a_folder_of_many_kinds(body, tmp_path):
    """Natural order; what macOS and FreeSurfer keep beside surfaces is left out."""
    for name in ("t10.vtk", "t9.VTP", "t2.stl"):
        FILES.get(name, xml() if name.endswith("P") else stl if name.endswith("stl") else legacy())(
            tmp_path / name, *body
        )
    gifti("GIFTI_ENCODING_ASCII")(tmp_path / "t11.surf.gii", *body)
    numbers(tmp_path / "t11.shape.gii", *body)
    (tmp_path / "._t2.stl").write_bytes(readers.APPLE_DOUBLE)
    found = sp.read_meshes(tmp_path)
    assert [surface.name for surface in found] == ["t2", "t9", "t10", "t11"]


def test_a_folder_of_freesurfers(body, tmp_path):
    for name in ("lh.white", "rh.white"):
        freesurfer(tmp_path / name, *body)
    nibabel.freesurfer.write_morph_data(str(tmp_path / "lh.curv"), body[0][:, 0])
    (tmp_path / "lh.aparc.annot").write_bytes(b"\0\0\0\1")
    assert [path.name for path in sp.mesh_files(tmp_path)] == ["lh.white", "rh.white"]


def test_a_folder_of_freesurfers_and_others(body, tmp_path):
    """Numbers on surfaces, and notes, are left out; surfaces are not."""
    FILES["legacy ascii.vtk"](tmp_path / "a.vtk", *body)
    gifti("GIFTI_ENCODING_ASCII")(tmp_path / "m.gii", *body)
    stl(tmp_path / "sub.stl", *body)
    for name in ("lh.white", "rh.white"):
        freesurfer(tmp_path / name, *body)
    nibabel.freesurfer.write_morph_data(str(tmp_path / "lh.curv"), body[0][:, 0])
    (tmp_path / "lh.notes").write_text("mine")
    found = [path.name for path in sp.mesh_files(tmp_path)]
    assert found == ["a.vtk", "lh.white", "m.gii", "rh.white", "sub.stl"]
    assert run("convert", tmp_path, "--to", tmp_path / "made", "--space", "ras") == 0
    made = ["a.ply", "lh.white.ply", "m.ply", "rh.white.ply", "sub.ply"]
    assert sorted(os.listdir(tmp_path / "made")) == made


def test_freesurfers_of_other_names_are_warned_of(body, tmp_path):
    stl(tmp_path / "sub.stl", *body)
    freesurfer(tmp_path / "outer_skull_surface", *body)
    with pytest.warns(sp.SpherePropagationWarning, match=r"by name \(outer_skull_surface\)"):
        assert [path.name for path in sp.mesh_files(tmp_path)] == ["sub.stl"]


def test_label_volumes_that_a_folder_holds_beside_meshes_are_warned_of(body, tmp_path):
    stl(tmp_path / "a.stl", *body)
    (tmp_path / "labels.nii.gz").touch()
    from sphere_propagation.files import input_files

    with pytest.warns(sp.SpherePropagationWarning, match="and not labels.nii.gz"):
        assert [path.name for path in input_files(tmp_path)] == ["a.stl"]


# ---------------------------------------------------------------- the command line


def run(*arguments):
    return command.main([str(argument) for argument in arguments])


def test_run_takes_them(cycle, tmp_path, capsys):
    write = [FILES[name] for name in ("legacy ascii.vtk", "binary.vtp", "lh.white")]
    names = ["t0.vtk", "t1.vtp", "lh.t2"]
    for surface, name, writer in zip(cycle.surfaces, names, write):
        writer(tmp_path / name, surface.vertices, surface.faces)
    files = [tmp_path / name for name in names]
    assert run("run", *files, "-o", tmp_path / "out", "--frequency", 2, "--no-pictures") == 0
    assert "3 meshes: t0.vtk to lh.t2" in capsys.readouterr().out


def test_convert(body, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    legacy(SetHeader="3D Slicer output. SPACE=LPS")(
        tmp_path / "a.vtk", body[0] * [-1, -1, 1], body[1]
    )
    freesurfer(tmp_path / "lh.white", *body)
    assert run("convert", "a.vtk", "lh.white", "--to", "made") == 0
    said = capsys.readouterr()
    assert (
        re.findall(r"closed$", said.out, re.M) == ["closed", "closed"] and "warning" not in said.out
    )
    for name in ("a", "lh.white"):
        assert b"\ncomment SPACE=RAS\n" in (tmp_path / f"made/{name}.ply").read_bytes()
        surface = sp.read_mesh(f"made/{name}.ply")
        assert np.abs(surface.vertices - body[0]).max() < 1e-4
        assert np.array_equal(surface.faces, body[1])


@pytest.mark.parametrize("format", ["ply", "stl", "obj"])
def test_convert_to_each_format(format, body, tmp_path, capsys):
    gifti("GIFTI_ENCODING_B64GZ")(tmp_path / "a.surf.gii", *body)
    assert run("convert", tmp_path / "a.surf.gii", "--format", format) == 0  # beside it
    surface = sp.read_mesh(tmp_path / f"a.{format}")
    assert surface.space == "RAS" and surface.vertices.shape == body[0].shape
    assert surface.volume == pytest.approx(sp.Surface(*body).volume, rel=1e-5)


@pytest.mark.parametrize(
    "more, said",
    [
        (lambda f: f, "closed"),
        (lambda f: f[:, ::-1], "closed, faces inwards"),
        (lambda f: f[1:], "open at 3 edges"),
        (lambda f: np.vstack([f, f[:1, [1, 0, 2]]]), "3 edges with more than two faces"),
    ],
)
def test_convert_says_what_is_to_be_mended(more, said, body, tmp_path, capsys):
    vertices, faces = body
    legacy(SetFileTypeToBinary=None)(tmp_path / "a.vtk", vertices, more(faces))
    assert run("convert", tmp_path / "a.vtk") == 0
    assert capsys.readouterr().out.strip().endswith(f"triangles, {said}")


def test_convert_keeps_numbers_per_vertex(body, tmp_path):
    data = polydata(*body)
    data["wall thickness"], data["x"] = body[0][:, 2], body[0][:, 1]
    data["normals"], data["of faces"] = body[0], np.arange(len(body[1]))
    written(vtk.vtkPolyDataWriter(), tmp_path / "a.vtk", data)
    assert run("convert", tmp_path / "a.vtk", "--space", "ras") == 0
    kept = pyvista.read(tmp_path / "a.ply")
    header = (tmp_path / "a.ply").read_bytes().split(b"end_header")[0]
    assert b"property float wall_thickness\nproperty float x_\n" in header
    assert len(kept.points) == len(body[0])
    assert np.allclose(sp.read_mesh(tmp_path / "a.ply").vertices, body[0], atol=1e-4)


@pytest.mark.parametrize("space, factor", [(None, 1), ("ras", 1), ("lps", [-1, -1, 1])])
def test_convert_guesses_no_frame_in_silence(space, factor, body, tmp_path, capsys):
    stl(tmp_path / "a.stl", *body)
    more = ["--space", space] if space else []
    assert run("convert", tmp_path / "a.stl", *more) == 0
    said = capsys.readouterr().err
    assert ("warning: " in said and "is taken to be in RAS" in said) == (space is None)
    found = sp.read_mesh(tmp_path / "a.ply")
    low = (body[0] * factor).min(0)
    assert np.abs(found.vertices.min(0) - low).max() < 1e-4 and found.volume > 0


def test_convert_overwrites_nothing_unasked(body, tmp_path, capsys):
    stl(tmp_path / "a.stl", *body)
    (tmp_path / "a.ply").write_text("mine")
    assert run("convert", tmp_path / "a.stl") == 1
    assert "a.ply exists" in capsys.readouterr().err
    assert (tmp_path / "a.ply").read_text() == "mine"
    assert run("convert", tmp_path / "a.stl", "--overwrite", "--space", "ras") == 0
    assert run("convert", tmp_path / "a.ply", "--overwrite") == 1
    assert "by itself" in capsys.readouterr().err


def test_convert_does_what_it_can_and_names_what_it_cannot(body, tmp_path, capsys):
    stl(tmp_path / "b.stl", *body)
    (tmp_path / "a.vtk").write_text("hello")
    (tmp_path / "c.gii").touch()
    assert run("convert", tmp_path, "--to", tmp_path / "made", "--space", "ras") == 1
    said = capsys.readouterr()
    assert "a.vtk cannot be read" in said.err and "c.gii cannot be read" in said.err
    assert "1 of 3 converted" in said.err and os.listdir(tmp_path / "made") == ["b.ply"]


def test_convert_beside_files_of_one_name(body, tmp_path, capsys):
    """Where each goes beside its own file nothing collides."""
    for name in ("a/p.stl", "b/p.stl"):
        (tmp_path / name).parent.mkdir()
        stl(tmp_path / name, *body)
    given = [tmp_path / "a", tmp_path / "b/p.stl", tmp_path / "a/p.stl"]  # one of them twice
    assert run("convert", *given, "--space", "ras") == 0
    assert capsys.readouterr().out.count("closed") == 2
    assert (tmp_path / "a/p.ply").is_file() and (tmp_path / "b/p.ply").is_file()


def test_convert_refuses_what_would_become_one_file(body, tmp_path, capsys):
    for name in ("a/p.stl", "b/p.stl", "b/q.stl"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        stl(tmp_path / name, *body)
    given = [tmp_path / "a", tmp_path / "b"]
    assert run("convert", *given, "--to", tmp_path / "made", "--space", "ras") == 1
    said = capsys.readouterr().err
    together = f"{tmp_path / 'a/p.stl'} and {tmp_path / 'b/p.stl'} would become one file"
    assert said.count(together) == 1 and "layer" not in said and "1 of 3 converted" in said
    assert os.listdir(tmp_path / "made") == ["q.ply"]


def test_order_and_parents_exclude_each_other(capsys):
    with pytest.raises(SystemExit) as end:
        run("run", "x", "-o", "y", "--order", "star", "--parents", "-1,0")
    assert end.value.code == 2 and "not together with --order" in capsys.readouterr().err
