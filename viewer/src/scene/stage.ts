// The 3-D picture of one plan.

import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { Colors } from "../colors";
import type { Plan } from "../data";
import { ContactsView } from "./contacts";
import { Floor } from "./floor";
import { RobotView, setBlended } from "./robot";
import { body, setPose } from "./shapes";
import { Trail } from "./trail";

/** What can be switched on and off. */
export interface Layers { forces: boolean; cones: boolean; contacts: boolean; path: boolean; ghost: boolean; follow: boolean }

export const LAYERS: Layers = { forces: true, cones: true, contacts: true, path: true, ghost: true, follow: false };

/** Width over height of a picture whose caption stands over what it shows. */
const NARROW = 1.7;

const THEMES = {
  light: { background: "#eef1f5", line: "#7a8798", shadow: 0.24, sky: "#ffffff", ground: "#b9c0cb", ambient: 1.9, sun: 2.1, glow: "#000000" },
  dark: { background: "#161a20", line: "#8fa0b8", shadow: 0.5, sky: "#dbe5f6", ground: "#626d80", ambient: 1.7, sun: 2.0, glow: "#2f3641" },
};

export class Stage {
  readonly renderer: THREE.WebGLRenderer;
  readonly robot: RobotView;
  readonly contacts: ContactsView;
  private readonly scene = new THREE.Scene();
  private readonly camera = new THREE.PerspectiveCamera(36, 1, 0.05, 60);
  private readonly controls: OrbitControls;
  private readonly sky = new THREE.HemisphereLight();
  private readonly sun = new THREE.DirectionalLight();
  private readonly floor: Floor;
  private readonly trail: Trail;
  private readonly objects: THREE.Group[] = [];
  private readonly statics: THREE.Object3D[] = [];
  private readonly ghost = new THREE.Group();
  private readonly followed = new THREE.Vector3();
  private readonly box = new THREE.Box3();
  /** Corners of everything that moves or stands, over the whole motion. */
  private readonly corners: THREE.Vector3[] = [];
  private time = 0;
  private layers = { ...LAYERS };
  private pending = false;
  /** Frames drawn, for measurements. */
  frames = 0;

  constructor(private readonly plan: Plan, colors: Colors, canvas: HTMLCanvasElement) {
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true });
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFShadowMap;
    this.robot = new RobotView(plan.raw.robot, plan.surfaces);
    this.scene.add(this.robot.root, this.sky, this.sun, this.sun.target, this.ghost);
    this.addBodies(colors);
    const floor = floorHeight(plan);
    this.measure();
    const center = this.box.getCenter(new THREE.Vector3());
    this.floor = new Floor(floor, center, 2 + 1.5 * this.box.getSize(new THREE.Vector3()).length());
    this.trail = new Trail(plan, floor);
    this.contacts = new ContactsView(plan, colors, (index) => this.frameOf(index));
    this.scene.add(this.floor.root, this.trail.root, this.contacts.root);
    this.addGhost(colors);
    this.addLight(center);
    // The controls turn about the direction that is up when they are made.
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = false;
    this.controls.maxPolarAngle = 0.53 * Math.PI;
    this.controls.addEventListener("change", () => this.request());
    this.home();
  }

  private addBodies(colors: Colors): void {
    const { environment, objects } = this.plan.raw;
    for (const fixed of environment) {
      const tint = new THREE.Color(colors.body(fixed.name)).lerp(new THREE.Color("#ffffff"), 0.35);
      const group = body(fixed.shapes, `#${tint.getHexString()}`);
      this.statics.push(group);
      this.scene.add(group);
    }
    for (const object of objects) {
      const group = body(object.shapes, colors.body(object.name));
      this.objects.push(group);
      this.scene.add(group);
    }
  }

  /** The objects at the end (without any, the robot), and the regions where the goal wants something. */
  private addGhost(colors: Colors): void {
    const { objects, goal_regions: regions } = this.plan.raw;
    objects.forEach((object, i) => {
      const rows = this.plan.objectPose[i];
      const ghost = body(object.shapes, colors.body(object.name), 0.25);
      setPose(ghost, rows.row(rows.length - 1));
      this.ghost.add(ghost);
    });
    for (const region of regions) {
      const low = region.lower.map((x, i) => x ?? this.box.min.getComponent(i));
      const high = region.upper.map((x, i) => x ?? this.box.max.getComponent(i));
      const size = high.map((x, i) => Math.max(0.005, x - low[i]));
      const paint = new THREE.MeshBasicMaterial({ color: "#2fa36b", transparent: true, opacity: 0.12, depthWrite: false });
      const mesh = new THREE.Mesh(new THREE.BoxGeometry(...(size as [number, number, number])), paint);
      mesh.position.set(...(low.map((x, i) => x + size[i] / 2) as [number, number, number]));
      this.ghost.add(mesh);
    }
    // Where the goal is the robot's own place, the robot is the ghost.
    if (objects.length > 0) return;
    const robot = new RobotView(this.plan.raw.robot, this.plan.surfaces, true);
    robot.set(this.plan.q, this.plan.q.length - 1, 0);
    this.ghost.add(robot.root);
  }

  private addLight(center: THREE.Vector3): void {
    const reach = 0.5 * this.box.getSize(new THREE.Vector3()).length() + 0.3;
    const azimuth = this.plan.raw.view[0] - 0.55;
    const from = new THREE.Vector3(1.7 * Math.cos(azimuth), 1.7 * Math.sin(azimuth), 3.0);
    this.sun.position.copy(center).addScaledVector(from, Math.max(1, reach));
    this.sun.target.position.copy(center);
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(1024, 1024);
    this.sun.shadow.radius = 5;
    this.sun.shadow.bias = -0.0004;
    this.sun.shadow.normalBias = 0.01;
    Object.assign(this.sun.shadow.camera, { left: -reach, right: reach, top: reach, bottom: -reach, near: 0.1, far: 6 * reach + 4 });
  }

  /** The room that robot and objects pass through, over the whole motion. */
  private measure(): void {
    const { plan } = this;
    const take = (root: THREE.Object3D) => root.traverse((part) => {
      if (part instanceof THREE.Mesh) this.take(new THREE.Box3().setFromObject(part));
    });
    // Static bodies that are never touched may stand outside of the picture.
    const touched = new Set(plan.phases.flatMap((phase) => phase.contacts.flatMap(({ a, b }) => [a, b].map((i) => plan.raw.interfaces[i].body))));
    this.statics.forEach((group, i) => {
      if (!touched.has(plan.raw.environment[i].name)) return;
      group.updateMatrixWorld(true);
      take(group);
    });
    const step = Math.max(1, Math.floor(plan.time.length / 12));
    for (let node = 0; node < plan.time.length; node += step) {
      this.place(node, 0);
      [this.robot.root, ...this.objects].forEach((group) => {
        group.updateMatrixWorld(true);
        take(group);
      });
    }
  }

  private take(part: THREE.Box3): void {
    if (part.isEmpty()) return;
    this.box.union(part);
    for (let corner = 0; corner < 8; corner++) {
      this.corners.push(new THREE.Vector3(
        corner & 1 ? part.max.x : part.min.x, corner & 2 ? part.max.y : part.min.y, corner & 4 ? part.max.z : part.min.z,
      ));
    }
  }

  private place(node: number, share: number): void {
    this.robot.set(this.plan.q, node, share);
    this.objects.forEach((group, i) => {
      const rows = this.plan.objectPose[i];
      setBlended(group, rows, 0, node, Math.min(node + 1, rows.length - 1), share);
    });
  }

  private frameOf(index: number): THREE.Matrix4 {
    const { on, index: at } = this.plan.raw.interfaces[index];
    if (at === null || on === "static") return new THREE.Matrix4();
    return (on === "joint" ? this.robot.joints[at] : this.objects[at]).matrixWorld;
  }

  /** Shows the motion at a time. */
  show(time: number): void {
    this.time = time;
    const { node, share } = this.plan.at(time);
    this.place(node, share);
    this.scene.updateMatrixWorld();
    this.contacts.update(time, this.layers);
    this.trail.update(time);
    if (this.layers.follow) this.follow();
    this.request();
  }

  private follow(): void {
    const base = new THREE.Vector3().setFromMatrixPosition(this.robot.joints[0].matrixWorld);
    const moved = base.clone().sub(this.followed).setZ(0);
    this.camera.position.add(moved);
    this.controls.target.add(moved);
    this.controls.update();
    this.followed.copy(base);
  }

  setLayers(layers: Layers): void {
    if (layers.follow && !this.layers.follow) this.followed.setFromMatrixPosition(this.robot.joints[0].matrixWorld);
    this.layers = { ...layers };
    this.ghost.visible = layers.ghost;
    this.trail.root.visible = layers.path;
    this.show(this.time);
  }

  setTheme(name: "light" | "dark"): void {
    const theme = THEMES[name];
    this.scene.background = new THREE.Color(theme.background);
    this.floor.setTheme(theme.line, theme.shadow);
    this.sky.color.set(theme.sky);
    this.sky.groundColor.set(theme.ground);
    this.sky.intensity = theme.ambient;
    this.sun.intensity = theme.sun;
    // Black robots would be lost before the dark.
    this.robot.setGlow(theme.glow);
    this.request();
  }

  /** The camera looks at everything, from where little is hidden. */
  home(): void {
    const center = this.box.getCenter(new THREE.Vector3());
    const [azimuth, elevation] = this.plan.raw.view;
    const away = new THREE.Vector3(Math.cos(azimuth) * Math.cos(elevation), Math.sin(azimuth) * Math.cos(elevation), Math.sin(elevation));
    const distance = this.fit(center, away);
    this.camera.position.copy(center).addScaledVector(away, distance);
    this.controls.target.copy(center);
    this.controls.update();
    this.followed.setFromMatrixPosition(this.robot.joints[0].matrixWorld);
    this.request();
  }

  /** Distance at which everything is in the picture; moves `center` to the middle of what is seen. */
  private fit(center: THREE.Vector3, away: THREE.Vector3): number {
    const right = new THREE.Vector3(-away.y, away.x, 0).normalize();
    const up = new THREE.Vector3().crossVectors(away, right);
    const tall = Math.tan((this.camera.fov * Math.PI) / 360);
    const wide = tall * Math.max(this.camera.aspect, 0.2);
    // Beside another plan there is no room to the right of the caption, so the picture leaves some below it.
    const headroom = this.camera.aspect < NARROW ? 0.16 : 0;
    // Seen from afar, the tangents of the rays to all corners; a few rounds settle distance and middle.
    let distance = 4;
    for (let round = 0; round < 8; round++) {
      const extent = { left: Infinity, right: -Infinity, low: Infinity, high: -Infinity };
      for (const corner of this.corners) {
        const at = corner.clone().sub(center);
        const depth = Math.max(0.1, distance - at.dot(away));
        const [x, y] = [at.dot(right) / depth, at.dot(up) / depth];
        extent.left = Math.min(extent.left, x); extent.right = Math.max(extent.right, x);
        extent.low = Math.min(extent.low, y); extent.high = Math.max(extent.high, y);
      }
      center.addScaledVector(right, (distance * (extent.left + extent.right)) / 2).addScaledVector(up, (distance * (extent.low + extent.high)) / 2);
      const filled = Math.max((extent.right - extent.left) / 2 / wide, (extent.high - extent.low) / 2 / (tall * (1 - headroom)));
      distance = Math.max(0.5, distance * (0.15 + 0.85 * (filled / 0.88)));
    }
    center.addScaledVector(up, distance * tall * headroom);
    return distance;
  }

  resize(width: number, height: number): void {
    if (width < 2 || height < 2) return;
    const before = this.camera.aspect;
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (Math.abs(before - this.camera.aspect) > 0.02 && !this.touched) this.home();
    this.request();
  }

  /** True once the reader has moved the camera. */
  touched = false;

  /** Draws with the next frame of the display. */
  request(): void {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame(() => {
      this.pending = false;
      this.draw();
    });
  }

  /** Draws now. */
  draw(): void {
    this.frames += 1;
    this.renderer.render(this.scene, this.camera);
  }
}

/** Height of the lowest ground, or below everything. */
function floorHeight(plan: Plan): number {
  const planes = plan.raw.environment.flatMap((body) => body.shapes.filter((shape) => shape.plane).map((shape) => shape.pose[2]));
  return planes.length > 0 ? Math.min(...planes) : 0;
}
