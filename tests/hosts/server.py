# SPDX-License-Identifier: GPL-3.0-only
"""Runs meshlabserver 2020.09 under Xvfb."""

import os
import subprocess
import xml.etree.ElementTree as xml
from pathlib import Path
from xml.sax.saxutils import quoteattr

PROJECT = Path(__file__).resolve().parents[2]
SCRIPTS = PROJECT / "sample_projects"


class Run:
    """What came of it."""

    def __init__(self, code, output):
        self.code, self.output = code, output


class Server:
    def __init__(self, binary):
        self.binary = Path(binary)

    def __call__(self, *arguments, folder):
        """Runs meshlabserver with these arguments in a folder."""
        environment = {k: v for k, v in os.environ.items() if not k.startswith(("QT_", "DISPLAY"))}
        environment.update(
            HOME=str(folder),
            XDG_CONFIG_HOME=str(folder / "config"),
            LIBGL_ALWAYS_SOFTWARE="1",
            LC_ALL="C.UTF-8",
        )
        ended = subprocess.run(
            ["xvfb-run", "-a", str(self.binary), *map(str, arguments)],
            cwd=folder,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            timeout=1800,
            check=False,
        )
        return Run(ended.returncode, ended.stdout)

    def job(self, files, folder, script=SCRIPTS / "main_job.mlx"):
        """The whole job on these meshes; everything is written to `folder`. Returns (Run, the
        project's path)."""
        copies = []
        for file in files:  # the project is written beside the meshes
            copies.append(folder / file.name)
            copies[-1].write_bytes(file.read_bytes())
        run = self("-i", *copies, "-s", script, "-w", folder / "out.mlp", folder=folder)
        return run, folder / "out.mlp"


def layer_files(project):
    """The mesh files of an .mlp, in layer order."""
    return [
        Path(project).parent / m.get("filename")
        for m in xml.parse(project).getroot().iter("MLMesh")
    ]


def write_project(path, layers):
    """An .mlp. layers: list of (file, matrix as 16 numbers or None, visible)."""
    identity = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
    text = ["<!DOCTYPE MeshLabDocument>\n<MeshLabProject>\n <MeshGroup>\n"]
    for file, matrix, visible in layers:
        numbers = [repr(float(x)) for x in (identity if matrix is None else matrix)]
        rows = "\n".join(" ".join(numbers[4 * i : 4 * i + 4]) + " " for i in range(4))
        text.append(
            f"  <MLMesh filename={quoteattr(str(file))} label={quoteattr(Path(file).name)} "
            f'visible="{int(visible)}">\n   <MLMatrix44>\n{rows}\n</MLMatrix44>\n  </MLMesh>\n'
        )
    Path(path).write_text("".join(text) + " </MeshGroup>\n <RasterGroup/>\n</MeshLabProject>\n")
    return Path(path)


def write_script(path, *filters, base=SCRIPTS / "main_job.mlx"):
    """A filter script made of some filters of `base`. filters: menu name, or (menu name,
    {parameter: value})."""
    known = {f.get("name"): f for f in xml.parse(base).getroot().findall("filter")}
    root = xml.Element("FilterScript")
    for f in filters:
        name, changed = f if isinstance(f, tuple) else (f, {})
        element = (
            xml.fromstring(xml.tostring(known[name]))
            if name in known
            else xml.Element("filter", {"name": name})
        )
        for parameter in list(element):
            if parameter.get("name") in changed:
                value = changed[parameter.get("name")]
                if value is None:
                    element.remove(parameter)
                else:
                    parameter.set("value", str(value))
        root.append(element)
    Path(path).write_text("<!DOCTYPE FilterScript>\n" + xml.tostring(root, encoding="unicode"))
    return Path(path)
