// The data of the page of a search, as crates/view writes it (search/mod.rs).

import { decodeMeshes, Plan, type Mesh, type RawPlan } from "../data";
import { plain } from "./plain";

export type Stage = "open" | "refused" | "keyframes" | "alike" | "optimised" | "feasible";

export interface Node {
  parent: number | null;
  label: string;
  gained: string[];
  lost: string[];
  /** Complete sequences through it, and the greatest reward of them. */
  sequences: number;
  best: number;
  /** How often the tree search went through it, and the mean reward of that; unknown outside its tree. */
  visits?: number;
  value?: number;
  reached: Stage;
  reason?: string;
  cost?: number;
  seconds: number;
}

/** As it is in the file: reasons by their index, what is empty or zero left out. */
type RawNode = Partial<Omit<Node, "reason">> & Pick<Node, "parent" | "best" | "reached" | "seconds"> & { reason?: number };

export interface Sequence {
  number: number;
  node: number;
  at: number;
  reached: Stage;
  reason: string | null;
  cost: number | null;
  violation: number | null;
  /** Phase in which the motion failed, from 0. */
  failed_phase: number | null;
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
  /** Contacts of the goal. */
  goal: string[];
  nodes: RawNode[];
  reasons: string[];
  sequences: Sequence[];
  refused: { contacts: string[]; reason: string }[];
  asked: [[number, number], [number, number]];
  meshes?: Mesh[];
  plans: RawPlan[];
}

/** What a node or sequence got to, for people. */
export const STAGES: Record<Stage, { name: string; text: string }> = {
  feasible: { name: "solved", text: "a motion was found" },
  optimised: { name: "no motion", text: "keyframes exist, the full optimisation found no motion" },
  keyframes: { name: "no keyframes", text: "no configurations satisfy the whole sequence" },
  alike: { name: "left out", text: "sequences that failed had the same contacts" },
  refused: { name: "refused", text: "no configurations satisfy this beginning" },
  open: { name: "open", text: "looked at on the way, not tried to the end" },
};

/** A search, checked and indexed. */
export class Search {
  readonly nodes: Node[];
  readonly children: number[][];
  readonly roots: number[] = [];
  readonly sequenceOf = new Map<number, Sequence>();
  readonly plans: Plan[];

  constructor(readonly raw: RawSearch) {
    for (const key of ["nodes", "reasons", "sequences", "refused", "asked", "plans"] as const) {
      if (!Array.isArray(raw[key])) throw new Error(`the search's list "${key}" is missing`);
    }
    this.nodes = raw.nodes.map((node) => ({
      label: "", gained: [], lost: [], sequences: 0, ...node, reason: node.reason === undefined ? undefined : raw.reasons[node.reason],
    }));
    this.children = raw.nodes.map(() => []);
    this.nodes.forEach((node, i) => {
      if (node.parent === null) this.roots.push(i);
      else if (node.parent < i) this.children[node.parent].push(i);
      else throw new Error(`node ${i} comes before its parent ${node.parent}`);
    });
    for (const sequence of raw.sequences) {
      const known = this.sequenceOf.get(sequence.node);
      if (!known || sequence.reached === "feasible") this.sequenceOf.set(sequence.node, sequence);
    }
    const surfaces = decodeMeshes(raw.meshes);
    this.plans = raw.plans.map((plan) => new Plan(plan, surfaces));
  }

  /** From the root to a node. */
  path(node: number): number[] {
    const path = [];
    for (let at: number | null = node; at !== null; at = this.nodes[at].parent) path.unshift(at);
    return path;
  }

  /** What changes on entering a node, in one line. */
  change(node: number): string {
    const { gained, lost, parent, label } = this.nodes[node];
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
    for (const node of this.nodes) if (node.reached === "refused") add("beginning", node.reason || "no configuration");
    for (const sequence of this.raw.sequences) if (sequence.reached !== "feasible") add(STAGES[sequence.reached].name, sequence.reason || "no reason given");
    return [...counts].map(([kind, rest]) => ({ kind, ...rest })).sort((x, y) => y.count - x.count);
  }
}

/** A reason without amounts and phases: what comes before the subject, and the subject. */
export function kindOf(reason: string): string {
  const alike = /^sequences .* have no motion at the contacts of phase \d+ \((.*)\)$/.exec(reason);
  if (alike) return `others failed at ${alike[1]}`;
  const first = reason.split(/[;\n]/)[0].replace(/,?\s*(in|at|of)? phase \d+.*$/, "");
  const amount = /(,| by| stay| would slip) [\d.]+(e[+-]?\d+)? ?(mm|cm|m|N m|N|kg|s|%|°)?( apart| tilted| over the edge| too close| off)?(?=$|[ ,])/g;
  return first.replace(amount, "").replace(/: [\d.]+(e[+-]?\d+)? ?\S* (missing|off)/, ": $2").trim();
}
