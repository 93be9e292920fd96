#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-only
"""Prints how good propagation is and what it costs, in the unit u of the same run, and the paper's
Table 1 run again.

    propagation.py [--program EXE] [--data DATA] [--seeds N] [--threads N] [--peer PROGRAM]
                   [--curve FILE] [--state N] [--only PART ...]

    EXE     propagation_benchmark, which scripts/measure-propagation builds
            (default: build/pymeshlab/benchmarks/propagation_benchmark)
    DATA    folder with heart_cine and heart_truth, the yardstick beside it
            (default SPHERE_PROPAGATION_DATA, else ../shared/data)
    seeds   how many phantoms of each kind are averaged (default 1)
    peer    a program called as PROGRAM ROOT_MAP.ply LAYER.ply ... -o FOLDER, which writes
            landmarks_TT.ply; run in the first table
    curve   PNG file, what the part uncertainty draws: shares promised and found
    PART    of: sequences, paper, disturbed, orders (shuffled phases and a star, the motion's prior
            learnt or fixed), other (phantoms of another make and other organs: made_motions.py;
            data/classic, data/finch_skulls), made (each of these by itself, a row a seed, meshed by
            the random numbers of --state N, default 5; not run unless named), uncertainty (is it
            right?)

Errors: distance of landmarks from the same material points, mm, worst / mean over phases; root 0,
cyclic order. Beside the methods stands what no model is needed for, the closest-point walk: from
phase to phase, both ways from the root, each landmark goes to the closest point of the next
surface; and MeshMonk, where Python has it (pip install meshmonk), with its default settings. CPU:
seconds of all threads; u: CPU seconds of one Eigen SimplicialLDLT of the root's Laplacian. The
least of three runs, of other programs one.
"""

import argparse
import random
import re
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import made_motions
import numpy as np
from setting import DATA, PROJECT, yardstick

try:
    import meshmonk
except ImportError:
    meshmonk = None

LANDMARKS = 1002
# Table 1 of the paper: phases, vertices of the root and on average, seconds for the root and for
# the propagation (one core, 2.4 GHz).
PAPER = ((25, 4351, 3033, 54, 9), (20, 5721, 4035, 68, 10))
METHODS = {"published": "As published", "robust": "Robust"}
# That the factors of the uncertainty were chosen on (docs/propagation_robust.md).
CHOSEN_ON = {
    "real patient",
    "phantom, cavity 0",
    "phantom, wall 0",
    "other kind, cavity 0",
    "other kind, wall 0",
    "warped ventricle 1",
    "warped hippocampus 1",
}
WARPED = {
    "ventricle": "heart_cine/endo_00.ply",
    "hippocampus": "classic/hippocampus.ply",
    "skull": "finch_skulls/G.ConirostrisE.ply",
}
MESHMONK_WAYS = {"from phase to phase": True, "from the root": False}  # is it by phases?


def run(
    options,
    files,
    method="robust",
    repeat=3,
    root_map=None,
    may_fail=False,
    more=(),
    with_uncertainty=False,
):
    """What propagation_benchmark says (name -> number), and the landmarks, layer by layer; None
    where it failed and may."""
    with tempfile.TemporaryDirectory() as folder:
        landmarks, uncertainty = Path(folder) / "landmarks", Path(folder) / "uncertainty"
        more = [*more, *(["--uncertainty", uncertainty] if with_uncertainty else [])]
        more = [*more, *(["--root-map", root_map] if root_map else [])]
        done = subprocess.run(
            [
                options.program,
                "--method",
                method,
                "--repeat",
                str(repeat),
                "--threads",
                str(options.threads),
                "--landmarks",
                landmarks,
                *more,
                *files,
            ],
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode != 0 and may_fail:
            return None
        if done.returncode != 0:
            sys.exit(f"{options.program}: {done.stdout} {done.stderr}")
        figures = {
            name: float(value) for name, value in re.findall(r"(\w+)=([-+.\deE]+)", done.stdout)
        }
        if with_uncertainty:
            figures["uncertainty"] = np.fromfile(uncertainty).reshape(len(files), LANDMARKS)
        return figures, list(np.fromfile(landmarks).reshape(len(files), LANDMARKS, 3))


def run_peer(peer, root_map, files, measure):
    """CPU seconds of all it does, and its landmarks."""
    with tempfile.TemporaryDirectory() as folder:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(
            [sys.executable, peer, root_map, *files[1:], "-o", folder]
            if peer.endswith(".py")
            else [peer, root_map, *files[1:], "-o", folder],
            stdout=subprocess.DEVNULL,
            check=True,
        )
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        landmarks = [
            measure.points(measure.read_ply(file)[0])
            for file in sorted(Path(folder).glob("landmarks_*.ply"))
        ]
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, landmarks


def both_ways(count):
    """Each layer but the root, 0, with the one before it on the way from there, which comes
    first."""
    forward, back = range(1, count // 2 + 1), range(count - 1, count // 2, -1)
    return [(t, t - 1) for t in forward] + [(t, (t + 1) % count) for t in back]


def closest_point_walk(measure, files, first):
    """Landmarks, layer by layer. first: those on the root, layer 0."""
    landmarks = [first] * len(files)
    for t, before in both_ways(len(files)):
        vertex, f = measure.read_ply(files[t])
        v = measure.points(vertex)
        face, weights, _ = measure.closest_points(v, f, landmarks[before])
        landmarks[t] = np.einsum("pk,pkj->pj", weights, v[f[face]])
    return landmarks


def meshmonk_landmarks(measure, files, first, by_phases):
    """CPU seconds, and landmarks, layer by layer, by MeshMonk's non-rigid registration as it comes:
    the root's mesh is registered to each phase from where it lies on the one before (by_phases) or
    from where it lies, and takes the landmarks along."""
    start = time.process_time()
    surfaces = [(measure.points(v), f.astype(np.int32)) for v, f in map(measure.read_ply, files)]
    v, faces = surfaces[0]
    face, weights, _ = measure.closest_points(v, faces, first)
    shapes, landmarks = [v] * len(files), [first] * len(files)
    for t, before in both_ways(len(files)):
        floating, target = (shapes[before] if by_phases else v), surfaces[t]
        found = meshmonk.pyramid_register(
            floating_features=meshmonk.features_from_vertices(floating, faces),
            floating_faces=faces,
            floating_flags=np.ones(len(floating), np.float32),
            target_features=meshmonk.features_from_vertices(*target),
            target_faces=target[1],
            target_flags=np.ones(len(target[0]), np.float32),
        )
        shapes[t] = found.aligned_features[:, :3].astype(float)
        landmarks[t] = np.einsum("pk,pkj->pj", weights, shapes[t][faces[face]])
    return time.process_time() - start, landmarks


def meshmonks(measure, files, first):
    """Label -> CPU seconds and landmarks, where it is installed."""
    if meshmonk is None:
        return {}
    return {
        f"MeshMonk {meshmonk.__version__}, {way}": meshmonk_landmarks(measure, files, first, by)
        for way, by in MESHMONK_WAYS.items()
    }


def table(heads):
    print("\n| " + " | ".join(heads) + " |\n|" + " --- |" * len(heads), flush=True)


def row(cells):
    print("| " + " | ".join(cells) + " |", flush=True)


def error_text(errors, count=0):
    """errors: one list over phases per run; worst and mean, averaged over the runs. count: how many
    runs there should be."""
    text = (
        f"{np.mean([max(e) for e in errors]):.2f} / {np.mean([np.mean(e) for e in errors]):.2f}"
        if errors
        else ""
    )
    missing = count - len(errors)
    return text + (f" ({missing} of {count}: no valid map)" if missing > 0 else "")


def phases_of(phantom, kept, **choices):
    """A phantom of which only some phases are there."""

    class Kept(phantom.Ventricle):
        def sheet(self, t, *rest):
            return super().sheet(kept[t], *rest)

    return Kept(**choices)


def write_phases(phantom, ventricle, count, folder, noise=0.0):
    """noise: each vertex is moved in a direction of its own by up to this."""
    random = np.random.default_rng(0)
    files = []
    for t in range(count):
        v, f = ventricle.mesh(t)
        away = random.normal(size=v.shape)
        v = v + noise * random.random((len(v), 1)) * away / np.linalg.norm(
            away, axis=1, keepdims=True
        )
        files.append(Path(folder) / f"{t:02d}.ply")
        phantom.write_ply(files[-1], v, f)
    return files


def cost_cells(figures):
    u = figures["u"]
    return [
        f"{figures['root_vertices']:.0f}, {figures['mean_vertices']:.0f}",
        f"{1000 * u:.1f}",
        *(
            f"{figures[f'propagation_{kind}']:.2f} s = {figures[f'propagation_{kind}'] / u:.0f} u"
            for kind in ("cpu", "wall")
        ),
        *(
            f"{1000 * figures[f'remeshing_{kind}']:.0f} + "
            f"{1000 * figures[f'distances_{kind}']:.0f} ms = "
            f"{(figures[f'remeshing_{kind}'] + figures[f'distances_{kind}']) / u:.1f} u"
            for kind in ("cpu", "wall")
        ),
    ]


def known_truth(options, measure, phantom, folder):
    """Name, files, and what gives the errors of landmarks, of each sequence with known truth."""
    truth = [
        (measure.points(v), f)
        for v, f in map(
            measure.read_ply, sorted((options.data / "heart_truth/truth").glob("*.ply"))
        )
    ]
    data = [
        (
            "real patient with known truth",
            sorted((options.data / "heart_truth/mc").glob("*.ply")),
            lambda landmarks: [e.mean() for e in measure.truth_errors(truth, landmarks)],
        ),
    ]
    for part in ("cavity", "wall"):
        for seed in range(options.seeds):
            ventricle = phantom.Ventricle(part, seed)
            place = folder / f"{part}{seed}"
            place.mkdir(exist_ok=True)
            data.append(
                (
                    f"phantom, {part}, seed {seed}",
                    write_phases(phantom, ventricle, ventricle.phases, place),
                    ventricle.errors,
                )
            )
    return data


def sequences(options, measure, phantom, folder):
    table(
        [
            "data",
            "layers",
            "method",
            "vertices: root, mean",
            "u (ms)",
            "propagation, CPU",
            "propagation, wall",
            "landmarks + their distances, CPU",
            "the same, wall",
            "flipped faces",
            "error",
        ]
    )
    data = known_truth(options, measure, phantom, folder)
    data.insert(
        1, ("real patient, cine", sorted((options.data / "heart_cine").glob("endo_*.ply")), None)
    )
    for name, files, errors in data:
        files = list(map(str, files))
        root_map = str(folder / "root_map.ply")
        for method, label in METHODS.items():
            figures, landmarks = run(options, files, method, root_map=root_map)
            row(
                [
                    name,
                    str(len(files)),
                    label,
                    *cost_cells(figures),
                    f"{figures['flips']:.0f}",
                    error_text([errors(landmarks)] if errors else []),
                ]
            )
        others = {}
        if errors:
            walk = closest_point_walk(measure, files, landmarks[0])
            others["closest-point walk"] = "", walk
            for label, (seconds, found) in meshmonks(measure, files, landmarks[0]).items():
                others[label] = f"{seconds:.2f} s = {seconds / figures['u']:.0f} u", found
        if options.peer:
            seconds, landmarks = run_peer(options.peer, root_map, files, measure)
            others["peer"] = f"{seconds:.2f} s = {seconds / figures['u']:.0f} u", landmarks
        for label, (cpu, landmarks) in others.items():
            cells = [name, str(len(files)), label, "", "", cpu, "", "", "", ""]
            row([*cells, error_text([errors(landmarks)] if errors else [])])


def voxel_for(phantom, vertices):
    """The voxel size at which the cavity's first phase has about so many vertices."""
    voxel = phantom.VOXEL["cavity"]
    for _ in range(3):
        voxel *= np.sqrt(len(phantom.Ventricle("cavity", voxel=voxel).mesh(0)[0]) / vertices)
    return voxel


def paper(options, measure, phantom, folder):
    table(
        [
            "K",
            "vertices: root, mean (paper)",
            "root map",
            "propagation, as published",
            "propagation, robust",
            "paper: root map, propagation (2.4 GHz)",
        ]
    )
    for phases, root, mean, root_seconds, seconds in PAPER:
        ventricle = phantom.Ventricle("cavity", phases=phases, voxel=voxel_for(phantom, root))
        place = folder / f"paper{phases}"
        place.mkdir()
        files = list(map(str, write_phases(phantom, ventricle, phases, place)))
        figures = {method: run(options, files, method)[0] for method in METHODS}
        made = figures["robust"]
        row(
            [
                str(phases),
                f"{made['root_vertices']:.0f}, {made['mean_vertices']:.0f} ({root}, {mean})",
                f"{made['root_cpu']:.3f} s",
                *(f"{figures[method]['propagation_cpu']:.2f} s" for method in METHODS),
                f"{root_seconds} s, {seconds} s",
            ]
        )


def disturbed(options, measure, phantom, folder):
    table(
        ["phantom", "cavity: as published", "cavity: robust", "wall: as published", "wall: robust"]
    )
    whole = list(range(25))
    cases = {
        "as it is": {},
        "twisted by 10 degrees": {"twist": 10},
        "every vertex moved by up to half a voxel": {"noise": 0.5},
        "the sixth phase is missing": {"kept": whole[:5] + whole[6:]},
        "every second phase": {"kept": whole[::2]},
    }
    for name, choices in cases.items():
        cells = []
        for part in ("cavity", "wall"):
            errors = {method: [] for method in METHODS}
            for seed in range(options.seeds):
                kept = choices.get("kept", whole)
                ventricle = phases_of(
                    phantom, kept, part=part, seed=seed, twist=choices.get("twist", 0)
                )
                with tempfile.TemporaryDirectory(dir=folder) as place:
                    noise = choices.get("noise", 0) * ventricle.voxel
                    files = list(
                        map(str, write_phases(phantom, ventricle, len(kept), place, noise))
                    )
                    for method in METHODS:
                        errors[method].append(
                            ventricle.errors(run(options, files, method, repeat=1)[1])
                        )
            cells += [error_text(errors[method]) for method in METHODS]
        row([name, *cells])


def orders(options, measure, phantom, folder):
    """Does what is learnt from the sequence serve orders that are none in time?"""
    table(["data", "order", "prior learnt", "prior fixed"])
    fixed = ("--learn-from", "1000000")
    for name, files, errors in known_truth(options, measure, phantom, folder):
        for order in ("similarity", "star"):
            shuffled = list(range(len(files)))
            if order == "similarity":
                rest = shuffled[1:]
                random.Random(1).shuffle(rest)
                shuffled = [0, *rest]
            cells = []
            for prior in ((), fixed):
                landmarks = run(
                    options,
                    [str(files[i]) for i in shuffled],
                    repeat=1,
                    more=("--order", order, *prior),
                )[1]
                in_time = [landmarks[shuffled.index(i)] for i in range(len(files))]
                cells.append(error_text([errors(in_time)]))
            label = "Similarity tree, shuffled" if order == "similarity" else "Star"
            row([name, label, *cells])


def surface_of(options, measure, file):
    vertex, f = measure.read_ply(options.data / file)
    return measure.points(vertex), f


def phantom_distances(measure, ventricle, landmarks):
    """As made_motions.distances, of the yardstick's phantom: where its errors() has means."""
    rows, columns = 300, 600
    i, j = (x.ravel() for x in np.meshgrid(range(rows - 1), range(columns), indexing="ij"))
    a, c = i * columns + j, (i + 1) * columns + j
    b, d = i * columns + (j + 1) % columns, (i + 1) * columns + (j + 1) % columns
    sides = (0.0,) if ventricle.part == "cavity" else (0.0, 1.0)
    sheet = np.concatenate([np.stack([a, b, c], 1), np.stack([b, d, c], 1)])
    faces = np.concatenate([sheet + k * rows * columns for k in range(len(sides))])

    def at(t):
        return np.concatenate([ventricle.sheet(t, rows, m, 0.93).reshape(-1, 3) for m in sides])

    face, weights, distance = measure.closest_points(at(0), faces, landmarks[0])
    moved = [np.einsum("pk,pkj->pj", weights, at(t)[faces[face]]) for t in range(len(landmarks))]
    return distance < 1.2, [np.linalg.norm(x - y, axis=1) for x, y in zip(landmarks, moved)]


def uncertainty(options, measure, phantom, folder):
    """Is the true error of 95 % of the landmarks below 2.45 times the standard deviation that is
    told?"""
    table(["data", "error, mean", "uncertainty, mean", "inside 95 %", "CPU, with and without"])
    truth = [
        surface_of(options, measure, file)
        for file in sorted((options.data / "heart_truth/truth").glob("*.ply"))
    ]
    data = [
        (
            "real patient",
            sorted((options.data / "heart_truth/mc").glob("*.ply")),
            lambda landmarks: (slice(None), list(measure.truth_errors(truth, landmarks))),
        )
    ]
    for part in ("cavity", "wall"):
        for seed, noise in ((0, 0), (3, 0), (7, 0), (0, 0.5)):
            ventricle = phantom.Ventricle(part, seed)
            place = folder / f"uncertain_{part}{seed}_{noise}"
            place.mkdir()
            files = write_phases(
                phantom, ventricle, ventricle.phases, place, noise * ventricle.voxel
            )
            data.append(
                (
                    f"phantom, {part} {seed}" + (", noise" if noise else ""),
                    files,
                    lambda landmarks, v=ventricle: phantom_distances(measure, v, landmarks),
                )
            )
    made = {
        f"other kind, {part} {seed}": made_motions.Ventricle(part, seed)
        for part in ("cavity", "wall")
        for seed in (0, 1)
    }
    for name, seeds in (("ventricle", (1, 3)), ("hippocampus", (1, 2)), ("skull", (1,))):
        for seed in seeds:
            made[f"warped {name} {seed}"] = made_motions.WarpedSurface(
                surface_of(options, measure, WARPED[name]), seed
            )
    for name, motion in made.items():
        place = folder / f"uncertain_{name}".replace(" ", "_")
        data.append(
            (
                name,
                write_motion(phantom, motion, place),
                lambda landmarks, m=motion: made_motions.distances(
                    m, landmarks, measure.closest_points
                ),
            )
        )
    ratios = {}
    for name, files, distances in data:
        plain = run(options, files, repeat=1)[0]
        figures, landmarks = run(options, files, repeat=1, with_uncertainty=True)
        counted, away = distances(landmarks)
        away = np.array(away)[1:, counted]
        known = figures["uncertainty"][1:, counted]
        ratios[name] = (away / known).ravel()
        row(
            [
                name,
                f"{away.mean():.2f}",
                f"{known.mean():.2f}",
                f"{(ratios[name] < np.sqrt(-2 * np.log(0.05))).mean():.3f}",
                f"{figures['propagation_cpu']:.2f}, {plain['propagation_cpu']:.2f} s",
            ]
        )
    if options.curve:
        draw_shares(ratios, options.curve)


def draw_shares(ratios, file):
    """The share of landmarks within circles over the share that they promise, a line a sequence."""
    from matplotlib.figure import Figure

    promised = np.linspace(0.01, 0.99, 99)
    bounds = np.sqrt(-2 * np.log(1 - promised))
    panels = {
        "chosen on": [name for name in ratios if name in CHOSEN_ON],
        "not chosen on": [name for name in ratios if name not in CHOSEN_ON],
    }
    figure = Figure(figsize=(11, 5), dpi=100)
    for ax, (title, names) in zip(figure.subplots(1, len(panels), sharey=True), panels.items()):
        ax.plot([0, 1], [0, 1], color="0.8", lw=1)
        for k, name in enumerate(names):
            inside = (ratios[name][:, None] < bounds).mean(0)
            ax.plot(promised, inside, color=f"C{k}", lw=1.6, label=name)
        ax.set_title(title, fontsize=11, color="0.4")
        ax.set_xlabel("share promised", color="0.4")
        ax.set(xlim=(0, 1), ylim=(0, 1), aspect="equal")
        ax.legend(frameon=False, loc="lower right", fontsize=8)
    figure.axes[0].set_ylabel("share of landmarks inside", color="0.4")
    figure.tight_layout()
    figure.savefig(file)


def write_motion(phantom, motion, place, state=5):
    """The phases of one of made_motions, meshed anew."""
    place.mkdir()
    random = np.random.RandomState(state)
    files = [str(place / f"{t:02d}.ply") for t in range(motion.phases)]
    for t, file in enumerate(files):
        phantom.write_ply(file, *made_motions.meshed(motion, t, 3500, random))
    return files


def made(options, measure, phantom, folder):
    """Does every layer get a map from the motion's fit, and is the fit of all phases better?"""
    table(["moves", "flipped faces", "layers lost", "arc by arc", "all at once"])
    for seed in range(options.seeds):
        motions = {part: made_motions.Ventricle(part, seed) for part in ("cavity", "wall")}
        for name, file in WARPED.items():
            motions[f"warped {name}"] = made_motions.WarpedSurface(
                surface_of(options, measure, file), seed
            )
        for name, motion in motions.items():
            place = folder / f"made {name} {seed}".replace(" ", "_")
            files = write_motion(phantom, motion, place, options.state)
            runs = [
                run(options, files, repeat=1, may_fail=True, more=more)
                for more in (("--arcs-alone",), ())
            ]
            cells = ["refused"] * 2
            if runs[-1]:
                cells = [f"{runs[-1][0][figure]:.0f}" for figure in ("flips", "stood_in")]
            for there in runs:
                errors = there and [made_motions.errors(motion, there[1], measure.closest_points)]
                cells.append(error_text(errors or []))
            row([f"{name}, seed {seed}", *cells])


def other(options, measure, phantom, folder):
    groups = {
        f"ventricle of another make, {part}": [
            made_motions.Ventricle(part, seed) for seed in range(4)
        ]
        for part in ("cavity", "wall")
    }
    for name, seeds in (("ventricle", (1, 3)), ("hippocampus", (1, 2)), ("skull", (1, 2))):
        start = surface_of(options, measure, WARPED[name])
        groups[f"warped {name}"] = [made_motions.WarpedSurface(start, seed) for seed in seeds]
    columns = {**METHODS, "walk": "closest-point walk"}
    if options.peer:
        columns["peer"] = "peer"
    table(["moves", "how many", "R", *columns.values()])
    root_map = str(folder / "root_map.ply")
    for name, motions in groups.items():
        found = {column: [] for column in columns}
        radii = []
        for k, motion in enumerate(motions):
            files = write_motion(phantom, motion, folder / f"{name} {k}".replace(" ", "_"))
            v, f = motion.at(0)
            radii.append(np.sqrt(measure.triangle_areas(v, f).sum() / (4 * np.pi)))
            landmarks = {}
            for method in METHODS:
                made = run(options, files, method, repeat=1, root_map=root_map, may_fail=True)
                if made:
                    landmarks[method] = made[1]
            if landmarks:  # the root's are the same whatever the method
                first = next(iter(landmarks.values()))[0]
                landmarks["walk"] = closest_point_walk(measure, files, first)
            if options.peer:
                landmarks["peer"] = run_peer(options.peer, root_map, files, measure)[1]
            for column, there in landmarks.items():
                found[column].append(made_motions.errors(motion, there, measure.closest_points))
        row(
            [
                name,
                str(len(motions)),
                f"{np.mean(radii):.1f}",
                *(error_text(found[column], len(motions)) for column in columns),
            ]
        )


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--program", default=PROJECT / "build/pymeshlab/benchmarks/propagation_benchmark"
    )
    parser.add_argument(
        "--data",
        type=Path,
        default=DATA,
    )
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--threads", type=int, default=0)
    parser.add_argument("--peer")
    parser.add_argument("--curve")
    parser.add_argument("--state", type=int, default=5)
    parts = {
        "sequences": sequences,
        "paper": paper,
        "disturbed": disturbed,
        "orders": orders,
        "other": other,
        "made": made,
        "uncertainty": uncertainty,
    }
    parser.add_argument(
        "--only",
        nargs="+",
        choices=sorted(parts),
        default=[part for part in parts if part != "made"],
    )
    options = parser.parse_args()
    measure, phantom = yardstick(options.data)
    with tempfile.TemporaryDirectory() as folder:
        for part in options.only:
            parts[part](options, measure, phantom, Path(folder))


if __name__ == "__main__":
    main()
