// Which curves a plan has: torques, contact forces, use of friction and soles, joint speeds, heights, cost,
// residuals.

import { LINES, type Colors } from "../colors";
import { decode, type Contact, type Plan, type Rows } from "../data";
import type { Chart } from "./chart";
import { ContactChart } from "./contact_chart";
import { LineChart, type Curve } from "./line_chart";

const MOST = 6;

export function charts(plan: Plan, colors: Colors): Chart[] {
  const some = (chart: LineChart, curves: Curve[]) => (curves.length > 0 ? [chart] : []);
  const one = (options: ConstructorParameters<typeof LineChart>[1]) => some(new LineChart(plan, options), options.curves);
  return [
    new ContactChart(plan, colors),
    ...one({ title: "Torque / limit, most loaded joints", unit: "", share: true, low: 0, limit: 1, curves: torqueShares(plan) }),
    ...one({ title: "Normal force of contacts", unit: "N", low: 0, curves: perContact(plan, colors, (contact, i) => 1000 * contact.load.at(i, 0)) }),
    ...one({ title: "Friction used (tangential force / μ · normal force)", unit: "", share: true, low: 0, limit: 1, curves: perContact(plan, colors, frictionShare) }),
    ...one({ title: "Centre of pressure / half size of the patch", unit: "", share: true, low: 0, limit: 1, curves: perContact(plan, colors, (contact, i) => soleShare(plan, contact, i)) }),
    ...one({ title: "Joint speed / limit, fastest joints", unit: "", share: true, low: 0, limit: 1, curves: speedShares(plan) }),
    ...one({ title: "Height of base and centre of mass", unit: "m", curves: heights(plan) }),
    ...one({ title: "Cost per second, by term: the areas add up to the cost", unit: "/s", low: 0, curves: costRates(plan) }),
    ...one({ title: "Residual / tolerance of the checker", unit: "", share: true, low: 0, limit: 1, curves: residuals(plan) }),
  ];
}

function frictionShare(contact: Contact, i: number): number {
  return contact.kind === "patch" || contact.kind === "point" ? contact.load.at(i, 1) : NaN;
}

export function soleShare(plan: Plan, contact: Contact, i: number): number {
  const size = plan.raw.interfaces[contact.a].half_size;
  if (contact.kind !== "patch" || !size || size[0] === null || size[1] === null) return NaN;
  return Math.max(Math.abs(contact.load.at(i, 2)) / size[0], Math.abs(contact.load.at(i, 3)) / size[1]);
}

/** The curves with the largest values, the largest first. */
function largest(curves: Curve[], count: number): Curve[] {
  const top = (curve: Curve) => Array.from(curve.values).reduce((x, y) => (y > x ? y : x), 0);
  const sorted = curves.map((curve) => ({ curve, top: top(curve) })).sort((x, y) => y.top - x.top);
  return sorted.slice(0, count).map(({ curve }, i) => ({ ...curve, color: LINES[i % LINES.length] }));
}

export function joint(name: string): string { return name.replace(/_joint$/, "").replaceAll("_", " "); }

function torqueShares(plan: Plan): Curve[] {
  const all = plan.raw.robot.joints.flatMap(({ name, torque }, j) => {
    if (torque === null) return [];
    const column = (rows: Rows) => Float64Array.from({ length: rows.length }, (_, t) => rows.at(t, j));
    return [{ name: joint(name), color: "", values: column(plan.torqueShare), amounts: column(plan.tau), amountUnit: "N m" }];
  });
  return largest(all, MOST);
}

function speedShares(plan: Plan): Curve[] {
  const all = plan.raw.robot.joints.flatMap(({ name, speed }, j) => {
    if (speed === null || speed <= 0) return [];
    const amounts = Float64Array.from({ length: plan.rates.length }, (_, t) => plan.rates.at(t, j));
    return [{ name: joint(name), color: "", amounts, amountUnit: "rad/s", values: Float64Array.from({ length: plan.rates.length }, (_, t) => Math.abs(plan.rates.at(t, j)) / speed) }];
  });
  return largest(all, 4);
}

/** A curve per pair of interfaces over all phases, with gaps where they are apart. */
function perContact(plan: Plan, colors: Colors, value: (contact: Contact, interval: number) => number): Curve[] {
  const byPair = new Map<string, Curve & { values: Float64Array }>();
  const owners: number[] = [];
  for (const phase of plan.phases) {
    for (const contact of phase.contacts) {
      const name = plan.contactName(contact);
      let curve = byPair.get(name);
      if (!curve) {
        const earlier = owners.filter((x) => x === contact.a).length;
        owners.push(contact.a);
        curve = { name, color: lineColor(plan, colors, contact, earlier), values: new Float64Array(plan.tau.length).fill(NaN) };
        byPair.set(name, curve);
      }
      for (let i = 0; i < phase.steps; i++) curve.values[phase.start + i] = value(contact, i);
    }
  }
  return [...byPair.values()].filter((curve) => curve.values.some(Number.isFinite));
}

/** Feet and hands by side, hands a little different from feet; what touches its second partner or a later one takes some of their colour. */
function lineColor(plan: Plan, colors: Colors, contact: Contact, earlier: number): string {
  const side = colors.interface(contact.a);
  const own = plan.raw.interfaces[contact.a].name.includes("hand") ? `color-mix(in oklab, ${side}, #8f6bc7 60%)` : side;
  return earlier > 0 ? `color-mix(in oklab, ${own}, ${colors.interface(contact.b)} 55%)` : own;
}

function heights(plan: Plan): Curve[] {
  return [
    { name: "base", color: LINES[0], values: Float64Array.from({ length: plan.q.length }, (_, t) => plan.q.at(t, 2)) },
    { name: "centre of mass", color: LINES[3], values: Float64Array.from({ length: plan.com.length }, (_, t) => plan.com.at(t, 2)) },
  ];
}

/** The terms that cost most over all, and the others together. */
function costRates(plan: Plan): Curve[] {
  const terms = (plan.raw.costs?.terms ?? []).map(([name, sum], column) => ({ name: name.replaceAll("_", " "), sum, columns: [column] }));
  terms.sort((x, y) => y.sum - x.sum);
  const shown = terms.length > MOST ? terms.slice(0, MOST - 1) : terms;
  const others = terms.slice(shown.length);
  if (others.length > 0) shown.push({ name: "other terms", sum: others.reduce((sum, x) => sum + x.sum, 0), columns: others.flatMap((x) => x.columns) });
  return shown.map(({ name, sum, columns }, i) => {
    const rate = (t: number) => columns.reduce((total, column) => total + plan.costRates.at(t, column), 0);
    const { length } = plan.costRates;
    return { name, color: LINES[i % LINES.length], values: Float64Array.from({ length }, (_, t) => rate(t)), amounts: new Float64Array(length).fill(sum), amountUnit: "in all" };
  });
}

function residuals(plan: Plan): Curve[] {
  const rows = plan.raw.check.rows.filter((row) => row.over_time);
  return largest(rows.map((row) => ({ name: row.category.replaceAll("_", " "), color: "", values: decode(row.over_time!, row.category).values })), MOST);
}
