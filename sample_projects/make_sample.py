"""Writes the sample: five phases of a small beating ventricle with maps, landmarks and colours. Run by scripts/make-sample."""
import sys
from pathlib import Path

from sphere_propagation import pictures, pipeline, projects

surfaces = pipeline.make_phantom("Cavity", phases=5, voxel_size=4.0)
surfaces = [surface._replace(name=f"ventricle {i}") for i, surface in enumerate(surfaces)]
result = pipeline.run(surfaces, order="Cyclic time", frequency=5)["Robust"]
projects.write_layers(Path(sys.argv[1]), "ventricle", pictures.Row("ventricle", result, unit="mm", up=(0, 0, 1)))
# Small: the root's sphere is enough, and the project to look at.
folder = Path(sys.argv[1]) / "ventricle"
for path in sorted((folder / "spheres").glob("*.ply"))[1:]:
    path.unlink()
(folder / "ventricle_overview.mlp").replace(folder / "ventricle.mlp")
