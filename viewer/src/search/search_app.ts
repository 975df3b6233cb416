// The page of a search: tree at the left, what is selected and the whole at the right; solved sequences play.

import { App } from "../app";
import { el, percent, short } from "../dom";
import { progressChart, reasonBars } from "./charts";
import { Search, STAGES } from "./data";
import { findings } from "./failure";
import { plain } from "./plain";
import { TreeView } from "./tree_view";

/** A page that is served asks for news so often [ms]. */
const POLL = 2000;

export class SearchApp {
  readonly tree: TreeView;
  private readonly root = el("div", { class: "search-page" });
  private readonly motion = el("div", { id: "motion", hidden: true });
  private readonly overview = el("section");
  private readonly detail = el("section", { class: "detail" });
  private readonly title = el("div", { class: "run" });
  private plansShown = "";
  private app?: App;
  private selected = -1;

  constructor(public search: Search, parent: HTMLElement) {
    const dark = window.matchMedia("(prefers-color-scheme: dark)");
    document.documentElement.dataset.theme = dark.matches ? "dark" : "light";
    const theme = el("button", { class: "icon", title: "Light or dark (T)", "aria-label": "Light or dark", click: () => this.theme() }, "◐");
    this.tree = new TreeView((node) => this.select(node));
    this.root.append(el("header", {}, el("span", { class: "brand" }, "locotamp"), this.title, el("span", { class: "space" }), theme),
      this.tree.root, el("aside", { class: "panel" }, this.detail, this.overview));
    parent.replaceChildren(this.root, this.motion);
    parent.classList.add("searching");
    document.addEventListener("keydown", (event) => {
      if (event.key === "Escape" && !this.motion.hidden) this.back();
      if (event.key === "t" && this.motion.hidden && (event.target as HTMLElement).tagName !== "INPUT") this.theme();
    });
    this.show(search);
    this.select(search.best?.node ?? -1);
    if (search.raw.live) window.setTimeout(() => this.poll(), POLL);
  }

  private theme(): void {
    const { dataset } = document.documentElement;
    dataset.theme = dataset.theme === "dark" ? "light" : "dark";
    this.show(this.search);
  }

  /** Shows the present state of the search. */
  private show(search: Search): void {
    this.search = search;
    const { raw } = search;
    document.title = `${raw.scene} – search – locotamp`;
    this.title.replaceChildren(el("b", {}, raw.scene), ` ${raw.search} search, seed ${raw.seed}, at most ${raw.max_phases} phases`, raw.live ? el("span", { class: "live" }, "live") : "");
    this.tree.set(search);
    const reached = (stage: string) => raw.sequences.filter((x) => x.reached === stage).length;
    const [[states, noState], [beginnings, noBeginning]] = raw.asked;
    const last = raw.sequences.reduce((x, y) => Math.max(x, y.at), 0);
    const best = search.best;
    const facts: [string, string][] = [
      ["Solved", best ? `${reached("feasible")}, best cost ${short(best.cost ?? NaN, 4)}` : "nothing yet"],
      ["First solution", first(search)],
      ["Sequences tried", raw.sequences.length > 0 ? `${raw.sequences.length} in ${short(last)} s` : "none to its end"],
      ["… no keyframes", String(reached("keyframes"))],
      ["… left out", String(reached("alike"))],
      ["… no motion", String(reached("optimised"))],
      ["Contacts asked", `${states}, ${noState} refused`],
      ["Beginnings asked", `${beginnings}, ${noBeginning} refused`],
    ];
    this.overview.replaceChildren(
      best ? "" : this.failure(search),
      el("h3", {}, "The search"), el("dl", { class: "facts" }, ...facts.flatMap(([name, value]) => [el("dt", {}, name), el("dd", {}, value)])),
      ...(raw.sequences.length > 0 ? [el("h3", {}, best ? "Cost of solutions over time" : "Sequences over time"), progressChart(search, 340, (node) => this.select(node))] : []),
      el("h3", {}, best ? "Why the rest failed" : "Why beginnings and sequences failed"), reasonBars(search, (text) => this.tree.find(text, "")),
    );
  }

  /** That there is no plan, and what is known of why. */
  private failure(search: Search): HTMLElement {
    const { length } = search.raw.sequences;
    const optimised = search.raw.sequences.filter((x) => x.reached === "optimised").length;
    const tried = length === 0 ? "no sequence was tried to its end" : `${length} sequence${length > 1 ? "s" : ""} tried, ${optimised} as far as the full optimisation`;
    return el("div", { class: "nothing" },
      el("div", { class: "verdict bad" }, el("span", { class: "mark" }, "✕"), el("div", {}, el("b", {}, search.raw.live ? "No plan yet" : "No plan"), el("small", {}, tried))),
      ...findings(search).map(({ text, detail, find }) => el("button", { class: "finding", title: "Show in the tree", click: () => this.tree.find(find, "") }, el("b", {}, text), el("small", {}, detail))));
  }

  private select(node: number): void {
    this.selected = node;
    if (node < 0) {
      this.detail.replaceChildren(el("small", {}, "Choose a row of the tree to see how far it got and why not further."));
      // What is known of the whole stands first then.
      this.overview.after(this.detail);
      return;
    }
    this.overview.before(this.detail);
    this.tree.select(node);
    const { nodes } = this.search;
    const at = nodes[node];
    const sequence = this.search.sequenceOf.get(node);
    const path = this.search.path(node);
    const play = sequence && sequence.plan !== null ? el("button", { class: "show", click: () => this.play(sequence.plan!) }, "▶ Show the motion") : null;
    const facts: [string, string][] = sequence
      ? [["Sequence", `${sequence.number}, at ${short(sequence.at)} s`], ["Reward", percent(sequence.reward)], ["Iterations", `${sequence.iterations} in ${short(sequence.seconds)} s`]]
      : [["Sequences through it", String(at.sequences)], ["Largest reward", percent(at.best)], ["Time", `${short(at.seconds)} s`]];
    if (at.visits !== undefined) facts.push(["Visits of the search", String(at.visits)], ["Value, their mean reward", percent(at.value ?? 0)]);
    if (sequence && sequence.cost !== null) facts.push(["Cost", short(sequence.cost, 4)]);
    if (sequence && sequence.violation !== null) facts.push(["Violation", short(sequence.violation, 2)]);
    const reason = sequence?.reason ?? at.reason;
    this.detail.replaceChildren(
      el("div", { class: `verdict ${at.reached === "feasible" ? "good" : at.reached === "open" ? "" : "bad"}` }, el("div", {}, el("b", {}, STAGES[at.reached].name), el("small", {}, STAGES[at.reached].text))),
      play ?? "", reason && at.reached !== "feasible" ? el("p", { class: "reason" }, plain(reason), el("small", {}, reason.replaceAll("_", " "))) : "",
      el("dl", { class: "facts" }, ...facts.flatMap(([name, value]) => [el("dt", {}, name), el("dd", {}, value)])),
      el("h3", {}, `Its ${path.length} phases`),
      el("ol", { class: "path" }, ...path.map((i) => el("li", { class: i === node ? "here" : "" }, nodes[i].label && i !== path[0] ? el("b", {}, `${nodes[i].label}: `) : null, this.search.change(i)))),
    );
  }

  private play(index: number): void {
    const names = this.search.raw.plans.map((plan) => `${plan.name}/${this.search.raw.revision}`).join();
    this.motion.hidden = false;
    this.root.hidden = true;
    if (!this.app || this.plansShown !== names) {
      this.app?.player.pause();
      this.app = new App(this.search.plans, this.motion, () => this.back());
      this.plansShown = names;
      window.locotamp = this.app;
    }
    this.app.select(index);
  }

  private back(): void {
    this.app?.player.pause();
    this.motion.hidden = true;
    this.root.hidden = false;
  }

  /** Asks the server whether the run has gone on. */
  private async poll(): Promise<void> {
    try {
      const answer = await fetch(`data.json?revision=${this.search.raw.revision}`);
      if (answer.status === 200) {
        const key = this.selected >= 0 ? this.search.path(this.selected).map((i) => this.search.change(i)).join("|") : "";
        const next = new Search(await answer.json());
        this.show(next);
        const again = next.nodes.findIndex((_, i) => next.path(i).map((at) => next.change(at)).join("|") === key);
        this.select(again >= 0 ? again : next.best?.node ?? -1);
      }
      window.setTimeout(() => this.poll(), POLL);
    } catch {
      this.title.querySelector(".live")?.replaceWith(el("span", { class: "live over" }, "ended"));
    }
  }
}

function first(search: Search): string {
  const times = search.raw.sequences.filter((x) => x.reached === "feasible").map((x) => x.at);
  return times.length > 0 ? `after ${short(Math.min(...times))} s` : "–";
}
