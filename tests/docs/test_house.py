# SPDX-License-Identifier: GPL-3.0-only
"""The map of the house in CONTRIBUTING.md is the house: every folder is there, with what it
includes."""

import re

from pages import PROJECT

INCLUDE = re.compile(r'^#include "(vcg_ext|host)/(?:([^"]+)/)?[^"/]+"', flags=re.M)


def rows():
    """Of each folder of C++ in the table, what it may include."""
    table = {}
    for line in (PROJECT / "CONTRIBUTING.md").read_text().splitlines():
        cells = [cell.strip() for cell in line.split("|")]
        if len(cells) == 5 and re.fullmatch(r"`(vcg_ext/\S+|host|filter_\w+)`", cells[1]):
            table[cells[1].strip("`")] = {name.strip() for name in cells[3].split(",")} - {""}
    return table


def included_by(folder):
    """The folders of vcg_ext by their names there, others as a whole."""
    found = set()
    for path in folder.iterdir() if folder.parts[-1] != "host" else folder.rglob("*"):
        if path.suffix in (".h", ".cpp"):
            for room, inner in INCLUDE.findall(path.read_text()):
                found.add(inner if room == "vcg_ext" else room)
    own = folder.relative_to(PROJECT)
    inside = own.parts[0] == "vcg_ext"
    if not inside:
        found = {name if name == "host" else "vcg_ext" for name in found}
    return found - {"/".join(own.parts[1:]) if inside else own.parts[0]}


def test_every_folder_is_on_the_map():
    folders = {str(path.parent.relative_to(PROJECT)) for path in (PROJECT / "vcg_ext").rglob("*.h")}
    assert folders == {name for name in rows() if name.startswith("vcg_ext/")}


def test_folders_include_what_the_map_says():
    wrong = [
        f"{name} includes {sorted(included_by(PROJECT / name))}, the map says {sorted(allowed)}"
        for name, allowed in rows().items()
        if included_by(PROJECT / name) != allowed
    ]
    assert not wrong, "\n  ".join(["CONTRIBUTING.md:", *wrong])


def test_there_is_no_circle():
    above = {name[len("vcg_ext/") :]: includes for name, includes in rows().items() if "/" in name}
    while above:
        free = [name for name, includes in above.items() if not includes & above.keys()]
        assert free, f"a circle among {sorted(above)}"
        for name in free:
            del above[name]
