// The page's data as crates/view writes it (page_data.rs), and its decoded form.

export interface Table { step: number; columns: number; data: number[] }
export type Pose = [number, number, number, number, number, number, number];

export interface Shape {
  joint?: number;
  pose: Pose;
  color?: string;
  box?: [number, number, number];
  sphere?: number;
  cylinder?: [number, number];
  capsule?: [number, number];
  plane?: boolean;
  /** Index into the page's meshes. */
  mesh?: number;
  /** −1 for the axes along which the mesh is mirrored. */
  mirror?: [number, number, number];
}

/** A surface: places and faces in base64, the places as whole numbers of 16 bits. */
export interface Mesh { size: [number, number]; low: number[]; step: number[]; places: string; faces: string }

/** A decoded surface: three coordinates [m] per place, three indices per face. */
export interface Surface { places: Float32Array; faces: Uint32Array }

export interface Joint { parent: number | null; pose: Pose; kind: "free" | "turn" | "slide"; axis: [number, number, number]; q: number | null }

export interface Axis {
  name: string;
  torque: number | null;
  enforced: boolean;
  speed: number | null;
  lower: number | null;
  upper: number | null;
}

export interface Interface {
  name: string;
  body: string;
  on: "joint" | "object" | "static";
  index: number | null;
  pose: Pose;
  point: boolean;
  half_size: [number | null, number | null] | null;
}

export interface CheckRow {
  category: string;
  what: string;
  unit: string;
  value: number | null;
  tolerance: number;
  status: "PASS" | "WARN" | "FAIL" | "n/a";
  place: string;
  node: number | null;
  over_time?: Table;
}

export interface RawPlan {
  name: string;
  task: string;
  feasible: boolean;
  generator: string;
  objective: [string, number] | null;
  cost: number | null;
  costs: { terms: [string, number][]; rates: Table; end: [string, number][] } | null;
  integrator: string;
  /** Azimuth and elevation from which to look [rad]. */
  view: [number, number];
  robot: { name: string; mass: number; tree: Joint[]; shapes: Shape[]; joints: Axis[]; notes: string[] };
  objects: { name: string; mass: number; shapes: Shape[]; pose: Table }[];
  environment: { name: string; shapes: Shape[] }[];
  interfaces: Interface[];
  goal: [number, number][];
  goal_regions: { body: string; lower: (number | null)[]; upper: (number | null)[] }[];
  phases: {
    duration: number;
    steps: number;
    action: string;
    contacts: { a: number; b: number; kind: string; mu: number; mu_r: number; wrench: Table; load: Table }[];
  }[];
  time: Table;
  q: Table;
  rates: Table;
  tau: Table;
  torque_share: Table;
  com: Table;
  check: { ok: boolean; rows: CheckRow[]; margins: { limit: string; largest: number; what: string; node: number | null }[] };
  quality: Quality | null;
  explanation: string | null;
}

export interface Quality {
  rms_joint_jerk?: number;
  torque_rate?: { value: number; of: string; time: number };
  torque_jump_at_switch?: { value: number; of: string; time: number };
  force_at_switch?: { value: number; of: string; time: number };
  margins?: { name: string; unit: string; demanded: number; reached: number | null }[];
  between_nodes?: Record<string, number>;
}

/** Rows of numbers over time. */
export class Rows {
  constructor(readonly columns: number, readonly values: Float64Array) {}

  get length(): number { return this.columns === 0 ? 0 : this.values.length / this.columns; }

  at(row: number, column = 0): number { return this.values[row * this.columns + column]; }

  row(row: number): Float64Array { return this.values.subarray(row * this.columns, (row + 1) * this.columns); }
}

/** A table of differences as rows of numbers. */
export function decode(table: Table, place: string): Rows {
  const { step, columns, data } = table ?? {};
  if (typeof step !== "number" || typeof columns !== "number" || !Array.isArray(data)) {
    throw new Error(`${place}: expected a table with step, columns and data`);
  }
  if (columns > 0 && data.length % columns !== 0) {
    throw new Error(`${place}: ${data.length} numbers do not fill rows of ${columns}`);
  }
  const sums = new Array<number>(columns).fill(0);
  const values = new Float64Array(data.length);
  for (let i = 0; i < data.length; i++) {
    if (typeof data[i] !== "number") throw new Error(`${place}: entry ${i} is no number`);
    sums[i % columns] += data[i];
    values[i] = sums[i % columns] * step;
  }
  return new Rows(columns, values);
}

/** The numbers behind base64, of `width` bytes each, the lower byte first. */
function wholeNumbers(text: string, width: number, place: string): Uint32Array {
  let bytes: string;
  try {
    bytes = atob(text);
  } catch {
    throw new Error(`${place} is not base64`);
  }
  const numbers = new Uint32Array(bytes.length / width);
  for (let i = 0; i < numbers.length * width; i++) numbers[Math.floor(i / width)] += bytes.charCodeAt(i) * 256 ** (i % width);
  return numbers;
}

/** A surface of the page. */
export function decodeMesh({ size, low, step, places, faces }: Mesh, place: string): Surface {
  const whole = wholeNumbers(places, 2, `${place}: places`);
  const corners = wholeNumbers(faces, size[0] > 65536 ? 4 : 2, `${place}: faces`);
  if (whole.length !== 3 * size[0] || corners.length !== 3 * size[1]) {
    throw new Error(`${place}: ${whole.length} coordinates and ${corners.length} corners, expected ${3 * size[0]} and ${3 * size[1]}`);
  }
  if (corners.some((corner) => corner >= size[0])) throw new Error(`${place}: a corner is none of the ${size[0]} places`);
  return { places: Float32Array.from(whole, (x, i) => low[i % 3] + x * step[i % 3]), faces: corners };
}

/** The surfaces of a page, which it may have none of. */
export function decodeMeshes(meshes: Mesh[] = []): Surface[] {
  return meshes.map((mesh, i) => decodeMesh(mesh, `mesh ${i + 1}`));
}

/** A contact while it is uninterrupted within one phase. */
export interface Contact {
  a: number;
  b: number;
  kind: string;
  mu: number;
  mu_r: number;
  /** Force and moment on `a`, world axes, about its origin; one row per interval of the phase. */
  wrench: Rows;
  /** Normal force [kN], share of friction used, centre of pressure on `a` [m]. */
  load: Rows;
}

export interface Phase { duration: number; steps: number; action: string; contacts: Contact[]; start: number; end: number; gained: Contact[]; lost: Contact[] }

/** A plan, decoded. Node `t` begins interval `t`. */
export class Plan {
  readonly time: Float64Array;
  readonly q: Rows;
  readonly rates: Rows;
  readonly tau: Rows;
  readonly torqueShare: Rows;
  readonly com: Rows;
  /** What each term of the cost takes per second. */
  readonly costRates: Rows;
  readonly objectPose: Rows[];
  readonly phases: Phase[] = [];
  readonly phaseOf: number[] = [];

  /** `surfaces` are the page's, which shapes of the robot name by index. */
  constructor(readonly raw: RawPlan, readonly surfaces: Surface[] = []) {
    const name = raw.name ?? "plan";
    for (const key of ["robot", "objects", "environment", "interfaces", "phases", "check"] as const) {
      if (raw[key] === undefined) throw new Error(`${name}: the key "${key}" is missing`);
    }
    raw.robot.shapes.forEach(({ mesh }, i) => {
      if (mesh !== undefined && !surfaces[mesh]) throw new Error(`${name}: shape ${i + 1} of the robot has mesh ${mesh + 1}, the page has ${surfaces.length}`);
    });
    this.time = decode(raw.time, `${name}: time`).values;
    this.q = decode(raw.q, `${name}: q`);
    this.rates = decode(raw.rates, `${name}: rates`);
    this.tau = decode(raw.tau, `${name}: tau`);
    this.torqueShare = decode(raw.torque_share, `${name}: torque_share`);
    this.com = decode(raw.com, `${name}: com`);
    this.costRates = raw.costs ? decode(raw.costs.rates, `${name}: costs`) : new Rows(0, new Float64Array());
    this.objectPose = raw.objects.map((object) => decode(object.pose, `${name}: object ${object.name}`));
    if (this.time.length < 2) throw new Error(`${name}: ${this.time.length} nodes, expected two or more`);
    for (const [key, rows, least] of [["q", this.q, 0], ["com", this.com, 0], ["rates", this.rates, 0], ["tau", this.tau, 1], ["torque_share", this.torqueShare, 1], ["costs", this.costRates, 1]] as const) {
      if (rows.columns > 0 && rows.length !== this.time.length - least) {
        throw new Error(`${name}: ${key} has ${rows.length} rows, expected ${this.time.length - least}`);
      }
    }
    this.readPhases(name);
  }

  private readPhases(name: string): void {
    let start = 0;
    let before: Contact[] = [];
    this.raw.phases.forEach((phase, k) => {
      const contacts = phase.contacts.map((contact) => ({
        ...contact,
        wrench: decode(contact.wrench, `${name}: phase ${k + 1}: wrench`),
        load: decode(contact.load, `${name}: phase ${k + 1}: load`),
      }));
      const missing = (from: Contact[], those: Contact[]) => from.filter((x) => !those.some((y) => sameContact(x, y)));
      const first = k === 0;
      this.phases.push({
        ...phase, action: phase.action.replaceAll("_", " "), contacts, start, end: start + phase.steps,
        gained: first ? [] : missing(contacts, before), lost: missing(before, contacts),
      });
      for (let i = 0; i < phase.steps; i++) this.phaseOf.push(k);
      start += phase.steps;
      before = contacts;
    });
    if (start !== this.time.length - 1) throw new Error(`${name}: phases have ${start} intervals, time has ${this.time.length - 1}`);
  }

  get duration(): number { return this.time[this.time.length - 1]; }

  /** Weight of the robot [N]. */
  get weight(): number { return this.raw.robot.mass * 9.81; }

  /** The interval that contains a time, and the share of it that has passed. */
  at(time: number): { node: number; share: number } {
    let [low, high] = [0, this.time.length - 2];
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.time[middle] <= time) low = middle; else high = middle - 1;
    }
    const span = this.time[low + 1] - this.time[low];
    const share = span > 0 ? Math.min(1, Math.max(0, (time - this.time[low]) / span)) : 0;
    return { node: low, share };
  }

  phaseAt(time: number): number { return this.phaseOf[this.at(time).node]; }

  contactName(contact: { a: number; b: number }): string {
    return `${this.label(contact.a)} on ${this.label(contact.b)}`;
  }

  /** Name of an interface for people. */
  label(index: number): string { return this.raw.interfaces[index].name.replaceAll("_", " "); }
}

export function sameContact(x: { a: number; b: number }, y: { a: number; b: number }): boolean {
  return x.a === y.a && x.b === y.b;
}

/** Reads the data element of the page. */
export function readPage(text: string): Plan[] {
  let page: { format?: string; meshes?: Mesh[]; plans?: RawPlan[] };
  try {
    page = JSON.parse(text);
  } catch (error) {
    throw new Error(`the data inside the page is not JSON: ${(error as Error).message}`);
  }
  if (page.format !== "locotamp.page/1") throw new Error(`the data has the format ${JSON.stringify(page.format)}, expected "locotamp.page/1"`);
  if (!Array.isArray(page.plans) || page.plans.length === 0) throw new Error("there is no plan in the page");
  const surfaces = decodeMeshes(page.meshes);
  return page.plans.map((raw) => new Plan(raw, surfaces));
}
