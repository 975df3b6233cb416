// Curves over time with their legend at the left.

import { short } from "../dom";
import type { Plan } from "../data";
import { fittedMiddle, LEFT, phaseBands, prepare, ticks, TimeAxis, type Chart, type Hint, type Ink } from "./chart";

export interface Curve {
  name: string;
  color: string;
  /** One value per entry of `times`; NaN breaks the line. */
  values: ArrayLike<number>;
  /** The same in its own unit, for the tooltip. */
  amounts?: ArrayLike<number>;
  amountUnit?: string;
}

export interface LineOptions {
  title: string;
  unit: string;
  curves: Curve[];
  /** Lines that curves should not cross. */
  limit?: number;
  /** Bottom and top of the axis; by default what the curves need. */
  low?: number;
  high?: number;
  /** Values are shares, shown in percent. */
  share?: boolean;
}

const HEIGHT = 96;
const TOP = 20;
const BOTTOM = 6;

export class LineChart implements Chart {
  readonly canvas = document.createElement("canvas");
  readonly title: string;
  private low = 0;
  private high = 1;

  constructor(private readonly plan: Plan, private readonly options: LineOptions) {
    this.title = options.title;
    const values = options.curves.flatMap((curve) => Array.from(curve.values).filter(Number.isFinite));
    const [least, most] = [values.reduce((x, y) => Math.min(x, y), Infinity), values.reduce((x, y) => Math.max(x, y), -Infinity)];
    const margin = 0.08 * Math.max(1e-9, most - least);
    this.low = options.low ?? least - margin;
    this.high = Math.max(options.high ?? most + margin, options.limit !== undefined ? 1.06 * options.limit : -Infinity);
    if (options.high !== undefined) this.high = Math.max(this.high, most + margin);
    if (!(this.high > this.low)) [this.low, this.high] = [0, 1];
  }

  private y(value: number): number { return TOP + (HEIGHT - TOP - BOTTOM) * (1 - (value - this.low) / (this.high - this.low)); }

  private format(value: number): string { return this.options.share ? `${Math.round(100 * value)} %` : `${short(value)} ${this.options.unit}`.trim(); }

  draw(width: number, ink: Ink): void {
    const context = prepare(this.canvas, width, HEIGHT);
    const axis = new TimeAxis(this.plan.duration, width);
    const { curves, limit, title } = this.options;
    phaseBands(context, this.plan, axis, TOP, HEIGHT - BOTTOM, ink);
    context.textAlign = "left";
    context.fillStyle = ink.text;
    context.font = "600 11.5px system-ui, sans-serif";
    context.fillText(title, LEFT, 9);
    context.font = "11.5px system-ui, sans-serif";
    this.drawScale(context, axis, ink);
    curves.forEach((curve, i) => {
      const y = TOP + 6 + i * 12.5;
      if (y > HEIGHT - 4) return;
      context.fillStyle = curve.color;
      context.fillRect(8, y - 4, 8, 8);
      context.fillStyle = ink.text;
      context.textAlign = "left";
      context.fillText(fittedMiddle(context, curve.name, LEFT - 32), 21, y);
    });
    if (limit !== undefined) {
      context.strokeStyle = ink.bad;
      context.setLineDash([5, 4]);
      line(context, axis.x(0), this.y(limit), axis.x(this.plan.duration), this.y(limit));
      context.setLineDash([]);
    }
    for (const curve of curves) this.drawCurve(context, axis, curve);
  }

  private drawScale(context: CanvasRenderingContext2D, axis: TimeAxis, ink: Ink): void {
    const { limit } = this.options;
    const marks = limit !== undefined && this.low === 0 ? [0, limit] : ticks(this.high - Math.min(0, this.low), 3).filter((x) => x >= this.low && x <= this.high);
    if (marks.length < 2) marks.splice(0, 1, this.low + 0.08 * (this.high - this.low), this.high - 0.08 * (this.high - this.low));
    context.textAlign = "left";
    for (const mark of marks) {
      context.fillStyle = ink.faint;
      context.fillText(this.format(mark), axis.x(this.plan.duration) + 5, this.y(mark));
      context.fillStyle = ink.grid;
      context.fillRect(LEFT, this.y(mark), axis.x(this.plan.duration) - LEFT, 1);
    }
  }

  private drawCurve(context: CanvasRenderingContext2D, axis: TimeAxis, curve: Curve): void {
    context.strokeStyle = curve.color;
    context.lineWidth = 1.6;
    context.lineJoin = "round";
    context.beginPath();
    let drawing = false;
    for (let i = 0; i < curve.values.length; i++) {
      const value = curve.values[i];
      if (!Number.isFinite(value)) { drawing = false; continue; }
      const [x, y] = [axis.x(this.plan.time[i]), this.y(value)];
      if (drawing) context.lineTo(x, y); else context.moveTo(x, y);
      drawing = true;
    }
    context.stroke();
    context.lineWidth = 1;
  }

  hint(time: number): Hint[] {
    const { node, share } = this.plan.at(time);
    const values = this.options.curves.map((curve) => {
      const between = (values: ArrayLike<number>) => {
        const value = (1 - share) * values[node] + share * values[Math.min(node + 1, values.length - 1)];
        return Number.isFinite(value) ? value : values[node];
      };
      return { curve, value: between(curve.values), amount: curve.amounts && `, ${short(between(curve.amounts))} ${curve.amountUnit}` };
    });
    const known = values.filter(({ value }) => Number.isFinite(value));
    return known.map(({ curve, value, amount }) => ({ color: curve.color, text: `${curve.name}: ${this.format(value)}${amount ?? ""}` }));
  }
}

function line(context: CanvasRenderingContext2D, x0: number, y0: number, x1: number, y1: number): void {
  context.beginPath();
  context.moveTo(x0, y0);
  context.lineTo(x1, y1);
  context.stroke();
}
