# SPDX-License-Identifier: GPL-3.0-only
"""What a run was made with, for whoever wants to make it again: command line, versions, inputs."""

from __future__ import annotations

import json
import os
import platform
import shlex
from datetime import datetime, timezone
from pathlib import Path
from typing import Any, Dict, List, Mapping, NamedTuple, Sequence, Tuple

import numpy as np

from . import citation, plugin
from .digest import digest
from .version import version


class Input(NamedTuple):
    """A file that was read."""

    path: Path
    sha256: str


class Provenance(NamedTuple):
    """How a result was made."""

    command: str  # empty where there was none
    facts: Dict[str, str]  # what it depends on beside its inputs
    versions: Dict[str, str]
    inputs: List[Input]

    def saying(self, facts: Mapping[str, Any]) -> Provenance:
        """With what is known later."""
        return self._replace(
            facts={name: str(value) for name, value in facts.items() if value != ""}
        )

    def rows(self) -> List[Tuple[str, str]]:
        """For a table."""
        return [
            *([("command", self.command)] if self.command else []),
            *self.facts.items(),
            *self.versions.items(),
            ("cite the program", citation.program()),
            ("cite the paper", citation.PAPER),
        ]

    def as_json(self) -> str:
        """The same, for programs."""
        inputs = [{"file": str(path), "sha256": digest} for path, digest in self.inputs]
        return json.dumps({**dict(self.rows()), "inputs": inputs}, indent=2, ensure_ascii=False)


def provenance(
    command: Sequence[str], facts: Mapping[str, Any], paths: Sequence[Path]
) -> Provenance:
    """Of a run that begins now. command: its words, empty where there was none."""
    return Provenance(
        shlex.join(["sphere-propagation", *command]) if command else "",
        {},
        {
            "date": _now().isoformat(timespec="seconds"),
            "version": f"sphere-propagation {version()}, pymeshlab "
            f"{plugin.pymeshlab_version() or 'of unknown version'}, numpy {np.__version__}, python "
            f"{platform.python_version()}, {platform.system()} {platform.machine()}",
        },
        [Input(path, digest(path)) for path in paths],
    ).saying(facts)


def _now() -> datetime:
    epoch = os.environ.get("SOURCE_DATE_EPOCH", "")
    if epoch.isdecimal():  # https://reproducible-builds.org: files that do not differ by the time
        return datetime.fromtimestamp(int(epoch), timezone.utc)
    return datetime.now(timezone.utc).astimezone()
