"""Spherical maps of closed anatomical surfaces, propagated over layers and resampled by an icosphere.

The main job on arrays is in `pipeline`; it runs the MeshLab plugin's filters through PyMeshLab:

    from sphere_propagation import pipeline
    surfaces = pipeline.make_phantom("Cavity")
    result = pipeline.run(surfaces, order="Cyclic time")["Robust"]
    result.landmarks[t][j]      # landmark j at phase t: the same place on every shape
"""
