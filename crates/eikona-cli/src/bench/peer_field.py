"""Times direction fields of adobe-lagrange and the singularities that libigl counts, on the mesh in a folder, and prints JSON.

The folder holds V.f64 and F.i32 (raw arrays), and D.f64: the first of four directions per face of a cross field.
"""

import json
import os
import sys
import time

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "TBB_NUM_THREADS"):
    os.environ[name] = "1"

import numpy as np

folder, package = sys.argv[1], sys.argv[2]
read = lambda name, kind: np.fromfile(os.path.join(folder, name), dtype=kind)
V, F = read("V.f64", np.float64).reshape(-1, 3), read("F.i32", np.int32).reshape(-1, 3)
result = {}
if package == "adobe-lagrange":
    import lagrange

    for element in ("Vertex", "Facet"):
        mesh = lagrange.SurfaceMesh()
        mesh.add_vertices(V)
        mesh.add_triangles(F.astype(np.uint32))
        start = time.perf_counter()
        lagrange.polyddg.compute_smooth_direction_field(
            mesh, nrosy=4, output_element_type=getattr(lagrange.AttributeElement, element)
        )
        result[f"smoothest cross field, {element.lower()}"] = time.perf_counter() - start
else:
    import igl

    D = read("D.f64", np.float64).reshape(-1, 3)
    normal = np.cross(V[F[:, 1]] - V[F[:, 0]], V[F[:, 2]] - V[F[:, 0]])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    across = np.cross(normal, D)
    start = time.perf_counter()
    mismatch = igl.cross_field_mismatch(V, F.astype(np.int64), D, across, False)
    singular, index = igl.find_cross_field_singularities(V, F.astype(np.int64), mismatch)
    result["singularities of our field"] = time.perf_counter() - start
    result["sum of the indices times 4"] = int(np.sum(index))
print(json.dumps(result))
