# SPDX-License-Identifier: GPL-3.0-only
"""Surfaces and label volumes of other libraries: what comes out is where a known body is; what
could be meant in two ways is refused, and the lines that the error says make it work."""

import re
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import meshio
import nibabel
import numpy as np
import pymeshlab
import pytest
import pyvista
import sphere_propagation as sp
import trimesh
import vtk
from sphere_propagation.surface import as_surface, as_surfaces
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray


@pytest.fixture(scope="module")
def body():
    """A surface without symmetry: (vertices, faces)."""
    surface = sp.make_phantom(phases=1, voxel_size=4)[0]
    return surface.vertices * [1, 0.8, 1.2] + [10, -20, 30], surface.faces


def polydata(vertices, faces):
    """As vtk has it, without pyvista."""
    points, cells, made = vtk.vtkPoints(), vtk.vtkCellArray(), vtk.vtkPolyData()
    points.SetData(numpy_to_vtk(vertices, deep=True))
    counted = np.c_[np.full(len(faces), faces.shape[1]), faces].ravel().astype(np.int64)
    cells.ImportLegacyFormat(numpy_to_vtkIdTypeArray(counted, deep=True))
    made.SetPoints(points)
    made.SetPolys(cells)
    return made


def gifti(vertices, faces):
    return nibabel.gifti.GiftiImage(
        darrays=[
            nibabel.gifti.GiftiDataArray(
                vertices.astype(np.float32),
                "NIFTI_INTENT_POINTSET",
                coordsys=nibabel.gifti.GiftiCoordSystem(1, 1),
            ),
            nibabel.gifti.GiftiDataArray(faces, "NIFTI_INTENT_TRIANGLE"),
        ]
    )


class Tensor:
    """As open3d and torch have it."""

    def __init__(self, values):
        self.values = values

    def numpy(self):
        return self.values


OBJECTS = {
    "arrays": lambda v, f: (v, f),
    "lists": lambda v, f: [v.tolist(), f.tolist()],
    "trimesh": lambda v, f: trimesh.Trimesh(v, f, process=False),
    "pyvista": lambda v, f: pyvista.PolyData(v, np.c_[np.full(len(f), 3), f]),
    "pyvista, triangles alone in a grid": lambda v, f: pyvista.UnstructuredGrid({5: f}, v),
    "vtk": polydata,
    "meshio": lambda v, f: meshio.Mesh(v, [("triangle", f[:9]), ("triangle", f[9:])]),
    "meshio with lines": lambda v, f: meshio.Mesh(v, [("line", f[:, :2]), ("triangle", f)]),
    "pymeshlab": pymeshlab.Mesh,
    "nibabel": gifti,
    "open3d": lambda v, f: SimpleNamespace(vertices=v.tolist(), triangles=f.astype(np.uint32)),
    "open3d, tensors": lambda v, f: SimpleNamespace(
        vertex=SimpleNamespace(positions=Tensor(v)), triangle=SimpleNamespace(indices=Tensor(f))
    ),
    "nilearn": lambda v, f: SimpleNamespace(coordinates=v, faces=f),
    "methods": lambda v, f: SimpleNamespace(points=lambda: v, faces=lambda: f),
}


@pytest.mark.parametrize("library", OBJECTS)
def test_a_mesh_of_another_library_is_a_surface(library, body):
    vertices, faces = body
    surface = as_surface(OBJECTS[library](vertices, faces))
    assert np.abs(surface.vertices - vertices).max() < 1e-5
    assert np.array_equal(surface.faces, faces) and surface.volume > 0


def test_they_are_accepted_wherever_a_surface_is(cycle, tmp_path):
    surfaces = cycle.surfaces[:2]
    sp.write_ply(tmp_path / "second.ply", surfaces[1].vertices, surfaces[1].faces)
    first = OBJECTS["pyvista"](surfaces[0].vertices, surfaces[0].faces)
    assert np.array_equal(sp.parameterise_root(first).positions, cycle.root_map.positions)
    found = sp.correspond([first, tmp_path / "second.ply"], root=0, frequency=2)
    assert [surface.name for surface in found.surfaces] == ["surface 0", "second"]
    assert sp.evaluate([first, str(tmp_path / "second.ply")], found.maps)["valid"].all()


def test_what_stays_with_the_user_stays_as_it_was(body):
    """A surface is a copy of vtk's memory, which may change later."""
    mesh = OBJECTS["pyvista"](body[0].copy(), body[1])
    surface = as_surface(mesh)
    mesh.points[:] = 0
    assert np.array_equal(surface.vertices, body[0])


def test_a_layer_is_its_matrix_times_its_vertices(body):
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(*body), "heart")
    meshes.apply_filter("compute_matrix_from_translation", axisx=5.0, freeze=False)
    surface = as_surface(meshes)
    assert surface.name == "heart" and np.allclose(surface.vertices, body[0] + [5, 0, 0])


@pytest.mark.parametrize(
    "sequence",
    [
        lambda a, b: {"a": a, "b": b},
        lambda a, b: pyvista.MultiBlock({"a": a, "b": b}),
        lambda a, b: [sp.Surface(*parts(a), "a"), sp.Surface(*parts(b), "b")],
    ],
)
def test_sequences_with_names(sequence, body):
    a, b = OBJECTS["pyvista"](*body), OBJECTS["pyvista"](body[0] + 1, body[1])
    found = as_surfaces(sequence(a, b))
    assert [surface.name for surface in found] == ["a", "b"]
    assert np.array_equal(found[1].vertices, body[0] + 1)


def parts(mesh):
    return mesh.points, mesh.faces.reshape(-1, 4)[:, 1:]


def test_a_folder_stands_for_its_meshes(cycle, tmp_path):
    for i in (10, 9):
        sp.write_ply(tmp_path / f"t{i}.ply", cycle.surfaces[0].vertices, cycle.surfaces[0].faces)
    for given in (tmp_path, str(tmp_path)):
        assert [surface.name for surface in as_surfaces(given)] == ["t9", "t10"]


def quads():
    return pyvista.Cube()


def strips():
    sphere = pyvista.Sphere()
    return sphere.strip()


def tetrahedra():
    return pyvista.ImageData(dimensions=(4, 4, 4)).to_tetrahedra()


REFUSED = {
    "quadrilaterals": (quads, r"polygons other than triangles\. .*mesh = (.*)"),
    "strips": (strips, r"has strips, or .*mesh = (.*)"),
    "tetrahedra": (tetrahedra, r"cells other than triangles\. .*mesh = (.*)"),
    "a grid": (
        lambda: pyvista.ImageData(dimensions=(4, 4, 4)).cast_to_structured_grid(),
        r"no surface of triangles\. .*mesh = (.*)",
    ),
    "meshio's quadrilaterals": (
        lambda: meshio.Mesh(pyvista.Cube().points, [("quad", pyvista.Cube().regular_faces)]),
        r"cells other than triangles \(quad\)\. .*mesh = (.*)",
    ),
    "points": (lambda: pyvista.PolyData(np.eye(3)), "3 points and no faces"),
    "meshio's points": (lambda: meshio.Mesh(np.eye(3), [("vertex", [[0]])]), "no faces"),
    "trimesh's points": (lambda: trimesh.PointCloud(np.eye(3)), "vertices and no faces"),
    "a scene": (
        lambda: trimesh.Scene([trimesh.creation.box()] * 2),
        r"mesh = (scene\.to_mesh\(\))",
    ),
    "a reader": (vtk.vtkSTLReader, "vtkSTLReader, which makes a mesh"),
    "an image": (
        lambda: nibabel.Nifti1Image(np.zeros((2, 2, 2), "u1"), np.eye(4)),
        r"read_label_volume\(image",
    ),
    "a picture of vtk": (
        lambda: pyvista.ImageData(dimensions=(2, 2, 2)),
        r"read_label_volume\(image",
    ),
    "no surface in GIFTI": (nibabel.gifti.GiftiImage, "0 arrays of coordinates and 0 of"),
    "several meshes": (pymeshlab.MeshSet, "MeshSet of 0 meshes"),
    "one array": (lambda: np.eye(3), r"one array, of shape \(3, 3\)"),
    "a label volume's path": (lambda: "heart.nii.gz", r"read_label_volume\('heart.nii.gz'"),
    "two paths": (lambda: ("a.ply", "b.ply"), "holds two files"),
    "a number": (lambda: 7, "not int"),
    "nothing": (lambda: None, "not NoneType"),
    "ragged lists": (lambda: ([[0, 0, 0], [1]], [[0, 1, 2]]), "cannot be made an array"),
    "pyvista's faces": (
        lambda: (pyvista.Sphere().points, pyvista.Sphere().faces),
        r"faces\.reshape\(-1, 4\)\[:, 1:\]",
    ),
    "faces with their counts": (lambda: (np.eye(3), [[3, 0, 1, 2]]), r"faces\[:, 1:\]"),
    "quadrilaterals in an array": (lambda: (np.eye(4, 3), [[0, 1, 2, 3]]), "Quadrilaterals are"),
    "faces from 1": (lambda: (np.eye(3), [[1, 2, 3]]), "count from 1: faces - 1"),
    "masked in part": (lambda: (np.ma.masked_equal(np.eye(3), 1), [[0, 1, 2]]), "masked in part"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_what_could_be_meant_otherwise_is_refused(what):
    """And the line that the error says, where it says one, makes a surface."""
    make, words = REFUSED[what]
    given = make()
    with pytest.raises(sp.InputError) as refused:
        as_surface(given)
    found = re.search(words, str(refused.value))
    assert found, refused.value
    if found.groups():
        made = eval(found[1], {"mesh": given, "scene": given, "pyvista": pyvista})
        assert abs(as_surface(made).volume) > 0


@pytest.mark.parametrize("given", [7, None, np.eye(3), (np.eye(3), np.eye(3))])
def test_what_is_no_sequence_of_surfaces(given):
    with pytest.raises(sp.InputError):
        sp.correspond(given)
    with pytest.raises(sp.InputError, match="is \\[surface\\]"):
        sp.correspond(sp.Surface(np.eye(3), [[0, 1, 2]]))


def test_gifti_that_tells_of_another_frame_is_warned_of(body):
    """What a transformation is for differs from program to program: none is applied."""
    image = gifti(*body)
    image.darrays[0].coordsys.xform[0, 3] = 10
    with pytest.warns(sp.SpherePropagationWarning, match="which is not applied"):
        surface = as_surface(image)
    assert np.abs(surface.vertices - body[0]).max() < 1e-5
    image = gifti(*body)
    image.darrays[0].meta.update({"VolGeomC_R": "1", "VolGeomC_A": "2.5", "VolGeomC_S": "0"})
    with pytest.warns(sp.SpherePropagationWarning, match=r"\(1, 2\.5, 0\)"):
        as_surface(image)


def test_surfaces_of_two_frames_are_not_mixed(body):
    both = [sp.Surface(*body, name, name) for name in ("RAS", "LPS")]
    with pytest.raises(sp.InputError, match="RAS is in RAS, LPS in LPS"):
        as_surfaces(both)
    turned = eval(
        'sp.Surface(s.vertices * [-1, -1, 1], s.faces, s.name, "RAS")', {"sp": sp, "s": both[1]}
    )
    assert len(as_surfaces([both[0], turned])) == 2 and turned.volume > 0
    with pytest.raises(sp.InputError, match="space must be"):
        sp.Surface(*body, "name", "RSA")


# ---------------------------------------------------------------- label volumes

TURN = np.array([[0.8, -0.6, 0], [0.6, 0.8, 0], [0, 0, 1]])
SPACING, ORIGIN = np.array([1.5, 1.2, 2.0]), np.array([-40, 25, 110])


@pytest.fixture(scope="module")
def labels():
    """An egg with a bump, so that no turn nor reflection leaves it as it is."""
    i, j, k = np.indices((20, 18, 15)).astype(float)
    egg = ((i - 9) / 6) ** 2 + ((j - 9) / 4) ** 2 + ((k - 7) / 4.5) ** 2 < 1
    return (egg | ((i - 13) ** 2 + (j - 11) ** 2 + (k - 8) ** 2 < 7)).astype(np.uint8)


@pytest.fixture(scope="module")
def affine():
    found = np.eye(4)
    found[:3, :3], found[:3, 3] = TURN * SPACING, ORIGIN
    return found


class Image:
    """As SimpleITK has it, in LPS."""

    def __init__(self, labels, affine):
        to_lps = np.diag([-1, -1, 1]) @ affine[:3]
        self.labels, self.origin, self.size = labels, to_lps[:, 3], labels.ndim
        self.spacing = np.linalg.norm(affine[:3, :3], axis=0)
        self.direction = to_lps[:, :3] / self.spacing
        if labels.ndim == 4:
            self.spacing, self.origin = np.append(self.spacing, 0.04), np.append(self.origin, 0)
            self.direction = np.block([[self.direction, np.zeros((3, 1))], [0, 0, 0, 1]])

    GetNumberOfComponentsPerPixel = staticmethod(lambda: 1)

    def GetDimension(self):
        return self.size

    def GetSpacing(self):
        return tuple(self.spacing)

    def GetOrigin(self):
        return tuple(self.origin)

    def GetDirection(self):
        return tuple(self.direction.ravel())


Image.__module__ = "SimpleITK.SimpleITK"


@pytest.fixture
def simpleitk(monkeypatch):
    """What is used of it: arrays (z, y, x)."""
    module = ModuleType("SimpleITK")
    module.GetArrayViewFromImage = lambda image: image.labels.transpose()
    monkeypatch.setitem(sys.modules, "SimpleITK", module)


def of_library(library, **parts):
    """An object of a library that is not here."""
    kind = type("Image", (SimpleNamespace,), {"__module__": library + ".core"})
    return kind(**parts)


def ants(labels, affine):
    image = Image(labels, affine)
    return of_library(
        "ants",
        spacing=image.spacing,
        origin=image.origin,
        direction=image.direction,
        numpy=lambda: labels,
    )


VOLUMES = {
    "arrays": lambda a, m: (a, m),
    "64 bits": lambda a, m: (a.astype(np.int64), m.tolist()),
    "big endian": lambda a, m: (a.astype(">i2"), m),
    "true and false": lambda a, m: (a > 0, m),
    "floats": lambda a, m: (a.astype(np.float16), m),
    "one phase": lambda a, m: (a[..., None], m),
    "nibabel": nibabel.Nifti1Image,
    "nibabel, NIfTI-2": nibabel.Nifti2Image,
    "nibabel, MGH": lambda a, m: nibabel.MGHImage(a.astype(np.int32), m),
    "SimpleITK": Image,
    "ANTs": ants,
    "torchio": lambda a, m: of_library("torchio", numpy=lambda: a[None], affine=m),
    "MONAI": lambda a, m: of_library("monai", numpy=lambda: a[None], affine=m, meta={}),
    "MONAI in LPS": lambda a, m: of_library(
        "monai", numpy=lambda: a[None], affine=np.diag([-1, -1, 1, 1]) @ m, meta={"space": "LPS"}
    ),
}


@pytest.mark.parametrize("library", VOLUMES)
def test_a_label_volume_of_another_library(library, labels, affine, simpleitk):
    (surface,) = sp.read_label_volume(VOLUMES[library](labels, affine)).surfaces
    voxels = np.argwhere(labels) @ affine[:3, :3].T + affine[:3, 3]
    assert surface.volume == pytest.approx(len(voxels) * np.prod(SPACING), rel=0.02)
    corners = surface.vertices[surface.faces]
    weights = np.linalg.det(corners)
    center = np.einsum("f,fx->x", weights, corners.sum(1)) / 4 / weights.sum()
    assert np.abs(center - voxels.mean(0)).max() < 0.1 and surface.space == "RAS"


@pytest.mark.parametrize("library", ["arrays", "nibabel", "SimpleITK"])
def test_phases_and_names(library, labels, affine, simpleitk, tmp_path):
    phases = np.stack([labels, 300 * labels.astype(np.int16)], -1)
    given = VOLUMES[library](phases, affine)
    found = sp.read_label_volume(given, labels=300, skip_incomplete_phases=True, coordinates="LPS")
    assert found.figures["phase"].tolist() == [1] and found.surfaces[0].space == "LPS"
    if library == "nibabel":
        nibabel.save(given, tmp_path / "patient 7.nii.gz")
        with pytest.raises(sp.FilterError, match='"patient 7".* label 5') as refused:
            sp.read_label_volume(nibabel.load(tmp_path / "patient 7.nii.gz"), labels=5)
        assert "/tmp" not in str(refused.value)


@pytest.mark.parametrize("unit, factor", [("meter", 1e-3), ("micron", 1e3)])
def test_the_unit_of_a_nibabel_image_counts(unit, factor, labels, affine):
    image = nibabel.Nifti1Image(labels, np.diag([factor, factor, factor, 1]) @ affine)
    image.header.set_xyzt_units(unit)
    (surface,) = sp.read_label_volume(image).surfaces
    assert surface.volume == pytest.approx(labels.sum() * np.prod(SPACING), rel=0.02)


def test_an_image_that_does_not_say_where_it_lies_is_warned_of(labels, affine):
    image = nibabel.Nifti1Image(labels, affine)
    image.header["sform_code"] = image.header["qform_code"] = 0
    with pytest.warns(sp.SpherePropagationWarning, match="sform and qform are empty"):
        sp.read_label_volume(image)


A, M = np.ones((3, 3, 3), np.uint8), np.eye(4)
REFUSED_VOLUMES = {
    "an array alone": (lambda: A, "does not say where its voxels lie"),
    "an affine of 3 x 4": (lambda: (A, M[:3]), r"of shape \(4, 4\)"),
    "a spacing": (lambda: (A, (1, 1, 2)), r"np\.diag\(\[dx, dy, dz, 1\.0\]\)"),
    "a flat affine": (lambda: (A, np.diag([1, 0, 1, 1])), "must lead from indices to mm"),
    "an affine that is not finite": (lambda: (A, M * np.nan), "must lead from indices to mm"),
    "two axes": (lambda: (A[0], M), r"of shape \(3, 3\)"),
    "text": (lambda: (A.astype(str), M), "must be numbers"),
    "a header": (lambda: (A, {"space": "LPS"}), "give the file itself"),
    "a list of two parts": (lambda: [A, M], r"is the tuple \(labels, affine\)"),
    "a volume and a mesh": (lambda: [(A, M), "a.ply"], "A list must hold label volumes"),
    "vtk's image": (lambda: pyvista.ImageData(dimensions=(3, 3, 3)), "RAS or LPS"),
    "channels": (
        lambda: of_library("torchio", numpy=lambda: np.stack([A, A]), affine=M),
        "one channel",
    ),
    "a surface": (lambda: sp.Surface(np.eye(3), [[0, 1, 2]]), "not Surface"),
    "nothing": (lambda: None, "not NoneType"),
}


@pytest.mark.parametrize("what", REFUSED_VOLUMES)
def test_label_volumes_that_could_be_meant_otherwise(what):
    make, words = REFUSED_VOLUMES[what]
    with pytest.raises(sp.InputError, match=words):
        sp.read_label_volume(make())


def test_volumes_in_a_list_are_read_together(labels, affine, tmp_path):
    image = nibabel.Nifti1Image(labels, affine)
    nibabel.save(nibabel.Nifti1Image(labels, affine), tmp_path / "late.nii")
    read = sp.read_label_volume([(labels, affine), image, tmp_path / "late.nii"]).surfaces
    assert [surface.name for surface in read] == [
        f"{n} label 1" for n in ("volume 0", "volume 1", "late 2")
    ]
    (alone,) = sp.read_label_volume((labels, affine)).surfaces
    for surface in read:
        assert np.allclose(surface.vertices, alone.vertices, atol=1e-4)
    with pytest.raises(sp.FilterError, match='^"volume 1": No voxel has'):
        sp.read_label_volume([image, (0 * labels, affine)])
    with pytest.raises(sp.FileError, match="have the same name"):
        sp.read_label_volume([image, *[tmp_path / "late.nii"] * 2])


def test_a_scene_of_one_mesh_is_that_mesh(body):
    scene = trimesh.Scene()
    turned = trimesh.transformations.rotation_matrix(1, [1, 2, 3])
    scene.add_geometry(trimesh.Trimesh(*body, process=False), transform=turned)
    surface = as_surface(scene)
    assert np.allclose(surface.vertices, body[0] @ turned[:3, :3].T)
    assert np.array_equal(surface.faces, body[1])


def test_a_series_is_of_files():
    with pytest.raises(sp.InputError, match="it takes a file"):
        sp.read_label_volume((A, M), file_series=True)


def test_what_vtk_lacks_is_said_in_lines_that_work(labels, affine):
    image = pyvista.ImageData(dimensions=labels.shape, spacing=SPACING, origin=ORIGIN)
    image.point_data["labels"] = labels.ravel(order="F")
    with pytest.raises(sp.InputError) as refused:
        sp.read_label_volume(image)
    code = re.search(r"as (labels = .*) and (affine = .*; affine.*)$", str(refused.value))
    found = {"image": image, "np": np}
    for lines in code.groups():
        exec(lines, found)
    (surface,) = sp.read_label_volume((found["labels"], found["affine"])).surfaces
    center = np.argwhere(labels).mean(0) * SPACING + ORIGIN
    assert np.abs(surface.vertices.mean(0) - center).max() < 1.5


def test_nothing_is_left_behind(labels, affine, tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    sp.read_label_volume((labels, affine))
    assert not list(Path(tmp_path).iterdir())
