"""Reads the VTK series of a run of the sliding block with meshio, and checks what ParaView would show.

usage: python tests/read_vtk.py <folder of results> <law>
"""

import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import meshio
import numpy as np

folder, law = Path(sys.argv[1]), sys.argv[2]
frames = ET.parse(folder / f"{law}.pvd").getroot().findall("./Collection/DataSet")
assert len(frames) > 2, "the series has frames"
times = [float(frame.get("timestep")) for frame in frames]
assert times == sorted(times) and times[0] == 0.0, "in the order of time"

pressed = 0.0
for frame in frames:
    mesh = meshio.read(folder / frame.get("file"))
    nodes, triangles = len(mesh.points), len(mesh.cells_dict["triangle"])
    assert nodes > 100 and triangles > nodes
    for name, width in [("displacement", 3), ("velocity", 3), ("percussion", 3)]:
        data = mesh.point_data[name]
        assert data.shape == (nodes, width) and np.isfinite(data).all(), name
    assert mesh.cell_data["stress"][0].shape == (triangles, 3)
    stress, mises = mesh.cell_data["stress"][0], mesh.cell_data["von Mises"][0]
    xx, yy, xy = stress.T
    # Plane stress.
    expected = np.sqrt(xx**2 - xx * yy + yy**2 + 3 * xy**2)
    assert np.allclose(mises.ravel(), expected, rtol=1e-9), "von Mises of the stress"
    opening = mesh.point_data["opening"].ravel()
    bottom = mesh.points[:, 1] == 0.0
    assert (np.isnan(opening) == ~bottom).all(), "an opening where the block may touch, and nowhere else"
    assert np.allclose(opening[bottom], mesh.point_data["displacement"][bottom, 1], atol=1e-15)
    p = mesh.point_data["percussion"]
    assert (p[~bottom] == 0).all() and (p[:, 1] >= 0).all(), "the ground presses upwards, on the edge"
    pressed = max(pressed, p[:, 1].max())
    top = mesh.points[:, 1] == mesh.points[:, 1].max()
    assert np.allclose(mesh.point_data["displacement"][top, 1], -0.005, rtol=1e-12), "the top is held"
assert pressed > 0, "the block touches the ground"
print(f"{len(frames)} frames of {nodes} nodes and {triangles} triangles read")
