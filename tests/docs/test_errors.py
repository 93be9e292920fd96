# SPDX-License-Identifier: GPL-3.0-only
"""docs/errors.md has every message that users can meet, and none that is gone."""

import re

import pytest
from messages import messages, pieces
from pages import PROJECT, Page

PAGE = Page(PROJECT / "docs/errors.md")
OF_OTHERS = "## What MeshLab and PyMeshLab say"  # this section's messages are not in our sources


def on_the_page(without_others=False):
    """The messages that the page explains: items of lists that are code."""
    text = PAGE.prose
    if without_others:
        text = re.sub(rf"^{OF_OTHERS}\n.*?(?=^## )", "", text, flags=re.M | re.S)
    return re.findall(r"^- `([^`]+)`$", text, flags=re.M)


def test_every_message_is_explained():
    explained = on_the_page()
    missing = [
        f"{file}: {words}"
        for file, words in messages()
        if not any(words in message for message in explained)
    ]
    assert not missing, "\n  ".join(["not in docs/errors.md:", *missing])


def test_every_explained_message_exists():
    """A message may be put together from several pieces; what is left without them says nothing."""
    said = sorted({words for _, words in messages()}, key=len, reverse=True)

    def invented(piece):
        for words in said:
            piece = piece.replace(words, "…").strip() if piece not in words else ""
        return any(pieces(piece))

    gone = [
        message
        for message in on_the_page(without_others=True)
        if any(map(invented, pieces(message)))
    ]
    assert not gone, "\n  ".join(["in docs/errors.md, but nothing says so any more:", *gone])


@pytest.mark.parametrize(
    "text, expected",
    [
        (
            'throw Error("Layer \\"" + name + "\\": it is quite empty. " + remedy);',
            ["it is quite empty"],
        ),
        (
            'throw Error("one long line "\n'
            '  "of words" + std::to_string(n) + " and so it goes on");',
            ["one long line of words", "and so it goes on"],
        ),
        (
            'fail("it has holes: " + counted(holes, "edge is", "edges are") + " still open");',
            ["it has holes", "edges are still open"],
        ),
        ('// "a comment that says something"\nint x = 1;', []),
        ('outputs["area_ratio_sd"] = 1;', []),
    ],
)
def test_messages_are_found_in_cpp(text, expected):
    from messages import in_cpp

    assert [p for said in in_cpp(text) for p in pieces(said)] == expected
