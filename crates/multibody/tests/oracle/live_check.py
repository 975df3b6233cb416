"""Compares this crate with Pinocchio on random states of any robot, live.

usage: python live_check.py URDF [--fixed] [--states N] [--seed N] [--cargo CARGO]     (needs pin and numpy from PyPI)

Runs `cargo run --release -p multibody --example dump_dynamics` and evaluates the same states with Pinocchio. Second
derivatives are compared with central differences of Pinocchio's first ones. Exit code 0 if all agree.
"""
import argparse
import json
import os
import subprocess
import sys
import xml.etree.ElementTree as xml

import numpy as np
import pinocchio as pin

TOLERANCE = 1e-9       # of the largest entry of a quantity
DIFFERENCES = 1e-6     # the same where one side is a difference quotient


def ours(arguments):
    here = os.path.dirname(os.path.abspath(__file__))
    root = "fixed" if arguments.fixed else "floating"
    command = [arguments.cargo, "run", "--release", "--quiet", "-p", "multibody", "--example", "dump_dynamics", "--",
               os.path.abspath(arguments.urdf), root, str(arguments.states), str(arguments.seed)]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True, cwd=here).stdout)


def theirs(urdf, record):
    """The model, joints that we do not have locked (at the offset of their mimic tag), and their velocity index of ours."""
    model = pin.buildModelFromUrdf(urdf, pin.JointModelFreeFlyer()) if record["floating"] else pin.buildModelFromUrdf(urdf)
    names = record["joints"][1:] if record["floating"] else record["joints"]
    known = set(names) | {"root_joint", "universe"}
    locked = [i for i in range(1, model.njoints) if model.names[i] not in known]
    if locked:
        at = pin.neutral(model)
        for joint in xml.parse(urdf).getroot().iter("joint"):
            mimic = joint.find("mimic")
            if mimic is not None and model.existJointName(joint.get("name")):
                at[model.joints[model.getJointId(joint.get("name"))].idx_q] = float(mimic.get("offset", 0))
        model = pin.buildReducedModel(model, locked, at)
    base = 6 if record["floating"] else 0
    order = list(range(base)) + [model.joints[model.getJointId(name)].idx_v for name in names]
    return model, np.array(order)


def configuration(model, record, q):
    """Their q of ours; continuous joints are a sine and a cosine there."""
    out = pin.neutral(model)
    base = 7 if record["floating"] else 0
    out[:base] = q[:base]
    for name, value in zip(record["joints"][1 if base else 0:], q[base:]):
        joint = model.joints[model.getJointId(name)]
        if joint.nq == 2:
            out[joint.idx_q:joint.idx_q + 2] = np.cos(value), np.sin(value)
        else:
            out[joint.idx_q] = value
    return out


def compare(model, order, record, state):
    """Largest relative gap per quantity."""
    nv, inverse = model.nv, np.argsort(order)
    read = lambda key, shape: np.array(state[key]).reshape(shape)
    data = model.createData()
    q = configuration(model, record, state["q"])
    v, a, w = (np.array(state[key])[inverse] for key in "vaw")
    gaps = {}

    def check(key, mine, other, tolerance=TOLERANCE, floor=1e-300):
        gaps[key] = (np.abs(mine - other).max() / max(np.abs(other).max(), floor), tolerance)

    square = lambda matrix: matrix[np.ix_(order, order)]
    mass = pin.crba(model, data, q)
    check("M", read("M", (nv, nv)), square(np.triu(mass) + np.triu(mass, 1).T))
    check("tau", read("tau", nv), pin.rnea(model, data, q, v, a)[order])
    dtau_dq, dtau_dv, _ = (np.array(m) for m in pin.computeRNEADerivatives(model, data, q, v, a))
    check("dtau_dq", read("dtau_dq", (nv, nv)), square(dtau_dq))
    check("dtau_dv", read("dtau_dv", (nv, nv)), square(dtau_dv))
    check("com", read("com", 3), pin.centerOfMass(model, data, q))
    pin.computeCentroidalMap(model, data, q)
    check("A", read("A", (6, nv)), data.Ag[:, order])
    check("h", read("h", 6), data.Ag @ v)
    dh_dq = np.array(pin.computeCentroidalDynamicsDerivatives(model, data, q, v, a)[0])
    check("dh_dq", read("dh_dq", (6, nv)), dh_dq[:, order])
    pin.framesForwardKinematics(model, data, q)
    poses = read("frames_xyzquat", (-1, 7))
    placed = lambda name: data.oMf[model.getFrameId(name, pin.BODY)]
    gap = [np.abs(pin.log6(pin.XYZQUATToSE3(pose).actInv(placed(name))).vector).max() for name, pose in
           zip(record["frames"], poses)]
    gaps["frames"] = (max(gap), TOLERANCE)

    def gradients(q, v):
        by_q, by_v, by_a = (np.array(m) for m in pin.computeRNEADerivatives(model, data, q, v, a))
        return w @ by_q, w @ by_v, w @ (np.triu(by_a) + np.triu(by_a, 1).T)

    columns = {"vv": [], "qv": [], "qa": []}
    step = 1e-4
    for k in order:
        unit = step * np.eye(nv)[k]
        plus, minus = gradients(q, v + unit), gradients(q, v - unit)
        columns["qv"].append((plus[0] - minus[0]) / (2 * step))
        columns["vv"].append((plus[1] - minus[1]) / (2 * step))
        plus, minus = gradients(pin.integrate(model, q, unit), v), gradients(pin.integrate(model, q, -unit), v)
        columns["qa"].append((plus[2] - minus[2]) / (2 * step))
    floor = 1e-2 * np.abs(mass).max()  # of blocks that vanish, as for a single body
    check("hessian_qv", read("hessian_qv", (nv, nv)), np.array(columns["qv"]).T[order], DIFFERENCES, floor)
    check("hessian_vv", read("hessian_vv", (nv, nv)), np.array(columns["vv"]).T[order], DIFFERENCES, floor)
    check("hessian_qa", read("hessian_qa", (nv, nv)), np.array(columns["qa"])[:, order], DIFFERENCES, floor)
    return gaps


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("urdf")
    parser.add_argument("--fixed", action="store_true", help="the root link does not move")
    parser.add_argument("--states", type=int, default=5)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--cargo", default="cargo")
    arguments = parser.parse_args()

    record = ours(arguments)
    model, order = theirs(arguments.urdf, record)
    mass = sum(inertia.mass for inertia in list(model.inertias)[1:])
    if model.nv != record["nv"] or abs(mass - record["mass"]) > TOLERANCE * mass:
        sys.exit(f"nv {record['nv']} and mass {record['mass']} here, {model.nv} and {mass} in Pinocchio")
    worst = {}
    for state in record["states"]:
        for key, (gap, tolerance) in compare(model, order, record, state).items():
            worst[key] = (max(gap, worst.get(key, (0.0, 0))[0]), tolerance)
    failed = [key for key, (gap, tolerance) in worst.items() if not gap <= tolerance]
    print(f"{arguments.urdf}: nv {model.nv}, {len(record['states'])} states, Pinocchio {pin.__version__}")
    for key, (gap, tolerance) in worst.items():
        print(f"  {key:11s} {gap:.1e}  (allowed {tolerance:.0e})" + ("  FAILED" if key in failed else ""))
    for note in record["notes"]:
        print("  note:", note)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
