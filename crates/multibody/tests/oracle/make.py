"""Writes the oracle files beside this script: dynamics of three robots as Pinocchio computes them.

usage: python make.py          (needs pin==4.1.0 example-robot-data==6.0.0, both from PyPI)

Per robot NAME.json: joint names in Pinocchio's order and, for each of two random states (q, v, a), the mass matrix M,
the inverse dynamics tau with its derivatives, the centroidal map A, the momentum h, its derivative by q, the centre of
mass and the pose of one frame. SI units, linear before angular, base velocity and tangents in the base frame. M is stored
as its upper triangle by rows, other matrices by rows. For robots whose licence permits it the URDF is written too, without
geometry; the others carry a table of joints in the JSON file.
"""
import json
import os
import re
import sys
import xml.etree.ElementTree as xml

import numpy as np
import pinocchio as pin

HERE = os.path.dirname(os.path.abspath(__file__))
ROBOTS = [
    # name, file of example-robot-data, floating base, may the URDF be copied, a frame
    ("g1", "g1_description/urdf/g1_29dof_rev_1_0.urdf", True, True, "left_rubber_hand"),
    ("panda", "panda_description/urdf/panda.urdf", False, True, "panda_hand"),
    ("talos", "talos_data/robots/talos_reduced.urdf", True, False, "gripper_left_base_link"),
]


def path_of(relative):
    """The file inside the wheel of example-robot-data, which has data and no module."""
    for root in sys.path:
        candidate = os.path.join(root, "cmeel.prefix", "share", "example-robot-data", "robots", relative)
        if os.path.isfile(candidate):
            return candidate
    raise FileNotFoundError(f"{relative}: install example-robot-data from PyPI")


def stripped(path):
    """The URDF text without geometry, materials, transmissions and simulator tags; numbers untouched."""
    root = xml.parse(path).getroot()
    for child in list(root):
        if child.tag not in ("link", "joint"):
            root.remove(child)
    for link in root.iter("link"):
        for child in list(link):
            if child.tag != "inertial":
                link.remove(child)
    for joint in root.iter("joint"):
        for child in list(joint):
            if child.tag not in ("origin", "parent", "child", "axis", "limit", "mimic"):
                joint.remove(child)
    xml.indent(root, space=" ")
    return xml.tostring(root, encoding="unicode") + "\n"


def load(path, floating):
    """The model with joints that mimic others locked at zero, as `Model::from_urdf` does."""
    model = pin.buildModelFromUrdf(path, pin.JointModelFreeFlyer()) if floating else pin.buildModelFromUrdf(path)
    mimicking = re.findall(r'<joint name="([^"]+)"(?:(?!</joint>).)*<mimic', open(path).read(), re.S)
    locked = [model.getJointId(name) for name in mimicking if model.existJointName(name)]
    return pin.buildReducedModel(model, locked, pin.neutral(model)) if locked else model


def random_state(model, rng):
    q = pin.neutral(model)
    for joint in list(model.joints)[1:]:
        if joint.nq == 7:
            quat = rng.normal(size=4)
            q[:7] = np.concatenate([rng.uniform(-1, 1, 3), quat / np.linalg.norm(quat)])
        else:
            low = max(model.lowerPositionLimit[joint.idx_q], -3.0)
            high = min(model.upperPositionLimit[joint.idx_q], 3.0)
            q[joint.idx_q] = rng.uniform(low, high)
    return q, rng.uniform(-2, 2, model.nv), rng.uniform(-5, 5, model.nv)


def numbers(array):
    return [float(f"{x:.15g}") + 0.0 for x in np.ravel(array)]


def dynamics(model, frame, q, v, a):
    data = model.createData()
    mass = pin.crba(model, data, q)
    mass = np.triu(mass) + np.triu(mass, 1).T
    tau = pin.rnea(model, data, q, v, a).copy()
    dtau_dq, dtau_dv, _ = (np.array(m) for m in pin.computeRNEADerivatives(model, data, q, v, a))
    com = pin.centerOfMass(model, data, q).copy()
    pin.computeCentroidalMap(model, data, q)
    centroidal = np.array(data.Ag)
    dh_dq = np.array(pin.computeCentroidalDynamicsDerivatives(model, data, q, v, a)[0])
    pin.framesForwardKinematics(model, data, q)
    pose = pin.SE3ToXYZQUAT(data.oMf[model.getFrameId(frame)])
    return {
        "q": numbers(q), "v": numbers(v), "a": numbers(a),
        "M_upper": numbers(mass[np.triu_indices(model.nv)]),
        "tau": numbers(tau), "dtau_dq": numbers(dtau_dq), "dtau_dv": numbers(dtau_dv),
        "com": numbers(com), "A": numbers(centroidal), "h": numbers(centroidal @ v), "dh_dq": numbers(dh_dq),
        "frame_xyzquat": numbers(pose),
    }


def axis_of(joint):
    short = joint.shortname()
    for letter, axis in (("X", [1, 0, 0]), ("Y", [0, 1, 0]), ("Z", [0, 0, 1])):
        if short in (f"JointModelR{letter}", f"JointModelP{letter}"):
            return axis
    raise ValueError(short)


def joint_table(model):
    """Kind, parent (−1 for the world), axis, placement and inertia of every joint."""
    table = []
    for i in range(1, model.njoints):
        joint, placement, inertia = model.joints[i], model.jointPlacements[i], model.inertias[i]
        free = joint.nq == 7
        table.append({
            "name": model.names[i], "parent": model.parents[i] - 1, "kind": "free" if free else "revolute",
            "axis": [0, 0, 0] if free else axis_of(joint),
            "rotation": numbers(placement.rotation), "translation": numbers(placement.translation),
            "mass": inertia.mass, "com": numbers(inertia.lever), "inertia": numbers(inertia.inertia),
        })
    return table


def main():
    for name, relative, floating, copy, frame in ROBOTS:
        path = path_of(relative)
        model = load(path, floating)
        rng = np.random.default_rng(20261121)
        record = {
            "source": f"Pinocchio {pin.__version__} on example-robot-data, {relative}",
            "floating": floating,
            "joints": list(model.names)[2 if floating else 1:],
            "mass": sum(inertia.mass for inertia in list(model.inertias)[1:]),
            "frame": frame,
            "states": [],
        }
        if copy:
            with open(os.path.join(HERE, f"{name}.urdf"), "w") as out:
                out.write(stripped(path))
        else:
            record["table"] = joint_table(model)
        for _ in range(2):
            record["states"].append(dynamics(model, frame, *random_state(model, rng)))
        with open(os.path.join(HERE, f"{name}.json"), "w") as out:
            json.dump(record, out, separators=(",", ":"))
            out.write("\n")
        print(name, "nv", model.nv, "mass", record["mass"])


if __name__ == "__main__":
    main()
