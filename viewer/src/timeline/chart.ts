// What all charts share: the axis of time, a canvas that stays sharp, hover.

import type { Plan } from "../data";

/** Room for the names at the left and for the last label at the right [px]. */
export const LEFT = 172;
export const RIGHT = 48;

export interface Ink { text: string; faint: string; grid: string; band: string; surface: string; accent: string; bad: string }

/** The theme's colours for charts. */
export function ink(): Ink {
  const style = getComputedStyle(document.documentElement);
  const value = (name: string) => style.getPropertyValue(name).trim();
  return {
    text: value("--text"), faint: value("--muted"), grid: value("--grid"), band: value("--band"),
    surface: value("--surface"), accent: value("--accent"), bad: value("--bad"),
  };
}

/** What the pointer is over: lines of a tooltip, with a colour each. */
export interface Hint { color?: string; text: string }

export interface Chart {
  readonly canvas: HTMLCanvasElement;
  readonly title: string;
  draw(width: number, ink: Ink): void;
  hint(time: number, y: number): Hint[];
  /** Click on the chart; a time to jump to other than that of the pointer. */
  pick?(time: number, y: number): number | undefined;
}

/** Time to pixels and back. */
export class TimeAxis {
  constructor(readonly duration: number, readonly width: number) {}
  x(time: number): number { return LEFT + (time / this.duration) * (this.width - LEFT - RIGHT); }
  time(x: number): number { return Math.min(this.duration, Math.max(0, ((x - LEFT) / (this.width - LEFT - RIGHT)) * this.duration)); }
}

/** Sizes a canvas for the display and clears it. */
export function prepare(canvas: HTMLCanvasElement, width: number, height: number): CanvasRenderingContext2D {
  const scale = Math.max(1, window.devicePixelRatio);
  canvas.width = Math.round(width * scale);
  canvas.height = Math.round(height * scale);
  canvas.style.width = `${width}px`;
  canvas.style.height = `${height}px`;
  const context = canvas.getContext("2d")!;
  context.setTransform(scale, 0, 0, scale, 0, 0);
  context.font = "11.5px system-ui, sans-serif";
  context.textBaseline = "middle";
  return context;
}

/** Shades every other phase from `top` to `bottom`. */
export function phaseBands(context: CanvasRenderingContext2D, plan: Plan, axis: TimeAxis, top: number, bottom: number, { band }: Ink): void {
  plan.phases.forEach((phase, k) => {
    const [from, to] = [axis.x(plan.time[phase.start]), axis.x(plan.time[phase.end])];
    if (k % 2 === 1) {
      context.fillStyle = band;
      context.fillRect(from, top, to - from, bottom - top);
    }
  });
}

/** A text cut to a width. */
export function fitted(context: CanvasRenderingContext2D, text: string, width: number): string {
  if (context.measureText(text).width <= width) return text;
  let kept = text;
  while (kept.length > 1 && context.measureText(`${kept}…`).width > width) kept = kept.slice(0, -1);
  return kept.length > 1 ? `${kept}…` : "";
}

/** Round numbers that divide a span of time. */
export function ticks(span: number, count: number): number[] {
  const rough = span / count;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= rough) ?? rough;
  return Array.from({ length: Math.floor(span / step + 1e-9) + 1 }, (_, i) => Number((i * step).toPrecision(6)));
}
