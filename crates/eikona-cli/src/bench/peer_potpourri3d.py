"""Times the signed heat solver of potpourri3d on the mesh and curve in a folder, and prints the times as JSON.

The folder holds V.f64 and F.i32 (raw arrays), truth.f64 (the exact distance) and area.f64 (a third of the areas of the faces
around each vertex), and curves.json: nodes as [a, b, t], at (1 - t) a + t b.
"""

import json
import os
import sys
import time

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"

import numpy as np
import potpourri3d as pp3d


def peak_memory():
    try:
        with open("/proc/self/status") as status:
            return next(int(line.split()[1]) * 1024 for line in status if line.startswith("VmHWM"))
    except (OSError, StopIteration):
        return None


folder, time_coefficient, repeats = sys.argv[1], float(sys.argv[2]), int(sys.argv[3])
read = lambda name, kind: np.fromfile(os.path.join(folder, name), dtype=kind)
V, F = read("V.f64", np.float64).reshape(-1, 3), read("F.i32", np.int32).reshape(-1, 3)
truth, area = read("truth.f64", np.float64), read("area.f64", np.float64)

number_of = {}
for e, (a, b) in enumerate(pp3d.edges(V, F).tolist()):
    number_of[a, b] = (e, False)
    number_of[b, a] = (e, True)


def node(a, b, t):
    if t == 0.0 or a == b:
        return (a, [])
    e, reversed_ = number_of[a, b]
    return (e, [1.0 - t if reversed_ else t])


with open(os.path.join(folder, "curves.json")) as file:
    curves = [[node(*n) for n in curve] for curve in json.load(file)]

start = time.perf_counter()
solver = pp3d.MeshSignedHeatSolver(V, F, time_coefficient)
result = {"construct": time.perf_counter() - start, "modes": []}
for mode, constraint in (("free", "None"), ("zero", "ZeroSet")):
    times = []
    for _ in range(1 + repeats):
        start = time.perf_counter()
        phi = solver.compute_distance(curves, level_set_constraint=constraint)
        times.append(time.perf_counter() - start)
    # Its distance is positive on the left of a curve, ours negative.
    difference = -phi - truth
    error = np.sqrt((area * difference**2).sum() / area.sum()) / (truth.max() - truth.min())
    later = sorted(times[1:])[len(times[1:]) // 2]
    result["modes"].append({"mode": mode, "first": times[0], "later": later, "l2_error": float(error)})
result["peak_memory_bytes"] = peak_memory()
print(json.dumps(result))
