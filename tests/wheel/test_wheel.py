# SPDX-License-Identifier: GPL-3.0-only
"""The wheel: what is in it and where it may be installed; and in a fresh environment the import,
the main job, the command."""

import re
import shutil
import sys
import zipfile
from pathlib import Path

import check_wheel
import pytest
import volume_files

PROJECT = Path(__file__).resolve().parents[2]
VERSION = re.search(
    r"VERSION ([0-9.]+)", re.search(r"project\(.*", (PROJECT / "CMakeLists.txt").read_text())[0]
)[1]


def test_contents_tag_and_symbols(wheel):
    assert check_wheel.wheel_complaints(wheel) == []
    assert wheel.name == f"sphere_propagation-{VERSION}-{check_wheel.TAG}.whl"


@pytest.fixture
def plugin(wheel, tmp_path):
    with zipfile.ZipFile(wheel) as file:
        return file.extract(check_wheel.PLUGIN, tmp_path)


def test_libraries_that_are_missing_are_found(wheel, tmp_path):
    """Also those that a library inside needs, and the copyright."""
    bad = tmp_path / wheel.name
    with zipfile.ZipFile(wheel) as good, zipfile.ZipFile(bad, "w") as file:
        lost = next(
            name for name in good.namelist() if name.startswith(check_wheel.BUNDLE + "libitkvnl-")
        )
        for name in good.namelist():
            if name != lost and "COPYRIGHT" not in name:
                file.writestr(name, good.read(name))
    complaints = check_wheel.wheel_complaints(bad)
    assert any(f"needs {Path(lost).name}, which" in text for text in complaints)
    assert "nothing says whose the libraries in it are" in complaints


def test_symbols_that_are_too_new_are_found(plugin):
    old = {**check_wheel.NEWEST, "GLIBC": (2, 3), "GLIBCXX": (3, 4, 9)}
    found = check_wheel.library_complaints(plugin, newest=old)
    assert any(re.search(r"GLIBC_2\.\d+, newer than 2\.3$", text) for text in found)
    assert any(re.search(r"GLIBCXX_3\.4\.\d+, newer than 3\.4\.9$", text) for text in found)
    assert check_wheel.library_complaints(
        plugin, libraries=check_wheel.LIBRARIES - {"libQt5Core.so.5"}
    ) == ["needs libQt5Core.so.5, which neither PyMeshLab nor the system has"]


def test_a_wheel_that_lacks_things_is_found(wheel, tmp_path):
    bad = tmp_path / wheel.name.replace(check_wheel.TAG, "py3-none-linux_x86_64")
    with zipfile.ZipFile(wheel) as good, zipfile.ZipFile(bad, "w") as file:
        for name in good.namelist():
            if not name.endswith("py.typed"):
                file.writestr(
                    name,
                    good.read(name).replace(check_wheel.TAG.encode(), b"py3-none-linux_x86_64"),
                )
        file.writestr("tests/test_x.py", "")
    assert len(check_wheel.wheel_complaints(bad)) == 4  # name, metadata, py.typed, tests


def test_metadata_suits_pip(environment):
    assert "No broken requirements" in environment.run("pip", "check")
    extras = environment.run(
        "python",
        "-c",
        "from importlib.metadata import metadata\n"
        "print(metadata('sphere-propagation').get_all('Provides-Extra'))",
    )
    assert all(f"'{extra}'" in extras for extra in ("surfaces", "pictures", "models"))
    about = environment.run("pip", "show", "sphere-propagation")
    assert f"Version: {VERSION}\n" in about and re.search(r"Requires: numpy, pymeshlab\n", about)


def test_the_plugin_comes_with_the_package(environment):
    said = environment.run(
        "python",
        "-c",
        "import pymeshlab, sphere_propagation as sp; from sphere_propagation import plugin\n"
        "m = pymeshlab.MeshSet()\n"
        "m.apply_filter('create_ventricle_phantom', phases=1, voxel_size=4)\n"
        "m.apply_filter('compute_spherical_parameterisation_root')\n"
        "print(plugin.loaded(), sp.__version__)",
    )
    path, version = said.split()
    assert (
        Path(path).parent.name == "sphere_propagation"
        and environment.bin.parent in Path(path).parents
    )
    assert version == VERSION


def test_the_main_job(environment):
    code = """
import numpy as np, sphere_propagation as sp
surfaces = sp.make_phantom(phases=5, voxel_size=4)
result = sp.correspond(surfaces, root=0, order="Cyclic time", frequency=5)
assert result.landmarks.shape == (5, 252, 3) and result.figures["flipped_faces"].sum() == 0
assert (sp.evaluate(surfaces, result.maps)["valid"] == 1).all()
assert sp.Ventricle("Cavity", 5).errors(result.landmarks).max() < 2.5
sp.write_layers("layers", "phantom", result)
again = sp.read_mesh("layers/phantom/surfaces/phantom_cavity_02.ply")
assert np.array_equal(again.faces, surfaces[2].faces)
"""
    environment.run("python", "-W", "error", "-c", code)


def test_label_volumes_need_nothing_of_the_system(environment):
    """ITK's libraries are the wheel's own."""
    (environment.folder / "egg.nii").write_bytes(volume_files.nifti(volume_files.egg()))
    code = """
import sphere_propagation as sp
for name in ("egg.nii", "egg.mha", "egg.nrrd"):
    (surface,) = sp.read_label_volume(name).surfaces
    assert len(surface.vertices) - len(surface.faces) // 2 == 2
used = {line.split()[-1] for line in open("/proc/self/maps") if "itk" in line.lower()}
assert used and all("/sphere_propagation/" in path for path in used), used
"""
    (environment.folder / "egg.mha").write_bytes(volume_files.meta(volume_files.egg()))
    (environment.folder / "egg.nrrd").write_bytes(volume_files.nrrd(volume_files.egg()))
    environment.run("python", "-W", "error", "-c", code)


def test_the_command(environment):
    """Without Matplotlib and VTK: everything but the pictures."""
    said = environment.run(
        "sphere-propagation", "demo", "out", "--phases", 3, "--voxel-size", 4, "--frequency", 3
    )
    assert (
        "matplotlib and vtk not installed" in said
        and (environment.folder / "out/wall/wall.mlp").is_file()
    )
    said = environment.run(
        "sphere-propagation",
        "run",
        "out/cavity/surfaces",
        "-o",
        "mine",
        "--name",
        "heart",
        "--frequency",
        3,
    )
    assert (
        re.search(r"heart +Robust +3 +0 ", said)
        and (environment.folder / "mine/heart/heart.mlp").is_file()
    )
    assert (
        environment.run("sphere-propagation", "run", "nowhere", "-o", "x", code=1)
        == "error: There is no file or folder nowhere.\n"
    )
    assert environment.run("sphere-propagation", "--version") == f"sphere-propagation {VERSION}\n"
    assert (
        environment.run("python", "-m", "sphere_propagation", "--version")
        == f"sphere-propagation {VERSION}\n"
    )
    assert VERSION in environment.run("sphere-propagation", "info")


def test_surfaces_that_need_an_extra_name_it(environment):
    (environment.folder / "heart.vtk").write_text("# vtk DataFile Version 3.0\n")
    said = environment.run("sphere-propagation", "convert", "heart.vtk", code=1)
    assert "vtk, which is not installed: pip install 'sphere-propagation[surfaces]'" in said


def test_cohorts_need_an_extra_and_name_it(environment):
    said = environment.run("sphere-propagation", "cohort", ".", "study", "group", code=1)
    assert "pip install 'sphere-propagation[cohort]'" in said or "Python 3.11" in said


@pytest.mark.skipif(sys.version_info < (3, 11), reason="Snakemake takes Python 3.11 or later")
def test_a_cohort_takes_the_wheel_and_its_extra_alone(environment, wheel):
    environment.install(f"{wheel}[cohort]")
    make = (
        "import sphere_propagation as sp, pathlib\n"
        "for seed in range(3):\n"
        "    folder = pathlib.Path(f'hearts/sub-0{seed}'); folder.mkdir(parents=True)\n"
        "    for k, one in enumerate(sp.make_phantom(phases=3, voxel_size=4.0, seed=seed)):\n"
        "        sp.write_ply(folder / f'{k}.ply', one.vertices, one.faces)\n"
    )
    environment.run("python", "-c", make)
    (environment.folder / "study.toml").write_text("frequency = 4\n")
    words = "hearts", "study", "group", "--config", "study.toml", "--cores", 1
    said = environment.run("sphere-propagation", "cohort", *words)
    assert "3 subjects done, 9 surfaces; 0 failed" in said
    assert (environment.folder / "study/model/model.npz").is_file()


def test_a_package_without_its_plugin_says_so(environment):
    library = next(environment.bin.parent.glob("lib/*/site-packages/" + check_wheel.PLUGIN))
    shutil.move(library, environment.folder / "elsewhere.so")
    try:
        said = environment.run("sphere-propagation", "info", code=1)
    finally:
        shutil.move(environment.folder / "elsewhere.so", library)
    assert (
        said.startswith("error: The plugin libfilter_sphere_propagation.so is not in the package.")
        and "Traceback" not in said
    )
