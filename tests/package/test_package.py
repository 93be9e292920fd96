# SPDX-License-Identifier: GPL-3.0-only
"""vcg_ext as a package: another project finds it where it is installed, or brings it along in a
folder of its own, and the examples work either way.

SPHERE_PROPAGATION_BUILD is a build folder with vcg_ext built in it.
"""

import os
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

PROJECT = Path(__file__).resolve().parents[2]
SURFACES = sorted((PROJECT / "sample_projects/ventricle/surfaces").glob("ventricle_*.ply"))
EXAMPLES = ("map_of_mesh", "landmarks_of_sequence", "model_of_shapes")

# What a user of the library does not have. CMake then finds none of them.
ABSENT = ("Qt5", "ITK", "GTest", "ZLIB", "Python3", "benchmark")


def run(*command, **options):
    done = subprocess.run(
        [str(word) for word in command], capture_output=True, text=True, check=False, **options
    )
    assert done.returncode == 0, f"{command}: {(done.stdout + done.stderr)[-3000:]}"
    return done.stdout


def build(source, folder, absent=ABSENT, target="all", **definitions):
    """Configures and builds; a cache of its own shows whether anything is downloaded."""
    environment = {**os.environ, "XDG_CACHE_HOME": str(folder / "cache")}
    environment.pop("MESHLAB_SOURCE_DIR", None)
    if "CMAKE_BUILD_TYPE" not in definitions:
        definitions["CMAKE_BUILD_TYPE"] = "Debug"  # quicker to compile
        definitions["CMAKE_CXX_FLAGS_DEBUG"] = "-O0"
    definitions.update({f"CMAKE_DISABLE_FIND_PACKAGE_{name}": "ON" for name in absent})
    run(
        *("cmake", "-G", "Ninja", "-S", source, "-B", folder),
        *[f"-D{name}={value}" for name, value in definitions.items()],
        env=environment,
    )
    run("cmake", "--build", folder, "--target", target, env=environment)
    assert not (folder / "cache/sphere-propagation").exists(), "something was fetched"


@pytest.fixture(scope="module")
def prefix(tmp_path_factory):
    """The package, installed."""
    folder = tmp_path_factory.mktemp("prefix")
    built = os.environ.get("SPHERE_PROPAGATION_BUILD", PROJECT / "build/pymeshlab")
    run("cmake", "--install", built, "--component", "vcg_ext", "--prefix", folder)
    return folder


@pytest.fixture(scope="module")
def examples(prefix, tmp_path_factory):
    """The examples, built against the installed package."""
    folder = tmp_path_factory.mktemp("installed")
    build(
        PROJECT / "examples",
        folder,
        absent=(*ABSENT, "nanoflann", "Boost"),
        CMAKE_PREFIX_PATH=prefix,
    )
    return folder


def read_off(path):
    lines = path.read_text().split("\n")
    assert lines[0] == "OFF"
    vertices, faces, _ = map(int, lines[1].split())
    points = np.array([line.split() for line in lines[2 : 2 + vertices]], float)
    corners = np.array([line.split() for line in lines[2 + vertices : 2 + vertices + faces]], int)
    return points, corners[:, 1:]


def check_map(program, folder):
    said = run(program, SURFACES[0], folder / "sphere.off")
    points, faces = read_off(folder / "sphere.off")
    assert np.allclose(np.linalg.norm(points, axis=1), 1, atol=1e-6)
    a, b, c = (points[faces[:, k]] for k in range(3))
    assert np.all(np.einsum("ij,ij->i", a, np.cross(b, c)) > 0), "a face is flipped"
    assert float(re.search(r"area ratio ([\d.e-]+)", said)[1]) < 0.1


def test_installed_package_maps_a_mesh(examples, tmp_path):
    check_map(examples / "map_of_mesh", tmp_path)


def test_installed_package_takes_a_sequence_to_a_model(examples, tmp_path):
    said = run(examples / "landmarks_of_sequence", tmp_path, *SURFACES)
    distances = [float(d) for d in re.findall(r"within ([\d.e-]+) of", said)]
    assert len(distances) == len(SURFACES) and max(distances) < 5
    files = [tmp_path / f"landmarks_{i}.off" for i in range(len(SURFACES))]
    assert {len(read_off(file)[0]) for file in files} == {1002}

    said = run(examples / "model_of_shapes", tmp_path / "model.npz", *files)
    shares = [float(share) for share in re.findall(r": ([\d.e-]+) % of", said)]
    assert shares == sorted(shares, reverse=True) and sum(shares) == pytest.approx(100, abs=1e-3)
    model = np.load(tmp_path / "model.npz")
    assert model["mean"].shape == (1002, 3) and len(model["eigenvalues"]) == len(shares)


@pytest.mark.parametrize("name", EXAMPLES)
def test_examples_say_how_they_are_called(examples, name):
    done = subprocess.run([examples / name], capture_output=True, text=True, check=False)
    assert done.returncode == 2 and f"usage: {name} " in done.stderr


def test_examples_tell_the_library_s_errors(examples, tmp_path):
    path = tmp_path / "open.off"
    path.write_text("OFF\n4 3 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n")
    done = subprocess.run(
        [examples / "map_of_mesh", path, tmp_path / "sphere.off"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1 and str(path) in done.stderr


def test_subdirectory_brings_the_library_alone(tmp_path):
    # As deep as build/pymeshlab, and with its flags: a compiler cache knows the library from there.
    folder = PROJECT / "build/subdirectory"
    shutil.rmtree(folder, ignore_errors=True)
    build(
        PROJECT / "tests/package/subdirectory",
        folder,
        target="map_of_mesh",
        CMAKE_BUILD_TYPE="Release",
    )
    check_map(folder / "examples/map_of_mesh", tmp_path)
    listed = run("cmake", "--build", folder, "--target", "help")
    for name in ("filter_sphere_propagation", "core_tests", "propagation_benchmark"):
        assert name not in listed
    run("cmake", "--install", folder, "--prefix", tmp_path / "nothing")
    assert not (tmp_path / "nothing").exists(), "a part of another project installs itself"


def test_headers_are_complete_and_meet_no_other_library(prefix, tmp_path):
    headers = sorted((prefix / "include").rglob("*.h"))
    ours = {str(path.relative_to(PROJECT)) for path in (PROJECT / "vcg_ext").rglob("*.h")}
    assert {str(path.relative_to(prefix / "include")) for path in headers} == ours
    with_vcg = [path for path in headers if "#include <vcg/" in path.read_text()]
    assert [path.name for path in with_vcg] == ["vcg_conversion.h"]
    for path in headers:
        assert not re.search(r"#include <(boost|nanoflann|Q|common|wrap)", path.read_text()), path

    # Each of them first in a file of its own would take long: all of them in one, backwards.
    lines = [f'#include "{name}"' for name in sorted(ours, reverse=True)]
    source = tmp_path / "all.cpp"
    source.write_text("\n".join(line for line in lines if "vcg_conversion" not in line) + "\n")
    (tmp_path / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.21)\n"
        "project(Headers LANGUAGES CXX)\n"
        "find_package(sphere_propagation 1 CONFIG REQUIRED)\n"
        "add_library(headers OBJECT all.cpp)\n"
        "target_compile_options(headers PRIVATE -fsyntax-only)\n"
        "target_link_libraries(headers PRIVATE sphere_propagation::vcg_ext)\n"
    )
    build(tmp_path, tmp_path / "build", CMAKE_PREFIX_PATH=prefix)
