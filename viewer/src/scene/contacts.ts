// The active contacts: highlighted interfaces, forces at the centre of pressure, friction cones, what was just made.

import * as THREE from "three";
import type { Colors } from "../colors";
import type { Contact, Plan } from "../data";
import { Arrow } from "./arrow";
import { matrixOf } from "./shapes";

/** Length of the arrow of the robot's weight [m]. */
const WEIGHT_LENGTH = 0.55;
/** A contact that was just made flashes for so long [s]. */
const FLASH = 0.35;
const CONE_HEIGHT = 0.13;

interface Marker { patch: THREE.Mesh; edge: THREE.LineSegments | null; arrow: Arrow; cone: THREE.Mesh }

export interface Shown { forces: boolean; cones: boolean; contacts: boolean }

export class ContactsView {
  readonly root = new THREE.Group();
  private readonly markers = new Map<string, Marker>();
  private readonly own: THREE.Matrix4[];

  constructor(private readonly plan: Plan, private readonly colors: Colors, private readonly frameOf: (index: number) => THREE.Matrix4) {
    this.own = plan.raw.interfaces.map((x) => matrixOf(x.pose));
  }

  /** Pose of an interface in the world; bodies must have been updated. */
  worldFromInterface(index: number): THREE.Matrix4 {
    return new THREE.Matrix4().multiplyMatrices(this.frameOf(index), this.own[index]);
  }

  update(time: number, shown: Shown): void {
    const { plan } = this;
    const { node, share } = plan.at(time);
    const phase = plan.phases[plan.phaseOf[node]];
    this.markers.forEach((marker) => Object.values(marker).forEach((part) => { if (part) part.visible = false; }));
    const since = time - plan.time[phase.start];
    for (const contact of phase.contacts) {
      const flash = phase.gained.includes(contact) ? Math.max(0, 1 - since / FLASH) : 0;
      this.show(contact, node - phase.start, share, flash, shown);
    }
  }

  private show(contact: Contact, interval: number, share: number, flash: number, shown: Shown): void {
    const marker = this.marker(contact);
    const color = this.colors.interface(contact.b);
    const side = this.colors.interface(contact.a);
    const worldFromA = this.worldFromInterface(contact.a);
    const worldFromB = this.worldFromInterface(contact.b);
    if (shown.contacts) {
      const grow = 1 + 0.9 * flash;
      const lift = new THREE.Matrix4().makeTranslation(0, 0, 0.0015).scale(new THREE.Vector3(grow, grow, 1));
      for (const part of [marker.patch, marker.edge]) {
        if (!part) continue;
        part.visible = true;
        part.matrix.multiplyMatrices(worldFromA, lift);
        (part.material as THREE.MeshBasicMaterial).color.set(color);
      }
      (marker.patch.material as THREE.MeshBasicMaterial).opacity = 0.55 + 0.45 * flash;
    }
    const rows = contact.wrench;
    const next = Math.min(interval + 1, rows.length - 1);
    const mix = (from: typeof rows, column: number) => (1 - share) * from.at(interval, column) + share * from.at(next, column);
    const force = new THREE.Vector3(mix(rows, 0), mix(rows, 1), mix(rows, 2));
    const pressure = new THREE.Vector3(mix(contact.load, 2), mix(contact.load, 3), 0).applyMatrix4(worldFromA);
    if (shown.forces) {
      marker.arrow.set(pressure, force.multiplyScalar(WEIGHT_LENGTH / this.plan.weight), side);
    }
    if (shown.cones && contact.mu > 0 && !contact.kind.includes("held") && contact.kind !== "grasp") {
      marker.cone.visible = true;
      const radius = CONE_HEIGHT * contact.mu;
      const turn = new THREE.Quaternion().setFromRotationMatrix(worldFromB);
      marker.cone.matrix.compose(pressure, turn, new THREE.Vector3(radius, radius, CONE_HEIGHT));
      (marker.cone.material as THREE.MeshBasicMaterial).color.set(side);
    }
  }

  private marker(contact: Contact): Marker {
    const key = `${contact.a}/${contact.b}`;
    const known = this.markers.get(key);
    if (known) return known;
    const interfaceA = this.plan.raw.interfaces[contact.a];
    const size = interfaceA.half_size;
    const bounded = !interfaceA.point && size && size[0] !== null && size[1] !== null;
    const form = bounded ? new THREE.PlaneGeometry(2 * size[0]!, 2 * size[1]!) : new THREE.SphereGeometry(0.018, 20, 14);
    const patch = new THREE.Mesh(form, new THREE.MeshBasicMaterial({ transparent: true, side: THREE.DoubleSide, depthWrite: false, depthTest: false }));
    const edge = bounded ? new THREE.LineSegments(new THREE.EdgesGeometry(form), new THREE.LineBasicMaterial({ depthTest: false, transparent: true })) : null;
    const cone = new THREE.Mesh(
      // Its tip at the origin, opening along z.
      new THREE.ConeGeometry(1, 1, 28, 1, true).rotateX(-Math.PI / 2).translate(0, 0, 0.5),
      new THREE.MeshBasicMaterial({ transparent: true, opacity: 0.16, side: THREE.DoubleSide, depthWrite: false }),
    );
    const arrow = new Arrow();
    for (const part of [patch, edge, cone]) {
      if (!part) continue;
      Object.assign(part, { matrixAutoUpdate: false, renderOrder: 2, visible: false });
      this.root.add(part);
    }
    arrow.visible = false;
    this.root.add(arrow);
    const marker = { patch, edge, arrow, cone };
    this.markers.set(key, marker);
    return marker;
  }
}
