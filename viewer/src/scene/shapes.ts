// Primitive shapes as meshes.

import * as THREE from "three";
import { RoundedBoxGeometry } from "three/addons/geometries/RoundedBoxGeometry.js";
import type { Pose, Shape } from "../data";

export function setPose(object: THREE.Object3D, pose: ArrayLike<number>, at = 0): void {
  object.position.set(pose[at], pose[at + 1], pose[at + 2]);
  object.quaternion.set(pose[at + 3], pose[at + 4], pose[at + 5], pose[at + 6]).normalize();
}

export function matrixOf(pose: Pose): THREE.Matrix4 {
  const holder = new THREE.Object3D();
  setPose(holder, pose);
  holder.updateMatrix();
  return holder.matrix;
}

/** Geometry of a shape about its own frame; `undefined` for planes. */
export function geometry(shape: Shape): THREE.BufferGeometry | undefined {
  if (shape.box) {
    const [x, y, z] = shape.box;
    const least = Math.min(x, y, z);
    return new RoundedBoxGeometry(2 * x, 2 * y, 2 * z, 2, Math.min(0.3 * least, 0.012));
  }
  if (shape.sphere) return new THREE.SphereGeometry(shape.sphere, 28, 18);
  // Three's cylinders and capsules stand along y, ours along z.
  if (shape.cylinder) return new THREE.CylinderGeometry(shape.cylinder[0], shape.cylinder[0], 2 * shape.cylinder[1], 32).rotateX(Math.PI / 2);
  if (shape.capsule) return new THREE.CapsuleGeometry(shape.capsule[0], 2 * shape.capsule[1], 8, 24).rotateX(Math.PI / 2);
  return undefined;
}

/** `open`: seen from both sides. */
export function material(color: string, opacity = 1, open = false): THREE.MeshStandardMaterial {
  const transparent = opacity < 1;
  const side = open ? THREE.DoubleSide : THREE.FrontSide;
  // Shadows are thrown by what the lamp does not see, so that lit surfaces do not shade themselves.
  return new THREE.MeshStandardMaterial({ color, side, shadowSide: THREE.BackSide, roughness: 0.62, metalness: 0.05, transparent, opacity, depthWrite: !transparent });
}

/** Meshes of shapes in the frame of a body; planes are left out. */
export function body(shapes: Shape[], color: string, opacity = 1): THREE.Group {
  const group = new THREE.Group();
  for (const shape of shapes) {
    const form = geometry(shape);
    if (!form) continue;
    const mesh = new THREE.Mesh(form, material(shape.color ?? color, opacity));
    setPose(mesh, shape.pose);
    mesh.castShadow = mesh.receiveShadow = opacity === 1;
    group.add(mesh);
  }
  return group;
}
