"""Writes the filter scripts for meshlabserver, main_job.mlx and main_job_as_published.mlx, from what the plugin says of itself:

    python make_scripts.py libfilter_sphere_propagation.so [FOLDER]

meshlabserver wants every parameter of a filter in a script, so these hold them all with their defaults; a test compares them with the
plugin's.
"""
import sys
import tempfile
import xml.etree.ElementTree as xml
from pathlib import Path

import pymeshlab

JOB = [
    "compute_spherical_parameterisation_root",
    "transfer_spherical_parameterisation_to_layers",
    "generate_icosphere_remeshing",
]
# What MeshLab is told first: the layer that was loaded last is the current one, but the root is the first.
ROOT_IS_THE_FIRST_LAYER = """\
 <filter name="Change the current layer">
  <Param type="RichMesh" name="layer" value="0"/>
 </filter>
"""
VARIANTS = {
    "main_job.mlx": {},
    "main_job_as_published.mlx": {("compute_spherical_parameterisation_root", "initial_map"): "Brechbuehler",
                                  ("transfer_spherical_parameterisation_to_layers", "method"): "As published"},
}


def defaults():
    """The job's filters: list of (python name, menu name, [attributes of each parameter])."""
    meshes = pymeshlab.MeshSet()
    meshes.apply_filter("create_ventricle_phantom", phases=2, voxel_size=4.0)
    meshes.clear_filter_script()
    for name in JOB:
        meshes.apply_filter(name)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "job.mlx"
        meshes.save_filter_script(str(file))
        filters = xml.parse(file).getroot().findall("filter")
    return [(name, f.get("name"), [dict(p.attrib) for p in f]) for name, f in zip(JOB, filters, strict=True)]


def script(changed):
    """The text of a filter script. changed: {(python name of a filter, parameter): choice} instead of the default."""
    lines = ["<!DOCTYPE FilterScript>\n<FilterScript>\n", ROOT_IS_THE_FIRST_LAYER]
    for name, menu_name, parameters in defaults():
        lines.append(f' <filter name="{menu_name}">\n')
        for p in parameters:
            if (name, p["name"]) in changed:
                choices = [p[f"enum_val{i}"] for i in range(int(p["enum_cardinality"]))]
                p["value"] = str(choices.index(changed[name, p["name"]]))
            order = ["type", "name", "value", *sorted(k for k in p if k.startswith("enum"))]
            element = xml.Element("Param", {k: p[k] for k in order})
            lines.append("  " + xml.tostring(element, encoding="unicode").replace(" />", "/>") + "\n")
        lines.append(" </filter>\n")
    return "".join(lines) + "</FilterScript>\n"


def scripts():
    """{file name: text} of all of them; the plugin must have been loaded."""
    return {file: script(changed) for file, changed in VARIANTS.items()}


if __name__ == "__main__":
    pymeshlab.load_plugin(str(Path(sys.argv[1]).resolve()))
    folder = Path(sys.argv[2]) if len(sys.argv) > 2 else Path(__file__).parent
    for file, text in scripts().items():
        (folder / file).write_text(text)
        print(folder / file)
