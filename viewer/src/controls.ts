// Buttons and keys.

import { el } from "./dom";
import { Player, SPEEDS } from "./player";

/** Everything that buttons and keys do. */
export interface Actions {
  node(steps: number): void;
  phase(steps: number): void;
  home(): void;
  layer(name: "forces" | "cones" | "contacts" | "path" | "ghost" | "follow"): void;
  theme(): void;
  plan(index: number): void;
  side(): void;
  help(): void;
}

export const KEYS: [string, string][] = [
  ["Space", "play, pause"],
  ["← →", "one node back, on"],
  ["Shift ← →", "one phase back, on"],
  ["Home End", "beginning, end"],
  ["− +", "slower, faster"],
  ["L", "repeat"],
  ["R", "camera back"],
  ["F", "follow the robot"],
  ["W", "forces"],
  ["K", "friction cones"],
  ["C", "contact patches"],
  ["M", "path of the centre of mass"],
  ["G", "ghost of the end"],
  ["1 … 9", "plan by number"],
  ["S", "side by side"],
  ["T", "light, dark"],
  ["?", "this list"],
];

/** The bar with play, scrubber, speed. */
export class Transport {
  readonly root: HTMLElement;
  private readonly play: HTMLButtonElement;
  private readonly scrubber: HTMLInputElement;
  private readonly clock = el("output", { class: "clock" });
  private readonly speed: HTMLSelectElement;
  private readonly loop: HTMLButtonElement;

  constructor(private readonly player: Player, actions: Actions) {
    const button = (text: string, title: string, click: () => void) => el("button", { title, "aria-label": title, click }, text);
    this.play = button("▶", "Play (space)", () => player.toggle());
    this.play.className = "play";
    this.scrubber = el("input", { type: "range", class: "scrubber", min: 0, max: 10000, value: 0, "aria-label": "Time", input: () => {
      player.pause();
      player.seek((Number(this.scrubber.value) / 10000) * player.duration);
    } });
    this.speed = el("select", { title: "Speed", "aria-label": "Speed", change: () => { player.speed = Number(this.speed.value); player.changed(); } },
      ...SPEEDS.map((speed) => el("option", { value: speed }, `${speed} ×`)));
    this.loop = button("↻", "Repeat (L)", () => { player.loop = !player.loop; player.changed(); });
    this.root = el("div", { class: "transport" },
      button("«", "Phase back (shift ←)", () => actions.phase(-1)), button("‹", "Node back (←)", () => actions.node(-1)), this.play,
      button("›", "Node on (→)", () => actions.node(1)), button("»", "Phase on (shift →)", () => actions.phase(1)),
      this.scrubber, this.clock, this.speed, this.loop);
  }

  update(): void {
    const { time, duration, playing, speed, loop } = this.player;
    this.play.textContent = playing ? "❚❚" : "▶";
    this.scrubber.value = String(Math.round((time / duration) * 10000));
    this.scrubber.setAttribute("aria-valuetext", `${time.toFixed(2)} seconds`);
    this.clock.textContent = `${time.toFixed(2)} / ${duration.toFixed(2)} s`;
    this.speed.value = String(speed);
    this.loop.setAttribute("aria-pressed", String(loop));
  }
}

/** Keys of the whole page; those of a focused select stay its own. */
export function listen(player: Player, actions: Actions, isShown: () => boolean): void {
  const layers: Record<string, Parameters<Actions["layer"]>[0]> = { w: "forces", k: "cones", c: "contacts", m: "path", g: "ghost", f: "follow" };
  // A button that was clicked keeps no focus, so that the space bar goes on to play and pause.
  document.addEventListener("pointerup", () => { if (document.activeElement instanceof HTMLButtonElement) document.activeElement.blur(); });
  document.addEventListener("keydown", (event) => {
    if (!isShown()) return;
    const target = event.target as HTMLElement;
    if (event.ctrlKey || event.metaKey || event.altKey || target.tagName === "SELECT") return;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    if (key === " " && (target.tagName === "BUTTON" || target.tagName === "SUMMARY")) return;
    const done = () => event.preventDefault();
    if (key === " ") { player.toggle(); done(); }
    else if (key === "ArrowLeft" || key === "ArrowRight") {
      const steps = key === "ArrowLeft" ? -1 : 1;
      if (event.shiftKey) actions.phase(steps); else actions.node(steps);
      done();
    } else if (key === "Home" || key === "End") { player.seek(key === "Home" ? 0 : player.duration); done(); }
    else if (key === "+" || key === "=") player.faster(1);
    else if (key === "-" || key === "_") player.faster(-1);
    else if (key === "l") { player.loop = !player.loop; player.changed(); }
    else if (key === "r") actions.home();
    else if (key === "s") actions.side();
    else if (key === "t") actions.theme();
    else if (key === "?" || key === "h") actions.help();
    else if (key === "Escape") document.querySelector<HTMLDialogElement>("dialog[open]")?.close();
    else if (key in layers) actions.layer(layers[key]);
    else if (/^[1-9]$/.test(key)) actions.plan(Number(key) - 1);
  });
}

export function helpDialog(): HTMLDialogElement {
  const dialog = el("dialog", {}, el("h2", {}, "Keys"),
    el("dl", { class: "keys" }, ...KEYS.flatMap(([key, what]) => [el("dt", {}, key), el("dd", {}, what)])),
    el("p", {}, "Drag the scene to turn it, with the right button to move it; the wheel zooms. Click or drag on the charts to go to a time."),
    el("form", { method: "dialog" }, el("button", {}, "Close")));
  return dialog;
}
