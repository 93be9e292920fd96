# SPDX-License-Identifier: GPL-3.0-only
"""Subjects whose files are byte copies of others', by other names: a shape that counts twice."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, Iterator, List, Mapping, Sequence, Tuple

from . import likeness, store
from .landmarks import LANDMARKS


def found_in(folder: Path, chunks: Sequence[str], plan: Mapping[str, Any]) -> Dict[str, str]:
    """Subject -> of whose files its own are copies, in words, of those that are in the models.
    plan: plan/model.json."""
    seen, shared = set(), set()
    for _, file in _files(folder, chunks, plan):
        short = int(file["sha256"][:15], 16)  # 50,000 subjects have 2.5 million files
        if short in seen:
            shared.add(file["sha256"])
        seen.add(short)
    if not shared:
        return {}
    groups: Dict[str, List[Tuple[str, str]]] = {}
    for name, file in _files(folder, chunks, plan):
        if file["sha256"] in shared:
            groups.setdefault(file["sha256"], []).append((name, file["file"]))
    pairs: Dict[str, Dict[str, List[Tuple[str, str]]]] = {}
    for its in groups.values():
        for name, file in its if len(its) > 1 else ():
            other, theirs = next(one for one in its if one != (name, file))
            pairs.setdefault(name, {}).setdefault(other, []).append((file, theirs))
    return {
        name: "; ".join(_words(name, *one) for one in its.items()) for name, its in pairs.items()
    }


def _files(
    folder: Path, chunks: Sequence[str], plan: Mapping[str, Any]
) -> Iterator[Tuple[str, Mapping[str, str]]]:
    excluded = set(plan["exclude"])
    for chunk in chunks:
        for record in store.read_json(folder / LANDMARKS / f"{chunk}.json")["subjects"]:
            out = record["failed"] or record["subject"] in excluded
            if out or likeness.left_out(record, plan["parameters"]):
                continue
            for file in record["files"]:
                if file["sha256"]:
                    yield record["subject"], file


def _words(name: str, other: str, files: Sequence[Tuple[str, str]]) -> str:
    (file, theirs), more = files[0], len(files) - 1
    rest = f", and {more} more of its files are copies" if more else ""
    if name == other:
        return f"its files {file} and {theirs} are the same, byte by byte{rest}: is one misplaced?"
    return (
        f"its file {file} is the same, byte by byte, as {theirs} of {other}{rest}: a subject that "
        "counts twice is a wrong model; exclude one of them"
    )
