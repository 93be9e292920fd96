# SPDX-License-Identifier: GPL-3.0-only
"""docs/errors.md has every message that users can meet, and none that is gone."""

import re
import sys
from pathlib import Path

import pymeshlab
import pytest
from messages import catalogue, faults, menu_entries, messages, pieces, said_by
from pages import PROJECT, Page

sys.path.insert(0, str(PROJECT / "python"))
from sphere_propagation import errors

PAGE = Page(PROJECT / "docs/errors.md")
OF_OTHERS = "## What MeshLab and PyMeshLab say"  # this section's messages are not in our sources


def on_the_page(without_others=False):
    """The messages that the page explains: items of lists that are code."""
    text = PAGE.prose
    if without_others:
        text = re.sub(rf"^{OF_OTHERS}\n.*?(?=^## )", "", text, flags=re.M | re.S)
    return re.findall(r"^- `([^`]+)`$", text, flags=re.M)


#: Faults whose remedy is as good for arrays.
SAME_FOR_ARRAYS = {
    "TooFewVertices",
    "NotRepairable",
    "NoRoom",
    "RootOutOfRange",
    "ParentOutOfRange",
    "SecondRoot",
    "NoRoot",
    "Circle",
    "NoCorrespondence",
    "AnchorFileUnknown",
    "AnchorFileSyntax",
    "AnchorFrame",
    "AnchorNotNumbers",
    "AnchorsInOnePlace",
    "AnchorsChangePlaces",
    "AnchorsNotHeld",
    "FileIsFolder",
    "NoFolder",
    "FileTooLarge",
    "TooThin",
    "WorkingVoxelsSmall",
    "WorkingVoxelsLarge",
}


def test_every_fault_is_explained():
    explained = on_the_page()
    missing = [f["sentence"] for f in faults().values() if f["sentence"] not in explained]
    assert not missing, "\n  ".join(["not in docs/errors.md:", *missing])


def test_every_message_of_the_catalogue_is_explained(plugin):
    explained, said = on_the_page(), said_by(plugin)
    missing = [message for message in said if message not in explained]
    assert said and not missing, "\n  ".join(["not in docs/errors.md:", *missing])


def test_hosts_differ_in_what_menus_and_python_call_things_only():
    for name, fault in faults("MeshLab 2020.09").items():
        words = fault["sentence"].replace("coherentely", "coherently")
        assert words == faults()[name]["sentence"]
    for name, fault in faults("PyMeshLab").items():
        words = re.sub(r", [a-z]+(_[a-z]+)+(?=\))", "", fault["sentence"])
        words = re.sub(r" \([a-z]+(_[a-z]+)+\)|(?<=\()[a-z]+(_[a-z]+)+, ", "", words)
        assert words == faults()[name]["sentence"]


def test_menu_entries_are_those_of_pymeshlab(plugin):
    """By their names in Python, and by those that its plugins give MeshLab's menus."""
    named = {}
    for kind in ("clean", "func", "meshing", "screened_poisson", "select"):
        file = Path(pymeshlab.__file__).parent / f"lib/plugins/libfilter_{kind}.so"
        named.update(menu_entries(file))
    for entry in catalogue()["entries"]:
        assert entry["python"] in pymeshlab.filter_list()
        assert named[entry["python"]] == entry["name"]


def test_menu_entries_in_messages_are_known():
    """Those in angle brackets are spelled as each host has them."""
    named = {entry["name"] for entry in catalogue()["entries"]}
    for file in PROJECT.glob("*/messages.def"):
        text = re.sub(r'"\n\s*"', "", file.read_text())
        assert set(re.findall(r"<(?!=)([^<>]+)>", text)) <= named


def test_every_remedy_has_its_counterpart_for_arrays():
    """And is known by its first words, which stand in no other message."""
    pymeshlab_says = faults("PyMeshLab")
    advised = {name for name, fault in pymeshlab_says.items() if fault["remedy"]}
    assert advised == SAME_FOR_ARRAYS | set(errors.FOR_ARRAYS)
    for name, fault in pymeshlab_says.items():
        said = fault["sentence"]
        statement = said[: len(said) - len(fault["remedy"])]
        if name in errors.FOR_ARRAYS:
            opening, advice = errors.FOR_ARRAYS[name]
            assert fault["remedy"].startswith(opening)
            said = statement + advice
        assert errors.for_arrays(fault["sentence"]) == said.replace('Layer "', 'Surface "', 1)
        assert "layer dialog" not in said and "menu" not in said


#: Words that mean something in a window only.
OF_WINDOWS = (
    r"the filter again|Load it again|Load or show|layer dialog|[Hh]ide |hidden|menu|current layer"
)
#: What Python never meets: its surfaces are all visible, come from no file and have no marks.
NOT_IN_PYTHON = (
    "The project has no layer",
    "No surface layer is visible",
    "; hidden, left out",
    "the maps come from different roots",
    "the surfaces of …",
    "The landmarks do not correspond, since",
    "cannot be the root: it is hidden",
    "is the root and has no map",
    "the current layer is …",
    "it also holds landmarks of",
    'layers "…" and "…" both hold',
    "layer|layers} side by side",
    "layers side by side, by their",
    "No landmark layer is visible",
    "left out, since",
    "by their matrices alone",
    "No visible layer has places",
    "the surface of this sphere is not visible",
    "the matrices of",
    "end-diastole first and the current one",
    "the first is the current layer",
)


def test_no_message_speaks_of_windows_in_python(plugin):
    """Nor on the command line."""
    left = [
        text
        for text in map(errors.for_arrays, said_by(plugin))
        if re.search(OF_WINDOWS, text) and not any(words in text for words in NOT_IN_PYTHON)
    ]
    assert not left, "\n  ".join(["without advice for arrays in errors.py:", *left])


def test_advice_for_arrays_is_on_messages_that_exist(plugin):
    text = re.sub(r'"\n\s*"', "", (PROJECT / "filter_sphere_propagation/messages.def").read_text())
    said = dict(re.findall(r'MESSAGE\((\w+), \w+,\s*"((?:[^"\\]|\\.)*)"', text))
    for name, (opening, _) in errors.MESSAGES_FOR_ARRAYS.items():
        assert opening in said[name].replace('\\"', '"'), name


def test_every_message_is_explained():
    explained = on_the_page()
    missing = [
        f"{file}: {words}"
        for file, words in messages()
        if not any(words in message for message in explained)
    ]
    assert not missing, "\n  ".join(["not in docs/errors.md:", *missing])


def test_every_explained_message_exists(plugin):
    """A message may be put together from several pieces; what is left without them says nothing."""
    said = sorted({words for _, words in messages()}, key=len, reverse=True)
    of_faults = {fault["sentence"] for fault in faults().values()} | set(said_by(plugin))

    def invented(piece):
        for words in said:
            piece = piece.replace(words, "…").strip() if piece not in words else ""
        return any(pieces(piece))

    gone = [
        message
        for message in on_the_page(without_others=True)
        if message not in of_faults and any(map(invented, pieces(message)))
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


def test_the_index_is_sorted_and_leads_to_most_sections():
    text = re.search(r"^## Index\n(.*?)^## ", PAGE.prose, re.M | re.S)[1]
    words = re.findall(r"^\| (?!about|---)([^|]+) \|", text, re.M)
    assert len(words) > 40 and words == sorted(words, key=str.lower)
    sections = re.findall(r"^### (.+)$", PAGE.prose, re.M)
    missing = [name for name in sections if f"[{name}]" not in text]
    assert len(missing) <= 4, missing
