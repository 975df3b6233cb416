// Colours of bodies and contacts, the same in the scene and in the charts.

import type { Plan } from "./data";

const NAMED: Record<string, string> = {
  red: "#d8473c", green: "#3d9b55", blue: "#3f7fd6", yellow: "#d9ab35", orange: "#e08a2c", purple: "#8f6bc7", white: "#c9ccd1", black: "#4a4d55",
};
const STATIC = ["#b18b5a", "#4f9d97", "#8d7cc4", "#c07a9c", "#8aa352", "#6d8fb8"];
const OBJECT = ["#d8473c", "#3d9b55", "#3f7fd6", "#d9ab35", "#8f6bc7"];
const GROUND = "#7f8a99";
const LEFT = "#2d8fd5";
const RIGHT = "#ee8d2b";
/** Lines of charts, told apart by eye. */
export const LINES = ["#2d8fd5", "#ee8d2b", "#2fa36b", "#c9539a", "#8f6bc7", "#b9a227", "#5aa9a3", "#d8473c"];

export class Colors {
  private readonly byBody = new Map<string, string>();

  constructor(private readonly plan: Plan) {
    const { environment, objects } = plan.raw;
    let next = 0;
    for (const body of environment) {
      const isGround = body.shapes.some((shape) => shape.plane);
      this.byBody.set(body.name, isGround ? GROUND : STATIC[next++ % STATIC.length]);
    }
    objects.forEach((body, i) => this.byBody.set(body.name, named(body.name) ?? OBJECT[i % OBJECT.length]));
  }

  body(name: string): string {
    return this.byBody.get(name) ?? (/(^|_)(left|l)(_|$)/.test(name) ? LEFT : /(^|_)(right|r)(_|$)/.test(name) ? RIGHT : "#8f6bc7");
  }

  /** Colour of what an interface belongs to; of a robot's, its side. */
  interface(index: number): string {
    const { name, body, on } = this.plan.raw.interfaces[index];
    return this.body(on === "joint" ? name : body);
  }
}

function named(name: string): string | undefined {
  const word = name.split("_").find((part) => part in NAMED);
  return word && NAMED[word];
}
