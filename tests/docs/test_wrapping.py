# SPDX-License-Identifier: GPL-3.0-only
"""scripts/wrap_markdown.py: prose is wrapped; nothing else is touched or means something else."""

import subprocess
import sys

import pytest
from pages import PROJECT

sys.path.append(str(PROJECT / "scripts"))
from wrap_markdown import COLUMNS, wrapped

LONG = "A sentence of seven words, again and again. " * 6
KEPT = {
    "a heading": "# " + LONG.strip(),
    "a table": f"| {LONG}|\n| --- |\n| {LONG}|",
    "code": f"```sh\n{LONG}\n\n- {LONG}\n```",
    "indented code": "    " + LONG.strip(),
    "HTML": f"<p>{LONG}</p>",
    "a picture": f"![{LONG}](images/picture.png)",
    "a long word": "https://example.org/" + "x" * 200,
    "inline code": "`" + LONG + "`",
}


@pytest.mark.parametrize("what", KEPT)
def test_what_is_no_prose_stays(what):
    page = f"# A page\n\n{KEPT[what]}\n\nIts end.\n"
    assert wrapped(page) == page


def test_prose_is_wrapped_once_and_for_all():
    page = f"{LONG}\n{LONG}\n\n- {LONG}\n- short\n  1. {LONG}\n\n{LONG.strip()}  \n{LONG}\n"
    once = wrapped(page)
    assert max(map(len, once.splitlines())) <= COLUMNS + len("  ")
    assert wrapped(once) == once and once.split() == page.split()
    lines = once.splitlines()
    assert [line for line in lines if line.startswith(("- ", "  1. "))] == [
        line for line in lines if line.lstrip()[:2] in ("- ", "1.")
    ]
    assert sum(line.endswith("  ") for line in lines) == 1  # the page's own line break


@pytest.mark.parametrize("word", ["-", "+", "*", "1.", "#", ">"])
def test_no_line_begins_a_block_that_was_none(word):
    for length in range(80, COLUMNS):
        page = "x" * length + f" {word} and so on\n"
        assert all(not line.startswith(word) for line in wrapped(page).splitlines())
        assert wrapped(page).split() == page.split()


def test_links_are_not_broken():
    page = "word " * 18 + "[a text with blanks](a/path with blanks.md) and more\n"
    assert "](a/path with blanks.md)" in wrapped(page)


def test_check_names_the_page_and_changes_nothing(tmp_path):
    page = tmp_path / "page.md"
    page.write_text(LONG)
    command = [sys.executable, str(PROJECT / "scripts/wrap_markdown.py"), "--check", str(page)]
    found = subprocess.run(command, capture_output=True, text=True, check=False)
    assert found.returncode == 1 and str(page) in found.stdout and page.read_text() == LONG
    subprocess.run([command[0], command[1], str(page)], check=True)
    assert subprocess.run(command, check=False).returncode == 0
