#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-only
"""Prints how good the root map is and what it costs, beside the unit u and, where one is given,
beside another program.

    root_map.py [--program EXE] [--data DATA] [--peer EXE [--peer-arguments "A B ..."]]
                [--threads N] [--series LARGEST] [MESH ...]

    EXE     root_map_benchmark, which scripts/measure-root-map builds
            (default: build/pymeshlab/benchmarks/root_map_benchmark)
    MESH    PLY files or what the program makes (blob:22, limbs:20:2, ...); default: the data's
            classic meshes, hearts and skulls, and made limbs
    peer    a program called as EXE ARGUMENTS INPUT.ply OUTPUT.ply; where ARGUMENTS contain {input}
            or {output}, these stand for the files instead. OUTPUT has the vertices in the same
            order and properties px, py, pz (unit vectors).
    series  the cost from 5 thousand vertices to about LARGEST (default 1000000; 0: none), and its
            exponent

CPU seconds, warm, the least of three runs; u: CPU seconds of one Eigen SimplicialLDLT of the mesh's
Laplacian, by the same program with the same flags. The area sd and the angle error are the
yardstick's.
"""

import argparse
import math
import re
import resource
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

from setting import DATA, PROJECT


def figures(program, *arguments):
    """What root_map_benchmark says of one mesh: name -> number; None where it failed."""
    done = subprocess.run(
        [program, *map(str, arguments)], capture_output=True, text=True, check=False
    )
    line = done.stdout.strip().splitlines()[-1] if done.stdout.strip() else done.stderr
    if done.returncode != 0:
        print(f"  {line}", file=sys.stderr)
        return None
    return {name: float(value) for name, value in re.findall(r"(\w+)=([-+.\deE]+)", line)}


def cpu_of_children():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def peer_figures(program, peer, arguments, mesh, folder):
    """The least CPU seconds of three runs of the peer, reading and writing files included, and the
    figures of its map."""
    given, made = Path(folder) / "given.ply", Path(folder) / "made.ply"
    figures(program, "--make", given, mesh)
    words = [word.format(input=given, output=made) for word in shlex.split(arguments)]
    if "{output}" not in arguments:
        words += [str(given), str(made)]
    seconds = math.inf
    for _ in range(3):
        made.unlink(missing_ok=True)
        before = cpu_of_children()
        subprocess.run(
            [peer, *words], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False
        )
        seconds = min(seconds, cpu_of_children() - before)
    if not made.exists():
        return None
    found = figures(program, "--measure", made)
    if found:
        found["cpu"] = seconds
    return found


def cells(found, unit):
    if found is None:
        return ["", "", "", "", ""]
    return [
        f"{found['sd']:.4f}",
        f"{found['angle']:.1f}",
        f"{found['flips']:.0f}",
        f"{found['cpu']:.3f}",
        f"{found['cpu'] / unit:.1f}",
    ]


def default_meshes(data):
    meshes = sorted((data / "classic").glob("*.ply"))
    meshes += (
        sorted((data / "heart_cine").glob("endo_*.ply"))[::10]
        + sorted((data / "heart_truth/mc").glob("*.ply"))[::12]
    )
    meshes += sorted((data / "finch_skulls").glob("*.ply"))
    return [str(m) for m in meshes] + [
        "limbs:20:2",
        "limbs:10:3",
        "tree:2:4:2",
        "tree:3:3:2",
        "disc:30",
        "coil:3:24:200",
        "blob:22",
    ]


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--program", default=PROJECT / "build/pymeshlab/benchmarks/root_map_benchmark"
    )
    parser.add_argument(
        "--data",
        type=Path,
        default=DATA,
    )
    parser.add_argument("--peer")
    parser.add_argument("--peer-arguments", default="")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--series", type=int, default=1000000, metavar="LARGEST")
    parser.add_argument("meshes", nargs="*")
    options = parser.parse_args()

    header = ["mesh", "vertices", "sd", "angle", "flips", "CPU s", "/ u"]
    if options.peer:
        header += [f"peer: {name}" for name in header[2:]]
    print("| " + " | ".join(header) + " |")
    print("| " + " | ".join(["---"] * len(header)) + " |")
    for mesh in options.meshes or default_meshes(Path(options.data)):
        found = figures(options.program, "--threads", options.threads, "--repeat", 3, mesh)
        if found is None:
            continue
        row = [Path(mesh).name, f"{found['vertices']:.0f}", *cells(found, found["u"])]
        if options.peer:
            with tempfile.TemporaryDirectory() as folder:
                row += cells(
                    peer_figures(
                        options.program, options.peer, options.peer_arguments, mesh, folder
                    ),
                    found["u"],
                )
        print("| " + " | ".join(row) + " |", flush=True)

    if options.series:
        print("\n| series | vertices | sd | CPU s | wall s | MB | exponent from the first |")
        print("| --- | --- | --- | --- | --- | --- | --- |")
        blobs = [
            f"blob:{round(math.sqrt(n / 10))}"
            for n in (5000, 20000, 100000, 300000, 1000000, 3000000, 10000000)
            if n <= options.series
        ]
        limbs = [f"limbs:6:{k}" for k in range(3, 8) if 80 * 4**k <= 1.2 * options.series]
        for series in (blobs, limbs):
            first = None
            for mesh in series:
                small = options.series and float(mesh.split(":")[-1]) < 50
                found = figures(
                    options.program,
                    "--threads",
                    options.threads,
                    "--unit",
                    0,
                    "--repeat",
                    3 if small else 1,
                    mesh,
                )
                if found is None:
                    continue
                first = first or found
                grown = math.log(found["vertices"] / first["vertices"])
                exponent = (
                    f"{math.log(found['cpu'] / first['cpu']) / grown:.3f}" if grown > 0 else ""
                )
                print(
                    f"| {mesh} | {found['vertices']:.0f} | {found['sd']:.4f} | {found['cpu']:.2f} "
                    f"| {found['wall']:.2f} | {found['MB']:.0f} | {exponent} |",
                    flush=True,
                )


if __name__ == "__main__":
    main()
