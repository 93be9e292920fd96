# SPDX-License-Identifier: GPL-3.0-only
"""The steps of a study by name, and what they cost."""

from __future__ import annotations

import os
import resource
import sys
import time
import traceback
from pathlib import Path
from typing import Callable, Dict, Sequence

from ..errors import SpherePropagationError
from . import atlas, cycles, importing, landmarks, merging, spatial, store, study_report, worker

COSTS = Path("costs")
PARENT = "SPHERE_PROPAGATION_PARENT"  # the engine's process, as the Snakefile says it
STEPS: Dict[str, Callable[..., int]] = {
    "import": importing.run,
    "atlas": atlas.run,
    "landmarks": landmarks.run,
    "scatter": merging.run_scatter,
    "merge": lambda level, place: merging.run_merge(int(level), place),
    "model": spatial.run_model,
    "scores": spatial.run_scores,
    "cycle": cycles.run,
    "report": study_report.run,
}


def main(words: Sequence[str]) -> int:
    """Runs one; 0 done, 1 it could not be done, 2 there is none of this name."""
    step, arguments = (words[0], words[1:]) if words else ("", ())
    if step not in STEPS:
        print(f"steps: {', '.join(STEPS)}", file=sys.stderr)
        return 2
    worker.die_with_parent(int(os.environ.get(PARENT, os.getppid())))
    began = time.time()
    try:
        count = STEPS[step](*arguments)
    except (SpherePropagationError, worker.Failed) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    except Exception:
        traceback.print_exc()
        return 1
    _write_costs("-".join([step, *arguments]), count, time.time() - began)
    return 0


def _write_costs(name: str, count: int, wall: float) -> None:
    """Beside the results, which are the same from run to run; costs are not."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    store.write_json(
        COSTS / f"{name}.json",
        {
            "cpu_seconds": round(sum(one.ru_utime + one.ru_stime for one in used), 3),
            "wall_seconds": round(wall, 3),
            "max_rss_mb": round(max(one.ru_maxrss for one in used) / 1024, 1),
            "count": count,
        },
    )
