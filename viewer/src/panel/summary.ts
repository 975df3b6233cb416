// What the plan is, what limits it, and the checker's verdict.

import type { CheckRow, Plan } from "../data";
import { el, percent, short } from "../dom";
import type { Player } from "../player";
import { joint } from "../timeline/curves";

interface Use { name: string; detail: string; share: number; node: number }

export function summary(plan: Plan, player: Player): HTMLElement {
  return el("div", { class: "summary" }, explanation(plan), limits(plan, player), facts(plan), checks(plan, player), quality(plan, player), notes(plan));
}

function jump(player: Player, time: number): void {
  player.pause();
  player.seek(time);
}

export function verdict(plan: Plan): HTMLElement {
  const { check, feasible } = plan.raw;
  const failed = check.rows.filter((row) => row.status === "FAIL").map((row) => row.category.replaceAll("_", " "));
  const text = check.ok ? "Accepted by the checker" : `Rejected: ${failed.slice(0, 4).join(", ")}${failed.length > 4 ? " …" : ""}`;
  return el("div", { class: `verdict ${check.ok ? "good" : "bad"}` }, el("span", { class: "mark" }, check.ok ? "✓" : "✕"), el("div", {}, el("b", {}, text),
    el("small", {}, feasible ? "the planner calls it feasible" : "the planner calls it infeasible")));
}

function facts(plan: Plan): HTMLElement {
  const { raw } = plan;
  const pairs: [string, string][] = [
    ["Duration", `${plan.duration.toFixed(2)} s`],
    ["Phases", `${plan.phases.length}, ${plan.time.length - 1} intervals`],
    ["Robot", `${raw.robot.name || "robot"}, ${raw.robot.joints.length} joints, ${short(raw.robot.mass)} kg`],
    ["Integrator", raw.integrator],
  ];
  for (const object of raw.objects) pairs.push(["Object", `${object.name.replaceAll("_", " ")}, ${short(object.mass)} kg`]);
  if (raw.cost !== null) pairs.push(["Cost", short(raw.cost, 4)]);
  const terms = raw.costs ? [...raw.costs.terms, ...raw.costs.end].sort((x, y) => Math.abs(y[1]) - Math.abs(x[1])) : [];
  if (terms.length > 0) pairs.push(["… of which", terms.map(([name, sum]) => `${name.replaceAll("_", " ")} ${short(sum)}`).join(", ")]);
  const goal = raw.goal.map(([a, b]) => `${plan.label(a)} on ${plan.label(b)}`);
  goal.push(...raw.goal_regions.map((region) => `${region.body.replaceAll("_", " ")} in a region`));
  if (goal.length > 0) pairs.unshift(["Goal", goal.join(", ")]);
  return el("dl", { class: "facts" }, ...pairs.flatMap(([name, value]) => [el("dt", {}, name), el("dd", {}, value)]));
}

function explanation(plan: Plan): HTMLElement | null {
  if (!plan.raw.explanation) return null;
  const lines = plan.raw.explanation.split("\n").filter((line) => line.trim() !== "");
  return el("section", { class: "why" }, el("h3", {}, "Why there is no motion"), ...lines.map((line) => {
    // "cause   what it is": a label and what follows; lines that begin with space go on with the label before.
    const labelled = /^(\S.*?)\s{2,}(.*)$/.exec(line);
    return labelled ? el("p", { class: "item" }, el("b", {}, labelled[1]), labelled[2]) : el("p", { class: /^\s/.test(line) ? "item" : "" }, line.trim());
  }));
}

/** How much of each kind of limit is used at most, the scarcest first. */
function uses(plan: Plan): Use[] {
  const names: Record<string, string> = { friction: "Friction", cop: "Centre of pressure", torsion: "Torsional friction", torque: "Joint torque", torque_speed: "Torque at speed" };
  const found: Use[] = plan.raw.check.margins
    .filter((margin) => margin.node !== null)
    .map((margin) => ({ name: names[margin.limit] ?? margin.limit, detail: place(margin.what), share: margin.largest, node: margin.node! }));
  const speed = { name: "Joint speed", detail: "", share: 0, node: 0 };
  plan.raw.robot.joints.forEach((axis, j) => {
    for (let t = 0; axis.speed && t < plan.rates.length; t++) {
      const share = Math.abs(plan.rates.at(t, j)) / axis.speed;
      if (share > speed.share) Object.assign(speed, { share, node: t, detail: joint(axis.name) });
    }
  });
  if (speed.share > 0) found.push(speed);
  return found.sort((x, y) => y.share - x.share);
}

function place(what: string): string { return joint(what).replace("/", " on "); }

function limits(plan: Plan, player: Player): HTMLElement {
  const rows = uses(plan).map(({ name, detail, share, node }) => el(
    "button", { class: "use", click: () => jump(player, plan.time[node]), title: `${name}: ${percent(share)} of the limit, ${detail}, at ${plan.time[node].toFixed(2)} s` },
    el("span", { class: "name" }, name), el("span", { class: "value" }, percent(share)),
    el("span", { class: "bar" }, el("i", { style: `width:${Math.min(100, 100 * share)}%`, class: share > 0.98 ? "full" : share > 0.8 ? "high" : "" })),
    el("small", {}, `${detail}, ${plan.time[node].toFixed(2)} s`),
  ));
  const hasLimits = plan.raw.robot.joints.some((axis) => axis.enforced);
  const free = hasLimits ? null : el("small", { class: "warn" }, "This plan was made without torque limits; shares are of the robot's rated torques.");
  return el("section", {}, el("h3", {}, "What limits it"), ...rows, free);
}

function checks(plan: Plan, player: Player): HTMLElement {
  const { rows } = plan.raw.check;
  const count = (status: string) => rows.filter((row) => row.status === status).length;
  const head = `Checker: ${count("PASS")} passed, ${count("WARN")} warned, ${count("FAIL")} failed`;
  const order = { FAIL: 0, WARN: 1, PASS: 2, "n/a": 3 };
  const sorted = [...rows].sort((x, y) => order[x.status] - order[y.status] || share(y) - share(x));
  const details = el("details", { class: "checks", open: !plan.raw.check.ok }, el("summary", {}, head), ...sorted.map((row) => checkRow(plan, player, row)));
  return el("section", {}, details);
}

function share(row: CheckRow): number { return row.tolerance > 0 ? (row.value ?? 0) / row.tolerance : row.value ?? 0; }

function checkRow(plan: Plan, player: Player, row: CheckRow): HTMLElement {
  const value = row.value === null ? "–" : `${short(row.value, 2)} / ${short(row.tolerance, 2)} ${row.unit}`;
  const node = row.node;
  const label = [el("i", { class: `dot ${row.status.replace("/", "")}` }), el("span", { class: "name" }, row.category.replaceAll("_", " ")), el("span", { class: "value" }, value)];
  const title = `${row.what}${row.place ? `\nworst: ${row.place}` : ""}`;
  if (node === null || row.value === null || row.value === 0) return el("div", { class: "check", title }, ...label);
  return el("button", { class: "check", title, click: () => jump(player, plan.time[Math.min(node, plan.time.length - 1)]) }, ...label);
}

function quality(plan: Plan, player: Player): HTMLElement | null {
  const known = plan.raw.quality;
  if (!known) return null;
  const rows: [string, string, number | null][] = [];
  if (known.rms_joint_jerk !== undefined) rows.push(["Joint jerk, r.m.s.", `${short(known.rms_joint_jerk)} rad/s³`, null]);
  const peak = (name: string, unit: string, value?: { value: number; of: string; time: number }) => {
    if (value) rows.push([`${name} (${place(value.of)})`, `${short(value.value)} ${unit}`, value.time]);
  };
  peak("Fastest torque", "N m/s", known.torque_rate);
  peak("Torque jump at a switch", "of limit", known.torque_jump_at_switch);
  peak("Force at a switch", "N", known.force_at_switch);
  const margins = (known.margins ?? []).filter((margin) => margin.reached !== null);
  const items = rows.map(([name, value, time]) => {
    const parts = [el("span", { class: "name" }, name), el("span", { class: "value" }, value)];
    return time === null ? el("div", { class: "check" }, ...parts) : el("button", { class: "check", click: () => jump(player, time) }, ...parts);
  });
  const margin = margins.map((x) => el("div", { class: "check" }, el("span", { class: "name" }, `Margin ${x.name.replaceAll("_", " ")}`),
    el("span", { class: "value" }, `${short(x.reached!, 2)} (asked ${short(x.demanded, 2)}) ${x.unit === "1" ? "" : x.unit}`)));
  return el("section", {}, el("details", { class: "checks" }, el("summary", {}, "Smoothness and margins"), ...items, ...margin));
}

function notes(plan: Plan): HTMLElement | null {
  const list = [...plan.raw.robot.notes];
  if (plan.raw.robot.joints.every((axis) => axis.torque === null)) list.push("The robot has no torque limits, so there are no torque shares.");
  if (list.length === 0) return null;
  return el("section", {}, el("h3", {}, "Notes"), el("ul", {}, ...list.map((text) => el("li", {}, text))));
}
