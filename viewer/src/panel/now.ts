// What holds at this moment: phase, what was made and broken, forces.

import type { Colors } from "../colors";
import type { Contact, Plan } from "../data";
import { el } from "../dom";

/** Over the scene: which phase, and what changed on entering it. */
export class Caption {
  readonly root = el("div", { class: "caption", "aria-live": "off" });
  private shown = -1;

  constructor(private readonly plan: Plan, private readonly colors: Colors) {}

  update(time: number): void {
    const { plan } = this;
    const k = plan.phaseAt(time);
    if (k === this.shown) return;
    this.shown = k;
    const phase = plan.phases[k];
    const chip = (contact: Contact, sign: string) => el(
      "span", { class: `chip ${sign === "+" ? "made" : "broken"}` }, el("i", { style: `background:${this.colors.interface(contact.b)}` }), `${sign} ${plan.contactName(contact)}`,
    );
    const next = plan.phases[k + 1];
    this.root.replaceChildren(
      el("div", { class: "phase" }, el("small", {}, `Phase ${k + 1} of ${plan.phases.length}`), el("b", {}, phase.action || "—")),
      el("div", { class: "chips" }, ...phase.gained.map((x) => chip(x, "+")), ...phase.lost.map((x) => chip(x, "−"))),
      el("small", { class: "next" }, next ? `then ${next.action}` : "to the end"),
    );
  }
}

/** In the panel: the active contacts with their normal force. */
export class Forces {
  readonly root = el("div", { class: "forces" });
  private phase = -1;
  private rows: { bar: HTMLElement; value: HTMLElement; contact: Contact }[] = [];

  constructor(private readonly plan: Plan, private readonly colors: Colors) {
    // Room for the most, so that what stands below keeps its place.
    this.root.style.minHeight = `${29 * Math.max(...plan.phases.map((phase) => phase.contacts.length))}px`;
  }

  update(time: number): void {
    const { plan } = this;
    const { node, share } = plan.at(time);
    const k = plan.phaseOf[node];
    if (k !== this.phase) this.rebuild(k);
    const interval = node - plan.phases[k].start;
    for (const { bar, value, contact } of this.rows) {
      const next = Math.min(interval + 1, contact.load.length - 1);
      const mix = (rows: typeof contact.load, column: number) => (1 - share) * rows.at(interval, column) + share * rows.at(next, column);
      const force = Math.hypot(mix(contact.wrench, 0), mix(contact.wrench, 1), mix(contact.wrench, 2));
      bar.style.transform = `scaleX(${Math.min(1, force / plan.weight).toFixed(4)})`;
      value.textContent = `${force.toFixed(0)} N`;
    }
  }

  private rebuild(k: number): void {
    this.phase = k;
    this.rows = this.plan.phases[k].contacts.map((contact) => ({ bar: el("i"), value: el("span", { class: "value" }), contact }));
    this.root.replaceChildren(...this.rows.map(({ bar, value, contact }) => {
      bar.style.background = this.colors.interface(contact.a);
      return el("div", { class: "force" }, el("i", { class: "dot", style: `background:${this.colors.interface(contact.b)}` }),
        el("span", { class: "name" }, this.plan.contactName(contact)), value, el("span", { class: "bar" }, bar));
    }));
  }
}
