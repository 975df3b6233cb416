// An arrow whose length, direction and colour change every frame.

import * as THREE from "three";

const SHAFT = new THREE.CylinderGeometry(1, 1, 1, 14).translate(0, 0.5, 0);
const HEAD = new THREE.ConeGeometry(1, 1, 20).translate(0, 0.5, 0);
const UP = new THREE.Vector3(0, 1, 0);
const direction = new THREE.Vector3();

export class Arrow extends THREE.Group {
  private readonly shaft: THREE.Mesh;
  private readonly head: THREE.Mesh;
  /** Seen through the body that it stands in. */
  readonly paint = new THREE.MeshStandardMaterial({ roughness: 0.5, depthTest: false, transparent: true, opacity: 0.92 });

  constructor(private readonly radius = 0.011) {
    super();
    this.shaft = new THREE.Mesh(SHAFT, this.paint);
    this.head = new THREE.Mesh(HEAD, this.paint);
    this.shaft.renderOrder = this.head.renderOrder = 4;
    this.add(this.shaft, this.head);
  }

  /** Shows `vector` [m] from `origin`; hidden where it is too short to see. */
  set(origin: THREE.Vector3, vector: THREE.Vector3, color: string): void {
    const length = vector.length();
    this.visible = length > 0.012;
    if (!this.visible) return;
    const head = Math.min(0.055, 0.5 * length);
    const slim = Math.min(1, length / 0.12);
    this.position.copy(origin);
    this.quaternion.setFromUnitVectors(UP, direction.copy(vector).divideScalar(length));
    this.shaft.scale.set(this.radius * slim, length - head, this.radius * slim);
    this.head.position.set(0, length - head, 0);
    this.head.scale.set(2.4 * this.radius * slim, head, 2.4 * this.radius * slim);
    this.paint.color.set(color);
  }
}
