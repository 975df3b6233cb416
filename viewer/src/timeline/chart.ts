// What all charts share: the axis of time, a canvas that stays sharp, hover.

import type { Plan } from "../data";

/** Room for the names at the left and for the last label at the right [px]. */
export const LEFT = 172;
export const RIGHT = 56;

export interface Ink { text: string; faint: string; grid: string; band: string; surface: string; accent: string; bad: string }

const inks = new Map<string | undefined, Ink>();

/** The theme's colours for charts; asked for once per theme, since the browser works out all styles to answer. */
export function ink(): Ink {
  const { theme } = document.documentElement.dataset;
  const known = inks.get(theme);
  if (known) return known;
  const fresh = readInk();
  if (theme !== undefined) inks.set(theme, fresh);
  return fresh;
}

function readInk(): Ink {
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
  const [wide, tall] = [Math.round(width * scale), Math.round(height * scale)];
  // A canvas that is sized anew gets new memory, which is too much to do in every frame.
  if (canvas.width !== wide || canvas.height !== tall) {
    [canvas.width, canvas.height] = [wide, tall];
    canvas.style.width = `${width}px`;
    canvas.style.height = `${height}px`;
  }
  const context = canvas.getContext("2d")!;
  context.reset();
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

/** A text cut in its middle to a width, for names that differ at their ends. */
export function fittedMiddle(context: CanvasRenderingContext2D, text: string, width: number): string {
  let cut = text;
  for (let kept = text.length - 1; kept > 1 && context.measureText(cut).width > width; kept--) {
    const head = Math.floor(0.45 * kept);
    cut = `${text.slice(0, head).trimEnd()}…${text.slice(text.length - (kept - head)).trimStart()}`;
  }
  return cut;
}

/** A text in at most `most` lines of a width, broken between words; the last is cut. */
export function broken(context: CanvasRenderingContext2D, text: string, width: number, most: number): string[] {
  const lines: string[] = [];
  for (const word of text.split(" ")) {
    const longer = `${lines[lines.length - 1]} ${word}`;
    const isFull = lines.length === most || (lines.length > 0 && context.measureText(longer).width <= width);
    if (isFull) lines[lines.length - 1] = longer; else lines.push(word);
  }
  return lines.map((line) => fitted(context, line, width));
}

/** Round numbers that divide a span of time. */
export function ticks(span: number, count: number): number[] {
  const rough = span / count;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= rough) ?? rough;
  return Array.from({ length: Math.floor(span / step + 1e-9) + 1 }, (_, i) => Number((i * step).toPrecision(6)));
}
