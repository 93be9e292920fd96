# SPDX-License-Identifier: GPL-3.0-only
"""Small surfaces, good and bad, as (vertices n x 3, faces m x 3). The good one is `egg`; each bad
one has one defect."""

import numpy as np


def egg(rings=10, sectors=14, centre=(0, 0, 0), radii=(20, 24, 35)):
    """A closed surface: two poles and rings of vertices between them, thicker towards one end."""
    colatitude = np.pi * (np.arange(rings) + 1) / (rings + 1)
    longitude = 2 * np.pi * np.arange(sectors) / sectors
    c, s = (x.ravel() for x in np.meshgrid(colatitude, longitude, indexing="ij"))
    unit = np.stack([np.sin(c) * np.cos(s), np.sin(c) * np.sin(s), np.cos(c)], 1)
    unit = np.concatenate([[[0, 0, 1]], unit, [[0, 0, -1]]])
    vertices = unit * radii * (1 + 0.15 * unit[:, 2:]) + centre

    def at(ring, sector):
        return 1 + ring * sectors + sector % sectors

    faces = []
    for s in range(sectors):
        faces.append([0, at(0, s), at(0, s + 1)])
        for r in range(rings - 1):
            faces.append([at(r, s), at(r + 1, s), at(r, s + 1)])
            faces.append([at(r + 1, s), at(r + 1, s + 1), at(r, s + 1)])
        faces.append([at(rings - 1, s + 1), at(rings - 1, s), len(vertices) - 1])
    return vertices, np.array(faces, np.int32)


def tetrahedron(a, b, c, d):
    """Four corners, d on the inner side of abc."""
    return np.array([a, b, c, d], float), np.array(
        [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]], np.int32
    )


def joined(first, second, shared=()):
    """Both surfaces in one mesh. shared: pairs (vertex of first, vertex of second) that become one
    vertex."""
    (v, f), (w, g) = first, second
    number = np.arange(len(w)) + len(v)
    for kept, dropped in shared:
        number[dropped] = kept
    return without_unreferenced(np.concatenate([v, w]), np.concatenate([f, number[g]]))


def without_unreferenced(v, f):
    used = np.unique(f)
    number = np.full(len(v), -1)
    number[used] = np.arange(len(used))
    return v[used], number[f].astype(np.int32)


def open_egg():
    v, f = egg()
    return v, np.delete(f, 40, axis=0)


def two_parts():
    return joined(egg(), egg(6, 8, centre=(100, 0, 0)))


def small_second_part():
    v, f = egg()
    return joined((v, f), tetrahedron([90, 0, 0], [91, 0, 0], [90, 1, 0], [90, 0, -1]))


def torus(around=16, across=8):
    u, w = (x.ravel() for x in np.meshgrid(np.arange(around), np.arange(across), indexing="ij"))
    a, b = 2 * np.pi * u / around, 2 * np.pi * w / across
    v = np.stack(
        [(30 + 10 * np.cos(b)) * np.cos(a), (30 + 10 * np.cos(b)) * np.sin(a), 10 * np.sin(b)], 1
    )

    def at(i, j):
        return (i % around) * across + j % across

    f = np.concatenate(
        [
            np.stack([at(u, w), at(u + 1, w), at(u + 1, w + 1)], 1),
            np.stack([at(u, w), at(u + 1, w + 1), at(u, w + 1)], 1),
        ]
    )
    return v, f.astype(np.int32)


def fin_on_an_edge():
    """A third face on one edge."""
    v, f = egg()
    a, b = f[40, :2]
    return np.concatenate([v, [1.5 * v[a]]]), np.concatenate([f, [[a, b, len(v)]]]).astype(np.int32)


def pinched_at_a_vertex():
    """A small tetrahedron that touches the egg's tip with its own."""
    v, f = egg()
    tip = v[0]
    return joined(
        (v, f), tetrahedron(tip, tip + [3, 0, 4], tip + [0, 3, 4], tip + [0, 0, 8]), shared=[(0, 0)]
    )


def one_face_turned():
    v, f = egg()
    f[40] = f[40][::-1]
    return v, f


def half_the_faces_turned():
    v, f = egg()
    f[len(f) // 2 :] = f[len(f) // 2 :, ::-1]
    return v, f


def inside_out():
    v, f = egg()
    return v, np.ascontiguousarray(f[:, ::-1])


def with_coordinate(value):
    v, f = egg()
    v[17, 1] = value
    return v, f


def empty():
    return np.empty((0, 3)), np.empty((0, 3), np.int32)


def points_only():
    return egg()[0], np.empty((0, 3), np.int32)


def three_vertices():
    """A triangle with two sides: closed, but it encloses nothing."""
    return np.array([[0, 0, 0], [10, 0, 0], [0, 10, 0]], float), np.array(
        [[0, 1, 2], [0, 2, 1]], np.int32
    )


def unreferenced_vertices():
    v, f = egg()
    return np.concatenate([v, [[1, 2, 3], [4, 5, 6]]]), f


def unwelded():
    """Every face has corners of its own, as in STL files."""
    v, f = egg()
    return v[f].reshape(-1, 3), np.arange(3 * len(f), dtype=np.int32).reshape(-1, 3)


def face_with_a_vertex_twice():
    v, f = egg()
    return v, np.concatenate([f, [[5, 5, 6]]]).astype(np.int32)


def flat():
    """All vertices at one place."""
    v, f = egg()
    return np.zeros_like(v), f


def zero_area_faces():
    """Sound topology, but six vertices lie exactly where a neighbour lies. Works."""
    v, f = egg()
    for a, b in f[[10, 50, 90, 130, 170, 210], :2]:
        v[a] = v[b]
    return v, f
