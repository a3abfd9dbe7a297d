"""Holds the numbers of `tackscope ground ... --out FOLDER` against SurfaceTopography.

Needs numpy and SurfaceTopography (pip install SurfaceTopography); run as
    python3 examples/surface_topography.py FOLDER
"""

import json
import sys

import numpy as np
from SurfaceTopography import Topography

folder = sys.argv[1]
told = json.load(open(f"{folder}/ground.json"))["mesh"]
with open(f"{folder}/heights.csv") as file:
    length = float(file.readline().split("=")[1])
    heights = np.loadtxt(file, delimiter=",")
surface = Topography(heights.T, (length, length), periodic=True)
worst = 0.0
for name in ["rms_height_from_area", "rms_gradient", "rms_laplacian", "rms_curvature_from_area"]:
    theirs, ours = getattr(surface, name)(), told[name]
    worst = max(worst, abs(ours / theirs - 1))
    print(f"{name:26} {ours:.12g}  SurfaceTopography {theirs:.12g}")
sys.exit(f"they differ by {worst:.1e}" if worst > 1e-9 else 0)
