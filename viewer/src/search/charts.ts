// Solutions over time, and why the rest failed.

import { el, short } from "../dom";
import { ink, prepare, ticks } from "../timeline/chart";
import type { Search, Stage } from "./data";

const COLORS: Record<Stage, string> = { feasible: "#2fa36b", optimised: "#e0a02c", keyframes: "#d8473c", alike: "#c98b5e", refused: "#a0504a", open: "#8f9aa8" };

/** Every tried sequence at its time: solved ones by cost, the others below. */
export function progressChart(search: Search, width: number, onPick: (node: number) => void): HTMLElement {
  const canvas = el("canvas", { "aria-label": "Sequences tried and cost of solutions over time" });
  const isSolved = search.raw.sequences.some((x) => x.reached === "feasible");
  const [left, right, top, base] = [44, 12, 12, isSolved ? 112 : 12];
  const height = base + 38;
  const context = prepare(canvas, width, height);
  const colors = ink();
  const { sequences } = search.raw;
  const end = Math.max(1, ...sequences.map((x) => x.at));
  const costs = sequences.filter((x) => x.reached === "feasible" && x.cost !== null).map((x) => x.cost!);
  const [low, high] = [Math.min(...costs), Math.max(...costs)];
  const x = (at: number) => left + (at / end) * (width - left - right);
  const y = (cost: number) => (high > low ? top + ((high - cost) / (high - low)) * (base - top - 12) : (top + base) / 2);
  context.fillStyle = colors.faint;
  context.textAlign = "center";
  for (const time of ticks(end, 5)) {
    context.fillRect(x(time), base + 16, 1, 4);
    context.fillText(`${short(time)} s`, x(time), base + 29);
  }
  context.textAlign = "right";
  if (costs.length > 0) for (const cost of new Set([low, high])) context.fillText(short(cost), left - 6, y(cost));
  context.fillText("tried", left - 6, base + 6);
  const places: { x: number; y: number; node: number; text: string }[] = [];
  let best = Infinity;
  let before: [number, number] | null = null;
  for (const sequence of [...sequences].sort((a, b) => a.at - b.at)) {
    const solved = sequence.reached === "feasible" && sequence.cost !== null;
    const place: [number, number] = [x(sequence.at), solved ? y(sequence.cost!) : base + 6];
    if (solved && sequence.cost! < best) {
      context.strokeStyle = COLORS.feasible;
      context.beginPath();
      context.moveTo(...(before ?? place));
      context.lineTo(place[0], (before ?? place)[1]);
      context.lineTo(...place);
      context.stroke();
      [best, before] = [sequence.cost!, place];
    }
    context.fillStyle = COLORS[sequence.reached];
    context.beginPath();
    if (solved) context.arc(...place, 4.5, 0, 2 * Math.PI); else context.rect(place[0] - 1, place[1] - 5, 2, 10);
    context.fill();
    places.push({ x: place[0], y: place[1], node: sequence.node, text: `sequence ${sequence.number} at ${short(sequence.at)} s${solved ? `, cost ${short(sequence.cost!, 4)}` : ""}` });
  }
  const near = (event: MouseEvent) => {
    const { left: l, top: t } = canvas.getBoundingClientRect();
    const distance = (p: { x: number; y: number }) => Math.hypot(p.x - event.clientX + l, p.y - event.clientY + t);
    const nearest = places.sort((a, b) => distance(a) - distance(b))[0];
    return nearest && distance(nearest) < 14 ? nearest : undefined;
  };
  canvas.addEventListener("mousemove", (event) => { const found = near(event); canvas.title = found?.text ?? ""; canvas.style.cursor = found ? "pointer" : ""; });
  canvas.addEventListener("click", (event) => { const found = near(event); if (found) onPick(found.node); });
  return canvas;
}

/** The most frequent reasons of failure as bars; a click finds them in the tree. */
export function reasonBars(search: Search, onFind: (text: string) => void): HTMLElement {
  const reasons = search.reasons().slice(0, 9);
  if (reasons.length === 0) return el("p", {}, "Nothing has failed.");
  const most = reasons[0].count;
  return el("div", { class: "reasons" }, ...reasons.map(({ kind, count, example }) => el(
    "button", { class: "use", title: example, click: () => onFind(kind.replace(/^.*?: /, "")) },
    el("span", { class: "name" }, kind), el("span", { class: "value" }, String(count)),
    el("span", { class: "bar" }, el("i", { style: `width:${(100 * count) / most}%` })),
  )));
}
