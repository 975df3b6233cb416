// Where the pressure stands inside the patches that bear: drawn from above, toe up.

import type { Colors } from "../colors";
import type { Plan } from "../data";
import { ink, prepare } from "../timeline/chart";
import { percent } from "../dom";
import { soleShare } from "../timeline/curves";

const WIDTH = 284;
const HEIGHT = 140;

export class Soles {
  readonly canvas = document.createElement("canvas");
  /** Bounded patches of the robot that ever touch. */
  private readonly patches: number[];

  constructor(private readonly plan: Plan, private readonly colors: Colors) {
    const used = new Set(plan.phases.flatMap((phase) => phase.contacts.filter((x) => x.kind === "patch").map((x) => x.a)));
    this.patches = plan.raw.interfaces.map((_, i) => i).filter((i) => {
      const { on, half_size: size } = plan.raw.interfaces[i];
      return used.has(i) && on === "joint" && size !== null && size[0] !== null && size[1] !== null;
    }).slice(0, 4);
    // Left before right, as seen from behind.
    this.patches.sort((x, y) => plan.raw.interfaces[x].name.localeCompare(plan.raw.interfaces[y].name));
    this.canvas.setAttribute("aria-label", "Centre of pressure inside the soles");
  }

  get isEmpty(): boolean { return this.patches.length === 0; }

  draw(time: number): void {
    const { plan } = this;
    const colors = ink();
    const context = prepare(this.canvas, WIDTH, HEIGHT);
    const { node, share } = plan.at(time);
    const phase = plan.phases[plan.phaseOf[node]];
    const slot = WIDTH / this.patches.length;
    this.patches.forEach((index, place) => {
      const interfaceA = plan.raw.interfaces[index];
      const [halfX, halfY] = interfaceA.half_size as [number, number];
      const scale = Math.min((HEIGHT - 46) / (2 * halfX), (slot - 28) / (2 * halfY));
      const [w, h] = [2 * halfY * scale, 2 * halfX * scale];
      const [cx, cy] = [slot * (place + 0.5), (HEIGHT - 32) / 2 + 2];
      const contact = phase.contacts.find((x) => x.a === index && x.kind === "patch");
      const color = colors2(this.colors.interface(index));
      context.fillStyle = contact ? color.fill : "transparent";
      context.strokeStyle = contact ? color.line : colors.grid;
      context.lineWidth = 1.5;
      context.beginPath();
      context.roundRect(cx - w / 2, cy - h / 2, w, h, 5);
      context.fill();
      context.stroke();
      context.fillStyle = contact ? colors.text : colors.faint;
      context.textAlign = "center";
      const name = plan.label(index);
      const interval = node - phase.start;
      const used = contact ? soleShare(plan, contact, interval) : NaN;
      context.fillText(name, cx, HEIGHT - 22);
      context.fillText(contact ? percent(used) : "free", cx, HEIGHT - 8);
      if (!contact || contact.load.at(interval, 0) < 0.002) return;
      const next = Math.min(interval + 1, contact.load.length - 1);
      const mix = (column: number) => (1 - share) * contact.load.at(interval, column) + share * contact.load.at(next, column);
      // Interface axes: x forward; its z points out of the body, down for a foot, so seen from above y goes to the right.
      const [x, y] = [cx + mix(3) * scale, cy - mix(2) * scale];
      context.strokeStyle = colors.grid;
      context.beginPath();
      context.moveTo(cx - w / 2, cy); context.lineTo(cx + w / 2, cy);
      context.moveTo(cx, cy - h / 2); context.lineTo(cx, cy + h / 2);
      context.stroke();
      const radius = 3 + 5 * Math.min(1, (1000 * mix(0)) / plan.weight);
      context.fillStyle = used > 0.98 ? colors.bad : color.line;
      context.beginPath();
      context.arc(x, y, radius, 0, 2 * Math.PI);
      context.fill();
    });
  }
}

function colors2(color: string): { fill: string; line: string } {
  return { fill: `color-mix(in srgb, ${color} 18%, transparent)`, line: color };
}
