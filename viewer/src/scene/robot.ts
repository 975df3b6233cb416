// The robot: one group per joint, so that the scene graph does the forward kinematics.

import * as THREE from "three";
import { mergeGeometries } from "three/addons/utils/BufferGeometryUtils.js";
import type { RawPlan, Rows, Shape, Surface } from "../data";
import { surfaceGeometry } from "./mesh";
import { geometry, material, matrixOf, setPose } from "./shapes";

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
    const hold = (part: THREE.Mesh, joint?: number) => {
      part.castShadow = part.receiveShadow = !ghost;
      const holder = joint === undefined ? this.root : this.joints[joint];
      holder.add(part);
      if (ghost) holder.add(foremost(part));
    };
    for (const shape of robot.shapes) {
      if (shape.mesh === undefined) continue;
      // Mesh files may be open, or turn triangles inside out.
      const part = new THREE.Mesh(surfaceGeometry(surfaces[shape.mesh]), paint(shape.color ?? PALE, true));
      setPose(part, shape.pose);
      part.scale.set(...(shape.mirror ?? [1, 1, 1]));
      hold(part, shape.joint);
    }
    for (const shapes of alike(robot.shapes)) {
      const form = merged(shapes);
      if (form) hold(new THREE.Mesh(form, paint(shapes[0].color ?? PALE, false)), shapes[0].joint);
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

const PALE = "#c0c4cc";

/** Primitive shapes that move together and look alike: drawn as one, since every part costs time in every frame. */
function alike(shapes: Shape[]): Iterable<Shape[]> {
  const groups = new Map<string, Shape[]>();
  for (const shape of shapes) {
    if (shape.mesh !== undefined) continue;
    const key = `${shape.joint} ${shape.color}`;
    groups.set(key, [...(groups.get(key) ?? []), shape]);
  }
  return groups.values();
}

/** The shapes as one, in the frame of their joint; `undefined` if there are only planes. */
function merged(shapes: Shape[]): THREE.BufferGeometry | undefined {
  const forms = shapes.flatMap((shape) => {
    const form = geometry(shape);
    form?.deleteAttribute("uv");
    return form ? [(form.index ? form.toNonIndexed() : form).applyMatrix4(matrixOf(shape.pose))] : [];
  });
  return forms.length > 0 ? mergeGeometries(forms) : undefined;
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
