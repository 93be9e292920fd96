# SPDX-License-Identifier: GPL-3.0-only
"""The pages of the project, and what is in them: headings, links, pictures, blocks of code."""

import re
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import List, Optional

PROJECT = Path(__file__).resolve().parents[2]
NOT_RUN = re.compile(r"<!-- not run: (.+) -->")


@dataclass(frozen=True)
class Block:
    """A fenced block of code. `line` is that of its first line in the page; `not_run` the reason
    that a comment before it gives."""

    language: str
    line: int
    code: str
    not_run: Optional[str] = None


class Page:
    def __init__(self, path):
        self.path = Path(path)
        self.name = str(self.path.relative_to(PROJECT))
        self.lines = self.path.read_text(encoding="utf-8").splitlines()

    @cached_property
    def blocks(self) -> List[Block]:
        found, start = [], None
        for number, line in enumerate(self.lines):
            if not line.lstrip().startswith("```"):
                continue
            if start is None:
                start = number
                continue
            before = NOT_RUN.fullmatch(self.lines[start - 1].strip()) if start else None
            found.append(
                Block(
                    self.lines[start].strip().strip("`"),
                    start + 2,
                    "\n".join(self.lines[start + 1 : number]) + "\n",
                    before and before[1],
                )
            )
            start = None
        assert start is None, f"{self.name}:{start + 1}: a block of code does not end"
        return found

    @cached_property
    def prose(self) -> str:
        """The page without its blocks of code and indented formulas."""
        kept, inside = [], False
        for line in self.lines:
            if line.lstrip().startswith("```"):
                inside = not inside
            elif not inside and not line.startswith("    "):
                kept.append(line)
        return "\n".join(kept)

    @cached_property
    def headings(self) -> List[str]:
        return [
            re.sub(r"^#+ ", "", line).strip()
            for line in self.prose.splitlines()
            if re.match(r"#+ ", line)
        ]

    @cached_property
    def anchors(self) -> List[str]:
        """Of the headings, as GitHub makes them."""
        return [anchor(heading) for heading in self.headings]

    @cached_property
    def links(self) -> List[str]:
        """Targets of links and pictures, without those of other sites."""
        prose = re.sub(r"`[^`]*`", "", self.prose)
        targets = re.findall(r"\]\(([^)\s]+)\)", prose) + re.findall(
            r'(?:src|href)="([^"]+)"', prose
        )
        return [target for target in targets if not re.match(r"https?://", target)]

    @cached_property
    def inline_code(self) -> List[str]:
        return re.findall(r"`([^`\n]+)`", self.prose)


def anchor(heading):
    """The anchor that GitHub gives a heading."""
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("`", "").replace("*", "")
    return re.sub(r"[^\w\- ]", "", text.lower()).replace(" ", "-")


def all_pages() -> List[Page]:
    folders = [PROJECT, PROJECT / "docs", PROJECT / "docs/images", PROJECT / "sample_projects"]
    return [Page(path) for folder in folders for path in sorted(folder.glob("*.md"))]
