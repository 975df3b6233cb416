"""Fits primitive shapes to the meshes of the Unitree G1 and writes g1.urdf beside this file.

Reads g1_29dof_rev_1_0.urdf and its meshes from the PyPI package example-robot-data, keeps every number of the
description (placements, inertias, limits) as the text it is there, and replaces each mesh by boxes, spheres and
capsules in the link's frame. A capsule is written as a cylinder and two spheres.

The fit of a link minimises, over the parameters of its shapes, the 8-norm of three distances: of mesh points outside
the union of the shapes (scale UNDER), of points on the mesh's convex hull outside it (scale HULL), and of points on
the shapes outside the mesh (scale OVER). Left links are fitted; right ones are their mirror images in y.

Needs: pip install example-robot-data trimesh numpy scipy. Takes about ten minutes. `python check_g1.py` judges the result.
Options: link names restrict the fit to them and print their numbers, without writing.
"""
import site
import sys
import warnings
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import trimesh
from scipy import ndimage
from scipy.cluster.vq import kmeans2
from scipy.optimize import least_squares
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

warnings.filterwarnings("ignore", message="Gimbal lock")   # a capsule along x has no unique angles

UNDER, HULL, OVER = 0.003, 0.007, 0.006   # m: distances that cost one unit
PITCH = 0.004                  # m: voxels of the distance field
SOLE_Z = -0.0354               # m: the sole plane in left_ankle_roll_link, measured (see docs/robots.md)
PALM_Y = -0.0125               # m: the palm plane in left_rubber_hand, measured
YAW_X = 0.046                  # m: the axis of the wrist's yaw joint in left_wrist_pitch_link, whose housing is round about it

# Shapes of each link: kind and material. box: axis-aligned in the link's frame; pbox: pitched about y; rbox: pitched and
# rolled; obox: any orientation; cap: capsule; ball: sphere; ybox, yball: symmetric in y; wcap: symmetric, its axis along y;
# sole, palm: a box with one face given; xcap: a capsule along x that ends at YAW_X.
LINKS = {
    "pelvis": [("box", "graphite")],
    "pelvis_contour_link": [("wcap", "shell")],
    "left_hip_pitch_link": [("pbox", "graphite")],
    "left_hip_roll_link": [("pbox", "shell"), ("pbox", "shell")],
    "left_hip_yaw_link": [("rbox", "shell"), ("rbox", "shell")],
    "left_knee_link": [("cap", "shell"), ("pbox", "shell"), ("obox", "shell")],
    "left_ankle_pitch_link": [("ball", "joint")],
    "left_ankle_roll_link": [("sole", "graphite"), ("sole", "graphite")],
    "waist_yaw_link": [("yball", "graphite")],
    "waist_roll_link": [("yball", "joint")],
    "torso_link": [("ybox", "shell"), ("ybox", "shell"), ("ybox", "shell")],
    "head_link": [("ybox", "graphite"), ("ybox", "graphite"), ("ybox", "visor"), ("yball", "graphite")],
    "left_shoulder_pitch_link": [("ball", "joint")],
    "left_shoulder_roll_link": [("ball", "shell"), ("ball", "shell"), ("ball", "shell")],   # a cup and the sides of a fork
    "left_shoulder_yaw_link": [("pbox", "shell")],
    "left_elbow_link": [("pbox", "shell"), ("pbox", "shell")],
    "left_wrist_roll_link": [("ball", "joint")],
    "left_wrist_pitch_link": [("xcap", "shell")],
    "left_wrist_yaw_link": [("ball", "joint")],
    "left_rubber_hand": [("palm", "rubber"), ("obox", "rubber")],
}
OPEN = {"head_link"}                    # links whose hollows stay open: the face
STARTS = {"head_link": [(-0.005, 0.337, 0.046, 0.07, 0.013),   # where clustering finds no good start: x, z and half sizes of
                        (0.01, 0.382, 0.042, 0.038, 0.017),    # collar, chin, visor, skull
                        (0.03, 0.48, 0.033, 0.05, 0.036), (-0.02, 0.49, 0.051)]}
COVERS = {"torso_link": ["logo_link"]}  # links without shapes of their own that another link of the same body covers
FILLED = {"pelvis_contour_link": ["pelvis"]}   # a shell, and the link of the same body that fills it
MATERIALS = {"shell": "0.86 0.87 0.89 1", "graphite": "0.16 0.17 0.19 1", "joint": "0.38 0.40 0.44 1",
             "rubber": "0.24 0.25 0.28 1", "visor": "0.10 0.22 0.36 1"}
HEADER = """
  Unitree G1, 29 actuated joints, with primitive shapes instead of meshes.

  Numbers (placements, masses, inertias, joint limits, effort and velocity limits): g1_29dof_rev_1_0.urdf of
  https://github.com/unitreerobotics/unitree_ros (robots/g1_description), as in the PyPI package example-robot-data.
  Copyright (c) 2016-2022 HangZhou YuShu TECHNOLOGY CO.,LTD. ("Unitree Robotics"), licence BSD-3-Clause: LICENSE-unitree.

  Written by fit_g1.py, which fits the shapes to the published meshes; check_g1.py verifies both. Do not edit.
  A capsule is three elements: NAME_cyl and the spheres NAME_end0, NAME_end1.
"""


# ---------------------------------------------------------------- shapes
# ("box", centre, R, half) | ("cap", p0, p1, radius), a sphere if p0 = p1

SIZES = {"box": 6, "obox": 9, "pbox": 7, "rbox": 8, "ybox": 6, "cap": 7, "wcap": 4, "xcap": 2, "ball": 4, "yball": 3, "sole": 4, "palm": 5}


def shape(kind, x):
    """The shape that parameters x describe; sizes are logarithms."""
    if kind in ("box", "obox"):
        R = Rotation.from_rotvec(x[6:9]).as_matrix() if kind == "obox" else np.eye(3)
        return "box", x[:3], R, np.exp(x[3:6])
    if kind == "pbox":
        return "box", x[:3], Rotation.from_rotvec([0, x[6], 0]).as_matrix(), np.exp(x[3:6])
    if kind == "rbox":
        return "box", x[:3], Rotation.from_rotvec([x[7], x[6], 0]).as_matrix(), np.exp(x[3:6])
    if kind == "ybox":
        return "box", np.array([x[0], 0, x[1]]), Rotation.from_rotvec([0, x[5], 0]).as_matrix(), np.exp(x[2:5])
    if kind == "cap":
        return kind, x[:3], x[3:6], np.exp(x[6])
    if kind == "wcap":
        h = np.exp(x[2])
        return "cap", np.array([x[0], -h, x[1]]), np.array([x[0], h, x[1]]), np.exp(x[3])
    if kind == "xcap":
        return "cap", np.array([x[0], 0, 0]), np.array([YAW_X, 0, 0]), np.exp(x[1])
    if kind == "ball":
        return "cap", x[:3], x[:3], np.exp(x[3])
    if kind == "yball":
        return "cap", np.array([x[0], 0, x[1]]), np.array([x[0], 0, x[1]]), np.exp(x[2])
    if kind == "sole":                                     # centre x, half x, half y, height; lower face at SOLE_Z
        hx, hy, h = np.exp(x[1:4])
        return "box", np.array([x[0], 0, SOLE_Z + h / 2]), np.eye(3), np.array([hx, hy, h / 2])
    hx, hz, d = np.exp(x[2:5])                             # palm: centre x, z, half x, half z, depth; face at PALM_Y
    return "box", np.array([x[0], PALM_Y + d / 2, x[1]]), np.eye(3), np.array([hx, d / 2, hz])


def start(kind, P):
    """Parameters of a shape around the points P."""
    c, lo, hi = P.mean(0), P.min(0), P.max(0)
    mid, half = (lo + hi) / 2, np.maximum((hi - lo) / 2, 0.004)
    if kind in ("box", "obox", "pbox", "rbox"):
        return np.r_[mid, np.log(half), np.zeros(SIZES[kind] - 6)]
    if kind == "ybox":
        return np.r_[mid[[0, 2]], np.log(half), 0]
    if kind in ("ball", "yball"):
        return np.r_[mid if kind == "ball" else mid[[0, 2]], np.log(half.mean())]
    if kind == "wcap":
        r = half[[0, 2]].mean()
        return np.r_[mid[[0, 2]], np.log(max(half[1] - r, 0.005)), np.log(r)]
    if kind == "xcap":
        r = half[1:].mean()
        return np.r_[lo[0] + r, np.log(r)]
    if kind == "cap":
        Q = P - c
        axis = np.linalg.svd(Q, full_matrices=False)[2][0]
        s = Q @ axis
        r = 0.8 * np.sort(np.linalg.norm(P - c - np.outer(s, axis), axis=1))[-len(P) // 5]
        ends = np.array([c + axis * min(s.min() + r, -0.003), c + axis * max(s.max() - r, 0.003)])
        return np.r_[ends.ravel(), np.log(r)]
    if kind == "sole":
        return np.r_[mid[0], np.log(half[:2]), np.log(hi[2] - SOLE_Z)]
    return np.r_[mid[0], mid[2], np.log(half[[0, 2]]), np.log(max(hi[1] - PALM_Y, 0.01))]


def distance(s, P):
    """Distance of the points P to a shape, zero inside."""
    if s[0] == "box":
        return np.linalg.norm(np.maximum(np.abs((P - s[1]) @ s[2]) - s[3], 0), axis=1)
    a, b = s[1], s[2] - s[1]
    t = np.clip((P - a) @ b / max(b @ b, 1e-12), 0, 1)
    return np.maximum(np.linalg.norm(P - a - t[:, None] * b, axis=1) - s[3], 0)


_u = np.linspace(-1, 1, 21)
_face = np.array([[x, y] for x in _u for y in _u])
CUBE = np.unique(np.vstack([np.insert(_face, i, s, 1) for i in range(3) for s in (-1, 1)]), axis=0)
_k = np.arange(250) + 0.5
_z, _phi = 1 - 2 * _k / 250, np.pi * (1 + 5 ** 0.5) * _k
BALL = np.c_[np.sqrt(1 - _z**2) * np.cos(_phi), np.sqrt(1 - _z**2) * np.sin(_phi), _z]

def surface(s):
    """Points on a shape."""
    if s[0] == "box":
        return s[1] + (CUBE * s[3]) @ s[2].T
    return np.vstack([(1 - t) * s[1] + t * s[2] + s[3] * BALL for t in ((0,) if np.array_equal(s[1], s[2]) else (0, 0.25, 0.5, 0.75, 1))])


# ---------------------------------------------------------------- meshes

class Field:
    """Distance from the meshes of a link on a grid, zero inside them (winding number above one half)."""

    def __init__(self, meshes):
        dense = np.vstack([samples(m) for m in meshes])
        self.origin = dense.min(0) - 0.05
        size = np.ceil((np.ptp(dense, axis=0) + 0.1) / PITCH).astype(int) + 1
        grid = np.argwhere(np.ones(size, bool)) * PITCH + self.origin
        self.grid = cKDTree(dense).query(grid, workers=-1)[0].reshape(size)
        coarse = tuple(slice(None, None, 2) for _ in range(3))   # the winding number varies slowly away from the surface
        centre, near = grid.reshape(*size, 3)[coarse].reshape(-1, 3), np.all((grid > dense.min(0)) & (grid < dense.max(0)), axis=1)
        inner = np.all((centre > dense.min(0)) & (centre < dense.max(0)), axis=1)
        turns = np.zeros(len(centre))
        turns[inner] = np.max([winding(m, centre[inner]) for m in meshes], axis=0)
        turns = turns.reshape(self.grid[coarse].shape)
        full = ndimage.map_coordinates(turns, (grid[near] - self.origin).T / (2 * PITCH), order=1, mode="nearest")
        self.grid.ravel()[np.flatnonzero(near)[full > 0.5]] = 0
        wall = np.zeros(size, bool)
        wall[self.cell(dense)] = True
        free = ndimage.label(~wall)[0]
        self.seen = ndimage.binary_dilation(free == free[0, 0, 0], iterations=2)   # what a flood from afar reaches

    def cell(self, P):
        return tuple(np.rint((P - self.origin) / PITCH).astype(int).T)

    def distance(self, P):
        return ndimage.map_coordinates(self.grid, ((P - self.origin) / PITCH).T, order=1, mode="nearest")

    def skin(self, mesh):
        """Points of a mesh that the outside sees: one per 6 mm cell, and the extreme ones."""
        P = samples(mesh)
        P = P[self.seen[self.cell(P)]]
        cell = np.unique(np.floor(P / 0.006).astype(int), axis=0, return_index=True)[1]
        return P[np.union1d(cell, np.unique((P @ BALL.T).argmax(0)))]


def winding(mesh, P):
    """Winding number of a mesh about the points P: one inside, zero outside, between the two near holes."""
    out = np.zeros(len(P))
    for i, p in enumerate(P):
        a, b, c = (mesh.triangles[:, k] - p for k in range(3))
        la, lb, lc = (np.sqrt((x * x).sum(1)) for x in (a, b, c))
        dot = lambda x, y: (x * y).sum(1)
        out[i] = np.arctan2(dot(a, np.cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb).sum() / (2 * np.pi)
    return out


def samples(mesh):
    """Vertices of a mesh and points spread over its faces, about 2 mm apart."""
    rng = np.random.default_rng(0)
    n = int(np.clip(mesh.area / 0.002**2, 4000, 60000))
    tri = rng.choice(len(mesh.faces), n, p=mesh.area_faces / mesh.area_faces.sum())
    return np.vstack([mesh.vertices, np.einsum("ij,ijk->ik", rng.dirichlet(np.ones(3), n), mesh.triangles[tri])])


def hull_points(P):
    """Points on the convex hull of P, about 8 mm apart."""
    hull = trimesh.convex.convex_hull(P)
    return trimesh.sample.sample_surface(hull, max(200, int(hull.area / 0.008**2)), seed=0)[0]


def fit(field, points, hull, kinds, units, given=None, tries=8):
    """Shapes of the given kinds that fit the field, and the worst distances: of points, of hull, of the shapes outside the mesh."""
    cuts = np.cumsum([0] + [SIZES[k] for k in kinds])
    shapes = lambda x: [shape(k, x[a:b]) for k, a, b in zip(kinds, cuts, cuts[1:])]

    def distances(x):
        S = shapes(x)
        gap = lambda P: np.min([distance(s, P) for s in S], axis=0)
        return gap(points), gap(hull), np.concatenate([field.distance(surface(s)) for s in S])

    def residual(x):
        return np.concatenate([(d / unit) ** 4 / len(d) ** 0.5 for d, unit in zip(distances(x), units)])

    best, rng = None, np.random.default_rng(1)
    for i in range(tries if given is None else 1):
        label = kmeans2(points, len(kinds), minit="++", seed=i)[1] if len(kinds) > 1 else np.zeros(len(points), int)
        if len(np.unique(label)) < len(kinds):
            continue
        order = rng.permutation(len(kinds)) if i else np.arange(len(kinds))
        x0 = np.concatenate([start(k, points[label == order[j]]) for j, k in enumerate(kinds)])
        x0 = x0 + (0.01 * rng.standard_normal(len(x0)) if i else 0) if given is None else given
        r = least_squares(residual, x0, max_nfev=100)
        if best is None or r.cost < 0.9999 * best.cost:    # rounding does not choose between starts that end alike
            best = r
    return shapes(best.x), *(d.max() for d in distances(best.x)), best.cost


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
    """(name, xyz, rpy, tag, attributes) of the URDF elements of one shape, rounded to 10 µm and 1e-5 rad."""
    num = lambda v: " ".join(f"{round(x, 5) + 0.0:.5f}".rstrip("0").rstrip(".") for x in np.atleast_1d(v))
    rpy = lambda R: num(Rotation.from_matrix(R).as_euler("xyz"))
    if s[0] == "box":
        return [(name, num(s[1]), rpy(s[2]), "box", {"size": num(2 * np.round(s[3], 5))})]   # so that given faces stay in place
    if np.array_equal(s[1], s[2]):
        return [(name, num(s[1]), "0 0 0", "sphere", {"radius": num(s[3])})]
    low, high = sorted(s[1:3], key=lambda p: p[2])         # upwards, so that the angles are small
    axis = high - low
    length = np.linalg.norm(axis)
    R, r = Rotation.align_vectors([axis / length], [[0, 0, 1]])[0].as_matrix(), num(s[3])
    return [(name + "_cyl", num((low + high) / 2), rpy(R), "cylinder", {"radius": r, "length": num(length)}),
            (name + "_end0", num(low), "0 0 0", "sphere", {"radius": r}),
            (name + "_end1", num(high), "0 0 0", "sphere", {"radius": r})]


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


def read_meshes(ref):
    """{link: (body, origin in the body, mesh)}; links joined by fixed joints are one body, named after its first link."""
    root = ET.parse(ref / "urdf/g1_29dof_rev_1_0.urdf").getroot()
    fixed = {j.find("child").get("link"): j for j in root.findall("joint") if j.get("type") == "fixed"}
    out = {}
    for link in root.findall("link"):
        for v in link.findall("visual"):
            name = body = link.get("name")
            mesh = trimesh.load(ref / "meshes" / Path(v.find("geometry/mesh").get("filename")).name)
            offset = np.zeros(3)
            while body in fixed:                           # the fixed joints of links with meshes do not rotate
                origin = fixed[body].find("origin")
                offset = offset + ([float(x) for x in origin.get("xyz").split()] if origin is not None else 0)
                body = fixed[body].find("parent").get("link")
            out[name] = body, offset, mesh
    return out


def main():
    ref, only = reference(), sys.argv[1:]
    meshes, fitted = read_meshes(ref), {}

    def place(name, to):
        mesh = meshes[name][2].copy()
        mesh.apply_translation(meshes[name][1] - meshes[to][1])
        return mesh

    for name, spec in LINKS.items():
        if only and name not in only:
            continue
        covered = [place(n, name) for n in [name, *COVERS.get(name, [])]]
        field = Field(covered + [place(n, name) for n in FILLED.get(name, [])])
        points = np.vstack([field.skin(m) for m in covered])
        units = UNDER, np.inf if name in OPEN else HULL, OVER
        given = [np.r_[x[:2], np.log(x[2:]), [0] * (len(x) == 5)] for x in STARTS.get(name, [])]
        shapes, under, beyond, over, cost = fit(field, points, hull_points(points), [k for k, _ in spec], units,
                                                np.concatenate(given) if given else None)
        print(f"{name:26} {len(shapes)} shapes, outside them: mesh {1e3 * under:5.1f} mm, hull {1e3 * beyond:5.1f} mm; "
              f"bulge {1e3 * over:5.1f} mm; cost {cost:.2f}", flush=True)
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
