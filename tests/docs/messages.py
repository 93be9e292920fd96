# SPDX-License-Identifier: GPL-3.0-only
"""The words for the user in the sources: what errors, warnings and log lines say, but for what
varies.

    python messages.py     lists them: file, words

The errors of vcg_ext come from its own catalogue, sentence by sentence (`faults`), and so does what
host/ says (`said_by`). What filters say beside their catalogues is written in pieces, as
`"Layer \\"" + name + "\\": it is empty."`, and a piece that says something (three words or more)
must be on the page docs/errors.md: in C++ every string of a filter that is no description of a
parameter or of a filter, in Python and in the scripts what goes into errors and warnings.
"""

import ast
import ctypes
import json
import re
from typing import Iterator, List, Tuple

from pages import PROJECT

VARIES = "…"
STRING = r'"((?:[^"\\\n]|\\.)*)"'
DESCRIPTIONS = (
    "FilterDescription describe() const override {",
    "parameters(const host::Layers& layers) const override {",
    "parameters(const host::Layers&) const override {",
    "::describe() const {",
    "patterns[]{",  # what the dialog calls them
    "schemes[]{",
    "connectivities[]{",
)
IN_PYTHON = re.compile(r".*(Error|warn|Warning|note|exit)$")


def catalogue():
    """The errors of vcg_ext and the menu entries that they name: see filter_descriptions.cpp."""
    return json.loads(_library().error_sentences().decode())


def said_by(plugin):
    """What the filters of a plugin, and of the one that reads label volumes beside it, say, as far
    as it is in the catalogues (messages.def): theirs and that of host/."""
    files = [plugin, plugin.with_name("libfilter_label_volume.so")]
    said = [_library().plugin_messages(str(file).encode()).decode() for file in files]
    return "\n".join(said).splitlines()


def menu_entries(file):
    """Of a plugin's filters by their names in Python those in MeshLab's menus."""
    lines = _library().filter_names(str(file).encode()).decode().splitlines()
    return dict(line.split("\t") for line in lines)


def _library():
    import pymeshlab  # noqa: F401  whose MeshLab ours uses

    library = ctypes.CDLL(str(PROJECT / "build/pymeshlab/tests/libfilter_descriptions.so"))
    for function in (
        library.error_sentences,
        library.filter_names,
        library.plugin_messages,
    ):
        function.restype = ctypes.c_char_p
    return library


def faults(host="MeshLab 2025.07"):
    """Of every fault by its name the sentence that users of a host read, and the remedy in it."""
    return {fault["name"]: fault["hosts"][host] for fault in catalogue()["faults"]}


def says_something(piece: str) -> bool:
    return len(re.findall(r"(?<!\S)[^\sA-Za-z]*[A-Za-z]{2,}", piece)) >= 3 and not piece.startswith(
        ("^", "\\")
    )  # regular expressions


def pieces(text: str) -> List[str]:
    """What stays the same in a message, without the blanks and the punctuation at its ends."""
    return [
        p
        for p in (part.strip(" ,:;.()\"'\n") for part in re.sub(r"\s+", " ", text).split(VARIES))
        if says_something(p)
    ]


def end_of(text: str, start: int) -> int:
    """The index behind the bracket that closes the one at `start`."""
    depth, at = 0, start
    while True:
        string = re.compile(STRING + r"|'\\?.'").match(text, at)
        if string:
            at = string.end()
            continue
        depth += (text[at] in "({[") - (text[at] in ")}]")
        at += 1
        if depth == 0:
            return at


def without_descriptions(code: str) -> str:
    for head in DESCRIPTIONS:
        while head in code:
            start = code.index(head)
            code = code[:start] + code[end_of(code, start + len(head) - 1) :]
    return code


def with_plurals(code: str) -> str:
    """counted(n, "edge", "edges") as what it says."""
    while (start := code.find("counted(")) >= 0:
        end = end_of(code, start + len("counted"))
        strings = re.findall(STRING, code[start:end])
        code = (
            code[:start] + (f'"{VARIES} {strings[-1]}"' if len(strings) == 2 else "") + code[end:]
        )
    return code


def in_cpp(code: str) -> Iterator[str]:
    code = re.sub(r"^\s*#.*$|//.*$", "", code, flags=re.M)
    code = with_plurals(without_descriptions(code))
    code = re.sub(r"(requireRange\(\s*)" + STRING, r"\1", code)  # what is out of range is a gap
    text, end = "", None
    for string in re.finditer(STRING, code):
        joined = end is not None and re.fullmatch(r"\s*\+?\s*", code[end : string.start()])
        if not joined:
            yield text
            text = ""
        text += string[1].replace('\\"', '"').replace("\\n", "\n")
        end = string.end()
    yield text


def in_python(code: str) -> Iterator[str]:
    def said(node):
        if isinstance(node, ast.Constant):
            return node.value if isinstance(node.value, str) else ""
        if isinstance(node, ast.JoinedStr):
            return "".join(said(part) for part in node.values)
        if isinstance(node, ast.BinOp):
            return said(node.left) + said(node.right)
        if isinstance(node, ast.BoolOp):  # words, or others where there are none
            return " ".join(map(said, node.values))
        if isinstance(node, ast.Call) and getattr(node.func, "attr", "") == "strip":
            return said(node.func.value)
        return VARIES

    for node in ast.walk(ast.parse(code)):
        if isinstance(node, ast.Call) and IN_PYTHON.match(
            getattr(node.func, "id", getattr(node.func, "attr", ""))
        ):
            for argument in node.args:
                yield said(argument)


def in_shell(code: str) -> Iterator[str]:
    for said in re.findall(r'\b(?:die|say) "((?:[^"\\]|\\.)*)"', code):
        if not said.startswith("=="):  # headlines of scripts/test
            yield re.sub(
                r"\$\((?:[^()]|\([^()]*\))*\)|\$\{[^}]*\}|\$[\w@*#]+|\$\S",
                VARIES,
                said.splitlines()[0],
            )


def messages() -> List[Tuple[str, str]]:
    """All pieces of all messages: list of (file, words)."""
    found = []
    for folder in sorted(PROJECT.glob("filter_*")):
        for path in sorted(folder.rglob("*")):
            if path.suffix in (".h", ".cpp"):
                found += [(path, text) for text in in_cpp(path.read_text())]
    for path in sorted((PROJECT / "python").rglob("*.py")):
        found += [(path, text) for text in in_python(path.read_text())]
    for path in sorted((PROJECT / "scripts").iterdir()):
        if path.is_file() and path.suffix in ("", ".sh"):
            found += [(path, text) for text in in_shell(path.read_text())]
    return [
        (str(path.relative_to(PROJECT)), piece) for path, text in found for piece in pieces(text)
    ]


if __name__ == "__main__":
    for name, fault in faults().items():
        print(f"{name}: {fault['sentence']}")
    for file, words in messages():
        print(f"{file}: {words}")
