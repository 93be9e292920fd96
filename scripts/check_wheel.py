#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-only
"""Makes sure that a wheel holds what it must and that its plugins load on every system its tag
promises: check_wheel.py WHEEL

The tag manylinux_2_35 stands for glibc 2.35, and Ubuntu 22.04 is the oldest system that is meant:
its libstdc++ is that of GCC 12. Reads the libraries' dynamic sections with objdump (binutils, which
comes with the compiler).
"""

import re
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

TAG = "py3-none-manylinux_2_35_x86_64"
PLUGIN = "sphere_propagation/libfilter_sphere_propagation.so"
VOLUME_PLUGIN = "sphere_propagation/libfilter_label_volume.so"
# The libraries that VOLUME_PLUGIN needs, and what their packages say of copyright.
BUNDLE = "sphere_propagation/lib/"
CONTENTS = (
    PLUGIN,
    VOLUME_PLUGIN,
    "sphere_propagation/__init__.py",
    "sphere_propagation/py.typed",
    "sphere_propagation/_version.py",
    "sphere_propagation/explorer_page/page.html",
    "sphere_propagation/explorer_page/page.js",
    "sphere_propagation/cohort/Snakefile",
    "sphere_propagation/cohort/profiles/slurm/config.yaml",
    "_sphere_propagation_command.py",
)
NEWEST = {
    "GLIBC": (2, 35),
    "GLIBCXX": (3, 4, 30),
    "CXXABI": (1, 3, 13),
    "GCC": (12,),
    "Qt": (5, 15),
    "ZLIB": (1, 2, 11),
}
LIBRARIES = {  # that PyMeshLab has loaded before any plugin, and every system's
    "libmeshlab-common.so",
    "libQt5Core.so.5",
    "libQt5Gui.so.5",
    "libQt5Widgets.so.5",
    "libQt5OpenGL.so.5",
    "libQt5Xml.so.5",
    "libGL.so.1",
    "libstdc++.so.6",
    "libgcc_s.so.1",
    "libm.so.6",
    "libc.so.6",
    "libz.so.1",
    "ld-linux-x86-64.so.2",
}


def dynamic_section(path):
    return subprocess.run(
        ["objdump", "-p", str(path)], check=True, capture_output=True, text=True
    ).stdout


def needed(path):
    """Names of the libraries that a library asks for."""
    return re.findall(r"^ *NEEDED +(\S+)", dynamic_section(path), re.M)


def library_complaints(path, newest=None, libraries=None, rpath=None):
    """What keeps a library from loading where the tag says it does, one line each. rpath: the one
    that it must have, and no other."""
    text = dynamic_section(path)
    complaints = [
        f"needs {name}, which neither PyMeshLab nor the system has"
        for name in needed(path)
        if name not in (libraries or LIBRARIES)
    ]
    found = re.findall(r"^ *(RUNPATH|RPATH) +(\S+)", text, re.M)
    complaints += [
        f"looks for libraries in {where} ({kind})"
        for kind, where in found
        if (kind, where) != ("RPATH", rpath)
    ]
    if rpath and not found:
        complaints.append(f"does not look for libraries in {rpath}")
    references = text.partition("Version References:")[2]
    versions = re.findall(r"^ +0x\w+ 0x\w+ \d+ (\w+?)_([\d.]+)$", references, re.M)
    if not versions:
        complaints.append("names no symbol version: objdump was not understood")
    for name, version in sorted(set(versions)):
        limit = (newest or NEWEST).get(name)
        if limit is None or tuple(map(int, version.split("."))) > limit:
            complaints.append(
                f"needs symbols of {name}_{version}"
                + (f", newer than {'.'.join(map(str, limit))}" if limit else "")
            )
    return complaints


def wheel_complaints(path):
    """What is wrong with a wheel, one line each."""
    path, complaints = Path(path), []
    if not path.name.endswith(f"-{TAG}.whl"):
        complaints.append(f"its name does not end with the tag {TAG}")
    with zipfile.ZipFile(path) as wheel:
        names = wheel.namelist()
        complaints += [f"{name} is missing" for name in CONTENTS if name not in names]
        complaints += [
            f"{name} does not belong into it"
            for name in names
            if not re.match(
                r"sphere_propagation/((explorer_page|cohort|cohort/profiles/slurm)/)?[\w.]+$|sphere_propagation/lib/(lib[\w.-]+\.so[\d.]*|COPYRIGHT\.[\w.-]+\.txt)$|_sphere_propagation_command\.py$|sphere_propagation-[\d.]+\.dist-info/",
                name,
            )
        ]
        (about,) = [name for name in names if name.endswith(".dist-info/WHEEL")]
        if f"Tag: {TAG}\n" not in wheel.read(about).decode():
            complaints.append(f"its metadata does not say {TAG}")
        bundle = {name[len(BUNDLE) :] for name in names if name.startswith(BUNDLE + "lib")}
        if bundle and not any(name.startswith(BUNDLE + "COPYRIGHT.") for name in names):
            complaints.append("nothing says whose the libraries in it are")
        unused = set(bundle)
        with tempfile.TemporaryDirectory() as folder:
            for name in [name for name in names if ".so" in name]:
                file = wheel.extract(name, folder)
                own = LIBRARIES if name == PLUGIN else LIBRARIES | bundle
                complaints += [
                    f"{name} {text}"
                    for text in library_complaints(
                        file, libraries=own, rpath="$ORIGIN/lib" if name == VOLUME_PLUGIN else None
                    )
                ]
                unused -= set(needed(file))
        complaints += [f"{name} is inside, but nothing needs it" for name in sorted(unused)]
    return complaints


if __name__ == "__main__":
    found = wheel_complaints(sys.argv[1])
    for complaint in found:
        print(f"{Path(sys.argv[1]).name}: {complaint}", file=sys.stderr)
    sys.exit(bool(found))
