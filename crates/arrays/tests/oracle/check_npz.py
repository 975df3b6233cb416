"""Compares the arrays of an exported plan with Pinocchio, and with themselves.

usage: python check_npz.py PLAN.json PLAN.npz     (needs pin and numpy from PyPI)

Links and their velocities are computed with Pinocchio from the URDF in the plan, from the arrays of the base and the joints.
Velocities are compared with central differences of positions. Exit code 0 if all is within its tolerance.
"""
import json
import sys

import numpy as np
import pinocchio as pin

POSE = 1e-9       # m, and entries of rotation matrices
VELOCITY = 1e-9   # m/s, rad/s


def model_of(plan):
    """Pinocchio's model of the robot, joints that the plan does not name locked at zero."""
    model = pin.buildModelFromXML(plan["robot"]["urdf"], pin.JointModelFreeFlyer())
    known = set(plan["robot"]["joints"]) | {"root_joint", "universe"}
    locked = [i for i in range(1, model.njoints) if model.names[i] not in known]
    return pin.buildReducedModel(model, locked, pin.neutral(model)) if locked else model


def rotation(wxyz):
    return pin.Quaternion(wxyz[0], *wxyz[1:]).matrix()


def against_pinocchio(plan, arrays):
    """Largest gaps of positions, axes, linear and angular velocities of links."""
    model = model_of(plan)
    data = model.createData()
    joints = [model.joints[model.getJointId(str(name))] for name in arrays["joint_names"]]
    frames = [model.getFrameId(str(name), pin.FrameType.BODY) for name in arrays["body_names"]]
    gaps = dict.fromkeys(["body_pos_w", "body_quat_w", "body_lin_vel_w", "body_ang_vel_w"], 0.0)
    for t in range(len(arrays["time"])):
        q, v = pin.neutral(model), np.zeros(model.nv)
        w, x, y, z = arrays["body_quat_w"][t, 0]
        turn = rotation((w, x, y, z))
        q[:3], q[3:7] = arrays["body_pos_w"][t, 0], (x, y, z, w)
        v[:3] = turn.T @ arrays["body_lin_vel_w"][t, 0]
        v[3:6] = turn.T @ arrays["body_ang_vel_w"][t, 0]
        for joint, position, rate in zip(joints, arrays["joint_pos"][t], arrays["joint_vel"][t]):
            if joint.nq == 2:  # continuous
                q[joint.idx_q:joint.idx_q + 2] = np.cos(position), np.sin(position)
            else:
                q[joint.idx_q] = position
            v[joint.idx_v] = rate
        pin.forwardKinematics(model, data, q, v)
        pin.updateFramePlacements(model, data)
        for b, frame in enumerate(frames):
            pose = data.oMf[frame]
            twist = pin.getFrameVelocity(model, data, frame, pin.LOCAL_WORLD_ALIGNED)
            for key, gap in (
                ("body_pos_w", pose.translation - arrays["body_pos_w"][t, b]),
                ("body_quat_w", pose.rotation - rotation(arrays["body_quat_w"][t, b])),
                ("body_lin_vel_w", twist.linear - arrays["body_lin_vel_w"][t, b]),
                ("body_ang_vel_w", twist.angular - arrays["body_ang_vel_w"][t, b]),
            ):
                gaps[key] = max(gaps[key], np.abs(gap).max())
    return gaps


def differences(arrays):
    """Largest gaps between velocities and central differences; they shrink with the rate."""
    step = 2.0 / float(arrays["fps"][0])
    gap = lambda of, value: np.abs((arrays[of][2:] - arrays[of][:-2]) / step - arrays[value][1:-1]).max(initial=0.0)
    gaps = {"joint_vel": gap("joint_pos", "joint_vel")}
    for kind in ("body", "object"):
        gaps[f"{kind}_lin_vel_w"] = gap(f"{kind}_pos_w", f"{kind}_lin_vel_w")
        q = arrays[f"{kind}_quat_w"]
        rate, (w, x, y, z) = (q[2:] - q[:-2]) / step, np.moveaxis(q[1:-1], -1, 0)
        a, b, c, d = np.moveaxis(rate, -1, 0)  # (0, ω) = 2 rate · conjugate
        omega = 2 * np.stack([b * w - a * x - c * z + d * y, c * w - a * y - d * x + b * z, d * w - a * z - b * y + c * x], -1)
        gaps[f"{kind}_ang_vel_w"] = np.abs(omega - arrays[f"{kind}_ang_vel_w"][1:-1]).max(initial=0.0)
    return gaps


def at_the_nodes(plan, arrays):
    """Largest gap of joints at samples that lie at nodes, and how many those are."""
    nodes, times = np.array(plan["time"]), arrays["time"]
    near = [(k, int(np.abs(nodes - t).argmin())) for k, t in enumerate(times)]
    near = [(k, n) for k, n in near if abs(nodes[n] - times[k]) < 1e-9]
    q, v = np.array(plan["q"])[:, 7:], np.array(plan["v"])[:, 6:]
    gaps = [max(np.abs(arrays["joint_pos"][k] - q[n]).max(), np.abs(arrays["joint_vel"][k] - v[n]).max()) for k, n in near]
    return max(gaps), len(gaps)


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        plan = json.load(file)
    arrays = dict(np.load(sys.argv[2]))
    failed = False
    for key, gap in against_pinocchio(plan, arrays).items():
        failed |= not gap < (VELOCITY if "vel" in key else POSE)
        print(f"{key:16} from Pinocchio's by at most {gap:.1e}")
    gap, count = at_the_nodes(plan, arrays)
    failed |= not gap < POSE
    print(f"joints at {count} nodes from the plan's by at most {gap:.1e}")
    for key in ("body_quat_w", "object_quat_w"):
        along = (arrays[key][1:] * arrays[key][:-1]).sum(-1)
        failed |= bool((along < 0).any())
    print("least product of neighbouring quaternions", along.min(initial=1.0))
    for key, gap in differences(arrays).items():
        print(f"{key:16} from central differences by at most {gap:.1e}")
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
