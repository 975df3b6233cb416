// All charts of a plan under one another, with a cursor at the present time.

import type { Colors } from "../colors";
import type { Plan } from "../data";
import { el } from "../dom";
import type { Player } from "../player";
import { ink, TimeAxis, type Chart } from "./chart";
import { charts } from "./curves";

export class Timeline {
  readonly root: HTMLElement;
  private readonly charts: Chart[];
  private readonly cursor = el("div", { class: "cursor" });
  private readonly tip = el("div", { class: "tip", role: "status" });
  private readonly stack: HTMLElement;
  private axis: TimeAxis;
  private dragging = false;

  constructor(private readonly plan: Plan, colors: Colors, private readonly player: Player) {
    this.charts = charts(plan, colors);
    this.axis = new TimeAxis(plan.duration, 600);
    this.stack = el("div", { class: "stack" }, ...this.charts.map((chart) => chart.canvas), this.cursor);
    this.root = el("div", { class: "timeline" }, this.stack, this.tip);
    this.charts.forEach((chart) => {
      chart.canvas.setAttribute("role", "img");
      chart.canvas.setAttribute("aria-label", `${chart.title} over time`);
    });
    this.stack.addEventListener("pointerdown", (event) => this.press(event));
    this.stack.addEventListener("pointermove", (event) => this.move(event));
    this.stack.addEventListener("pointerup", () => { this.dragging = false; });
    this.stack.addEventListener("pointerleave", () => { this.tip.style.display = "none"; });
  }

  /** Draws all charts for the present width and theme. */
  redraw(): void {
    const width = this.stack.clientWidth;
    if (width < 50) return;
    this.axis = new TimeAxis(this.plan.duration, width);
    const colors = ink();
    this.charts.forEach((chart) => chart.draw(width, colors));
    this.update();
  }

  /** Moves the cursor. */
  update(): void {
    const x = this.axis.x(Math.min(this.player.time, this.plan.duration));
    this.cursor.style.transform = `translateX(${x}px)`;
    this.cursor.dataset.x = x.toFixed(1);
  }

  private press(event: PointerEvent): void {
    const { chart, x, y } = this.under(event);
    const time = this.axis.time(x);
    this.dragging = true;
    this.stack.setPointerCapture(event.pointerId);
    this.player.pause();
    this.player.seek(chart?.pick?.(time, y) ?? time);
  }

  private move(event: PointerEvent): void {
    const { chart, x, y } = this.under(event);
    const time = this.axis.time(x);
    if (this.dragging) this.player.seek(time);
    const hints = chart?.hint(time, y) ?? [];
    this.tip.style.display = hints.length > 0 ? "block" : "none";
    const rows = hints.map(({ color, text }) => el("div", {}, color ? el("i", { style: `background:${color}` }) : null, text));
    this.tip.replaceChildren(el("b", {}, `${time.toFixed(2)} s`), ...rows);
    const place = this.root.getBoundingClientRect();
    const left = Math.min(event.clientX + 14, place.right - this.tip.offsetWidth - 8);
    const above = event.clientY - this.tip.offsetHeight - 10;
    this.tip.style.left = `${Math.max(place.left + 4, left)}px`;
    this.tip.style.top = `${above < 4 ? event.clientY + 16 : above}px`;
  }

  /** The chart under the pointer, and the pointer's place on it. */
  private under(event: PointerEvent): { chart?: Chart; x: number; y: number } {
    const chart = this.charts.find(({ canvas }) => {
      const { top, bottom } = canvas.getBoundingClientRect();
      return event.clientY >= top && event.clientY < bottom;
    });
    const { left, top } = (chart?.canvas ?? this.stack).getBoundingClientRect();
    return { chart, x: event.clientX - left, y: event.clientY - top };
  }
}
