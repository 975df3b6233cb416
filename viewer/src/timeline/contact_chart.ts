// The contact sequence: a row per interface of robot and objects, a bar while it touches, in the colour of its partner.

import type { Colors } from "../colors";
import type { Contact, Plan } from "../data";
import { broken, fitted, LEFT, phaseBands, prepare, ticks, TimeAxis, type Chart, type Hint, type Ink } from "./chart";

const ROW = 19;
const PHASES = 34;
/** Room below which a phase shows its number alone, and distance of two lines of its name [px]. */
const NARROW = 54;
const LINE = 13;
const TIMES = 18;

interface Bar { row: number; partner: number; from: number; to: number; contact: Contact }

export class ContactChart implements Chart {
  readonly canvas = document.createElement("canvas");
  readonly title = "Contacts";
  private readonly rows: number[];
  private readonly bars: Bar[] = [];
  private width = 0;

  constructor(private readonly plan: Plan, private readonly colors: Colors) {
    this.rows = rowsOf(plan);
    for (const phase of plan.phases) {
      for (const contact of phase.contacts) {
        for (const [own, partner] of [[contact.a, contact.b], [contact.b, contact.a]]) {
          const row = this.rows.indexOf(own);
          if (row >= 0) this.extend({ row, partner, from: phase.start, to: phase.end, contact });
        }
      }
    }
  }

  /** Adds a bar, or lengthens the one that it continues. */
  private extend(bar: Bar): void {
    const before = this.bars.find((x) => x.row === bar.row && x.partner === bar.partner && x.to === bar.from);
    if (before) before.to = bar.to; else this.bars.push(bar);
  }

  get height(): number { return PHASES + this.rows.length * ROW + TIMES; }

  draw(width: number, ink: Ink): void {
    this.width = width;
    const { plan } = this;
    const axis = new TimeAxis(plan.duration, width);
    const context = prepare(this.canvas, width, this.height);
    const bottom = this.height - TIMES;
    phaseBands(context, plan, axis, 0, bottom, ink);
    this.drawPhases(context, axis, ink);
    this.rows.forEach((index, row) => {
      const y = PHASES + (row + 0.5) * ROW;
      context.textAlign = "right";
      context.fillStyle = ink.text;
      context.fillText(fitted(context, plan.label(index), LEFT - 26), LEFT - 12, y);
      context.fillStyle = ink.grid;
      context.fillRect(LEFT, y, axis.x(plan.duration) - LEFT, 1);
    });
    for (const bar of this.bars) this.drawBar(context, axis, bar);
    context.fillStyle = ink.faint;
    context.textAlign = "center";
    for (const time of ticks(plan.duration, Math.max(2, (width - LEFT) / 90))) {
      context.fillRect(axis.x(time), bottom, 1, 4);
      context.fillText(time === 0 ? "0 s" : String(time), axis.x(time), bottom + 11);
    }
  }

  private drawPhases(context: CanvasRenderingContext2D, axis: TimeAxis, ink: Ink): void {
    context.textAlign = "right";
    context.fillStyle = ink.faint;
    context.fillText("phase", LEFT - 12, PHASES / 2);
    this.plan.phases.forEach((phase, k) => {
      const [from, to] = [axis.x(this.plan.time[phase.start]), axis.x(this.plan.time[phase.end])];
      const room = to - from - 6;
      const full = `${k + 1} ${phase.action}`;
      context.fillStyle = ink.text;
      context.textAlign = "left";
      const isWide = room > NARROW || context.measureText(full).width <= room;
      const lines = isWide ? broken(context, full, room, 2) : [fitted(context, String(k + 1), room + 4)];
      lines.forEach((line, i) => context.fillText(line, from + 4, PHASES / 2 + LINE * (i - (lines.length - 1) / 2)));
      context.fillStyle = ink.grid;
      context.fillRect(from, 3, 1, PHASES - 6);
    });
  }

  private drawBar(context: CanvasRenderingContext2D, axis: TimeAxis, bar: Bar): void {
    const [from, to] = [axis.x(this.plan.time[bar.from]), axis.x(this.plan.time[bar.to])];
    const y = PHASES + bar.row * ROW + 3;
    context.fillStyle = this.colors.interface(bar.partner);
    context.beginPath();
    context.roundRect(from + 0.5, y, Math.max(2, to - from - 1), ROW - 6, 3);
    context.fill();
    const name = fitted(context, this.plan.label(bar.partner), to - from - 12);
    if (name.length < 4) return;
    context.fillStyle = "#ffffff";
    context.textAlign = "left";
    context.fillText(name, from + 6, y + (ROW - 6) / 2 + 0.5);
  }

  hint(time: number, y: number): Hint[] {
    const { plan } = this;
    const { node } = plan.at(time);
    const phase = plan.phases[plan.phaseOf[node]];
    const row = Math.floor((y - PHASES) / ROW);
    const head = { text: `phase ${plan.phaseOf[node] + 1} of ${plan.phases.length}: ${phase.action} (${phase.duration.toFixed(2)} s)` };
    const bar = this.bars.filter((x) => x.row === row && plan.time[x.from] <= time && time <= plan.time[x.to]);
    return [head, ...bar.map((x) => ({
      color: this.colors.interface(x.partner),
      text: `${plan.contactName(x.contact)}, ${x.contact.kind}, ${plan.time[x.from].toFixed(2)} to ${plan.time[x.to].toFixed(2)} s`,
    }))];
  }

  /** A click on the name of a phase goes to its beginning. */
  pick(time: number, y: number): number | undefined {
    return y < PHASES && this.width > 0 ? this.plan.time[this.plan.phases[this.plan.phaseAt(time)].start] : undefined;
  }
}

/** Interfaces of robot and objects that ever touch, robot first; those of static bodies are only partners. */
function rowsOf(plan: Plan): number[] {
  const used = new Set(plan.phases.flatMap((phase) => phase.contacts.flatMap((contact) => [contact.a, contact.b])));
  const all = plan.raw.interfaces.map((_, i) => i).filter((i) => used.has(i));
  const on = (kind: string) => all.filter((i) => plan.raw.interfaces[i].on === kind);
  return [...on("joint"), ...on("object")];
}
