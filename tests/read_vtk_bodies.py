"""Reads the VTK series of a run of rigid bodies with meshio, and checks what ParaView would show against the tables.

usage: python tests/read_vtk_bodies.py <folder of results> <law>
"""

import csv
import re
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import meshio
import numpy as np

folder, law = Path(sys.argv[1]), sys.argv[2]
with open(folder / "trajectory.csv") as file:
    rows = [row for row in csv.DictReader(file) if row["law"] == law]
text = (folder / f"{law}.pvd").read_text()
shapes = re.findall(r"<!-- shape (\d+) of (?:body (\d+)|the ground): (.*) -->", text)
assert [int(number) for number, _, _ in shapes] == list(range(len(shapes))) and shapes, "every shape has a name"
bodies = sorted({(int(body), name.rsplit(".", 1)[0]) for _, body, name in shapes if body})
spatial = f"{bodies[0][1]}.qw" in rows[0]


def frames(name):
    found = ET.parse(folder / f"{name}.pvd").getroot().findall("./Collection/DataSet")
    times = [float(frame.get("timestep")) for frame in found]
    assert len(found) > 2 and times == sorted(times) and times[0] == 0.0, "frames in the order of time"
    return [(time, folder / frame.get("file")) for time, frame in zip(times, found)]


def turn(row, name):
    if not spatial:
        c, s = np.cos(float(row[f"{name}.angle"])), np.sin(float(row[f"{name}.angle"]))
        return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    w, x, y, z = (float(row[f"{name}.q{k}"]) for k in "wxyz")
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])


points_of, local, checked = {}, {}, 0
for time, path in frames(law):
    mesh = meshio.read(path)
    assert np.isfinite(mesh.points).all() and mesh.point_data["velocity"].shape == mesh.points.shape
    kinds = [len(block.data) for block in mesh.cells]
    for name, width in [("body", 1), ("shape", 1), ("spin", 3)]:
        for count, data in zip(kinds, mesh.cell_data[name]):
            assert data.reshape(count, -1).shape == (count, width), name
    seen = set()
    row = next((row for row in rows if abs(float(row["time"]) - time) <= 1e-9 * max(1, time)), None)
    for block, body_of, spin in zip(mesh.cells, mesh.cell_data["body"], mesh.cell_data["spin"]):
        for cell, body, omega in zip(np.asarray(block.data, dtype=int), body_of.ravel(), spin):
            seen.add(int(body))
            velocity = mesh.point_data["velocity"][cell]
            x = mesh.points[cell]
            if body < 0:
                assert (velocity == 0).all() and (omega == 0).all(), "what is fixed does not move"
                continue
            # v(x) = v(o) + ω × (x − o), at any two points of a body.
            expected = velocity[0] + np.cross(omega, x - x[0])
            scale = 1 + np.abs(velocity).max() + np.abs(omega).max()
            assert np.allclose(velocity, expected, atol=1e-5 * scale), "the velocity of a rigid body"
            if row is None:
                continue
            # In the frame of the body nothing moves.
            name = bodies[int(body)][1]
            axes = "xyz" if spatial else "xy"
            origin = np.array([float(row[f"{name}.{k}"]) for k in axes] + [0] * (3 - len(axes)))
            inside = (x - origin) @ turn(row, name)
            for point, place in zip(cell, inside):
                known = local.setdefault(point, place)
                assert np.allclose(known, place, atol=2e-5 * (1 + np.abs(origin).max())), "a rigid surface"
            checked += 1
    assert {body for body, _ in bodies} <= seen, "every body is drawn"
assert checked > 0, "a frame at a time of the table"

pressed, count = 0.0, 0
for (time, path), (other, _) in zip(frames(f"{law}_contacts"), frames(law)):
    assert time == other
    if 'NumberOfPoints="0"' in path.read_text()[:400]:
        continue
    mesh = meshio.read(path)
    data = mesh.point_data
    gap, p, n, status = data["gap"].ravel(), data["percussion"], data["normal"], data["status"].ravel()
    assert len(gap) == len(mesh.points) and p.shape == n.shape == mesh.points.shape
    assert np.allclose((n**2).sum(axis=1), 1), "unit normals"
    push = (p * n).sum(axis=1)
    assert (push >= -1e-12 * (1 + np.abs(p).max())).all(), "nothing pulls"
    assert set(status) <= {0, 1, 2} and ((push > 0) == (status > 0)).all()
    pressed, count = max(pressed, push.max()), count + len(gap)
assert pressed > 0, "bodies touch"
print(f"{len(frames(law))} frames of {len(bodies)} bodies and {count} contacts read")
