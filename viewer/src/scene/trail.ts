// The path of the robot's centre of mass: all of it thin, what has passed strong, and where it stands above the floor.

import * as THREE from "three";
import type { Plan } from "../data";

const COLOR = "#c9539a";

export class Trail {
  readonly root = new THREE.Group();
  private readonly passed: THREE.Mesh;
  private readonly dot: THREE.Mesh;
  private readonly foot: THREE.Mesh;
  private readonly drop: THREE.Line;
  private readonly segments: number;
  private readonly sides = 6;

  constructor(private readonly plan: Plan, private readonly floor: number) {
    const points = Array.from({ length: plan.com.length }, (_, t) => new THREE.Vector3(...plan.com.row(t)));
    const line = new THREE.BufferGeometry().setFromPoints(points);
    const faint = new THREE.LineBasicMaterial({ color: COLOR, transparent: true, opacity: 0.45, depthTest: false });
    this.root.add(new THREE.Line(line, faint));
    // A curve without length cannot be swept.
    const isStill = points.every((point) => point.distanceTo(points[0]) < 1e-6);
    this.segments = Math.min(600, 2 * points.length);
    const curve = new THREE.CatmullRomCurve3(isStill ? [points[0], points[0].clone().setZ(points[0].z + 1e-4)] : points);
    curve.getPoint = (u, target = new THREE.Vector3()) => this.placeAt(u * plan.duration, target);
    curve.getPointAt = curve.getPoint;
    curve.getTangentAt = (u, target = new THREE.Vector3()) => {
      const [a, b] = [Math.max(0, u - 0.01), Math.min(1, u + 0.01)];
      target.copy(curve.getPoint(b)).sub(curve.getPoint(a));
      return target.lengthSq() < 1e-12 ? target.set(0, 0, 1) : target.normalize();
    };
    const strong = new THREE.MeshBasicMaterial({ color: COLOR, depthTest: false, transparent: true, opacity: 0.9 });
    this.passed = new THREE.Mesh(new THREE.TubeGeometry(curve, this.segments, 0.004, this.sides), strong);
    this.dot = new THREE.Mesh(new THREE.SphereGeometry(0.02, 20, 14), strong);
    this.foot = new THREE.Mesh(new THREE.RingGeometry(0.014, 0.024, 32), strong);
    const dashes = new THREE.LineDashedMaterial({ color: COLOR, dashSize: 0.02, gapSize: 0.02, transparent: true, opacity: 0.6, depthTest: false });
    this.drop = new THREE.Line(new THREE.BufferGeometry().setFromPoints([new THREE.Vector3(), new THREE.Vector3(0, 0, -1)]), dashes);
    this.drop.computeLineDistances();
    this.root.add(this.passed, this.dot, this.foot, this.drop);
    this.root.children.forEach((child) => { child.renderOrder = 3; });
  }

  private placeAt(time: number, target: THREE.Vector3): THREE.Vector3 {
    const { node, share } = this.plan.at(time);
    const [a, b] = [this.plan.com.row(node), this.plan.com.row(node + 1)];
    return target.set(a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]), a[2] + share * (b[2] - a[2]));
  }

  update(time: number): void {
    const here = this.placeAt(time, new THREE.Vector3());
    this.dot.position.copy(here);
    this.foot.position.set(here.x, here.y, this.floor + 0.003);
    this.drop.position.copy(here);
    const height = here.z - this.floor;
    this.drop.scale.set(1, 1, Math.max(1e-3, height));
    const part = Math.round((time / this.plan.duration) * this.segments);
    this.passed.geometry.setDrawRange(0, part * this.sides * 6);
  }
}
