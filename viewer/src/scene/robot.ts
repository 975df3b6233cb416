// The robot: one group per joint, so that the scene graph does the forward kinematics.

import * as THREE from "three";
import type { RawPlan, Rows, Surface } from "../data";
import { surfaceGeometry } from "./mesh";
import { geometry, material, setPose } from "./shapes";

export class RobotView {
  readonly root = new THREE.Group();
  /** Frames of the joints, which move. */
  readonly joints: THREE.Group[] = [];
  private readonly materials = new Map<string, THREE.MeshStandardMaterial>();

  constructor(private readonly robot: RawPlan["robot"], surfaces: Surface[], ghost = false) {
    for (const joint of robot.tree) {
      const place = new THREE.Group();
      setPose(place, joint.pose);
      const moving = new THREE.Group();
      place.add(moving);
      (joint.parent === null ? this.root : this.joints[joint.parent]).add(place);
      this.joints.push(moving);
    }
    const { materials } = this;
    const paint = (color: string, open: boolean) => {
      const key = `${color} ${open}`;
      if (!materials.has(key)) materials.set(key, material(color, ghost ? 0.16 : 1, open));
      return materials.get(key)!;
    };
    for (const shape of robot.shapes) {
      const isMesh = shape.mesh !== undefined;
      const form = isMesh ? surfaceGeometry(surfaces[shape.mesh!]) : geometry(shape);
      if (!form) continue;
      // Mesh files may be open, or turn triangles inside out.
      const mesh = new THREE.Mesh(form, paint(shape.color ?? "#c0c4cc", isMesh));
      setPose(mesh, shape.pose);
      mesh.scale.set(...(shape.mirror ?? [1, 1, 1]));
      mesh.castShadow = mesh.receiveShadow = !ghost;
      const holder = shape.joint === undefined ? this.root : this.joints[shape.joint];
      holder.add(mesh);
      if (ghost) holder.add(foremost(mesh));
    }
  }

  /** The colour that everything has where no light falls. */
  setGlow(color: string): void { this.materials.forEach((material) => material.emissive.set(color)); }

  /** Moves to the configuration between rows `node` and `node + 1`. */
  set(q: Rows, node: number, share: number): void {
    const next = Math.min(node + 1, q.length - 1);
    const value = (column: number) => (1 - share) * q.at(node, column) + share * q.at(next, column);
    this.robot.tree.forEach((joint, i) => {
      const frame = this.joints[i];
      if (joint.kind === "free") setBlended(frame, q, joint.q ?? 0, node, next, share);
      else if (joint.q !== null) {
        const axis = new THREE.Vector3(...joint.axis);
        if (joint.kind === "turn") frame.quaternion.setFromAxisAngle(axis, value(joint.q));
        else frame.position.copy(axis.multiplyScalar(value(joint.q)));
      }
    });
  }
}

const DEPTH = new THREE.MeshBasicMaterial({ colorWrite: false, transparent: true, side: THREE.DoubleSide });

/** Fills the depth buffer before a transparent mesh is drawn, so that only its foremost surface shows. */
function foremost(mesh: THREE.Mesh): THREE.Mesh {
  const depth = mesh.clone();
  depth.material = DEPTH;
  [depth.renderOrder, mesh.renderOrder] = [0.4, 0.5];
  return depth;
}

const from = new THREE.Quaternion();
const to = new THREE.Quaternion();

/** Sets the pose that lies between two rows. */
export function setBlended(object: THREE.Object3D, rows: Rows, column: number, node: number, next: number, share: number): void {
  const [a, b] = [rows.row(node), rows.row(next)];
  const mix = (i: number) => (1 - share) * a[column + i] + share * b[column + i];
  object.position.set(mix(0), mix(1), mix(2));
  from.fromArray(a as unknown as number[], column + 3).normalize();
  to.fromArray(b as unknown as number[], column + 3).normalize();
  object.quaternion.slerpQuaternions(from, to, share);
}
