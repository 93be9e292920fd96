# SPDX-License-Identifier: GPL-3.0-only
"""Surface files that PyMeshLab does not open, VTK's, GIFTI and FreeSurfer's, by the libraries that
keep these formats; and in which frame a file says that its coordinates are.

Frames: coordinates that a file declares to be LPS are turned into RAS. GIFTI is in RAS. FreeSurfer
has coordinates around the middle of the image, which become those of the scanner where the file
tells where the image lay. A file that says nothing is taken as it is.
"""

from __future__ import annotations

import re
import warnings
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, Optional

import numpy as np

from . import adapters
from .attention import warn
from .errors import FileError, InputError
from .surface import Surface

OF_MESHLAB = (".ply", ".stl", ".obj", ".off")  # what else it opens is not looked for in folders
VTK_SUFFIXES = (".vtk", ".vtp", ".vtu")
SUFFIXES = (*VTK_SUFFIXES, ".gii")
# GIFTI files of these names hold something else, by the custom of those who write them.
NO_SURFACES = re.compile(r"\.(shape|func|label|time|rgba|vector|tensor|coord|topo)\.gii$", re.I)
FREESURFER = re.compile(r"^[lr]h\.", re.I)  # lh.white; what is behind the point is no suffix
FREESURFER_MAGIC = b"\xff\xff\xfe"
FREESURFER_ASCII = b"#!ascii"  # as mris_convert writes lh.white.asc
APPLE_DOUBLE = b"\x00\x05\x16\x07"  # what macOS keeps beside files, as ._name
NEEDED = ("vtk", "nibabel")

# Of numbers in .vtk files; 4 of the others.
BYTES = {
    **dict.fromkeys(("char", "unsigned_char", "bit"), 1),
    **dict.fromkeys(("short", "unsigned_short"), 2),
    **dict.fromkeys(("double", "long", "unsigned_long", "vtktypeint64", "vtktypeuint64"), 8),
}
PLY_TYPES = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("float", "float32"), "f4"),
    **dict.fromkeys(("double", "float64"), "f8"),
}
PLY_FACES = re.compile(
    rb"^property[ \t]+list[ \t]+(\w+)[ \t]+(\w+)[ \t]+(vertex_index|vertex_indices)\b", re.M
)
PLY_DOUBLE = re.compile(rb"^property[ \t].*\b(double|float64)\b", re.M)
PLAIN_PLY_FACES = b"property list uchar int vertex_indices"
PLY_FACES_END = ["property", "element"]  # the list is all that a face has
# vtkCellType: vertices and lines, which are no part of a surface, and what can be cut in triangles.
NO_FACES, FACES = {1, 2, 3, 4}, {5, 6, 7, 8, 9}


@dataclass
class Found:
    """A mesh as a file holds it."""

    vertices: np.ndarray
    faces: np.ndarray
    space: str = ""  # as of Surface
    scalars: Dict[str, np.ndarray] = field(default_factory=dict)  # one number per vertex, by name


def read(path: Path) -> Optional[Found]:
    """The mesh in a file; None where PyMeshLab opens its kind. For one whose turn it is: VTK's log
    is listened to meanwhile."""
    _refuse_what_is_none(path)
    reader = _reader_for(path)
    if reader is None:
        return None
    try:
        found = reader(path)
    except InputError as error:  # of an adapter, for which the file is an object
        raise FileError(str(error)) from error
    if not len(found.faces):
        raise FileError(f"{path} holds no triangles.")
    if found.faces.min() < 0 or found.faces.max() >= len(found.vertices):
        raise FileError(f"{path} cannot be read as a mesh. Its faces name vertices that it lacks.")
    found = _welded(_without_loose_points(found))
    return _in_ras(found)


def is_freesurfer(path: Path) -> bool:
    """Whether it holds a surface of FreeSurfer's."""
    return path.is_file() and _start(path, 7).startswith((FREESURFER_MAGIC, FREESURFER_ASCII))


def space_in_header(path: Path) -> str:
    """What 3D Slicer, or this package, wrote into a PLY, STL, OBJ or OFF file: RAS or LPS, or
    nothing."""
    start = _start(path, 1 << 16)
    if path.suffix.lower() == ".ply":
        start = start.partition(b"end_header")[0]
        lines = [line for line in re.split(rb"[\r\n]+", start) if line.startswith(b"comment")]
    elif path.suffix.lower() == ".stl":
        lines = [re.split(rb"[\r\n]", start[:300])[0] if start[:5] == b"solid" else start[:80]]
    else:
        lines = [line for line in re.split(rb"[\r\n]+", start) if line.startswith(b"#")]
    return _space_in(path, b"\n".join(lines).decode("latin-1"))


def faces_lack_vertices(path: Path) -> bool:
    """Whether a face of a PLY, OBJ or OFF file names a vertex that is not there, over which
    PyMeshLab crashes. Of PLY binary files are looked at, whose faces hold nothing else."""
    look = {".ply": _in_ply, ".obj": _in_obj, ".off": _in_off}.get(path.suffix.lower())
    try:
        return look is not None and look(path.read_bytes())
    except (ValueError, IndexError, OverflowError):
        return False  # PyMeshLab says what is wrong


def _in_ply(content: bytes) -> bool:
    header, end, _ = content.partition(b"end_header")
    start = content.find(b"\n", len(header) + len(end)) + 1
    words = [line.split() for line in header.decode("latin-1").splitlines()]
    order = {"binary_little_endian": "<", "binary_big_endian": ">"}
    order = next((order.get(line[1]) for line in words if line[:1] == ["format"]), None)
    elements = [line for line in words if line[:1] in (["element"], ["property"])]
    kinds = [line[1] for line in elements if line[0] == "element"]
    if order is None or kinds != ["vertex", "face"]:
        return False
    split = next(i for i, line in enumerate(elements) if line[1] == "face")
    faces = elements[split + 1 :]
    if len(faces) != 1 or faces[0][1] != "list":
        return False
    sizes = [PLY_TYPES[line[1]] for line in elements[1:split] if line[1] in PLY_TYPES]
    if len(sizes) != split - 1 or faces[0][2] not in PLY_TYPES or faces[0][3] not in PLY_TYPES:
        return False
    vertices, count = int(elements[0][2]), int(elements[split][2])
    start += vertices * sum(int(size[1:]) for size in sizes)
    kind = [("count", order + PLY_TYPES[faces[0][2]])]
    kind += [("indices", order + PLY_TYPES[faces[0][3]], 3)]
    triangles = content[start : start + count * np.dtype(kind).itemsize]
    if len(triangles) == count * np.dtype(kind).itemsize:
        found = np.frombuffer(triangles, kind)
        if (found["count"] == 3).all():
            indices = found["indices"]
            return bool(count and (indices.min() < 0 or indices.max() >= vertices))
    number, corner = np.dtype(kind[0][1]), np.dtype(kind[1][1])
    for _ in range(count):
        corners = int(np.frombuffer(content, number, 1, start)[0])
        indices = np.frombuffer(content, corner, corners, start + number.itemsize)
        if corners and (indices.min() < 0 or indices.max() >= vertices):
            return True
        start += number.itemsize + corners * corner.itemsize
    return False


def plain_ply(path: Path) -> Optional[bytes]:
    """The same PLY file with faces as lists of uchar and int, and in the order of bytes that
    PyMeshLab knows for doubles; None where it knows the types. Most others it takes for something
    else, and may not notice."""
    content = path.read_bytes()
    header, end, rest = content.partition(b"end_header")
    found = PLY_FACES.search(header)
    if not found:
        return None
    order = re.search(rb"^format[ \t]+(\w+)", header, re.M)
    endian = {b"binary_little_endian": "<", b"binary_big_endian": ">"}.get(order and order[1])
    swapped = endian == ">" and bool(PLY_DOUBLE.search(header))
    number, corner = (PLY_TYPES.get(name.decode()) for name in found.groups()[:2])
    known = ("i4", "u4") if found[3] == b"vertex_indices" else ("i4",)
    if number in ("i1", "u1") and corner in known and not swapped:
        return None
    plain = header[: found.start()] + PLAIN_PLY_FACES + header[found.end() :] + end
    if order and order[1] == b"ascii":
        return plain + rest
    lists = f"faces as lists of {found[1].decode()} and {found[2].decode()}"
    refused = FileError(
        f"{path} cannot be read as a mesh. It holds {'big-endian doubles' if swapped else lists} "
        "beside other things: write it as little-endian, with lists of uchar and int."
    )
    words = [line.split() for line in header.decode("latin-1").splitlines()]
    elements = [line for line in words if line[:1] in (["element"], ["property"])]
    split = next((i for i, line in enumerate(elements) if line[1] == "face"), 0)
    sizes = [PLY_TYPES.get(line[1]) for line in elements[1:split]]
    kinds = [line[1] for line in elements if line[0] == "element"]
    if (
        kinds[:2] != ["vertex", "face"]
        or None in (*sizes, number, corner, endian)
        or [line[0] for line in elements[split + 1 : split + 3]]
        not in (["property"], PLY_FACES_END)
    ):
        raise refused
    kind = np.dtype([(str(i), f"{endian}{size}") for i, size in enumerate(sizes)])
    start = rest.find(b"\n") + 1
    begin = start + int(elements[0][2]) * kind.itemsize
    vertices = rest[start:begin]
    written = "<" if swapped else endian
    count_type, corner_type = np.dtype(f"{endian}{number}"), np.dtype(f"{endian}{corner}")
    faces = []
    at = begin
    try:
        if swapped:
            vertices = np.frombuffer(vertices, kind).astype(kind.newbyteorder("<")).tobytes()
        for _ in range(int(elements[split][2])):
            corners = int(np.frombuffer(rest, count_type, 1, at)[0])
            at += count_type.itemsize
            indices = np.frombuffer(rest, corner_type, corners, at)
            at += corners * corner_type.itemsize
            faces.append(bytes([corners]) + indices.astype(f"{written}i4").tobytes())
    except (ValueError, IndexError) as error:
        raise FileError(f"{path} cannot be read as a mesh. It ends too early.") from error
    after = rest[at:]
    if swapped:  # what comes after the faces is left out, and so is what the header says of it
        plain = _without_other_elements(plain).replace(b"binary_big", b"binary_little", 1)
        after = b""
    return plain + rest[:start] + vertices + b"".join(faces) + after


def _without_other_elements(header: bytes) -> bytes:
    """Of a PLY file whose first elements are vertices and faces."""
    others = list(re.finditer(rb"^element\b", header, re.M))[2:]
    return header[: others[0].start()] + b"end_header" if others else header


def refuse_cut_off_stl(path: Path) -> None:
    """PyMeshLab takes the triangles that are there."""
    start, said = _start(path, 84), 0
    if start[:5].lower() == b"solid":  # as text begins, and some binary files
        content = path.read_bytes()
        said = len(re.findall(rb"\bfacet\s", content, re.I))
        there = len(re.findall(rb"\bendfacet\b", content, re.I))
    if not said:
        if len(start) < 84:
            return
        said = int(np.frombuffer(start, "<u4", 1, 80)[0])
        there = (path.stat().st_size - 84) // 50
    if there < said:
        raise FileError(
            f"{path} cannot be read as a mesh. It ends too early: {there} of its {said} triangles "
            "are there."
        )


def _in_obj(content: bytes) -> bool:
    vertices = len(re.findall(rb"^[ \t]*v[ \t]", content, re.M))
    for line in re.findall(rb"^[ \t]*f[ \t]+([^\r\n]*)", content, re.M):
        for corner in line.replace(b"\\", b"").split():
            number = re.match(rb"(-?\d+)(/|$)", corner)
            if not number or not 1 <= abs(int(number[1])) <= vertices:
                return True
    return False


def _in_off(content: bytes) -> bool:
    lines = [line for line in content.splitlines() if line.strip() and line.lstrip()[:1] != b"#"]
    if lines[0].strip() != b"OFF":
        return False  # with counts behind it, or colours and normals in it
    vertices, faces = (int(word) for word in lines[1].split()[:2])
    for line in lines[2 + vertices : 2 + vertices + faces]:
        words = line.split()
        corners = [int(word) for word in words[1 : 1 + int(words[0])]]
        if len(corners) != int(words[0]) or not all(0 <= corner < vertices for corner in corners):
            return True
    return False


def turned(space: str, vertices: np.ndarray) -> np.ndarray:
    """From LPS to RAS, where the space is LPS."""
    return vertices * [-1.0, -1.0, 1.0] if space == "LPS" else vertices


def _space_in(path: Path, text: str) -> str:
    said = set(re.findall(r"\bSPACE=([A-Za-z-]+)", text))
    if len(said) > 1 or said - {"RAS", "LPS"}:
        raise FileError(
            f"{path} says SPACE={', '.join(sorted(said))}: one of RAS and LPS is understood here."
        )
    return said.pop() if said else ""


def _start(path: Path, count: int) -> bytes:
    with open(path, "rb") as file:
        return file.read(count)


def _refuse_what_is_none(path: Path) -> None:
    start = _start(path, len(APPLE_DOUBLE))
    if not start:
        raise FileError(f"{path} cannot be read as a mesh. It is empty.")
    if start == APPLE_DOUBLE:
        raise FileError(f"{path} is what macOS keeps beside a file of this name: it holds no mesh.")
    named = FREESURFER.match(path.name) and path.suffix.lower() not in (*SUFFIXES, *OF_MESHLAB)
    if named and not is_freesurfer(path):
        raise FileError(
            f"{path} holds no surface, although FreeSurfer calls its surfaces so: lh.white and "
            "lh.pial are some, lh.curv and lh.thickness hold numbers on them."
        )
    _refuse_decimal_commas(path)


# Where coordinates stand in text, by suffix; binary files are left to their readers.
COORDINATES = {
    ".obj": rb"^v[ \t]",
    ".stl": rb"^[ \t]*vertex[ \t]",
    ".ply": rb"^[ \t]*[-+.\d]",
    ".off": rb"^[ \t]*[-+.\d]",
    ".vtk": rb"^[ \t]*[-+.\d]",
}


def _refuse_decimal_commas(path: Path) -> None:
    """What follows a comma is no number to most readers, which go on without a word."""
    line = COORDINATES.get(path.suffix.lower())
    start = _start(path, 1 << 16) if line else b""
    if path.suffix.lower() == ".vtk":
        start = start.partition(b"DATASET")[2]  # a title may say anything
    comma = line and b"\0" not in start and re.search(line + rb"[^\n]*\d,\d", start, re.M)
    if comma:
        number = re.search(rb"[-+]?\d*,\d+", comma[0])
        raise FileError(
            f"{path} writes numbers with a comma, as {number[0].decode()}: write them with a point."
        )


def _reader_for(path: Path) -> Optional[Callable[[Path], Found]]:
    suffix = path.suffix.lower()
    if suffix in VTK_SUFFIXES:
        return _read_vtk
    if suffix == ".gii":
        return _read_gifti
    return _read_freesurfer if is_freesurfer(path) else None


def _needs(path: Path, package: str) -> FileError:
    return FileError(
        f"{path} is read by the package {package}, which is not installed: "
        "pip install 'sphere-propagation[surfaces]'"
    )


# ---------------------------------------------------------------- VTK


def _read_vtk(path: Path) -> Found:
    try:
        from vtkmodules.vtkCommonCore import vtkVersion  # noqa: F401
    except ImportError as error:
        raise _needs(path, "vtk") from error
    data, complaints = _vtk_data(path)
    if complaints:
        raise FileError(f"{path} cannot be read as a mesh. {complaints}")
    space = _vtk_space(path, data)
    data = _in_triangles(path, data)
    mesh = adapters.mesh_of(data, str(path))
    scalars = {}
    for i in range(data.GetPointData().GetNumberOfArrays()):
        array = data.GetPointData().GetArray(i)  # none where it holds texts
        if array is not None and array.GetNumberOfComponents() == 1:
            scalars[array.GetName() or f"scalars {i}"] = adapters.numbers_of(array).copy()
    return Found(np.asarray(mesh.vertices, float), np.asarray(mesh.faces), space, scalars)


def _vtk_data(path: Path):
    """What VTK reads, and its first complaint, which would otherwise go to standard error."""
    from vtkmodules.vtkIOLegacy import vtkPolyDataReader, vtkUnstructuredGridReader
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLUnstructuredGridReader

    start = _start(path, 1 << 12)
    if path.suffix.lower() == ".vtk":
        if not re.match(rb"# vtk datafile version \d+\.\d+\s", start, re.I):
            raise FileError(f"{path} cannot be read as a mesh. It has no VTK header.")
        if _is_damaged(path.read_bytes()):
            raise FileError(f"{path} cannot be read as a mesh. It ends too early, or is damaged.")
        # The reader of all kinds crashes where a header names none.
        kind = re.search(rb"^DATASET[ \t]+(\w+)", start, re.M | re.I)
        if not kind:
            raise FileError(f"{path} cannot be read as a mesh. It has no VTK header.")
        if kind[1].upper() not in (b"POLYDATA", b"UNSTRUCTURED_GRID"):
            raise FileError(f"{path} holds no surface, but {kind[1].decode()}.")
        reader = (
            vtkPolyDataReader() if kind[1].upper() == b"POLYDATA" else vtkUnstructuredGridReader()
        )
        for kind in ("Scalars", "Fields"):
            getattr(reader, f"ReadAll{kind}On")()
    else:
        kind = re.search(rb"<VTKFile[^>]*\btype\s*=\s*[\"'](\w+)", start)
        if not kind:
            raise FileError(f"{path} cannot be read as a mesh. It has no VTK header.")
        if kind[1] not in (b"PolyData", b"UnstructuredGrid"):
            raise FileError(f"{path} holds no surface, but {kind[1].decode()}.")
        reader = (
            vtkXMLPolyDataReader() if kind[1] == b"PolyData" else vtkXMLUnstructuredGridReader()
        )
    reader.SetFileName(str(path))
    with _listening() as said:
        reader.Update()
    return reader.GetOutput(), said()


def _is_damaged(content: bytes) -> bool:
    """Whether a .vtk file has less than its header promises, or cells of impossible sizes: VTK then
    makes faces of what happens to be in memory, without a word, or crashes. Looks as far as the
    cells."""
    lines = content[:1024].splitlines(keepends=True)[:3]
    at = sum(map(len, lines))
    ascii = len(lines) > 2 and lines[2].strip().upper() == b"ASCII"
    version = [int(digits) for digits in re.findall(rb"\d+", lines[0])]

    def next_words():
        nonlocal at
        while at < len(content):
            end = content.find(b"\n", at) + 1 or len(content)
            words, at = content[at:end].split(), end
            if words:
                return [word.decode("latin-1") for word in words]
        return []

    def skip(count: int, kind: str) -> None:
        nonlocal at
        at += count * BYTES.get(kind, 4)

    words = next_words()
    while words:
        try:
            if words[0].upper() == "POINTS" and ascii:
                return 6 * int(words[1]) > len(content) - at  # a digit and a blank each
            if words[0].upper() == "POINTS":
                skip(3 * int(words[1]), words[2].lower())
            elif words[0].upper() in ("VERTICES", "LINES", "POLYGONS", "TRIANGLE_STRIPS", "CELLS"):
                offsets, indices, before = int(words[1]), int(words[2]), at
                words = next_words()
                if (words[:1] == ["OFFSETS"]) != (version >= [5, 1]):
                    return True
                if words[:1] == ["OFFSETS"]:
                    skip(offsets, words[1].lower())
                    words = next_words()
                    if at > len(content) or words[:1] != ["CONNECTIVITY"]:
                        return True
                    skip(indices, words[1].lower())
                else:
                    at = before
                    skip(indices, "int")
                    if not ascii and not _are_cells(content[before:at], offsets):
                        return True
            elif words[0].upper() == "CELL_TYPES":
                skip(int(words[1]), "int")
            elif words[0].upper() == "METADATA":
                at = content.find(b"\n\n", at) + 1 or len(content)
            elif words[0].upper() not in ("DATASET",):
                return False  # a field, or what belongs to points and cells
        except (IndexError, ValueError):
            return False  # VTK says what is wrong
        if at > len(content):
            return True
        words = next_words()
    return False


def _are_cells(content: bytes, count: int) -> bool:
    """Whether these are so many cells, each the number of its corners and these."""
    numbers = np.frombuffer(content[: len(content) // 4 * 4], ">i4")
    if len(numbers) == 4 * count and (numbers[::4] == 3).all():
        return True
    at = 0
    for _ in range(count):
        if at >= len(numbers) or numbers[at] < 0:
            return False
        at += int(numbers[at]) + 1
    return at == len(numbers)


@contextmanager
def _listening() -> Iterator[Callable[[], str]]:
    """Gives what tells of VTK's errors within, in its own words."""
    from vtkmodules.vtkCommonCore import vtkLogger, vtkOutputWindow, vtkStringOutputWindow

    window, ear = vtkOutputWindow.GetInstance(), vtkStringOutputWindow()
    level = vtkLogger.GetCurrentVerbosityCutoff()

    def said() -> str:
        text = ear.GetOutput()
        text = text.decode("utf-8", "replace") if isinstance(text, bytes) else text
        lines = text.splitlines()
        words = [
            re.sub(r"^\w+ \(0x[0-9a-f]+\): ", "", words)
            for line, words in zip(lines, lines[1:])
            if re.match("ERROR:|Warning:", line)
        ]
        return words[0] if words else ""

    vtkOutputWindow.SetInstance(ear)
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    try:
        yield said
    finally:
        vtkLogger.SetStderrVerbosity(level)
        vtkOutputWindow.SetInstance(window)


def _vtk_space(path: Path, data: Any) -> str:
    """As 3D Slicer writes it: into the title of a .vtk file, or as a field called SPACE."""
    title = ""
    if path.suffix.lower() == ".vtk":
        title = _start(path, 512).decode("latin-1").splitlines()[1:2]
        title = title[0] if title else ""
    array = data.GetFieldData().GetAbstractArray("SPACE")
    if array is not None and array.GetNumberOfValues():
        value = str(array.GetVariantValue(0).ToString())
        title += " " + (value if "SPACE=" in value else f"SPACE={value}")
    return _space_in(path, title)


def _in_triangles(path: Path, data: Any) -> Any:
    """Polygons and strips as triangles."""
    from vtkmodules.vtkFiltersCore import vtkTriangleFilter
    from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter

    if data.IsA("vtkUnstructuredGrid"):
        kinds = {data.GetCellType(i) for i in range(data.GetNumberOfCells())}
        if kinds - NO_FACES - FACES:
            raise FileError(
                f"{path} holds a mesh of solids, no surface. What surrounds them is mesh = "
                f"pyvista.read({str(path)!r}).extract_surface().triangulate()"
            )
        geometry = vtkGeometryFilter()
        geometry.SetInputData(data)
        geometry.Update()
        data = geometry.GetOutput()
    elif not data.IsA("vtkPolyData"):
        raise FileError(f"{path} holds no surface, but {data.GetClassName()}.")
    if not data.GetNumberOfPolys() and not data.GetNumberOfStrips():
        raise FileError(f"{path} holds no triangles.")
    for cells in (data.GetPolys(), data.GetStrips()):
        indices = adapters.numbers_of(cells.GetConnectivityArray())
        ends = adapters.numbers_of(cells.GetOffsetsArray())
        if len(ends) and (ends[0] or ends[-1] != len(indices) or (np.diff(ends) < 0).any()):
            raise FileError(f"{path} cannot be read as a mesh. It ends too early, or is damaged.")
        if indices.size and (indices.min() < 0 or indices.max() >= data.GetNumberOfPoints()):
            raise FileError(
                f"{path} cannot be read as a mesh. Its faces name vertices that it lacks."
            )
    triangles = vtkTriangleFilter()
    triangles.SetInputData(data)
    triangles.PassVertsOff()
    triangles.PassLinesOff()
    triangles.Update()
    return triangles.GetOutput()


# ---------------------------------------------------------------- GIFTI and FreeSurfer


def _read_gifti(path: Path) -> Found:
    try:
        import nibabel
    except ImportError as error:
        raise _needs(path, "nibabel") from error
    try:
        image = nibabel.load(str(path))
        darrays = [array for array in image.darrays if array.data is not None]
    except Exception as error:  # nibabel's, or of the parsers behind it
        raise FileError(f"{path} cannot be read as GIFTI. {_words(error)}") from error
    if not any(array.intent in (adapters.POINTSET, adapters.TRIANGLES) for array in darrays):
        raise FileError(f"{path} holds no surface, but other arrays of GIFTI.")
    mesh = adapters.mesh_of(image, str(path))
    return Found(np.asarray(mesh.vertices, float), np.asarray(mesh.faces), "RAS")


def _read_freesurfer(path: Path) -> Found:
    if _start(path, 7) == FREESURFER_ASCII:
        return _read_freesurfer_ascii(path)
    try:
        from nibabel.freesurfer import read_geometry
    except ImportError as error:
        raise _needs(path, "nibabel") from error
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of what the file does not tell, which is said below
            vertices, faces, about = read_geometry(str(path), read_metadata=True)
    except Exception as error:
        raise FileError(f"{path} cannot be read as FreeSurfer's. {_words(error)}") from error
    turn_and_shift = _to_scanner(about)
    if turn_and_shift is None:
        _warn_of_own_frame(path)
        return Found(np.asarray(vertices, float), np.asarray(faces, np.int64), "RAS")
    rotation, shift = turn_and_shift
    faces = np.asarray(faces, np.int64)
    if np.linalg.det(rotation) < 0:
        faces = faces[:, ::-1]
    return Found(np.asarray(vertices, float) @ rotation.T + shift, faces, "RAS")


def _read_freesurfer_ascii(path: Path) -> Found:
    """Counts; x, y, z and a patch's mark per vertex; three corners and a mark per face."""
    damaged = FileError(f"{path} cannot be read as FreeSurfer's. It ends too early, or is damaged.")
    lines = path.read_text("latin-1").splitlines()[1:]
    try:
        vertices, faces = map(int, lines[0].split())
        rows = [line.split() for line in lines[1:] if line.strip()]
        points = np.array(rows[:vertices], float).reshape(vertices, 4)[:, :3]
        corners = np.array(rows[vertices:], np.int64).reshape(faces, 4)[:, :3]
    except (ValueError, IndexError) as error:
        raise damaged from error
    if faces and (corners.min() < 0 or corners.max() >= vertices):
        raise damaged
    _warn_of_own_frame(path)
    return Found(points, corners, "RAS")


def _warn_of_own_frame(path: Path) -> None:
    warn(
        f"{path} does not tell where the image lay (c_ras): its coordinates are FreeSurfer's "
        "own, around the image's middle, not those of the scanner."
    )


def _to_scanner(about: Dict[str, Any]):
    """From the image's own axes to those of the scanner: (3, 3) and (3,); None where the file does
    not tell, or says itself that what it tells is not valid."""
    if not str(about.get("valid", "")).strip().startswith("1"):
        return None
    try:
        axes = np.column_stack([np.asarray(about[f"{axis}ras"], float) for axis in "xyz"])
        shift = np.asarray(about["cras"], float)
    except (KeyError, ValueError):
        return None
    own = np.array([[-1.0, 0, 0], [0, 0, 1], [0, -1, 0]])  # the columns of FreeSurfer's own axes
    rotation = axes @ np.linalg.inv(own)
    if shift.shape != (3,) or not np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-3):
        return None
    return rotation, shift


def _words(error: BaseException) -> str:
    return " ".join(str(error).split()) or type(error).__name__


# ---------------------------------------------------------------- in order


def _in_ras(found: Found) -> Found:
    found.vertices = turned(found.space, found.vertices)
    found.space = found.space and "RAS"
    return found


def _without_loose_points(found: Found) -> Found:
    """Those that no face uses, which VTK's filters leave behind."""
    used = np.zeros(len(found.vertices), bool)
    used[found.faces] = True
    if used.all():
        return found
    place = np.cumsum(used) - 1
    return Found(
        found.vertices[used],
        place[found.faces],
        found.space,
        {name: values[used] for name, values in found.scalars.items()},
    )


def _faces_of_edges(faces: np.ndarray) -> np.ndarray:
    """How many faces each edge has."""
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), 1)
    return np.unique(edges, axis=0, return_counts=True)[1]


def open_edges(faces: np.ndarray) -> int:
    """How many edges have a face on one side only."""
    return int((_faces_of_edges(faces) == 1).sum())


def state_of(surface: Surface) -> str:
    """What of a surface is to be mended: "open at 12 edges, 7 edges with more than two faces", or
    "closed"."""
    count = _faces_of_edges(surface.faces)
    opened, fins = int((count == 1).sum()), int((count > 2).sum())
    found = [f"open at {opened} edge{'s' * (opened != 1)}"] * (opened > 0)
    found += [f"{fins} edge{'s' * (fins != 1)} with more than two faces"] * (fins > 0)
    if not found and surface.volume < 0:
        found = ["closed, faces inwards"]
    return ", ".join(found) or "closed"


def _welded(found: Found) -> Found:
    """With vertices that lie exactly in one place as one, where the surface has open edges without:
    writers of smooth shading, and of formats like STL, split vertices."""
    if not open_edges(found.faces):
        return found
    _, first, place = np.unique(
        found.vertices + 0.0, axis=0, return_index=True, return_inverse=True
    )  # + 0.0: of -0.0
    if len(first) == len(found.vertices):
        return found
    order = np.argsort(first)  # as they come in the file
    rank = np.empty(len(order), np.int64)
    rank[order] = np.arange(len(order))
    faces = rank[place.reshape(-1)][found.faces]
    faces = faces[(faces != np.roll(faces, 1, axis=1)).all(1)]  # which had become edges
    kept = first[order]
    return Found(
        found.vertices[kept],
        faces,
        found.space,
        {name: values[kept] for name, values in found.scalars.items()},
    )
