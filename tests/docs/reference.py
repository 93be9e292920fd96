# SPDX-License-Identifier: GPL-3.0-only
"""The reference of all filters, docs/filters.md, from what the plugins say of themselves:

    python reference.py FOLDER_OF_PLUGINS [FILE]

scripts/make-reference builds what this needs and runs it; test_reference.py compares the page with
the plugins.
"""

import ctypes
import html
import re
import sys
import xml.etree.ElementTree as xml
from pathlib import Path

import pymeshlab  # whose MeshLab the library below uses
from pages import PROJECT, anchor

sys.path.append(str(PROJECT / "scripts"))
from wrap_markdown import wrapped

MENUS = {  # bits of FilterPlugin::FilterClass -> the menu under Filters
    0x00040: "Create New Mesh Layer",
    0x00002: "Cleaning and Repairing",
    0x00004: "Remeshing, Simplification and Reconstruction",
    0x00200: "Mesh Layer",
    0x00010: "Color Creation and Processing",
    0x00100: "Quality Measure and Computations",
    0x10000: "Quality Measure and Computations",
}
TYPES = {
    "RichBool": "yes or no",
    "RichInt": "whole number",
    "RichFloat": "number",
    "RichString": "text",
    "RichMesh": "layer",
    "RichSaveFile": "file to write",
    "RichOpenFile": "file to read",
}

# In the order of the job.
PLUGINS = ("libfilter_label_volume.so", "libfilter_sphere_propagation.so")

HEADER = """\
# The filters

All filters with all parameters, as the plugins themselves describe them: `scripts/make-reference`
writes this page, and a test compares it with them. The first filter is that of
`libfilter_label_volume.so`, all others are those of `libfilter_sphere_propagation.so`. A parameter
that is not given has its default. In Python, a choice is given by its text, a layer by its number.
The [tutorial](tutorial.md) says how they work together, [When something goes wrong](errors.md) what
their messages mean. Every filter also returns `warnings`, where something deserves a look: [how to
read it](hosts.md#warnings).

| menu entry | in Python | menus |
| --- | --- | --- |
"""


def descriptions(plugin):
    """A plugin's filters, as filter_descriptions.cpp writes them: list of XML elements."""
    plugin = Path(plugin).resolve()
    library = plugin.parents[1] / "tests/libfilter_descriptions.so"
    if not library.is_file():
        raise FileNotFoundError(
            f"There is no {library}: scripts/build pymeshlab plugins filter_descriptions"
        )
    read = ctypes.CDLL(str(library)).filter_descriptions
    read.restype = ctypes.c_char_p
    return xml.fromstring(read(str(plugin).encode()).decode()).findall("filter")


def menus(element):
    """The menus under Filters that show a filter."""
    classes = int(element.get("classes"))
    return list(dict.fromkeys(name for bit, name in MENUS.items() if classes & bit))


def returned_keys(element):
    """The keys that a filter says it returns."""
    paragraph = next(
        (p for p in element.get("info").split("<br><br>") if p.startswith("Returned")), ""
    )
    return re.findall("<b>(.*?)</b>", paragraph)


def markdown(text):
    """MeshLab's HTML as Markdown: bold, italics, line breaks, superscripts."""
    text = re.sub("</?b>", "**", text)
    text = re.sub("</?i>", "*", text)
    return html.unescape(text.replace("<br>", "  \n").replace("<sup>2</sup>", "²"))


def returned(paragraph):
    """ "Returned: <b>key</b>: meaning; <b>key</b>: ..." as a list."""
    header, *items = re.split(r"(?:: |; |\. |, )(?=<b>)", paragraph)
    items = [re.sub("<b>(.*?)</b>", r"`\1`", item).rstrip(".") for item in items]
    items[-1], _, remark = items[-1].partition(". ")
    lines, keys = [], []
    for item in items:
        keys.append(item)
        # What several keys mean is said after the last of them.
        if ": " in item or "(" in item or item == items[-1]:
            lines.append("- " + html.unescape(", ".join(keys)))
            keys = []
    return f"**{header}:**\n" + "\n".join(lines) + (f"\n\n{remark}." if remark else "")


def references(paragraph):
    """ "See:<br><i>authors</i><br><b>"title"</b><br>reference<br>..." as a list."""
    lines, about = ["**References**"], ""
    texts = iter(paragraph.split("<br>"))
    for text in texts:
        if text.startswith("<i>"):
            title = next(texts)[len("<b>") : -len("</b>")]
            lines.append(f"- {about}{markdown(text)}: {title}, {html.unescape(next(texts))}")
            about = ""
        else:
            about = "" if text == "See:" else text + " "
    return "\n".join(lines)


def paragraphs(element):
    """The paragraphs of a filter's description: what it does, what it returns, references."""
    does, returns, cites = [], [], []
    for paragraph in filter(
        None, (re.sub("(<br>)+$", "", p).strip() for p in element.get("info").split("<br><br>"))
    ):
        if paragraph.startswith("Returned"):
            returns.append(returned(paragraph))
        elif "<b>warnings</b>" in paragraph:
            continue  # said once, on top of the page
        elif '</i><br><b>"' in paragraph:
            cites.append(references(paragraph))
        else:
            does.append(markdown(paragraph))
    return does, returns, cites


def default(parameter):
    value = parameter.get("value")
    if parameter.get("type") == "RichEnum":
        return parameter.get(f"enum_val{value}")
    if parameter.get("type") == "RichBool":
        return {"true": "yes", "false": "no"}[value]
    if parameter.get("name") == "root_layer":  # its default depends on the project
        return "the current layer, or the first with a map"
    if parameter.get("name") == "cells":
        return "by the coarsest mesh"
    return value or "empty"


def kind(parameter):
    if parameter.get("type") == "RichEnum":
        text = " / ".join(
            parameter.get(f"enum_val{i}") for i in range(int(parameter.get("enum_cardinality")))
        )
    else:
        text = TYPES[parameter.get("type")]
    return text + (", *advanced*" if parameter.get("advanced") == "true" else "")


def row(*cells):
    return (
        "| "
        + " | ".join(cell.replace("|", "\\|").replace("\n", " ").strip() for cell in cells)
        + " |"
    )


def section(element):
    """A filter's part of the page."""
    does, returns, cites = paragraphs(element)
    parameters = [
        row(f"`{p.get('name')}`", p.get("description"), kind(p), default(p), p.get("tooltip"))
        for p in element.findall("Param")
    ]
    table = "\n".join(
        [row("parameter", "in the dialog", "values", "default", ""), row(*["---"] * 5), *parameters]
    )
    blocks = [
        f"## {element.get('name')}",
        f"`{element.get('python_name')}`; in MeshLab: Filters, "
        f"*{'*, and *'.join(menus(element))}*.",
        *does,
        table if parameters else "No parameters.",
        *returns,
        *cites,
    ]
    return "\n\n".join(blocks) + "\n"


def page(folder):
    """The text of docs/filters.md. folder: of the plugins, which PyMeshLab must have loaded."""
    filters = [f for plugin in PLUGINS for f in descriptions(Path(folder) / plugin)]
    table = [
        row(
            f"[{f.get('name')}](#{anchor(f.get('name'))})",
            f"`{f.get('python_name')}`",
            "; ".join(menus(f)),
        )
        for f in filters
    ]
    return wrapped(HEADER + "\n".join(table) + "\n\n" + "\n".join(section(f) for f in filters))


if __name__ == "__main__":
    for plugin in PLUGINS:
        pymeshlab.load_plugin(str(Path(sys.argv[1]).resolve() / plugin))
    text = page(sys.argv[1])
    if len(sys.argv) > 2:
        Path(sys.argv[2]).write_text(text)
    else:
        print(text, end="")
