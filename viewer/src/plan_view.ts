// One plan on the page: scene with caption, and its charts. The panel beside it is made here too.

import { Colors } from "./colors";
import type { Plan } from "./data";
import { el } from "./dom";
import { Caption, Forces } from "./panel/now";
import { Soles } from "./panel/soles";
import { summary, verdict } from "./panel/summary";
import type { Player } from "./player";
import { Stage, type Layers } from "./scene/stage";
import { Timeline } from "./timeline/timeline";

export class PlanView {
  readonly root: HTMLElement;
  readonly panel: HTMLElement;
  /** Undefined where the browser has no WebGL. */
  readonly stage?: Stage;
  private readonly timeline: Timeline;
  private readonly caption: Caption;
  private readonly forces: Forces;
  private readonly soles: Soles;
  private readonly picture: HTMLElement;

  constructor(readonly plan: Plan, private readonly player: Player) {
    const colors = new Colors(plan);
    const canvas = el("canvas", { class: "stage", tabindex: 0, "aria-label": "The motion in three dimensions. Drag to turn, right drag to move, wheel to zoom." });
    this.caption = new Caption(plan, colors);
    this.forces = new Forces(plan, colors);
    this.soles = new Soles(plan, colors);
    this.timeline = new Timeline(plan, colors, player);
    this.picture = el("div", { class: "picture" }, canvas, this.caption.root);
    try {
      this.stage = new Stage(plan, colors, canvas);
      canvas.addEventListener("pointerdown", () => { if (this.stage) this.stage.touched = true; });
    } catch (error) {
      this.picture.append(el("p", { class: "apology" }, `No 3-D picture: ${(error as Error).message.replace(/\.$/, "")}. The charts below need none.`));
    }
    const divider = el("div", { class: "divider", title: "Drag to share the height" });
    divider.addEventListener("pointerdown", (event) => this.divide(event));
    this.root = el("div", { class: "plan" }, this.picture, divider, this.timeline.root);
    this.panel = el("aside", { class: "panel" }, verdict(plan),
      el("section", {}, el("h3", {}, "Now"), this.forces.root, this.soles.isEmpty ? null : this.soles.canvas),
      summary(plan, player));
    new ResizeObserver(() => this.resize()).observe(this.root);
    new ResizeObserver(() => this.resize()).observe(this.picture);
  }

  private divide(event: PointerEvent): void {
    const target = event.target as HTMLElement;
    target.setPointerCapture(event.pointerId);
    const { top, height } = this.root.getBoundingClientRect();
    const move = (at: PointerEvent) => {
      const share = Math.min(0.85, Math.max(0.15, (at.clientY - top) / height));
      document.documentElement.style.setProperty("--picture", `${(100 * share).toFixed(1)}%`);
    };
    target.addEventListener("pointermove", move);
    target.addEventListener("pointerup", () => target.removeEventListener("pointermove", move), { once: true });
  }

  resize(): void {
    this.stage?.resize(this.picture.clientWidth, this.picture.clientHeight);
    this.timeline.redraw();
  }

  /** Shows the player's time; a plan that is over stays at its end. */
  update(): void {
    const time = Math.min(this.player.time, this.plan.duration);
    this.stage?.show(time);
    this.timeline.update();
    this.caption.update(time);
    this.forces.update(time);
    if (!this.soles.isEmpty && this.panel.isConnected) this.soles.draw(time);
  }

  setTheme(theme: "light" | "dark"): void {
    this.stage?.setTheme(theme);
    this.timeline.redraw();
    this.update();
  }

  setLayers(layers: Layers): void { this.stage?.setLayers(layers); }
}
