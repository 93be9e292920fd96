# SPDX-License-Identifier: GPL-3.0-only
"""One version, which CMakeLists.txt says: the change log's newest section, CITATION.cff, README and
Git's tag of this commit agree with it."""

import re
import subprocess
from datetime import date

from pages import PROJECT
from sphere_propagation import citation


def version():
    text = (PROJECT / "CMakeLists.txt").read_text()
    return re.search(r"project\(SpherePropagation VERSION ([0-9.]+)", text)[1]


def newest():
    """The change log's newest section that has a number, and its date."""
    found = re.search(r"^## (\d[\d.]*) \((.*)\)$", (PROJECT / "CHANGELOG.md").read_text(), re.M)
    return found[1], date.fromisoformat(found[2])


def test_the_change_log_has_it():
    assert newest()[0] == version()


def test_the_citation_has_it():
    text = (PROJECT / "CITATION.cff").read_text()
    assert re.search(r"^version: (.*)$", text, re.M)[1] == version()
    assert re.search(r"^date-released: (.*)$", text, re.M)[1] == newest()[1].isoformat()
    assert f'- name: "{citation.AUTHORS}"' in text and newest()[1].year == citation.YEAR


def test_the_readme_has_it():
    assert f"This is version {version()} (" in (PROJECT / "README.md").read_text()


def test_the_tag_has_it():
    """Where this commit has one."""
    made = subprocess.run(
        ["git", "tag", "--points-at", "HEAD"],
        cwd=PROJECT,
        capture_output=True,
        text=True,
        check=False,
    )
    tags = [tag for tag in made.stdout.split() if re.fullmatch(r"v?\d+\.\d+.*", tag)]
    assert not tags or f"v{version()}" in tags or version() in tags
