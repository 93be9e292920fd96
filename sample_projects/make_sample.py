"""Writes the sample: five phases of a small beating ventricle with maps, landmarks and colours. Run by scripts/make-sample."""
import dataclasses
import shutil
import sys
from pathlib import Path

import sphere_propagation as sp
from sphere_propagation.results import LIST
from sphere_propagation.views import Row

surfaces = sp.make_phantom(phases=5, voxel_size=4.0)
surfaces = [dataclasses.replace(surface, name=f"ventricle {i}") for i, surface in enumerate(surfaces)]
result = sp.correspond(surfaces, root=0, order="Cyclic time", frequency=5)
folder = Path(sys.argv[1]) / "ventricle"
shutil.rmtree(folder, ignore_errors=True)
sp.write_layers(folder.parent, "ventricle", Row("ventricle", result, unit="mm", up=(0, 0, 1)))
# Small: the root's sphere is enough, and the project to look at.
for path in sorted((folder / "spheres").glob("*.ply"))[1:]:
    path.unlink()
(folder / "ventricle_overview.mlp").replace(folder / "ventricle.mlp")
(folder / LIST).unlink()
