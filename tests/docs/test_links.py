# SPDX-License-Identifier: GPL-3.0-only
"""Links lead somewhere: every page, heading, picture, script and source file that a page names is
there."""

import re

import pytest
from pages import PROJECT, Page, all_pages

PAGES = all_pages()
LARGEST_PICTURE = 200_000  # bytes
NAMES_A_FILE = re.compile(
    r"(?:\./)?((?:vcg_ext|host|filter_sphere_propagation|filter_label_volume|python|scripts|tests|docs|sample_projects|benchmarks|cmake)/[\w./*-]+)"
)


def target_of(page, link):
    path, _, fragment = link.partition("#")
    return (page.path.parent / path).resolve() if path else page.path, fragment


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page):
    for link in page.links:
        target, fragment = target_of(page, link)
        assert target.exists(), f"{page.name}: {link}"
        assert target.is_relative_to(PROJECT), f"{page.name}: {link} leads out of the project"
        if fragment:
            assert fragment in Page(target).anchors, (
                f"{page.name}: {link}: there is no such heading"
            )


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_files_that_are_named_are_there(page):
    """`scripts/demo`, `vcg_ext/map/certificate` (whatever its ending), `tests/core/*.cpp`."""
    for code in page.inline_code:
        named = NAMES_A_FILE.match(code)
        if named and not named[1].startswith("docs/images/NAME"):
            path = named[1].rstrip("/.")
            assert (PROJECT / path).exists() or any(PROJECT.glob(path + "*")), (
                f"{page.name}: there is no {path}"
            )


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_headings_have_anchors_of_their_own(page):
    twice = {a for a in page.anchors if page.anchors.count(a) > 1}
    assert page.name == "docs/filters.md" or not twice, f"{page.name}: {twice}"


def test_pictures_are_small_and_shown():
    shown = {target_of(page, link)[0] for page in PAGES for link in page.links}
    for picture in sorted((PROJECT / "docs/images").glob("*.png")):
        assert picture in shown, f"{picture.name} is on no page"
        assert picture.stat().st_size <= LARGEST_PICTURE, f"{picture.name} is too large"


def test_every_page_is_in_the_index():
    index = Page(PROJECT / "docs/README.md")
    listed = {target_of(index, link)[0] for link in index.links}
    for page in sorted((PROJECT / "docs").glob("*.md")):
        assert page == index.path or page in listed, f"docs/README.md does not name {page.name}"
