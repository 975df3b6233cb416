// Why a search has no plan (yet), in a few sentences: what was never possible, and where motions fail.

import type { Search, Sequence } from "./data";
import { plain } from "./plain";

/** A sentence and what explains it; `find` is what to look for in the tree. */
export interface Finding { text: string; detail: string; find: string }

const MOST = 4;
/** Share of the motions that fail from which a contact that they have is told. */
const USUAL = 0.7;

/** What a reader should know first; empty where there is nothing to tell. */
export function findings(search: Search): Finding[] {
  const states = contactsOf(search);
  const found = [...goals(search, states), ...whereMotionsFail(search, states)];
  return found.length > 0 ? found.slice(0, MOST) : neverPossible(search, states);
}

/** The contacts of every node. */
function contactsOf(search: Search): Set<string>[] {
  const states: Set<string>[] = [];
  search.nodes.forEach(({ parent, gained, lost }, i) => {
    const state = new Set(parent === null ? [] : states[parent]);
    lost.forEach((contact) => state.delete(contact));
    gained.forEach((contact) => state.add(contact));
    states[i] = state;
  });
  return states;
}

const spaced = (contact: string) => contact.replaceAll("_", " ");

/** Contacts of the goal that were found with no others, or not with some. */
function goals(search: Search, states: Set<string>[]): Finding[] {
  const possible = states.filter((_, i) => search.nodes[i].reached !== "refused");
  return search.raw.goal.flatMap((goal) => {
    const refused = search.raw.refused.filter(({ contacts }) => contacts.some((contact) => spaced(contact) === goal));
    if (refused.length === 0) return [];
    const others = [...new Set(refused.flatMap(({ contacts }) => contacts.map(spaced)))].filter((contact) => contact !== goal);
    const never = others.filter((contact) => !possible.some((state) => state.has(goal) && state.has(contact)));
    const isPossible = possible.some((state) => state.has(goal));
    if (isPossible && never.length === 0) return [];
    const examples = refused.filter(({ contacts }) => !isPossible || contacts.some((contact) => never.includes(spaced(contact))));
    return [{
      text: isPossible ? `The goal “${goal}” was never reached with ${listed(never)}` : `The goal “${goal}” was never reached`,
      detail: `${examples.length} set${examples.length > 1 ? "s" : ""} of contacts refused, such as ${examples[0].contacts.map(spaced).join(", ")}: ${plain(examples[0].reason)}`,
      find: goal,
    }];
  });
}

function listed(contacts: string[]): string {
  const more = contacts.length - 3;
  return contacts.slice(0, 3).join(", ") + (more > 0 ? ` or ${more} other contact${more > 1 ? "s" : ""}` : "");
}

/** The contact that was refused most often and was possible nowhere. */
function neverPossible(search: Search, states: Set<string>[]): Finding[] {
  const possible = new Set(states.flatMap((state, i) => (search.nodes[i].reached === "refused" ? [] : [...state])));
  const never = new Map<string, { count: number; reason: string }>();
  const note = (contact: string, reason: string) => {
    if (possible.has(contact)) return;
    const known = never.get(contact);
    if (known) known.count += 1; else never.set(contact, { count: 1, reason });
  };
  for (const { contacts, reason } of search.raw.refused) contacts.forEach((contact) => note(spaced(contact), reason));
  for (const node of search.nodes) if (node.reached === "refused") node.gained.forEach((contact) => note(contact, node.reason ?? ""));
  const [most] = [...never].sort(([, x], [, y]) => y.count - x.count);
  return most ? [{ text: `No configuration was found with ${most[0]}`, detail: `refused ${most[1].count} times: ${plain(most[1].reason)}`, find: most[0] }] : [];
}

/** The phase in which most motions fail, and what most of these hold or stand on that they did not at the start. */
function whereMotionsFail(search: Search, states: Set<string>[]): Finding[] {
  const failed = search.raw.sequences.filter((x) => x.reached === "optimised" && x.failed_phase !== null);
  if (failed.length === 0) return [];
  const nodes = failed.map((sequence) => failedNode(search, sequence));
  const counted = (texts: string[]) => {
    const counts = new Map<string, number>();
    texts.forEach((text) => counts.set(text, (counts.get(text) ?? 0) + 1));
    return [...counts].sort((x, y) => y[1] - x[1]);
  };
  const [label, count] = counted(nodes.map((node) => search.nodes[node].label || search.change(node)))[0];
  const start = states[search.path(failed[0].node)[0]];
  const [added] = counted(nodes.flatMap((node) => [...states[node]].filter((contact) => !start.has(contact))));
  const isUsual = added !== undefined && failed.length > 1 && added[1] >= USUAL * failed.length;
  const least = failed.reduce((x, y) => ((y.violation ?? Infinity) < (x.violation ?? Infinity) ? y : x));
  const where = failed.length === 1 ? "The only motion that was optimised fails" : `${count === failed.length ? "All" : count} of ${failed.length} motions fail`;
  const holding = isUsual ? `; ${added[1] === failed.length ? "all" : added[1]} fail with ${added[0]}` : "";
  return [{
    text: `${where} at “${label}”${holding}`,
    detail: `nearest to a plan is sequence ${least.number}: ${plain((least.reason ?? "").split(";")[0])}`,
    find: label,
  }];
}

function failedNode(search: Search, { node, failed_phase: phase }: Sequence): number {
  const path = search.path(node);
  return path[Math.min(phase ?? 0, path.length - 1)];
}
