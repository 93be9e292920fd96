# SPDX-License-Identifier: GPL-3.0-only
"""Runs blocks of Python in one namespace, as a reader who copies them one after another:
run_blocks.py < JSON

JSON: list of [page, line, code]. A traceback names the page and its line.
"""

import json
import linecache
import sys

namespace = {"__name__": "__main__"}
for page, line, code in json.load(sys.stdin):
    text = "\n" * (line - 1) + code
    linecache.cache[page] = (len(text), None, text.splitlines(keepends=True), page)
    exec(compile(text, page, "exec"), namespace)
