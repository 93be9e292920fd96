# SPDX-License-Identifier: GPL-3.0-only
"""Writes the filter scripts for meshlabserver, main_job.mlx and the others, from what the plugins
say of themselves:

    python make_scripts.py FOLDER_OF_PLUGINS [FOLDER]

meshlabserver wants every parameter of a filter in a script, so these hold them all, but for what
VARIANTS names with their defaults; a test compares them with the plugins'.
"""

import sys
import tempfile
import xml.etree.ElementTree as xml
from pathlib import Path

import pymeshlab

IMPORT = "create_layers_from_label_volume"
ROOT = "compute_spherical_parameterisation_root"
PROPAGATE = "transfer_spherical_parameterisation_to_layers"
REMESH = "generate_icosphere_remeshing"
MODEL = "compute_statistical_shape_model"

# What MeshLab is told first: the layer that was loaded last is the current one, but the root is the
# first. (The import sees to it itself.)
ROOT_IS_THE_FIRST_LAYER = """\
 <filter name="Change the current layer">
  <Param type="RichMesh" name="layer" value="0"/>
 </filter>
"""
VARIANTS = {  # the filters, and {parameter of a filter: value} where it is not the default
    "main_job.mlx": ([ROOT, PROPAGATE, REMESH], {}),
    "main_job_as_published.mlx": (
        [ROOT, PROPAGATE, REMESH],
        {(ROOT, "initial_map"): "Brechbuehler", (PROPAGATE, "method"): "As published"},
    ),
    "label_volume_to_model.mlx": (
        [IMPORT, ROOT, PROPAGATE, REMESH, MODEL],
        {
            (IMPORT, "file_name"): "labels.nii.gz",
            (PROPAGATE, "order"): "Cyclic time",
            (MODEL, "export_file"): "model.npz",
        },
    ),
}


def write_ball(path):
    """A label volume of two phases, as MetaImage."""
    size, centre = 12, 5.5
    inside = [
        sum((x - centre) ** 2 for x in voxel) < 20
        for voxel in ((i, j, k) for k in range(size) for j in range(size) for i in range(size))
    ]
    head = (
        f"ObjectType = Image\nNDims = 4\nDimSize = {size} {size} {size} 2\nElementType = "
        "MET_UCHAR\nElementDataFile = LOCAL\n"
    )
    Path(path).write_bytes(head.encode() + 2 * bytes(inside))


def defaults():
    """{python name: (menu name, [attributes of each parameter])} of the filters of all jobs."""
    job = [IMPORT, ROOT, PROPAGATE, REMESH, MODEL]
    meshes = pymeshlab.MeshSet()
    with tempfile.TemporaryDirectory() as folder:
        write_ball(f"{folder}/ball.mha")
        for name in job:
            meshes.apply_filter(
                name, **({"file_name": f"{folder}/ball.mha"} if name == IMPORT else {})
            )
        meshes.save_filter_script(f"{folder}/job.mlx")
        filters = xml.parse(f"{folder}/job.mlx").getroot().findall("filter")
    return {
        name: (f.get("name"), [dict(p.attrib) for p in f])
        for name, f in zip(job, filters, strict=True)
    }


def script(job, changed):
    """The text of a filter script. changed: {(python name of a filter, parameter): choice or text}
    instead of the default."""
    known = defaults()
    lines = ["<!DOCTYPE FilterScript>\n<FilterScript>\n"] + [ROOT_IS_THE_FIRST_LAYER] * (
        job[0] == ROOT
    )
    for name in job:
        menu_name, parameters = known[name]
        lines.append(f' <filter name="{menu_name}">\n')
        for p in parameters:
            if (name, p["name"]) in changed:
                value = changed[name, p["name"]]
                choices = [p[f"enum_val{i}"] for i in range(int(p.get("enum_cardinality", 0)))]
                p["value"] = str(choices.index(value)) if choices else value
            order = [
                "type",
                "name",
                "value",
                *sorted(k for k in p if k.startswith(("enum", "exts"))),
            ]
            element = xml.Element("Param", {k: p[k] for k in order})
            lines.append(
                "  " + xml.tostring(element, encoding="unicode").replace(" />", "/>") + "\n"
            )
        lines.append(" </filter>\n")
    return "".join(lines) + "</FilterScript>\n"


def scripts():
    """{file name: text} of all of them; the plugins must have been loaded."""
    return {file: script(*variant) for file, variant in VARIANTS.items()}


if __name__ == "__main__":
    for plugin in ("libfilter_sphere_propagation.so", "libfilter_label_volume.so"):
        pymeshlab.load_plugin(str(Path(sys.argv[1]).resolve() / plugin))
    folder = Path(sys.argv[2]) if len(sys.argv) > 2 else Path(__file__).parent
    for file, text in scripts().items():
        (folder / file).write_text(text)
        print(folder / file)
