#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-only
"""Wraps the prose of Markdown files at 100 columns: wrap_markdown.py [--check] FILE...

Tables, code, headings, HTML and pictures stay as they are; no link's target, picture and inline
code is broken. --check changes nothing, names the files that are not wrapped, and returns 1.
"""

import re
import sys
import textwrap
from pathlib import Path

COLUMNS = 100
FENCE = re.compile(r"\s*(```+|~~~+)")
ITEM = re.compile(r"(\s*)([-+*]|\d+[.)])(\s+)")
KEPT = re.compile(r"\s*(\||#|<|!\[)")  # tables, headings, HTML, pictures
INDENTED_CODE = re.compile(r"( {4}|\t)\S")
UNBROKEN = re.compile(r"`[^`]*`|!\[[^\]]*\]\([^)]*\)|(?<=\])\([^)]*\)")
# What would begin a list, a heading, a quotation or an underlining at the start of a line.
BEGINS_A_BLOCK = re.compile(r"\s*([-+*]|\d+[.)]|#+|>|=+)\s")
NO_BREAK = "\0"  # stands for a blank at which no line may end


def wrapped(text: str) -> str:
    """The page with its prose wrapped."""
    lines, paragraph, fence = [], _Paragraph(), None
    for line in text.split("\n"):
        opening = FENCE.match(line)
        if fence or opening:
            lines += paragraph.take()
            lines.append(line)
            if not fence:
                fence = opening[1]
            elif line.strip().startswith(fence):
                fence = None
        elif not line.strip() or KEPT.match(line):
            lines += [*paragraph.take(), line]
        elif INDENTED_CODE.match(line) and not paragraph.lines:
            lines.append(line)
        else:
            item = ITEM.match(line)
            if item:
                lines += paragraph.take()
            paragraph.add(line, item)
            if line.endswith("  "):  # a line break of the page's own
                lines += paragraph.take()
                lines[-1] += "  "
    return "\n".join(lines + paragraph.take())


class _Paragraph:
    """The lines of a paragraph or of a list's item that have been read so far."""

    def __init__(self):
        self.lines, self.first, self.rest = [], "", ""  # first, rest: what the lines begin with

    def add(self, line, item):
        if item:
            self.first, self.rest = item[0], " " * len(item[0])
            line = line[item.end() :]
        elif not self.lines:
            self.first = self.rest = re.match(r"\s*", line)[0]
        self.lines.append(line.strip())

    def take(self):
        """The lines, wrapped; none are left."""
        text = UNBROKEN.sub(lambda part: part[0].replace(" ", NO_BREAK), " ".join(self.lines))
        self.lines = []
        if not text:
            return []
        lines = textwrap.wrap(
            text,
            COLUMNS,
            initial_indent=self.first,
            subsequent_indent=self.rest,
            break_long_words=False,
            break_on_hyphens=False,
        )
        for i in range(1, len(lines)):
            while BEGINS_A_BLOCK.match(lines[i]):  # that word goes to the line before
                word, _, lines[i] = lines[i].strip().partition(" ")
                lines[i - 1] += " " + word
                lines[i] = self.rest + lines[i]
        return [line.replace(NO_BREAK, " ") for line in lines]


def main(arguments):
    check = arguments[:1] == ["--check"]
    paths = [Path(name) for name in arguments[check:]]
    if not paths or any(str(path).startswith("-") for path in paths):
        sys.exit(__doc__)
    different = []
    for path in paths:
        text = path.read_text(encoding="utf-8")
        if wrapped(text) != text:
            different.append(path)
            if not check:
                path.write_text(wrapped(text), encoding="utf-8")
    if check:
        for path in different:
            print(f"{path}: not wrapped at {COLUMNS} columns (scripts/lint --fix)")
    return int(check and bool(different))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
