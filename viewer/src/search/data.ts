// The data of the page of a search, as crates/view writes it (search/mod.rs).

import { Plan, type RawPlan } from "../data";
import { plain } from "./plain";

export type Stage = "open" | "refused" | "keyframes" | "optimised" | "feasible";

export interface Node {
  parent: number | null;
  label: string;
  gained: string[];
  lost: string[];
  visits: number;
  value: number;
  reached: Stage;
  reason?: string;
  cost?: number;
  seconds: number;
}

export interface Sequence {
  number: number;
  node: number;
  at: number;
  reached: Stage;
  reason: string | null;
  cost: number | null;
  violation: number | null;
  iterations: number;
  seconds: number;
  reward: number;
  plan: number | null;
}

interface RawSearch {
  format: string;
  revision: string;
  live: boolean;
  scene: string;
  search: string;
  seed: number;
  max_phases: number;
  nodes: Node[];
  sequences: Sequence[];
  refused: { contacts: string[]; reason: string }[];
  asked: [[number, number], [number, number]];
  plans: RawPlan[];
}

/** What a node or sequence got to, for people. */
export const STAGES: Record<Stage, { name: string; text: string }> = {
  feasible: { name: "solved", text: "a motion was found" },
  optimised: { name: "no motion", text: "keyframes exist, the full optimisation found no motion" },
  keyframes: { name: "no keyframes", text: "no configurations satisfy the whole sequence" },
  refused: { name: "refused", text: "no configurations satisfy this beginning" },
  open: { name: "open", text: "looked at on the way, not tried to the end" },
};

/** A search, checked and indexed. */
export class Search {
  readonly children: number[][];
  readonly roots: number[] = [];
  readonly sequenceOf = new Map<number, Sequence>();
  readonly plans: Plan[];

  constructor(readonly raw: RawSearch) {
    for (const key of ["nodes", "sequences", "refused", "asked", "plans"] as const) {
      if (!Array.isArray(raw[key])) throw new Error(`the search's list "${key}" is missing`);
    }
    // What is empty or zero is left out in the file.
    raw.nodes = raw.nodes.map((node) => ({ ...node, label: node.label ?? "", gained: node.gained ?? [], lost: node.lost ?? [], visits: node.visits ?? 0 }));
    this.children = raw.nodes.map(() => []);
    raw.nodes.forEach((node, i) => {
      if (node.parent === null) this.roots.push(i);
      else if (node.parent < i) this.children[node.parent].push(i);
      else throw new Error(`node ${i} comes before its parent ${node.parent}`);
    });
    for (const sequence of raw.sequences) {
      const known = this.sequenceOf.get(sequence.node);
      if (!known || sequence.reached === "feasible") this.sequenceOf.set(sequence.node, sequence);
    }
    this.plans = raw.plans.map((plan) => new Plan(plan));
  }

  /** From the root to a node. */
  path(node: number): number[] {
    const path = [];
    for (let at: number | null = node; at !== null; at = this.raw.nodes[at].parent) path.unshift(at);
    return path;
  }

  /** What changes on entering a node, in one line. */
  change(node: number): string {
    const { gained, lost, parent, label } = this.raw.nodes[node];
    if (parent === null) return label || "start";
    return [...gained.map((x) => `+ ${x}`), ...lost.map((x) => `− ${x}`)].join(", ") || label || "no change";
  }

  /** The solution to look at first: the cheapest. */
  get best(): Sequence | undefined {
    const solved = this.raw.sequences.filter((x) => x.reached === "feasible");
    return solved.sort((x, y) => (x.cost ?? Infinity) - (y.cost ?? Infinity))[0];
  }

  /** Why things failed, with how often, the most frequent first. Numbers and names are part of a reason's detail, not its kind. */
  reasons(): { kind: string; count: number; example: string }[] {
    const counts = new Map<string, { count: number; example: string }>();
    const add = (stage: string, reason: string) => {
      const kind = `${stage}: ${kindOf(plain(reason))}`;
      const known = counts.get(kind);
      if (known) known.count += 1; else counts.set(kind, { count: 1, example: reason });
    };
    for (const refused of this.raw.refused) add("contacts", refused.reason || "impossible together");
    for (const node of this.raw.nodes) if (node.reached === "refused") add("beginning", node.reason || "no configuration");
    for (const sequence of this.raw.sequences) if (sequence.reached !== "feasible") add(STAGES[sequence.reached].name, sequence.reason || "no reason given");
    return [...counts].map(([kind, rest]) => ({ kind, ...rest })).sort((x, y) => y.count - x.count);
  }
}

/** A reason without amounts and phases: what comes before the subject, and the subject. */
export function kindOf(reason: string): string {
  const first = reason.split(/[;\n]/)[0].replace(/,?\s*(in|at|of)? phase \d+.*$/, "");
  const amount = /\s*(,| by| stay| would slip)?\s*[-−]?\d+(\.\d+)?(e[+-]?\d+)?\s?(mm|cm|m|N m|N|kg|s|%|°)?( (apart|tilted|over the edge|too close|missing|off))?(?=$|[ ,])/g;
  return first.replace(amount, "").replace(/\s{2,}/g, " ").trim();
}
