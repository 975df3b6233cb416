// The page: tabs, one or two plans, the panel, the transport bar.

import { helpDialog, listen, Transport, type Actions } from "./controls";
import type { Plan } from "./data";
import { el } from "./dom";
import { PlanView } from "./plan_view";
import { Player } from "./player";
import { LAYERS, type Layers } from "./scene/stage";

const LAYER_NAMES: [keyof Layers, string][] = [
  ["forces", "Forces"], ["cones", "Friction cones"], ["contacts", "Contacts"], ["path", "CoM path"], ["ghost", "Ghost of the end"], ["follow", "Follow"],
];

export class App {
  readonly player: Player;
  readonly views: (PlanView | undefined)[];
  private readonly transport: Transport;
  private readonly stages = el("main", { class: "stages" });
  private readonly side = el("div", { class: "side" });
  private readonly tabs: HTMLButtonElement[];
  private readonly both: HTMLButtonElement | null;
  private readonly toggles: Record<string, HTMLButtonElement> = {};
  private readonly help = helpDialog();
  private readonly layers: Layers = { ...LAYERS };
  private active = 0;
  private together = false;
  private theme: "light" | "dark";

  /** Fills `root`; `back` leads to the page that this one was opened from. */
  constructor(readonly plans: Plan[], private readonly root: HTMLElement, back?: () => void) {
    this.player = new Player(plans[0].duration);
    this.views = plans.map(() => undefined);
    const dark = window.matchMedia("(prefers-color-scheme: dark)");
    const given = document.documentElement.dataset.theme;
    this.theme = given === "dark" || given === "light" ? given : dark.matches ? "dark" : "light";
    dark.addEventListener("change", () => { this.theme = dark.matches ? "dark" : "light"; this.applyTheme(); });
    const actions = this.actions();
    this.transport = new Transport(this.player, actions);
    this.tabs = plans.map((plan, i) => el("button", { role: "tab", class: "tab", click: () => this.select(i) }, plans.length > 1 ? plan.raw.name : plan.raw.task || plan.raw.name));
    this.both = plans.length > 1 ? el("button", { class: "tab both", title: "Two plans beside one another, in step (S)", click: () => actions.side() }, "Side by side") : null;
    root.replaceChildren(this.header(actions, back), this.stages, this.side, this.transport.root, this.help);
    listen(this.player, actions, () => this.root.isConnected && !this.root.hidden && this.root.contains(this.transport.root));
    this.player.onChange(() => this.update());
    this.select(0);
    this.applyTheme();
    if (!back) document.title = `${plans.map((plan) => plan.raw.name).join(", ")} – locotamp`;
  }

  private header(actions: Actions, back?: () => void): HTMLElement {
    const toggles = LAYER_NAMES.map(([name, text]) => {
      this.toggles[name] = el("button", { class: "toggle", "aria-pressed": String(this.layers[name]), click: () => actions.layer(name) }, text);
      return this.toggles[name];
    });
    return el("header", {}, back ? el("button", { class: "tab both", click: back, title: "Back to the search (Escape)" }, "← Search") : el("span", { class: "brand" }, "locotamp"), el("div", { class: "tabs", role: "tablist" }, ...this.tabs, this.both),
      el("div", { class: "toggles" }, ...toggles),
      el("button", { class: "icon", title: "Camera back (R)", "aria-label": "Camera back", click: () => actions.home() }, "⌂"),
      el("button", { class: "icon", title: "Light or dark (T)", "aria-label": "Light or dark", click: () => actions.theme() }, "◐"),
      el("button", { class: "icon", title: "Keys (?)", "aria-label": "Keys", click: () => actions.help() }, "?"));
  }

  private actions(): Actions {
    return {
      node: (steps) => this.stepNode(steps),
      phase: (steps) => this.stepPhase(steps),
      home: () => this.shown().forEach((view) => { if (view.stage) { view.stage.touched = false; view.stage.home(); } }),
      layer: (name) => {
        this.layers[name] = !this.layers[name];
        this.toggles[name].setAttribute("aria-pressed", String(this.layers[name]));
        this.views.forEach((view) => view?.setLayers(this.layers));
      },
      theme: () => { this.theme = this.theme === "dark" ? "light" : "dark"; this.applyTheme(); },
      plan: (index) => { if (index < this.plans.length) this.select(index); },
      side: () => { if (this.plans.length > 1) { this.together = !this.together; this.arrange(); } },
      help: () => { if (this.help.open) this.help.close(); else this.help.showModal(); },
    };
  }

  private get plan(): Plan { return this.plans[this.active]; }

  private stepNode(steps: number): void {
    this.player.pause();
    const { node, share } = this.plan.at(this.player.time);
    const here = share > 0.999 ? node + 1 : node;
    const to = steps > 0 ? here + 1 : share > 1e-3 && share <= 0.999 ? node : here - 1;
    this.player.seek(this.plan.time[Math.min(this.plan.time.length - 1, Math.max(0, to))]);
  }

  private stepPhase(steps: number): void {
    this.player.pause();
    const { plan } = this;
    const k = plan.phaseAt(this.player.time + 1e-6);
    const start = plan.time[plan.phases[k].start];
    // Back goes to the beginning of this phase first, as with music.
    if (steps < 0) this.player.seek(this.player.time - start > 0.05 || k === 0 ? start : plan.time[plan.phases[k - 1].start]);
    else this.player.seek(plan.time[plan.phases[k].end]);
  }

  private view(index: number): PlanView {
    const known = this.views[index];
    if (known) return known;
    const view = new PlanView(this.plans[index], this.player);
    this.views[index] = view;
    view.root.addEventListener("pointerdown", () => { if (this.together && this.active !== index) { this.active = index; this.arrange(); } }, true);
    view.stage?.setTheme(this.theme);
    view.setLayers(this.layers);
    return view;
  }

  /** The two plans side by side: the active one and its neighbour. */
  private shownIndices(): number[] {
    if (!this.together) return [this.active];
    const other = this.active > 0 ? this.active - 1 : 1;
    return [this.active, other].sort((x, y) => x - y);
  }

  private shown(): PlanView[] { return this.shownIndices().map((i) => this.view(i)); }

  select(index: number): void {
    this.active = index;
    this.arrange();
  }

  private arrange(): void {
    const indices = this.shownIndices();
    const views = indices.map((i) => this.view(i));
    this.stages.replaceChildren(...views.map((view, place) => {
      view.root.classList.toggle("active", this.together && indices[place] === this.active);
      view.root.dataset.name = this.together ? view.plan.raw.name : "";
      return view.root;
    }));
    this.side.replaceChildren(this.view(this.active).panel);
    this.tabs.forEach((tab, i) => tab.setAttribute("aria-selected", String(i === this.active)));
    this.both?.setAttribute("aria-pressed", String(this.together));
    this.player.duration = Math.max(...views.map((view) => view.plan.duration));
    views.forEach((view) => view.resize());
    this.player.seek(this.player.time);
  }

  private applyTheme(): void {
    document.documentElement.dataset.theme = this.theme;
    this.views.forEach((view) => view?.setTheme(this.theme));
  }

  private update(): void {
    this.shown().forEach((view) => view.update());
    this.transport.update();
  }
}
