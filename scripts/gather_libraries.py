#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-only
"""Copies the shared libraries that a plugin needs and that not every machine has into a folder:
gather_libraries.py PLUGIN FOLDER

Those that check_wheel.py calls PyMeshLab's or the system's stay where they are. The copies are byte
for byte those of the system: the plugin's RPATH, $ORIGIN/lib, leads to all of them, also to those
that they need. What their packages say of copyright goes beside them.
"""

import gzip
import re
import shutil
import subprocess
import sys
from pathlib import Path

from check_wheel import LIBRARIES, needed

COMMON_LICENCES = Path("/usr/share/common-licenses")
HEADER = """\
The libraries in this folder are those of the Debian package {package} {version}, unchanged;
its source: apt-get source {source}={version}
"""


def said(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def bundled(plugin):
    """{name: path} of the libraries to be copied."""
    paths = dict(re.findall(r"^\s*(\S+) => (/\S+)", said("ldd", str(plugin)), re.M))
    found, open_ends = {}, [plugin]
    while open_ends:
        for name in needed(open_ends.pop()):
            if name in LIBRARIES or name in found:
                continue
            if name not in paths:
                sys.exit(f"error: {name}, which {plugin} needs, is not on this system.")
            found[name] = Path(paths[name]).resolve()
            open_ends.append(found[name])
    return found


def packages_of(paths):
    """The Debian packages that libraries belong to."""
    found = set()
    for path in paths:
        for name in (path, Path("/usr") / path.relative_to("/")):  # /lib is /usr/lib
            owner = subprocess.run(
                ["dpkg-query", "-S", str(name)], capture_output=True, text=True, check=False
            )
            if owner.returncode == 0:
                found.add(re.split(r"[:,]", owner.stdout)[0])
                break
        else:
            sys.exit(
                f"error: {path} belongs to no package, so that its licence is not known: it "
                "cannot go into a wheel."
            )
    return sorted(found)


def write_licence(package, path):
    """Who made the package, where its source is, its copyright file, and the licences that this
    only names."""
    about = said("dpkg-query", "-W", "-f", "${source:Package} ${source:Version}", package).split()
    folder = Path("/usr/share/doc") / package
    parts = [HEADER.format(package=package, source=about[0], version=about[1])]
    for name in ("copyright", "NOTICE.gz"):
        if (folder / name).is_file():
            parts.append(
                (gzip.open if name.endswith(".gz") else open)(
                    folder / name, "rt", encoding="utf-8", errors="replace"
                ).read()
            )
    for name in sorted({"Apache-2.0", *re.findall(r"common-licenses/([\w.-]*\w)", parts[1])}):
        parts.append((COMMON_LICENCES / name).read_text())
    path.write_text(("\n" + 79 * "=" + "\n\n").join(parts))


def main(plugin, folder):
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    libraries = bundled(Path(plugin))
    for name, path in libraries.items():
        shutil.copyfile(path, folder / name)
    for package in packages_of(libraries.values()):
        write_licence(package, folder / f"COPYRIGHT.{package}.txt")


if __name__ == "__main__":
    main(*sys.argv[1:])
