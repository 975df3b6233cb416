"""Checks g1.urdf and g1.toml against the published description of the Unitree G1; exit code 1 if anything is off.

Numbers: the models that Pinocchio builds from g1.urdf and from g1_29dof_rev_1_0.urdf agree (names, placements,
inertias, limits, mass matrix, inverse dynamics). Shapes: every point of a link's published mesh lies within 2 cm of
the union of the shapes of its rigid body, no shape reaches further than 3 cm from the meshes of its body; a cylinder
is read exactly, and also as the capsule of the same total length that some readers make of it. Stance and
interfaces: no overlap of links more than two joints apart, soles level, centre of mass over them, patches on the meshes.

Needs: pip install pin example-robot-data trimesh numpy scipy (pin brings coal); Python 3.11. Takes half a minute.
`--verbose` prints every link; `--sweep` also moves each joint through its range and lists what then touches.
"""
import argparse
import itertools
import site
import sys
import tomllib
import xml.etree.ElementTree as ET
from pathlib import Path

import coal
import numpy as np
import pinocchio as pin
import trimesh
from scipy.spatial import ConvexHull, cKDTree

HERE = Path(__file__).parent
MAX_UNCOVERED = 0.020          # m: mesh point outside the shapes
MAX_BULGE = 0.030              # m: shape point outside the mesh
PALM_TOLERANCE = 0.001         # m: the palm's plane from wrist and finger tips
NUMBERS = 1e-12                # relative: mass matrix and inverse dynamics


def reference():
    """The folder of the G1 in the installed example-robot-data."""
    for root in site.getsitepackages() + sys.path:
        p = Path(root) / "cmeel.prefix/share/example-robot-data/robots/g1_description"
        if p.is_dir():
            return p
    raise SystemExit("example-robot-data is not installed: pip install example-robot-data")


class Report:
    def __init__(self):
        self.failed = 0

    def line(self, text, value, limit, unit="mm", scale=1e3):
        bad = not value <= limit
        self.failed += bad
        print(f'{"FAIL" if bad else "ok":4}  {text:58} {scale * value:9.3g} (limit {scale * limit:.3g}) {unit}')

    def holds(self, text, condition):
        self.failed += not condition
        print(f'{"ok" if condition else "FAIL":4}  {text}')


# ---------------------------------------------------------------- numbers

def check_numbers(r, ours, theirs):
    a, b = (pin.buildModelFromUrdf(str(u), pin.JointModelFreeFlyer()) for u in (ours, theirs))
    r.holds("same joints, links and frames",
            list(a.names) == list(b.names) and [(f.name, f.type) for f in a.frames] == [(f.name, f.type) for f in b.frames])
    worst = lambda pairs: max(np.abs(np.nan_to_num(np.asarray(x) - np.asarray(y))).max() for x, y in pairs)
    r.line("joint placements", worst((x.homogeneous, y.homogeneous) for x, y in zip(a.jointPlacements, b.jointPlacements)), 0, "m", 1)
    r.line("frame placements", worst((x.placement.homogeneous, y.placement.homogeneous) for x, y in zip(a.frames, b.frames)), 0, "m", 1)
    r.line("inertias", worst((x.matrix(), y.matrix()) for x, y in zip(a.inertias, b.inertias)), 0, "SI", 1)
    r.line("position, velocity and effort limits", worst(
        (getattr(a, n), getattr(b, n)) for n in ("lowerPositionLimit", "upperPositionLimit", "velocityLimit", "effortLimit")), 0, "SI", 1)
    rng, da, db, mass, torque = np.random.default_rng(0), a.createData(), b.createData(), 0.0, 0.0
    for _ in range(50):
        q = pin.integrate(a, pin.neutral(a), rng.uniform(-1, 1, a.nv))
        v, acc = rng.uniform(-5, 5, (2, a.nv))
        Ma, Mb = pin.crba(a, da, q), pin.crba(b, db, q)
        ta, tb = pin.rnea(a, da, q, v, acc), pin.rnea(b, db, q, v, acc)
        mass, torque = max(mass, np.abs(Ma - Mb).max() / np.abs(Mb).max()), max(torque, np.abs(ta - tb).max() / np.abs(tb).max())
    r.line("mass matrix", mass, NUMBERS, "relative", 1)
    r.line("inverse dynamics", torque, NUMBERS, "relative", 1)
    total = sum(i.mass for i in a.inertias)
    r.line(f"total mass {total:.4f} kg, from 33.34 kg", abs(total - 33.34), 0.01, "kg", 1)
    return a


# ---------------------------------------------------------------- shapes: (link, kind, placement in the body, size)

def pose_of(element):
    o = element.find("origin")
    xyz, rpy = ([float(x) for x in (o.get(k) or "0 0 0").split()] if o is not None else [0, 0, 0] for k in ("xyz", "rpy"))
    return pin.SE3(pin.rpy.rpyToMatrix(*rpy), np.array(xyz))


def read_shapes(urdf, model, tag):
    """Shapes by Pinocchio joint."""
    out = {}
    for link in ET.parse(urdf).getroot().findall("link"):
        frame = model.frames[model.getFrameId(link.get("name"), pin.BODY)]
        for e in link.findall(tag):
            g, M = e.find("geometry")[0], frame.placement * pose_of(e)
            size = (np.array([float(x) for x in g.get("size").split()]) / 2 if g.tag == "box" else float(g.get("radius")) if g.tag == "sphere"
                    else (float(g.get("radius")), float(g.get("length")) / 2))
            out.setdefault(frame.parentJoint, []).append((link.get("name"), g.tag, M, size))
    return out


def distance(shape, P, rounded):
    """Distance of points to a shape, zero inside; `rounded` reads a cylinder as a capsule of the same total length."""
    _, kind, M, size = shape
    X = (P - M.translation) @ M.rotation
    if kind == "box":
        return np.linalg.norm(np.maximum(np.abs(X) - size, 0), axis=1)
    if kind == "sphere":
        return np.maximum(np.linalg.norm(X, axis=1) - size, 0)
    radius, half = size
    if rounded:
        X[:, 2] -= np.clip(X[:, 2], *(np.array([-1, 1]) * max(half - radius, 1e-3)))
        return np.maximum(np.linalg.norm(X, axis=1) - radius, 0)
    return np.hypot(np.maximum(np.hypot(X[:, 0], X[:, 1]) - radius, 0), np.maximum(np.abs(X[:, 2]) - half, 0))


def surface(shape, step=0.004):
    """Points on a shape, about `step` apart (exact reading: it contains the capsule, except for short cylinders)."""
    _, kind, M, size = shape
    line = lambda h: np.linspace(-h, h, int(np.ceil(2 * h / step)) + 1)
    if kind == "box":
        X = []
        for i in range(3):
            u, v = np.meshgrid(line(size[i - 2]), line(size[i - 1]))
            X += [np.roll(np.c_[np.full(u.size, s * size[i]), u.ravel(), v.ravel()], i, axis=1) for s in (-1, 1)]
        X = np.vstack(X)
    elif kind == "sphere":
        n = int(4 * np.pi * (size / step) ** 2)
        z = 1 - (2 * np.arange(n) + 1) / n
        phi = np.pi * (1 + 5**0.5) * np.arange(n)
        X = size * np.c_[np.sqrt(1 - z**2) * np.cos(phi), np.sqrt(1 - z**2) * np.sin(phi), z]
    else:
        radius, half = size
        phi = np.linspace(0, 2 * np.pi, int(2 * np.pi * radius / step) + 1)
        ring = np.c_[np.cos(phi), np.sin(phi)]
        X = [np.c_[radius * ring, np.full(len(phi), z)] for z in line(half)]
        X += [np.c_[s * ring, np.full(len(phi), z)] for s in np.arange(step, radius, step) for z in (-half, half)]
        X = np.vstack(X)
    return X @ M.rotation.T + M.translation


# ---------------------------------------------------------------- meshes

def samples(mesh, spacing=0.0015):
    """All vertices and points spread over the faces."""
    rng = np.random.default_rng(0)
    n = int(mesh.area / spacing**2)
    tri = rng.choice(len(mesh.faces), n, p=mesh.area_faces / mesh.area_faces.sum())
    return np.vstack([mesh.vertices, np.einsum("ij,ijk->ik", rng.dirichlet(np.ones(3), n), mesh.triangles[tri])])


def inside(mesh, P):
    """Whether points are inside a mesh, holes notwithstanding: winding number above one half."""
    out = np.zeros(len(P))
    for i, p in enumerate(P):
        a, b, c = (mesh.triangles[:, k] - p for k in range(3))
        la, lb, lc = (np.linalg.norm(x, axis=1) for x in (a, b, c))
        det = np.einsum("ij,ij->i", a, np.cross(b, c))
        den = la * lb * lc + np.einsum("ij,ij->i", a, b) * lc + np.einsum("ij,ij->i", b, c) * la + np.einsum("ij,ij->i", c, a) * lb
        out[i] = np.arctan2(det, den).sum() / (2 * np.pi)
    return out > 0.5


def read_meshes(ref, model):
    """(link, mesh in the body) by Pinocchio joint."""
    out = {}
    for link in ET.parse(ref / "urdf/g1_29dof_rev_1_0.urdf").getroot().findall("link"):
        frame = model.frames[model.getFrameId(link.get("name"), pin.BODY)]
        for e in link.findall("visual"):
            mesh = trimesh.load(ref / "meshes" / Path(e.find("geometry/mesh").get("filename")).name)
            mesh.apply_transform((frame.placement * pose_of(e)).homogeneous)
            out.setdefault(frame.parentJoint, []).append((link.get("name"), mesh))
    return out


def hull_distance(hull, P):
    """How far points are beyond the worst face of a convex hull: a lower bound of the distance, zero inside."""
    return np.maximum((P @ hull.equations[:, :3].T + hull.equations[:, 3]).max(1), 0)


def check_coverage(r, model, shapes, meshes, verbose):
    rows = []
    for joint, body in meshes.items():
        mine = shapes.get(joint, [])
        clouds = {link: samples(m) for link, m in body}
        everything = np.vstack(list(clouds.values()))
        tree = cKDTree(everything)
        out = lambda P, S: max(np.min([distance(s, P, k) for s in S], axis=0).max() for k in (False, True)) if S else np.inf
        for link, mesh in body:
            own = [s for s in mine if s[0] == link]
            corners = mesh.vertices[ConvexHull(mesh.vertices).vertices]
            hull = ConvexHull(corners)
            filled = samples(trimesh.Trimesh(corners, hull.simplices), 0.003)
            bulge = strict = beyond_hull = 0.0
            for s in own:
                P = surface(s)
                P = P[np.min([distance(o, P, False) for o in own if o is not s] + [np.ones(len(P))], axis=0) > 0]
                if not len(P):
                    continue                                # inside the link's other shapes
                d = tree.query(P)[0]
                far = d > 0.02                              # those near a mesh need no further look
                far[far] = ~np.any([inside(m, P[far]) for _, m in body], axis=0) if far.any() else False
                bulge, beyond_hull = max(bulge, d[far].max() if far.any() else d.max().clip(0, 0.02)), max(beyond_hull, hull_distance(hull, P).max())
            rows.append((link, len(own), out(clouds[link], mine), out(clouds[link], own), out(filled, mine), bulge, beyond_hull))
    if verbose:
        print("      link: by the shapes of this link alone, - if it has none and its body's others cover it")
        print(f'{"link":28} shapes   uncovered mm: body  link  hull   bulge mm: meshes  hull')
        for n, k, a, b, c, d, e in rows:
            print(f"{n:28} {k:6} {1e3 * a:19.1f} {f'{1e3 * b:5.1f}' if k else '    -'} {1e3 * c:5.1f} {1e3 * d:18.1f} {1e3 * e:5.1f}")
    for i, what, limit in ((2, "mesh outside its body's shapes", MAX_UNCOVERED), (3, "mesh outside its own link's shapes", MAX_UNCOVERED),
                           (4, "convex hull of a mesh outside its body's shapes", np.inf), (5, "shape outside its body's meshes", MAX_BULGE),
                           (6, "shape outside the convex hull of its link's mesh", MAX_BULGE)):
        judged = [x for x in rows if x[1] or i != 3]
        w = max(judged, key=lambda x: x[i])
        r.line(f"{what}: {w[0]}", w[i], limit)


# ---------------------------------------------------------------- stance

def coal_shape(kind, size):
    if kind == "box":
        return coal.Box(*(2 * size))
    return coal.Sphere(size) if kind == "sphere" else coal.Cylinder(size[0], 2 * size[1])


def far_apart(model):
    """Pairs of joints whose bodies are more than two joints apart."""
    def up(j):
        return [j] + (up(model.parents[j]) if j > 1 else [])
    steps = lambda a, b: min(i + up(b).index(j) for i, j in enumerate(up(a)) if j in up(b))
    return [(a, b) for a in range(1, model.njoints) for b in range(a + 1, model.njoints) if steps(a, b) > 2]


class Collisions:
    def __init__(self, model, geometry):
        """geometry: {joint: [(link, coal geometry, placement in the body)]}"""
        self.model, self.data, self.geometry, self.pairs = model, model.createData(), geometry, far_apart(model)

    def distances(self, q):
        """{(body, body): signed distance in m} of bodies more than two joints apart, each named after its first link."""
        pin.forwardKinematics(self.model, self.data, q)
        req, res, out = coal.DistanceRequest(), coal.DistanceResult(), {}
        place = {j: [(g, coal.Transform3s(T.rotation, T.translation)) for _, g, M in S for T in [self.data.oMi[j] * M]]
                 for j, S in self.geometry.items()}
        for a, b in self.pairs:
            if np.linalg.norm(self.data.oMi[a].translation - self.data.oMi[b].translation) > 0.9:
                continue
            for ga, Ta in place.get(a, []):
                for gb, Tb in place.get(b, []):
                    key = self.geometry[a][0][0], self.geometry[b][0][0]
                    out[key] = min(out.get(key, np.inf), coal.distance(ga, Ta, gb, Tb, req, res))
                    res.clear()
        return out


def sweep(model, q0, ours, theirs):
    """Every joint through its range from the stance: bodies that touch, here and as convex hulls of the meshes."""
    differences = []
    for j in range(2, model.njoints):
        i = model.joints[j].idx_q
        seen = {}
        for x in np.linspace(model.lowerPositionLimit[i], model.upperPositionLimit[i], 25):
            q = q0.copy()
            q[i] = x
            a, b = ours.distances(q), theirs.distances(q)
            for pair in a:
                if min(a[pair], b[pair]) < 0:
                    seen.setdefault(pair, []).append((x, a[pair], b[pair]))
        for pair, hits in seen.items():
            x, a, b = np.array(hits).T
            print(f"      {model.names[j]:28} {min(x):6.2f} .. {max(x):5.2f} rad  {pair[0]} / {pair[1]}: distance "
                  f"{1e3 * min(a):.0f} mm, published hulls {1e3 * min(b):.0f} mm")
            differences += [(d, h, model.names[j], *pair) for d, h in zip(a, b)]
    print("      shapes touch, hulls furthest apart: {1:.4f} m, {2}, {3} / {4}".format(*max((x for x in differences if x[0] < 0), key=lambda x: x[1])))
    print("      hulls touch, shapes furthest apart: {0:.4f} m, {2}, {3} / {4}".format(*max((x for x in differences if x[1] < 0), key=lambda x: x[0])))


def check_stance(r, model, robot, shapes, meshes, do_sweep):
    q, data = pin.neutral(model), model.createData()
    for name, value in robot["home"].items():
        j = model.getJointId(name)
        r.failed += j >= model.njoints
        i = model.joints[j].idx_q
        q[i] = value
        if not model.lowerPositionLimit[i] <= value <= model.upperPositionLimit[i]:
            r.holds(f"home: {name} = {value} within its limits", False)
    ours = Collisions(model, {j: [(n, coal_shape(k, s), M) for n, k, M, s in S] for j, S in shapes.items()})
    gap = ours.distances(q)
    nearest = min(gap, key=gap.get)
    r.holds(f"home: no overlap of links more than two joints apart; nearest {nearest[0]} / {nearest[1]}, {1e3 * gap[nearest]:.0f} mm",
            gap[nearest] > 0)
    pin.centerOfMass(model, data, q)
    pin.framesForwardKinematics(model, data, q)
    soles = []
    for i in robot["interface"]:
        if i["role"] == "foot":
            f = model.frames[model.getFrameId(i["link"], pin.BODY)]
            soles.append(data.oMi[f.parentJoint] * f.placement * pin.XYZQUATToSE3(np.array(i["pose"])))
    low = np.vstack([s.act(np.array([x, y, 0])) for s, i in zip(soles, robot["interface"]) for x in (-1, 1) * np.array(i["half_size"][:1])
                     for y in (-1, 1) * np.array(i["half_size"][1:])])
    r.line("home: corners of the soles from one level plane", np.ptp(low[:, 2]), 1e-6)
    apart = abs(soles[0].translation[1] - soles[1].translation[1])
    r.holds(f"home: feet {apart:.3f} m apart, from 0.20 to 0.25", 0.20 <= apart <= 0.25)
    middle = np.mean([s.translation for s in soles], axis=0)
    r.line("home: centre of mass from the middle of the soles, x", abs(data.com[0] - middle)[0], 0.010)
    r.line("home: centre of mass from the middle of the soles, y", abs(data.com[0] - middle)[1], 0.010)
    print(f"      home: base {-low[:, 2].mean():.4f} m above the ground, {-middle[0]:.4f} m in x from the soles' middle")
    if do_sweep:
        hull = {}
        for j, body in meshes.items():
            for link, mesh in body:
                p = coal.StdVec_Vec3s()
                for v in mesh.vertices:
                    p.append(v)
                hull.setdefault(j, []).append((link, coal.Convex.convexHull(p, True, "Qt"), pin.SE3.Identity()))
        sweep(model, q, ours, Collisions(model, hull))


# ---------------------------------------------------------------- interfaces

def beyond(plane, points):
    """How far points reach beyond the plane z = 0 of a frame [m]; negative: all stay behind it."""
    return ((points - plane.translation) @ plane.rotation)[:, 2].max()


def wrist_beyond(model, hand, patch, points):
    """The same of the two joints above a hand, whose points are given by joint, at 40 angles of the hand's joint [m]."""
    data, q = model.createData(), pin.neutral(model)
    at = model.joints[hand].idx_q
    above = [model.parents[hand], model.parents[model.parents[hand]]]
    found = []
    for q[at] in np.linspace(model.lowerPositionLimit[at], model.upperPositionLimit[at], 40):
        pin.forwardKinematics(model, data, q)
        plane = data.oMi[hand] * patch
        found.append(max(beyond(plane, points[j] @ data.oMi[j].rotation.T + data.oMi[j].translation) for j in above))
    return np.array(found)


def check_interfaces(r, model, robot, shapes, meshes):
    names = set()
    for i in robot["interface"]:
        names.add(i["name"])
        frame = model.frames[model.getFrameId(i["link"], pin.BODY)]
        patch = frame.placement * pin.XYZQUATToSE3(np.array(i["pose"]))
        hx, hy = i["half_size"]
        u = (np.arange(40) + 0.5) / 40
        radius = np.hypot(*np.meshgrid(u * hx, u * hy)).mean()
        r.line(f"{i['name']}: mu_r, from mu times mean radius", i["mu_r"], i["mu"] * radius, "mm")
        mesh = next(m for n, m in meshes[frame.parentJoint] if n == i["link"])
        local = mesh.copy()
        local.apply_transform(patch.inverse().homogeneous)
        box = [(s, (patch.inverse() * s[2])) for s in shapes[frame.parentJoint] if s[0] == i["link"] and s[1] == "box"]
        face = min(abs(np.abs(M.rotation[2] @ (np.eye(3) * s[3])).max() + M.translation[2]) for s, M in box)
        if i["role"] == "foot":
            flat = local.vertices[local.vertices[:, 2] > local.vertices[:, 2].max() - 1e-4]
            r.line(f"{i['name']}: patch from the lowest plane of the mesh", abs(local.vertices[:, 2].max()), 1e-4)
            edge = ConvexHull(flat[:, :2]).equations
            corner = np.array([[sx * hx, sy * hy] for sx in (-1, 1) for sy in (-1, 1)])
            r.line(f"{i['name']}: corners outside the flat part of the mesh", max(0, (corner @ edge[:, :2].T + edge[:, 2]).max()), 0)
            r.line(f"{i['name']}: face of a box from the patch", face, 1e-4)
        else:
            hand = np.vstack([m.vertices for _, m in meshes[frame.parentJoint]])
            r.line(f"{i['name']}: plane from the mesh", abs(beyond(patch, hand)), PALM_TOLERANCE)
            vertices = {j: np.vstack([m.vertices for _, m in body]) for j, body in meshes.items()}
            wrist = wrist_beyond(model, frame.parentJoint, patch, vertices).min()
            r.line(f"{i['name']}: wrist and forearm beyond the plane, at the best of 40 wrist angles", max(0, wrist), PALM_TOLERANCE)
            outsides = {j: np.vstack([surface(s) for s in body]) for j, body in shapes.items()}
            behind = np.count_nonzero(wrist_beyond(model, frame.parentJoint, patch, outsides) <= PALM_TOLERANCE)
            r.holds(f"{i['name']}: their shapes behind it at {behind} of the 40, at least 15", behind >= 15)
            ahead = [(M.rotation @ (np.array(c) * s[3]) + M.translation)[2] for s, M in box for c in itertools.product((-1, 1), repeat=3)]
            r.line(f"{i['name']}: boxes beyond the plane", max(0, max(ahead)), PALM_TOLERANCE)
    r.holds("interfaces left_foot, right_foot, left_hand, right_hand", names == {"left_foot", "right_foot", "left_hand", "right_hand"})


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument("--verbose", action="store_true", help="print every link")
    ap.add_argument("--sweep", action="store_true", help="move each joint through its range")
    a = ap.parse_args()
    ref, r = reference(), Report()
    robot = tomllib.loads((HERE / "g1.toml").read_text())
    urdf = HERE / robot["urdf"]
    model = check_numbers(r, urdf, ref / "urdf/g1_29dof_rev_1_0.urdf")
    shapes = read_shapes(urdf, model, "collision")
    seen = read_shapes(urdf, model, "visual")
    r.holds("visual and collision shapes are the same", repr(shapes) == repr(seen))
    print(f"      {sum(map(len, shapes.values()))} elements: " + ", ".join(
        f"{sum(s[1] == k for S in shapes.values() for s in S)} {k}" for k in ("box", "sphere", "cylinder")))
    meshes = read_meshes(ref, model)
    check_coverage(r, model, shapes, meshes, a.verbose)
    check_interfaces(r, model, robot, shapes, meshes)
    check_stance(r, model, robot, shapes, meshes, a.sweep)
    print("all checks passed" if not r.failed else f"{r.failed} checks failed")
    return 1 if r.failed else 0


if __name__ == "__main__":
    sys.exit(main())
