"""Fits primitive shapes to the meshes of the Unitree G1 and writes g1.urdf beside this file.

Reads g1_29dof_rev_1_0.urdf and its meshes from the PyPI package example-robot-data, keeps every number of the
description (placements, inertias, limits) as the text it is there, and replaces each mesh by boxes, spheres and
capsules in the link's frame. A capsule is written as a cylinder and two spheres.

The fit of a link minimises, over the parameters of its shapes, the 4-norm of two distances: of mesh points outside
the union of the shapes (scale UNDER) and of points on the shapes outside the mesh (scale OVER). Left links are
fitted; right ones are their mirror images in y.

Needs: pip install example-robot-data trimesh numpy scipy. Takes about two minutes. `python check_g1.py` judges the result.
Options: link names restrict the fit to them and print their numbers, without writing.
"""
import site
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import trimesh
from scipy import ndimage
from scipy.cluster.vq import kmeans2
from scipy.optimize import least_squares
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

UNDER, OVER = 0.003, 0.007     # m: distances that cost one unit
PITCH = 0.004                  # m: voxels of the distance field
SOLE_Z = -0.0354               # m: the sole plane in left_ankle_roll_link, measured (see docs/robots.md)
PALM_Y = -0.0125               # m: the palm plane in left_rubber_hand, measured

# Shapes of each link, in the order of the file: kind and material, and a starting centre where clustering is not enough.
# box: axis-aligned in the link frame; obox: any orientation; cap: capsule; ball: sphere; sole, palm: a box with a fixed face.
LINKS = {
    "pelvis": [("box", "graphite")],
    "pelvis_contour_link": [("box", "shell")],
    "left_hip_pitch_link": [("obox", "graphite")],
    "left_hip_roll_link": [("obox", "shell")],
    "left_hip_yaw_link": [("cap", "shell"), ("box", "joint")],
    "left_knee_link": [("cap", "shell"), ("obox", "shell")],
    "left_ankle_pitch_link": [("ball", "joint")],
    "left_ankle_roll_link": [("sole", "graphite"), ("obox", "graphite")],
    "waist_yaw_link": [("ball", "graphite")],
    "waist_roll_link": [("ball", "joint")],
    "torso_link": [("obox", "shell"), ("obox", "shell")],
    "logo_link": [("box", "accent"), ("box", "joint")],
    "head_link": [("obox", "graphite"), ("obox", "graphite"), ("obox", "joint")],
    "left_shoulder_pitch_link": [("obox", "shell")],
    "left_shoulder_roll_link": [("obox", "shell")],
    "left_shoulder_yaw_link": [("obox", "shell")],
    "left_elbow_link": [("obox", "shell")],
    "left_wrist_roll_link": [("ball", "joint")],
    "left_wrist_pitch_link": [("obox", "shell")],
    "left_wrist_yaw_link": [("ball", "joint")],
    "left_rubber_hand": [("palm", "rubber"), ("obox", "rubber"), ("obox", "rubber")],
}
MATERIALS = {"shell": "0.86 0.87 0.89 1", "graphite": "0.16 0.17 0.19 1", "joint": "0.38 0.40 0.44 1",
             "rubber": "0.24 0.25 0.28 1", "accent": "0.16 0.42 0.72 1"}
HEADER = """
  Unitree G1, 29 actuated joints, with primitive shapes instead of meshes.

  Numbers (placements, masses, inertias, joint limits, effort and velocity limits): g1_29dof_rev_1_0.urdf of
  https://github.com/unitreerobotics/unitree_ros (robots/g1_description), as in the PyPI package example-robot-data.
  Copyright (c) 2016-2023 Hangzhou Yushu Technology Co., Ltd. ("Unitree Robotics"), licence BSD-3-Clause (docs/robots.md).

  Written by fit_g1.py, which fits the shapes to the published meshes; check_g1.py verifies both. Do not edit.
  A capsule is three elements: NAME_cyl and the spheres NAME_end0, NAME_end1.
"""


# ---------------------------------------------------------------- shapes: ("box", centre, R, half) | ("cap", p0, p1, radius)

def size_of(kind):
    return {"box": 6, "obox": 9, "cap": 7, "ball": 4, "sole": 4, "palm": 5}[kind]


def shape(kind, x):
    """The shape that parameters x describe; sizes are logarithms."""
    if kind in ("box", "obox"):
        R = Rotation.from_rotvec(x[6:9]).as_matrix() if kind == "obox" else np.eye(3)
        return "box", x[:3], R, np.exp(x[3:6])
    if kind == "cap":
        return "cap", x[:3], x[3:6], np.exp(x[6])
    if kind == "ball":
        return "cap", x[:3], x[:3], np.exp(x[3])
    if kind == "sole":                                     # centre x, half x, half y, height; lower face at SOLE_Z
        hx, hy, h = np.exp(x[1:4])
        return "box", np.array([x[0], 0, SOLE_Z + h / 2]), np.eye(3), np.array([hx, hy, h / 2])
    hx, hz, d = np.exp(x[2:5])                             # palm: centre x, z, half x, half z, depth; face at PALM_Y
    return "box", np.array([x[0], PALM_Y + d / 2, x[1]]), np.eye(3), np.array([hx, d / 2, hz])


def start(kind, P):
    """Parameters of a shape around the points P."""
    c, lo, hi = P.mean(0), P.min(0), P.max(0)
    mid, half = (lo + hi) / 2, np.maximum((hi - lo) / 2, 0.004)
    if kind in ("box", "obox"):
        return np.r_[mid, np.log(half), np.zeros(3 if kind == "obox" else 0)]
    if kind == "ball":
        return np.r_[mid, np.log(half.mean())]
    if kind == "cap":
        axis = np.linalg.svd(P - c, full_matrices=False)[2][0]
        s = (P - c) @ axis
        r = np.linalg.norm(P - c - np.outer(s, axis), axis=1).mean()
        return np.r_[c + axis * (s.min() + r), c + axis * (s.max() - r), np.log(r)]
    if kind == "sole":
        return np.r_[mid[0], np.log(half[:2]), np.log(hi[2] - SOLE_Z)]
    return np.r_[mid[0], mid[2], np.log(half[[0, 2]]), np.log(max(hi[1] - PALM_Y, 0.01))]


def distance(s, P):
    """Signed distance of the points P to a shape, negative inside."""
    if s[0] == "box":
        d = np.abs((P - s[1]) @ s[2]) - s[3]
        return np.linalg.norm(np.maximum(d, 0), axis=1) + np.minimum(d.max(1), 0)
    a, b = s[1], s[2] - s[1]
    t = np.clip((P - a) @ b / max(b @ b, 1e-12), 0, 1)
    return np.linalg.norm(P - a - t[:, None] * b, axis=1) - s[3]


_u = np.linspace(-1, 1, 7)
_face = np.array([[x, y] for x in _u for y in _u])
CUBE = np.unique(np.vstack([np.insert(_face, i, s, 1) for i in range(3) for s in (-1, 1)]), axis=0)
_k = np.arange(150) + 0.5
_z, _phi = 1 - 2 * _k / 150, np.pi * (1 + 5 ** 0.5) * _k
BALL = np.c_[np.sqrt(1 - _z**2) * np.cos(_phi), np.sqrt(1 - _z**2) * np.sin(_phi), _z]


def surface(s):
    """Points on a shape."""
    if s[0] == "box":
        return s[1] + (CUBE * s[3]) @ s[2].T
    return np.vstack([(1 - t) * s[1] + t * s[2] + s[3] * BALL for t in ((0,) if np.allclose(s[1], s[2]) else (0, 0.25, 0.5, 0.75, 1))])


# ---------------------------------------------------------------- meshes

class Field:
    """Points on a mesh, and its outside distance on a grid: zero inside, which is what a flood from afar does not reach."""

    def __init__(self, mesh):
        rng = np.random.default_rng(0)
        n = int(np.clip(mesh.area / 0.002**2, 4000, 60000))
        tri = rng.choice(len(mesh.faces), n, p=mesh.area_faces / mesh.area_faces.sum())
        w = rng.dirichlet(np.ones(3), n)
        dense = np.vstack([mesh.vertices, np.einsum("ij,ijk->ik", w, mesh.triangles[tri])])
        pad = 0.05
        self.origin = mesh.bounds[0] - pad
        shape = np.ceil((mesh.extents + 2 * pad) / PITCH).astype(int) + 1
        wall = np.zeros(shape, bool)
        wall[tuple(np.rint((dense - self.origin) / PITCH).astype(int).T)] = True
        free = ndimage.label(~wall)[0]
        outside = free == free[0, 0, 0]
        out = np.argwhere(outside)
        self.grid = np.zeros(shape)
        self.grid[outside] = cKDTree(dense).query(out * PITCH + self.origin, workers=-1)[0]
        # one point per 6 mm cell, extreme vertices included, and only those that the outside can see
        seen = ndimage.binary_dilation(outside, iterations=2)[tuple(np.rint((dense - self.origin) / PITCH).astype(int).T)]
        dense = dense[seen]
        cell = np.unique(np.floor(dense / 0.006).astype(int), axis=0, return_index=True)[1]
        extreme = np.unique((dense @ BALL.T).argmax(0))
        self.points = dense[np.union1d(cell, extreme)]

    def outside(self, P):
        return ndimage.map_coordinates(self.grid, ((P - self.origin) / PITCH).T, order=1, mode="nearest")


def fit(field, kinds, tries=8):
    """Shapes of the given kinds that fit the field, and the worst distances (mesh outside shapes, shapes outside mesh)."""
    cuts = np.cumsum([0] + [size_of(k) for k in kinds])
    shapes = lambda x: [shape(k, x[a:b]) for k, a, b in zip(kinds, cuts, cuts[1:])]

    def distances(x):
        S = shapes(x)
        under = np.maximum(np.min([distance(s, field.points) for s in S], axis=0), 0)
        over = np.concatenate([field.outside(surface(s)) for s in S])
        return under, over

    def residual(x):
        under, over = distances(x)
        return np.r_[(under / UNDER) ** 2 / len(under) ** 0.5, (over / OVER) ** 2 / len(over) ** 0.5]

    best = None
    rng = np.random.default_rng(1)
    for i in range(tries):
        label = kmeans2(field.points, len(kinds), minit="++", seed=i)[1] if len(kinds) > 1 else np.zeros(len(field.points), int)
        if len(np.unique(label)) < len(kinds):
            continue
        order = rng.permutation(len(kinds)) if i else np.arange(len(kinds))
        x0 = np.concatenate([start(k, field.points[label == order[j]]) for j, k in enumerate(kinds)])
        x0 = x0 + (0.01 * rng.standard_normal(len(x0)) if i else 0)
        r = least_squares(residual, x0, max_nfev=150)
        if best is None or r.cost < best.cost:
            best = r
    under, over = distances(best.x)
    return shapes(best.x), under.max(), over.max()


# ---------------------------------------------------------------- the file

def reference():
    """The folder of the G1 in the installed example-robot-data."""
    for root in site.getsitepackages() + sys.path:
        p = Path(root) / "cmeel.prefix/share/example-robot-data/robots/g1_description"
        if p.is_dir():
            return p
    raise SystemExit("example-robot-data is not installed: pip install example-robot-data")


def mirrored(s):
    S = np.diag([1.0, -1, 1])
    return ("box", S @ s[1], S @ s[2] @ S, s[3]) if s[0] == "box" else ("cap", S @ s[1], S @ s[2], s[3])


def elements(name, s):
    """(name, xyz, rpy, tag, attributes) of the URDF elements of one shape, rounded to 0.1 mm and 1e-5 rad."""
    num = lambda v, d=4: " ".join(f"{x:.{d}f}".rstrip("0").rstrip(".").replace("-0", "0") if abs(x) < 0.5 * 10**-d
                                  else f"{x:.{d}f}".rstrip("0").rstrip(".") for x in np.atleast_1d(v))
    rpy = lambda R: num(Rotation.from_matrix(R).as_euler("xyz"), 5)
    if s[0] == "box":
        return [(name, num(s[1]), rpy(s[2]), "box", {"size": num(2 * s[3])})]
    if np.allclose(s[1], s[2]):
        return [(name, num(s[1]), "0 0 0", "sphere", {"radius": num(s[3])})]
    axis = s[2] - s[1]
    length = np.linalg.norm(axis)
    R = Rotation.align_vectors([axis / length], [[0, 0, 1]])[0].as_matrix()
    r = num(s[3])
    return [(name + "_cyl", num((s[1] + s[2]) / 2), rpy(R), "cylinder", {"radius": r, "length": num(length)}),
            (name + "_end0", num(s[1]), "0 0 0", "sphere", {"radius": r}),
            (name + "_end1", num(s[2]), "0 0 0", "sphere", {"radius": r})]


def write(path, ref, fitted):
    tree = ET.parse(ref / "urdf/g1_29dof_rev_1_0.urdf")
    root = tree.getroot()
    root.set("name", "g1")
    for m in root.findall("material"):
        root.remove(m)
    for i, (m, rgba) in enumerate(MATERIALS.items()):
        e = ET.Element("material", name=m)
        ET.SubElement(e, "color", rgba=rgba)
        root.insert(i, e)
    count = 0
    for link in root.findall("link"):
        for tag in ("visual", "collision"):
            for g in link.findall(tag):
                link.remove(g)
        name = link.get("name")
        parts = [(f"{name}_{i}", s, LINKS[name.replace("right_", "left_")][i][1]) for i, s in enumerate(fitted.get(name, []))]
        for tag in ("visual", "collision"):
            for part, s, material in parts:
                for n, xyz, rpy, geometry, attributes in elements(part, s):
                    g = ET.SubElement(link, tag, name=n)
                    ET.SubElement(g, "origin", xyz=xyz, rpy=rpy)
                    ET.SubElement(ET.SubElement(g, "geometry"), geometry, attributes)
                    if tag == "visual":
                        ET.SubElement(g, "material", name=material)
                        count += 1
    ET.indent(tree)
    text = ET.tostring(root, encoding="unicode")
    path.write_text(f'<?xml version="1.0" encoding="utf-8"?>\n<!--{HEADER}-->\n{text}\n')
    return count


def main():
    ref, only = reference(), sys.argv[1:]
    meshes = {}
    for link in ET.parse(ref / "urdf/g1_29dof_rev_1_0.urdf").getroot().findall("link"):
        for v in link.findall("visual"):
            meshes[link.get("name")] = ref / "meshes" / Path(v.find("geometry/mesh").get("filename")).name
    fitted = {}
    for name, spec in LINKS.items():
        if only and name not in only:
            continue
        shapes, under, over = fit(Field(trimesh.load(meshes[name])), [k for k, _ in spec])
        print(f"{name:28} {len(shapes)} shapes  mesh outside {1e3 * under:5.1f} mm  bulge {1e3 * over:5.1f} mm", flush=True)
        if only:
            print("\n".join(str(e) for i, s in enumerate(shapes) for e in elements(f"{name}_{i}", s)))
        fitted[name] = shapes
        if name.startswith("left_"):
            fitted[name.replace("left_", "right_")] = [mirrored(s) for s in shapes]
    if not only:
        path = Path(__file__).with_name("g1.urdf")
        print(f"{path}: {write(path, ref, fitted)} elements")


if __name__ == "__main__":
    main()
