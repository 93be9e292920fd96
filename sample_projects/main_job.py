# SPDX-License-Identifier: GPL-3.0-only
"""The whole job in PyMeshLab, for a folder of closed meshes in time order:

pip install pymeshlab
python main_job.py libfilter_sphere_propagation.so MESHES OUTPUT
"""

import sys
from pathlib import Path

import pymeshlab

plugin, source, output = sys.argv[1:]
pymeshlab.load_plugin(str(Path(plugin).resolve()))  # scripts/build pymeshlab makes it
meshes = pymeshlab.MeshSet()
for path in sorted(
    Path(source).glob("*.ply")
):  # by name, so with leading zeros; layer order is time order
    meshes.load_new_mesh(str(path))

meshes.set_current_mesh(0)  # the root; for a heart end-diastole, the largest volume, is a good one
meshes.apply_filter("compute_spherical_parameterisation_root")
# "Cyclic time" for a whole heart cycle.
meshes.apply_filter("transfer_spherical_parameterisation_to_layers", order="Time")
# 1002 landmarks on each layer.
figures = meshes.apply_filter("generate_icosphere_remeshing", frequency=10)

print("distance from the surfaces, mm:", figures["surface_distance_mean"].round(2))
Path(output).mkdir(parents=True, exist_ok=True)
for i, mesh in enumerate(
    meshes
):  # surfaces with their maps, then landmark meshes with one face list
    meshes.set_current_mesh(mesh.id())
    meshes.save_current_mesh(str(Path(output) / f"{i:03d} {Path(mesh.label()).stem}.ply"))
