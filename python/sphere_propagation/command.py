# SPDX-License-Identifier: GPL-3.0-only
"""The command line; see `sphere-propagation --help`."""

from __future__ import annotations

import argparse
import platform
import re
import sys
import warnings
from dataclasses import replace
from importlib.util import find_spec
from math import inf
from pathlib import Path
from typing import Any, Callable, Dict, Iterable, List, NoReturn, Optional, Sequence, Tuple, Union

from . import (
    conversion,
    explorer,
    filters,
    fitting,
    gallery,
    jobs,
    morphing,
    pictures,
    plugin,
    progress,
    readers,
    report,
    statismo,
    units,
    version,
)
from .errors import FileError, InputError, SpherePropagationError, SpherePropagationWarning
from .flags import by_flags, option
from .parameters import DEFAULTS, INITIAL_MAPS, MOST_CENTRAL, CorrespondenceParameters, in_full
from .results import require_apart, require_writable

METHODS = {"robust": "Robust", "published": "As published"}
ORDERS = {"time": "Time", "cyclic": "Cyclic time", "similarity": "Similarity tree", "star": "Star"}
CONNECTIVITIES = dict(zip(("icosphere", "union"), morphing.CONNECTIVITIES))
PATHS = dict(zip(("linear", "model"), morphing.PATHS))
ALIGNMENTS = {name.lower(): name for name in filters.ALIGNMENTS}
MAPS = {name.lower(): name for name in INITIAL_MAPS}
REPAIRS = {name.lower(): name for name in filters.HANDLE_REPAIRS}
COORDINATES = {name.lower(): name for name in filters.COORDINATES}
STEPS_OF_PREPARE = ("join_shells", "remove_handles")  # that are off unless they are given
# Options that the demo has for files or for its phantom alone; one is of either.
OF_FILES = ("name", "file_series", "prepare", *STEPS_OF_PREPARE, "unit", "mixed")
OF_PHANTOMS, VOXELS = ("phases", "seed"), "voxel_size"
PHANTOM_DEFAULTS = filters.make_phantom.__kwdefaults__
VOLUME_DEFAULTS = filters.read_label_volume.__kwdefaults__


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Runs the command; returns its exit code: 0 done, 1 something is wrong with the input, 2 with
    the arguments, 130 interrupted."""
    words = list(map(str, sys.argv[1:] if arguments is None else arguments))
    options = parser().parse_args(_with_parents(words), argparse.Namespace(command=words))
    shown: List[progress.Lines] = []
    output = Path(getattr(options, "output", None) or getattr(options, "folder", None) or ".")
    was_there = output.exists()

    def make_progress(steps: int) -> progress.Lines:
        shown.append(progress.for_stream(steps))
        return shown[-1]

    def show_warning(message, category, filename, lineno, file=None, line=None) -> None:
        lines = shown[-1] if shown else progress.Lines()
        kind = "Note" if getattr(message, "kind", "") == "Note" else "warning"
        lines.warning(by_flags(str(message)), kind)

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # other people's are not for users
            warnings.simplefilter("always", SpherePropagationWarning)
            warnings.showwarning = show_warning
            return options.action(options, make_progress)
    except BrokenPipeError:
        raise
    except InputError as error:  # files are read by then: an argument cannot be what is meant
        words = str(error) if options.action is _cohort else by_flags(str(error))  # keys of a file
        code, text = 2, f"error: {words}"
    except (SpherePropagationError, OSError, MemoryError) as error:
        code, text = 1, f"error: {by_flags(_words(error))}"
    except KeyboardInterrupt:
        code, text = 130, "interrupted"
    finally:
        for lines in shown:
            lines.close()
    if not was_there and output.is_dir() and not any(output.iterdir()):
        output.rmdir()  # the run made it, and then failed
    print(text, file=sys.stderr)
    return code


def _with_parents(arguments: Sequence[str]) -> List[str]:
    """The same, with `--parents -1,0,1` as one word: argparse would take a list that begins with -1
    for an option."""
    words = list(arguments)
    for i in range(len(words) - 1, 0, -1):
        if words[i - 1] == "--parents" and re.match(r"-\d", words[i]):
            words[i - 1 : i + 1] = [f"--parents={words[i]}"]
    return words


def _words(error: BaseException) -> str:
    if isinstance(error, MemoryError):
        return "not enough memory"
    if isinstance(error, OSError) and error.strerror:
        return f"{error.filename}: {error.strerror}" if error.filename else error.strerror
    return str(error)


def _run(options, make_progress) -> int:
    for name in STEPS_OF_PREPARE:
        if getattr(options, name) and not options.prepare:
            raise InputError(f"{option(name)} is a step of --prepare: give both.")
    choices = _choices(options, DEFAULTS)
    return _report(
        options.output,
        jobs.run_meshes(options.meshes, options.output, options.name, choices, make_progress),
    )


def _demo(options, make_progress) -> int:
    if options.input:
        for name in OF_PHANTOMS:
            if getattr(options, name) is not None:
                raise InputError(f"{option(name)} is of the phantom: leave it out with --input.")
        options.meshes, options.output = [options.input], options.folder
        return _run(options, make_progress)
    for name in OF_FILES:
        if getattr(options, name):
            raise InputError(f"{option(name)} is for your own files: give them (--input).")
    made = {
        name: default if getattr(options, name) is None else getattr(options, name)
        for name, default in ((name, PHANTOM_DEFAULTS[name]) for name in (*OF_PHANTOMS, VOXELS))
    }
    cyclic = replace(DEFAULTS, order="Cyclic time", root=None if options.parents else 0)
    runs = jobs.run_phantom(
        options.folder, _choices(options, cyclic), progress=make_progress, **made
    )
    return _report(options.folder, runs)


def _report(output: str, runs: Sequence[report.Run]) -> int:
    folder = Path(output)
    print(f"\n{report.summary(runs)}\n\nIn {folder.resolve()}:")
    for data in dict.fromkeys(run.data for run in runs):
        print(
            f"  {data}/{data}.mlp, {data}/{data}_overview.mlp: open in MeshLab, to work on and to "
            "look at"
        )
        if (folder / data / "landmarks.npz").exists():
            print(f"  {data}/landmarks.npz, {data}/landmarks.csv: all landmarks in one file")
        if (folder / data / "model.npz").exists():
            print(
                f"  {data}/model.npz, {data}/scores.csv, {data}/model.csv: the shape model, its "
                "scores, and how good it is"
            )
            print(f"  {data}/{jobs.EXPLORER}: the shape model to explore, for a browser")
    print(
        "  figures.csv: one row per layer    warnings.csv: what deserves a look"
        + ("    *.png: pictures" if any(folder.glob("*.png")) else "")
    )
    print(f"  {gallery.PAGE}: everything on one page, for a browser")
    return 0


def _convert(options, make_progress) -> int:
    planned = conversion.plan(options.meshes, options.to, options.format, options.overwrite)
    failed = conversion.convert(planned.jobs, (options.space or "").upper(), print)
    failed.update({source: str(error) for source, error in planned.refused.items()})
    for text in dict.fromkeys(failed.values()):
        print(f"error: {text}", file=sys.stderr)
    if failed:
        count = len(planned.jobs) + len(planned.refused)
        print(f"{count - len(failed)} of {count} converted", file=sys.stderr)
    return int(bool(failed))


def _explore(options, make_progress) -> int:
    output = Path(options.output or Path(options.model).with_name("explore.html"))
    if output.is_dir():
        raise FileError(f"{output} is a folder: name the page in it, {output / 'explore.html'}.")
    require_apart([options.model, Path(options.model).with_name("landmarks.npz")], output)
    if not output.parent.is_dir():
        raise FileError(f"There is no folder {output.parent} to write {output.name} to.")
    require_writable(output.parent)
    page = explorer.explore(
        options.model,
        unit=options.unit,
        modes=options.modes,
        cyclic=options.order == ORDERS["cyclic"],
    )
    print(f"{page.about}\n{page.save(output)}: open it in a browser")
    return 0


def _fit(options, make_progress) -> int:
    files, failed = fitting.fit_files(
        options.model,
        options.surfaces,
        options.output,
        print,
        pose=options.pose,
        alignment=options.alignment,
        modes=options.modes,
        local_deviation=not options.modes_only,
        label=options.label,
        anchors=options.anchors,
        anchor_sd=options.anchor_sd,
        unit=options.unit,
    )
    print(f"\nIn {Path(options.output).resolve()}:")
    for what in files:
        print(f"  {what}")
    for text in dict.fromkeys(failed.values()):
        print(f"error: {text}", file=sys.stderr)
    if failed:
        print(f"not fitted: {', '.join(failed)}", file=sys.stderr)
    return int(bool(failed))


def _morph(options, make_progress) -> int:
    files = morphing.morph_files(
        options.surfaces,
        options.output,
        print,
        order=options.order,
        steps=options.steps,
        connectivity=options.connectivity,
        frequency=options.frequency,
        along=options.along,
        closed=options.closed,
        mirror_layers=options.mirror_layers,
        unit=options.unit,
    )
    print(f"\nIn {Path(options.output).resolve()}:")
    for what in files:
        print(f"  {what}")
    return 0


def _cohort(options, make_progress) -> int:
    from .cohort import cohort  # for this command alone

    return cohort.run(
        Path(options.input),
        Path(options.output),
        options.level,
        config=options.config,
        labels=options.participant_label,
        cores=options.cores,
        profile=options.profile,
        dry=options.dry_run,
        say=lambda text: print(text, flush=True),
    )


def _info(options, make_progress) -> int:
    from .cohort import engine  # and what belongs to that command

    extras = {
        name: "installed"
        if find_spec(name)
        else f"not installed (pip install 'sphere-propagation[{extra}]')"
        for extra, names in (
            ("pictures", pictures.NEEDED),
            ("surfaces", readers.NEEDED),
            ("models", statismo.NEEDED),
            ("cohort", engine.NEEDED[:1]),
        )
        for name in names
    }
    before = "loaded before this package"
    facts = {
        "sphere-propagation": version.version(),
        "plugin": plugin.loaded() or before,
        "label volumes": plugin.volume_failure() or plugin.loaded(plugin.VOLUME_LIBRARY) or before,
        "pymeshlab": plugin.pymeshlab_version() or "of unknown version",
        "python": platform.python_version(),
        **extras,
    }
    for name, fact in facts.items():
        print(f"{name:20}{fact}")
    print("\n  ".join(["filters", *plugin.filters()]))
    return 0


def _choices(options, defaults: CorrespondenceParameters) -> jobs.Choices:
    order = "Given" if options.parents else options.order or defaults.order
    parameters = CorrespondenceParameters(
        root=defaults.root if options.root is None else options.root,
        method=options.method,
        order=order,
        parents=options.parents or "",
        frequency=options.frequency,
        initial_map=options.initial_map,
        area_weight=options.area_weight,
        area_restoration=options.area_restoration,
        mirror_layers=options.mirror_layers,
        groupwise=options.groupwise,
        anchors=options.anchors,
        anchor_sd=options.anchor_sd,
        exact=options.exact_anchors,
        anchor_snap=options.anchor_snap,
        anchor_pose=options.anchor_pose,
        anchor_positions=options.anchor_positions,
        uncertainty=options.uncertainty,
    )
    steps = {name: getattr(options, name) for name in STEPS_OF_PREPARE}
    preparation = steps if options.prepare else None
    return jobs.Choices(
        parameters,
        options.pictures,
        _volume_choices(options),
        preparation,
        options.unit,
        options.mixed,
        options.alignment,
        options.export,
        options.picture_format,
        options.command,
    )


def _volume_choices(options) -> Dict[str, Any]:
    """What is said of label volumes; the rest is as read_label_volume has it."""
    given = {
        "labels": options.labels,
        "voxel_size": options.voxel_size,
        "smoothing": options.smoothing,
        "coordinates": options.coordinates,
        "skip_incomplete_phases": options.skip_incomplete_phases or None,
        "align_slices": options.align_slices or None,
        "handle_repair": options.handle_repair,
        "longest_gap": options.longest_gap,
        "file_series": options.file_series or None,
    }
    return {name: value for name, value in given.items() if value is not None}


class _Parser(argparse.ArgumentParser):
    """Says what is wrong in one line, as errors in files are said: all options before it, as they
    are by default, would hide it."""

    def error(self, message: str) -> NoReturn:
        words = re.sub(r"^argument ([^:]+):", r"\1:", message).replace(
            "not allowed with argument", "not together with"
        )
        self.exit(2, f"error: {words}\n{self.prog} --help lists what there is.\n")

    def _check_value(self, action, value) -> None:
        if action.choices is not None and value not in action.choices:
            raise argparse.ArgumentError(action, str(_none_of(value, action.choices)))

    def parse_args(self, args=None, namespace=None):
        """Options that there are none of belong to the command in front of them, whose help they
        are to be looked for in."""
        found, others = self.parse_known_args(args, namespace)
        if others:
            of = _Parser(prog=f"{self.prog} {found.called}", add_help=False)
            of.error(f"{' '.join(others)}: there is no such option")
        return found


def _none_of(text: str, choices: Iterable[str]) -> argparse.ArgumentTypeError:
    return argparse.ArgumentTypeError(f"{text!r} is none of {', '.join(choices)}")


def parser() -> argparse.ArgumentParser:
    """What the command line takes."""
    command = _Parser(
        prog="sphere-propagation",
        description="Corresponding landmarks on closed surfaces by propagated "
        "spherical parameterisations.",
        **_examples(
            (
                "sphere-propagation run phases/ -o results --order cyclic",
                "then results/report.html",
            ),
            ("sphere-propagation run --help", "what else can be chosen"),
        ),
    )
    command.add_argument(
        "--version", action="version", version=f"sphere-propagation {version.version()}"
    )
    actions = command.add_subparsers(metavar="COMMAND", dest="called", required=True)

    run = actions.add_parser(
        "run",
        help="meshes or a label volume to maps, landmarks, a shape model, MeshLab projects, "
        "pictures and figures",
        description="Takes closed meshes in order of time, or a label volume, through the whole "
        "job.",
        **_examples(
            ("sphere-propagation run phases/ -o results --order cyclic", "a heart cycle"),
            (
                "sphere-propagation run skulls/ -o results --order similarity",
                "shapes without order",
            ),
            ("sphere-propagation run labels_4d.nii.gz -o results --labels 1", "a segmentation"),
        ),
    )
    run.add_argument(
        "meshes",
        nargs="+",
        metavar="FILE",
        help="meshes (ply, stl, obj, off; vtk, vtp, vtu, gii, FreeSurfer's), label volumes of one "
        "or more phases (nii, nii.gz, hdr with img, nrrd, nhdr, mha, mhd), or folders of them, in "
        "natural order",
    )
    run.add_argument(
        "-o",
        "--output",
        required=True,
        metavar="FOLDER",
        help="where everything goes; an earlier run's files are replaced",
    )
    _add_choices(
        run,
        order="time",
        root="the mesh of largest volume",
        voxel_size="of a label volume's surfaces (default: the smallest spacing of the volume)",
    )
    run.set_defaults(action=_run)

    demo = actions.add_parser(
        "demo",
        help="the same for a beating phantom whose truth is known, by both methods",
        description="Makes a beating ventricle, cavity and wall, and takes it through the whole "
        "job by both methods.",
        **_examples(("sphere-propagation demo results --phases 12", "a short cycle")),
    )
    demo.add_argument(
        "folder",
        nargs="?",
        default="demo",
        metavar="FOLDER",
        help="where everything goes (default: %(default)s)",
    )
    demo.add_argument(
        "--input",
        metavar="MESHES",
        help="meshes or a label volume instead of the phantom, as `run MESHES -o FOLDER`",
    )
    demo.add_argument(
        "--phases",
        type=_number(int, 1),
        metavar="N",
        help=f"of the phantom (default: {PHANTOM_DEFAULTS['phases']})",
    )
    demo.add_argument(
        "--seed",
        type=_number(int, 0),
        metavar="N",
        help="of the phantom: another one makes another ventricle (default: "
        f"{PHANTOM_DEFAULTS['seed']})",
    )
    _add_choices(
        demo,
        order="cyclic; with --input time",
        root="phase 0; with --input the mesh of largest volume",
        voxel_size=f"of the phantom (default: {PHANTOM_DEFAULTS['voxel_size']:g}); with --input of "
        "a label volume's surfaces (default: the smallest spacing of the volume)",
    )
    demo.set_defaults(action=_demo)

    convert = actions.add_parser(
        "convert",
        help="meshes that MeshLab does not open (VTK, GIFTI, FreeSurfer) to PLY, STL or OBJ",
        description="Writes meshes that MeshLab does not open (vtk, vtp, vtu, gii, FreeSurfer's "
        "lh.white and the like) as files that it does. Files in LPS are turned into RAS, which the "
        "new ones say (SPACE=RAS), so that 3D Slicer puts them in place.",
        **_examples(("sphere-propagation convert lh.white heart.vtk -o plys", "two files")),
    )
    convert.add_argument("meshes", nargs="+", metavar="FILE", help="meshes, or folders of them")
    convert.add_argument(
        "-o",
        "--output",
        "--to",
        dest="to",
        metavar="FOLDER",
        help="where they go (default: each beside its file)",
    )
    convert.add_argument(
        "--format",
        choices=list(conversion.WRITERS),
        default="ply",
        help="what is written (default: %(default)s)",
    )
    convert.add_argument(
        "--coordinates",
        "--space",
        dest="space",
        choices=["ras", "lps"],
        type=str.lower,
        help="the frame of files that do not say theirs (default: ras, with a warning)",
    )
    convert.add_argument("--overwrite", action="store_true", help="replace files that are there")
    convert.set_defaults(action=_convert)

    explore = actions.add_parser(
        "explore",
        help="a shape model on one page: sliders, distances as colours, landmarks to drag",
        description="Writes one HTML page, with everything inside, to explore a shape model.",
        **_examples(
            ("sphere-propagation explore results/heart/model.npz --order cyclic", "a heart cycle"),
        ),
    )
    explore.add_argument("model", metavar="FILE", help="model.npz, as `run` leaves it")
    explore.add_argument(
        "-o",
        "--output",
        metavar="PAGE",
        help="what is written (default: explore.html beside the model)",
    )
    explore.add_argument(
        "--modes",
        type=_number(int, 1),
        default=30,
        metavar="N",
        help="how many of the first the page has, at most (default: %(default)s)",
    )
    explore.add_argument(
        "--order",
        **_choice(
            "order",
            ORDERS,
            "of the shapes, as `run` had it: cyclic, and the first follows the last, as in a heart",
            ORDERS["time"],
        ),
    )
    explore.add_argument(
        "--cyclic",
        dest="order",
        action="store_const",
        const=ORDERS["cyclic"],
        help="the same as --order cyclic",
    )
    explore.add_argument(
        "--unit",
        metavar="UNIT",
        help="of lengths (default: what landmarks.npz beside the model says, else mm)",
    )
    explore.set_defaults(action=_explore)

    fit = actions.add_parser(
        "fit",
        help="a shape model onto new surfaces: their shape, its certainty, how unusual it is",
        description="Fits a shape model to surfaces that it was not built from, closed or open, "
        "whole or a part.",
        **_examples(
            ("sphere-propagation fit results/heart/model.npz new.ply", "one patient"),
            ("sphere-propagation fit model.npz patients -o fits", "a folder of them"),
            ("sphere-propagation fit model.npz seg.nii.gz --labels 2", "a segmentation"),
        ),
    )
    fit.add_argument(
        "model",
        metavar="MODEL",
        help="model.npz, as `run` leaves it; or .h5 and .json of statismo and scalismo",
    )
    fit.add_argument(
        "surfaces", nargs="+", metavar="FILE", help="meshes, label volumes, or folders of them"
    )
    fit.add_argument(
        "--labels",
        "--label",
        dest="label",
        metavar="LIST",
        default="1",
        help='of label volumes: the label, or several to be united, as "1,2" (default: '
        "%(default)s)",
    )
    fit.add_argument(
        "-o",
        "--output",
        metavar="FOLDER",
        default="fit",
        help="where the results go (default: %(default)s)",
    )
    fit.add_argument(
        "--pose",
        choices=["search", "as-it-lies", "anchors"],
        type=_hyphened,
        default="search",
        help="where the model is to begin: anywhere, in its own frame, or where three anchors or "
        "more put it (default: %(default)s)",
    )
    fit.add_argument(
        "--anchors",
        metavar="PATH",
        default="",
        help="points whose landmarks are known, called by the landmark's number or by a name that "
        "the model has: a file, or a folder of files that are called as the surfaces are",
    )
    fit.add_argument(
        "--anchor-sd",
        type=_number(float, 0),
        default=0.0,
        metavar="LENGTH",
        help="how far an anchor may be off in each coordinate, as a standard deviation (default: "
        "0, the mesh's mean edge length)",
    )
    fit.add_argument(
        "--alignment",
        choices=["as-the-model", "rigid", "similarity"],
        type=_hyphened,
        default="as-the-model",
        help="whether size is sought, too (similarity); by default where the model was built "
        "without size",
    )
    fit.add_argument(
        "--modes",
        type=_number(int, 0),
        default=0,
        metavar="N",
        help="how many of the first, 0 for all (default: %(default)s)",
    )
    fit.add_argument(
        "--modes-only",
        action="store_true",
        help="shapes have nothing beside the modes: no local deformation",
    )
    fit.add_argument(
        "--unit",
        metavar="UNIT",
        help="of lengths (default: what landmarks.npz beside the model says, else mm)",
    )
    fit.set_defaults(action=_fit)

    morph = actions.add_parser(
        "morph",
        help="shapes between surfaces, as meshes and as an animation",
        description="Propagates a map over the surfaces, and makes shapes from each to the next.",
        **_examples(
            ("sphere-propagation morph A.ply B.ply -o between", "from one to another"),
            ("sphere-propagation morph phases --order cyclic --closed --along model", "a beat"),
        ),
    )
    morph.add_argument("surfaces", nargs="+", metavar="FILE", help="meshes, or folders of them")
    morph.add_argument(
        "-o",
        "--output",
        metavar="FOLDER",
        default="morph",
        help="where the results go (default: %(default)s)",
    )
    morph.add_argument(
        "--order", **_choice("order", ORDERS, "who hands the map to whom", ORDERS["time"])
    )
    morph.add_argument(
        "--steps",
        type=_number(int, 1),
        default=10,
        metavar="N",
        help="shapes between two neighbours (default: %(default)s)",
    )
    morph.add_argument(
        "--connectivity",
        **_choice(
            "connectivity",
            CONNECTIVITIES,
            "of the shapes: the landmarks', or all vertices and edges of both neighbours, which is "
            "both exactly at its ends",
            CONNECTIVITIES["icosphere"],
        ),
    )
    morph.add_argument(
        "--frequency",
        type=_number(int, 1),
        default=20,
        metavar="F",
        help="of the icosphere: 10 F^2 + 2 vertices (default: %(default)s)",
    )
    morph.add_argument(
        "--along",
        **_choice(
            "along",
            PATHS,
            "straight from each to the next, or smooth through the scores of all",
            PATHS["linear"],
        ),
    )
    morph.add_argument(
        "--closed", action="store_true", help="from the last back to the first as well"
    )
    morph.add_argument(
        "--mirror-layers",
        action="store_true",
        help="reflect a mesh that is a mirror image of the others, a left bone among right ones",
    )
    morph.add_argument(
        "--unit",
        metavar="UNIT",
        default=units.DEFAULT_UNIT,
        help="of the meshes' coordinates, for what is said; nothing is converted (default: "
        "%(default)s)",
    )
    morph.set_defaults(action=_morph)

    _add_cohort(actions)

    info = actions.add_parser(
        "info",
        help="versions, the plugin's path, the filters",
        description="Tells versions, where the plugin lies, what is installed, and the filters.",
        **_examples(("sphere-propagation info", "for a report of a problem, say")),
    )
    info.set_defaults(action=_info)
    return command


def _add_cohort(actions) -> None:
    cohort = actions.add_parser(
        "cohort",
        help="a folder of subjects to one model, on this machine or on a cluster, by Snakemake",
        description="Takes many subjects, of one or more phases each, through the whole job, in "
        "chunks that an engine runs on this machine or on a cluster. What is done stays done: the "
        "same command goes on where it ended, and does again what has changed.",
        **_examples(
            ("sphere-propagation cohort hearts/ out/ group --cores 4", "on this machine"),
            ("sphere-propagation cohort hearts/ out/ group --profile slurm", "on a cluster"),
            ("sphere-propagation cohort hearts/ out/ group --dry-run", "what would run, its cost"),
        ),
    )
    cohort.add_argument(
        "input",
        metavar="INPUT",
        help="a BIDS-like tree (sub-*), a folder per subject, one folder of files, one per "
        "subject, or a table (.csv, .tsv) with the columns subject, file and, where there are "
        "several, phase",
    )
    cohort.add_argument("output", metavar="OUTPUT", help="the study's folder")
    cohort.add_argument(
        "level",
        choices=("participant", "group"),
        help="participant: up to the landmarks of each subject; group: their models, too",
    )
    cohort.add_argument(
        "--config",
        metavar="FILE",
        help="the study (.toml): labels, order, frequency and so on (docs/cohorts.md)",
    )
    cohort.add_argument(
        "--participant-label",
        nargs="+",
        default=[],
        metavar="NAME",
        help="these subjects only, with or without sub-",
    )
    cohort.add_argument(
        "--cores",
        type=_number(int, 1),
        metavar="N",
        help="how many jobs run at once (default: 1; of a profile: what it says)",
    )
    cohort.add_argument(
        "--profile",
        metavar="NAME",
        help="slurm, or a profile of Snakemake's: its name or its folder",
    )
    cohort.add_argument(
        "--dry-run", action="store_true", help="say what would run and what it would cost"
    )
    cohort.set_defaults(action=_cohort)


def _examples(*lines: Tuple[str, str]) -> Dict[str, Any]:
    """What a parser says of them after its options."""
    width = max(len(line) for line, _ in lines)
    text = "".join(f"\n  {line.ljust(width)}  # {words}" for line, words in lines)
    return {
        "epilog": f"example{'s' * (len(lines) > 1)}:{text}",
        "formatter_class": _Help,
    }


class _Help(argparse.HelpFormatter):
    """Leaves the lines of examples as they are."""

    def _fill_text(self, text, width, indent):
        if text.startswith("example"):
            return text
        return super()._fill_text(text, width, indent)


def _number(kind: type, minimum: float, maximum: float = inf) -> Callable[[str], float]:
    """What an option takes for a number: argparse refuses the others."""

    what = "a whole number" if kind is int else "a number"
    reach = f"of {minimum} or more" if maximum == inf else f"from {minimum} to {maximum}"

    def convert(text: str):
        try:
            value = kind(text)
        except ValueError:
            value = None
        if value is None or not minimum <= value <= maximum:
            raise argparse.ArgumentTypeError(f"{text!r} is not {what} {reach}")
        return value

    return convert


def _root(text: str) -> Union[int, str]:
    """The number of a mesh, or MOST_CENTRAL."""
    if text.lower().replace("-", " ") == MOST_CENTRAL:
        return MOST_CENTRAL
    try:
        return _number(int, 0)(text)
    except argparse.ArgumentTypeError as error:
        raise argparse.ArgumentTypeError(f"{error}, nor most-central") from None


def _choice(
    parameter: str, names: Dict[str, str], words: str, default: str, *, fills: bool = True
) -> Dict[str, Any]:
    """Of an option that takes one of `names`, and their full names too, in any case. words: its
    help, to which the default is added; fills: whether that is its value where it is not given."""

    def convert(text: str) -> str:
        value = in_full(parameter, text)
        if value not in names.values():
            raise _none_of(text, names)
        return value

    short = {full: name for name, full in names.items()}
    return {
        "type": convert,
        "metavar": "{" + ",".join(map(_shell_word, names)) + "}",
        "default": default if fills else None,
        "help": f"{words} (default: {short.get(default, default)})",
    }


def _hyphened(text: str) -> str:
    """ "As it lies", as the filters have it, is as-it-lies."""
    return re.sub(r"[\s_-]+", "-", text.strip()).lower()


def _shell_word(name: str) -> str:
    return name.replace(" ", "-")


def _several(choices: Sequence[str]) -> Callable[[str], List[str]]:
    """What an option takes for some of these, between commas, or for "all"."""

    def convert(text: str) -> List[str]:
        words = [word.lower().lstrip(".") for word in re.split(r"[,;\s]+", text) if word]
        if words == ["all"]:
            return list(choices)
        for word in words:
            if word not in choices and word not in ALWAYS:
                raise _none_of(word, [*choices, "all"])
        return [word for word in choices if word in words]

    return convert


ALWAYS = ("npz", "csv", "png")  # what is written without being asked for


def _add_choices(
    action: argparse.ArgumentParser, *, order: str, root: str, voxel_size: str
) -> None:
    """What `run` and `demo` have in common; what is said of three defaults differs."""
    add = action.add_argument
    add(
        "--name",
        help="of the sequence, for its files (default: the name of the label volume, or of the "
        "meshes' folder)",
    )
    add(
        "--voxel-size",
        type=_number(float, 0),
        metavar="MM",
        help=voxel_size,
    )
    add(
        "--file-series",
        action="store_true",
        help="of one label volume: also read the files beside it whose names differ in one number "
        "only, one phase each",
    )
    add(
        "--prepare",
        action="store_true",
        help="make closed surfaces of meshes that are none: weld, close openings, keep the largest "
        "part, turn faces outwards; what was done is said",
    )
    add(
        "--join-shells",
        action="store_true",
        help="with --prepare: also join the inner and the outer side of a wall, open at its rim",
    )
    add(
        "--remove-handles",
        action="store_true",
        help="with --prepare: also remove handles, by a new mesh",
    )
    add(
        "--unit",
        metavar="UNIT",
        help="of the meshes' coordinates, for tables and pictures; nothing is converted (default: "
        f"{units.DEFAULT_UNIT})",
    )
    add(
        "--mixed",
        action="store_true",
        help="take label volumes and meshes together as one collection",
    )
    add(
        "--root",
        type=_root,
        metavar="N",
        help="number of the mesh that gets the first map, from 0, or most-central: the mesh that "
        f"is the most like all others (default: {root})",
    )
    add(
        "--method",
        **_choice("method", METHODS, "how a map gets to the next mesh", DEFAULTS.method),
    )
    who = action.add_mutually_exclusive_group()
    who.add_argument(
        "--order",
        **_choice("order", ORDERS, "who hands the map to whom", order, fills=False),
    )
    who.add_argument(
        "--parents",
        metavar="LIST",
        help="instead of --order: for each mesh the number of that which hands it the map, -1 for "
        "the root, as --parents -1,0,1",
    )
    add(
        "--frequency",
        type=_number(int, 1),
        default=DEFAULTS.frequency,
        metavar="F",
        help="10 F^2 + 2 landmarks (default: %(default)s, which gives "
        f"{10 * DEFAULTS.frequency**2 + 2})",
    )
    add(
        "--initial-map",
        **_choice("initial_map", MAPS, "where the root map starts", DEFAULTS.initial_map),
    )
    add(
        "--area-weight",
        type=_number(float, 0, 1),
        default=DEFAULTS.area_weight,
        metavar="W",
        help="of the root map, 0 (angles) to 1 (areas) (default: %(default)g)",
    )
    add(
        "--area-restoration",
        type=_number(float, 0, 1),
        default=DEFAULTS.area_restoration,
        metavar="W",
        help="of all maps in the end, 0 to 1 (default: %(default)g)",
    )
    add(
        "--mirror-layers",
        action="store_true",
        help="reflect a mesh that is a mirror image of the others, a left bone among right ones",
    )
    add(
        "--uncertainty",
        action="store_true",
        help="write how well each landmark is known along the surface (method Robust): "
        "uncertainty in landmarks.npz, a column in landmarks.csv",
    )
    add(
        "--groupwise",
        action="store_true",
        help="optimise all maps together before landmarks are made; for shapes in no order",
    )
    add(
        "--anchors",
        metavar="FOLDER",
        help="of files with points that must correspond, called as the meshes are: MeshLab's .pp, "
        "3D Slicer's .mrk.json and .fcsv, scalismo's .json, tables of name, x, y, z",
    )
    add(
        "--anchor-sd",
        type=_number(float, 0),
        default=DEFAULTS.anchor_sd,
        metavar="LENGTH",
        help="how far an anchor may be off in each coordinate, as a standard deviation (default: "
        "0, the mesh's mean edge length)",
    )
    add(
        "--exact-anchors",
        action="store_true",
        help="every map has the anchors in exactly the root's places",
    )
    add(
        "--anchor-snap",
        action="store_true",
        help="the root's anchors become landmarks, and with --exact-anchors those of all meshes; "
        "where --frequency is a multiple of 10",
    )
    add(
        "--anchor-pose",
        action="store_true",
        help="lay meshes for the fit where their anchors put them, three or more, whatever their "
        "shapes say",
    )
    add(
        "--anchor-positions",
        metavar="FILE",
        help="where the root's anchors are to lie on the sphere: a table of name, longitude, "
        "latitude (degrees), or name, x, y, z",
    )
    add(
        "--labels",
        metavar="LIST",
        help='of a label volume: the label, or several to be united, as "1,2" (default: '
        f"{VOLUME_DEFAULTS['labels']})",
    )
    add(
        "--smoothing",
        type=_number(float, 0),
        metavar="VOXELS",
        help="of a label volume's surfaces, standard deviation, 0 to 5 (default: "
        f"{VOLUME_DEFAULTS['smoothing']:g})",
    )
    add(
        "--coordinates",
        **_choice(
            "coordinates",
            COORDINATES,
            "of a label volume's surfaces",
            VOLUME_DEFAULTS["coordinates"],
            fills=False,
        ),
    )
    add(
        "--skip-incomplete-phases",
        action="store_true",
        help="of a label volume: leave out phases that lack a label, instead of an error",
    )
    add(
        "--align-slices",
        action="store_true",
        help="of a label volume: move slices in their plane that are not in line with the others, "
        "as after another breath",
    )
    add(
        "--handle-repair",
        **_choice(
            "handle_repair",
            REPAIRS,
            "of a label volume: how handles are removed",
            VOLUME_DEFAULTS["handle_repair"],
            fills=False,
        ),
    )
    add(
        "--longest-gap",
        type=_number(int, 0),
        metavar="N",
        help="of a label volume: how many empty slices in a row are interpolated (default: "
        f"{VOLUME_DEFAULTS['longest_gap']})",
    )
    add(
        "--alignment",
        **_choice(
            "alignment",
            ALIGNMENTS,
            "what is taken out of the shapes before their model is built: pose and size, pose, "
            "nothing, or as the anchors alone tell",
            filters.ALIGNMENTS[0],
        ),
    )
    add(
        "--export",
        type=_several(jobs.EXPORTS),
        default=[],
        metavar="LIST",
        help="write the shape model for other programs as well: h5 and json (statismo, scalismo), "
        "particles (ShapeWorks), ply, or all; npz and csv are always written",
    )
    add(
        "--picture-format",
        type=_several(jobs.FORMATS),
        default=[],
        metavar="LIST",
        help="write the pictures as svg or pdf as well, or as both: svg,pdf",
    )
    add("--no-pictures", dest="pictures", action="store_false", help="leave the pictures out")
