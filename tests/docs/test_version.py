# SPDX-License-Identifier: GPL-3.0-only
"""One version, which CMakeLists.txt says: the change log's newest section, CITATION.cff, README and
Git's tag of this commit agree with it."""

import re
import shutil
import subprocess
from datetime import date

import sphere_propagation
from pages import PROJECT
from sphere_propagation import citation


def version_in(text):
    return re.search(r"project\(SpherePropagation VERSION ([0-9.]+)", text)[1]


def version():
    return version_in((PROJECT / "CMakeLists.txt").read_text())


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


def git(*words):
    made = subprocess.run(["git", *words], cwd=PROJECT, capture_output=True, text=True, check=False)
    return made.stdout


def of_a_version(tags):
    return [tag for tag in tags.split() if re.fullmatch(r"v?\d+\.\d+.*", tag)]


def test_the_tag_has_it():
    """Where this commit has one."""
    tags = of_a_version(git("tag", "--points-at", "HEAD"))
    assert not tags or f"v{version()}" in tags


def test_tags_are_on_commits_of_their_version():
    """Where this checkout has any, and what they point to."""
    for tag in of_a_version(git("tag")):
        text = git("show", f"{tag}:CMakeLists.txt")
        assert not text or version_in(text) == tag.removeprefix("v"), tag


def test_the_package_has_it():
    """In a checkout; of the wheel tests/wheel says so."""
    assert sphere_propagation.__version__ == version()
    settings = (PROJECT / "pyproject.toml").read_text()
    assert 'dynamic = ["version"]' in settings and not re.search(r"(?m)^version *=", settings)


def test_a_release_names_it_everywhere(tmp_path):
    """scripts/release, on a copy: all of these pass, with another number and day."""
    named = (
        "CMakeLists.txt",
        "CHANGELOG.md",
        "CITATION.cff",
        "README.md",
        "python/sphere_propagation/citation.py",
        "scripts/release",
    )
    for name in named:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(PROJECT / name, tmp_path / name)
    changes = tmp_path / "CHANGELOG.md"
    if "\n## Unreleased\n" not in changes.read_text():
        changes.write_text(changes.read_text().replace("\n## ", "\n## Unreleased\n- x\n\n## ", 1))
    subprocess.run(["git", "init", "-q"], cwd=tmp_path, check=True)
    subprocess.run(["scripts/release", "7.8.9", "2031-02-03"], cwd=tmp_path, check=True)
    texts = {name: (tmp_path / name).read_text() for name in named}
    assert version_in(texts["CMakeLists.txt"]) == "7.8.9"
    assert "Unreleased" not in texts["CHANGELOG.md"]
    assert "\n## 7.8.9 (2031-02-03)\n" in texts["CHANGELOG.md"]
    assert "\nversion: 7.8.9\ndate-released: 2031-02-03\n" in texts["CITATION.cff"]
    assert "This is version 7.8.9 (" in texts["README.md"]
    assert re.search("\nAUTHORS, YEAR = .*, 2031\n", texts[named[4]])
    for words in ([], ["1.2"], ["v1.2.3"], ["1.2.3", "today"]):
        done = subprocess.run(["scripts/release", *words], cwd=tmp_path, check=False)
        assert done.returncode == 2, words
