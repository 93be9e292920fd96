# SPDX-License-Identifier: GPL-3.0-only
"""C++ on the pages compiles: each page's blocks as one function, with the variables that
docs/cpp.md names. A block after `<!-- example: NAME -->` is a part of examples/NAME.cpp instead."""

import re
import shutil
import subprocess
import textwrap

import pytest
from pages import PROJECT, all_pages

PAGES = [page for page in all_pages() if any(b.language == "cpp" for b in page.blocks)]
EXAMPLE = re.compile(r"<!-- example: (\w+) -->")
HEADERS = """\
#include <iostream>
#include "vcg_ext/model/training_set.h"
#include "vcg_ext/root_map/root_map.h"
#include "vcg_ext/sequence/sequence.h"
#include "vcg_ext/volume/label_grid.h"
"""
VARIABLES = (
    "const Points& vertices, const Triangles& faces, const Points& positions, "
    "const ClosedSurface& surface, const MappedSurface& mapped, const Sequence& sequence, "
    "const TrainingSet& shapes, const LabelGrid& labels"
)


def example_of(page, block):
    before = EXAMPLE.fullmatch(page.lines[block.line - 3].strip())
    return before and before[1]


def eigen():
    """The compiler's flags for Eigen."""
    try:
        said = subprocess.run(
            ["pkg-config", "--cflags-only-I", "eigen3"], capture_output=True, text=True, check=True
        ).stdout
        return said.replace("-I", "-isystem ").split()
    except (OSError, subprocess.CalledProcessError):
        return ["-isystem", "/usr/include/eigen3"]


def test_pages_compile(tmp_path):
    if not shutil.which("c++"):
        pytest.skip("no compiler")
    includes, functions = [], []
    for page in PAGES:
        body = []
        for block in page.blocks:
            if block.language != "cpp" or example_of(page, block):
                continue
            lines = block.code.splitlines()
            includes += [line for line in lines if line.startswith("#include")]
            body.append(f'#line {block.line} "{page.name}"')
            body += ["" if line.startswith("#include") else line for line in lines]
        if body:
            functions.append(
                f"void page{len(functions)}({VARIABLES}) {{\n" + "\n".join(body) + "\n}"
            )
    source = tmp_path / "pages.cpp"
    text = HEADERS + "\n".join(sorted(set(includes))) + "\nusing namespace sphere_propagation;\n"
    source.write_text(text + "\n".join(functions) + "\n")
    done = subprocess.run(
        ["c++", "-std=c++17", "-fsyntax-only", "-Wall", "-Wextra", "-Werror", "-Wno-unused"]
        + ["-Wno-unused-parameter", "-Wno-unused-variable", f"-I{PROJECT}", *eigen(), str(source)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-3000:]


def test_examples_on_pages_are_the_examples():
    found = 0
    for page in PAGES:
        for block in page.blocks:
            name = block.language == "cpp" and example_of(page, block)
            if name:
                found += 1
                text = (PROJECT / "examples" / f"{name}.cpp").read_text()
                assert textwrap.indent(block.code, "  ") in text, f"{page.name}:{block.line}"
    assert found


def test_every_algorithm_shows_its_calls():
    """In both languages, on the pages that the list of algorithms names."""
    listed = (PROJECT / "docs/README.md").read_text().split("## Algorithms")[1]
    for name in re.findall(r"\]\((\w+\.md)\)", listed):
        page = next(page for page in all_pages() if page.name == f"docs/{name}")
        assert {"cpp", "python"} <= {block.language for block in page.blocks}, page.name
