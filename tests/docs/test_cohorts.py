# SPDX-License-Identifier: GPL-3.0-only
"""docs/cohorts.md against the study that the command reads."""

from __future__ import annotations

import json
import re
import sys

import pytest
from pages import PROJECT
from sphere_propagation.cohort import quality, study_page
from sphere_propagation.cohort.study import checked, read_study

PAGE = PROJECT / "docs" / "cohorts.md"


def test_every_key_of_a_study_is_on_the_page_with_its_default():
    rows = re.findall(r"^\| `(\w+)` \| `([^`]*)` \|", PAGE.read_text(encoding="utf-8"), re.M)
    settings = checked({}).as_dict()
    assert [key for key, _ in rows] == list(settings)
    named = settings.pop("quality")
    assert (
        rows[-1][1] == "{" + ", ".join(f"{key} = {value:g}" for key, value in named.items()) + "}"
    )
    for key, shown in rows[:-1]:
        assert json.loads(shown) == settings[key], key


@pytest.mark.skipif(sys.version_info < (3, 11), reason="tomllib")
def test_the_page_s_defaults_are_a_study_that_is_read(tmp_path):
    rows = re.findall(r"^\| `(\w+)` \| `([^`]*)` \|", PAGE.read_text(encoding="utf-8"), re.M)
    path = tmp_path / "study.toml"
    path.write_text("\n".join(f"{key} = {shown}" for key, shown in rows), encoding="utf-8")
    assert read_study(path)[0] == checked({})


def test_what_the_page_says_of_outputs_is_what_is_written():
    text = PAGE.read_text(encoding="utf-8")
    assert f"`{study_page.REPORT}`" in text and f"`{study_page.REPORTS}/CHUNK.html`" in text
    assert f"pictures = {quality.DEFAULTS['pictures']}" in text
