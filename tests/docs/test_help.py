# SPDX-License-Identifier: GPL-3.0-only
"""The files help/*.html of the plugins: what users read of the filters."""

import re

import pytest
import reference
from pages import PROJECT

FILES = sorted(PROJECT.glob("filter_*/help/*.html"))


@pytest.fixture(scope="module")
def filters(plugins):
    """All filters as the plugins describe them, by python name."""
    every = [f for name in reference.PLUGINS for f in reference.descriptions(plugins / name)]
    return {f.get("python_name"): f for f in every}


def test_every_filter_has_a_file_and_every_file_is_used(filters):
    texts = [path.read_text() for path in FILES]
    for path in FILES:
        included = any(f"{{{path.stem}}}" in text for text in texts)
        assert (path.stem in filters) != included, path
    assert set(filters) <= {path.stem for path in FILES}


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_files_explain_the_parameters_that_there_are_in_their_order(path, filters):
    explained = re.findall(r'<dt id="(\w+)">', path.read_text())
    if path.stem in filters:
        assert explained == [p.get("name") for p in filters[path.stem].findall("Param")]
    else:
        assert not explained


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_lines_are_short_and_plain(path):
    text = path.read_text()
    assert text.isascii(), "write &uuml; and the like"
    assert max(map(len, text.splitlines())) <= 100


def test_nothing_of_the_files_own_marks_is_shown(filters):
    for element in filters.values():
        texts = [element.get("name"), element.get("info")]
        for parameter in element.findall("Param"):
            texts += [parameter.get("description"), parameter.get("tooltip")]
        for text in texts:
            assert not re.search(r"[{}]|<!--|</?(p|dl|dt|dd|title)\b", text), text


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_dialogs_show_four_to_six_lines(path):
    """The first paragraph, at some 65 letters a line."""
    text = re.sub("<!--.*?-->", "", path.read_text(), flags=re.S)
    if "<p>" in text:
        first = " ".join(re.sub("<.*?>", "", text.split("<p>")[1]).split())
        assert len(first) <= 360
