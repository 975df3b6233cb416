// The tree as rows that open and close, with a filter.

import { el, percent, short } from "../dom";
import { plain } from "./plain";
import { STAGES, type Search, type Stage } from "./data";

/** More rows than this are not made at once. */
const MOST_ROWS = 1500;

export class TreeView {
  readonly root: HTMLElement;
  private readonly rows = el("div", { class: "rows", role: "tree", "aria-label": "Contact sequences that were looked at" });
  private readonly query: HTMLInputElement;
  private readonly stage: HTMLSelectElement;
  private readonly count = el("small", { class: "count" });
  private readonly open = new Set<string>();
  private search!: Search;
  private selected = -1;

  constructor(private readonly onSelect: (node: number) => void) {
    this.query = el("input", { type: "search", placeholder: "Find contact, action or reason", "aria-label": "Find", input: () => this.draw() });
    const options = Object.entries(STAGES).map(([stage, { name }]) => el("option", { value: stage }, name));
    this.stage = el("select", { "aria-label": "Only what got to", change: () => this.draw() }, el("option", { value: "" }, "all"), ...options);
    const all = el("button", { click: () => { this.search.nodes.forEach((_, i) => this.open.add(this.key(i))); this.draw(); } }, "Open all");
    const none = el("button", { click: () => { this.open.clear(); this.draw(); } }, "Close all");
    this.root = el("div", { class: "tree" }, el("div", { class: "filter" }, this.query, this.stage, all, none, this.count), this.rows);
    this.rows.addEventListener("keydown", (event) => this.key_pressed(event));
  }

  /** Shows a search; what was open stays open. */
  set(search: Search): void {
    const first = this.search === undefined;
    this.search = search;
    if (first) this.reveal(search.best?.node ?? this.busiest());
    this.draw();
  }

  /** Finds a text; used by the histogram. */
  find(text: string, stage: Stage | ""): void {
    this.query.value = text;
    this.stage.value = stage;
    this.draw();
  }

  select(node: number): void {
    this.selected = node;
    this.reveal(node);
    this.draw();
    this.rows.querySelector(`[data-node="${node}"]`)?.scrollIntoView({ block: "nearest" });
  }

  /** The same node keeps its key when the search goes on: its path of changes. */
  private key(node: number): string { return this.search.path(node).map((i) => this.search.change(i)).join("|"); }

  private reveal(node: number): void {
    if (node >= 0) this.search.path(node).forEach((i) => this.open.add(this.key(i)));
  }

  /** The end of the path with the most sequences through it. */
  private busiest(): number {
    let at = this.search.roots[0] ?? -1;
    while (at >= 0 && this.search.children[at].length > 0) {
      at = this.search.children[at].reduce((x, y) => (this.search.nodes[y].sequences > this.search.nodes[x].sequences ? y : x));
    }
    return at;
  }

  private matches(node: number): boolean {
    const { label, reason, reached } = this.search.nodes[node];
    if (this.stage.value && this.stage.value !== reached) return false;
    const words = this.query.value.toLowerCase().split(/\s+/).filter(Boolean);
    const text = `${this.search.change(node)} ${label} ${reason ? `${plain(reason)} ${reason.replaceAll("_", " ")}` : ""}`.toLowerCase();
    return words.every((word) => text.includes(word));
  }

  private draw(): void {
    const filtering = this.query.value.trim() !== "" || this.stage.value !== "";
    const shown = new Set<number>();
    let found = 0;
    if (filtering) {
      this.search.nodes.forEach((_, i) => {
        if (!this.matches(i)) return;
        found += 1;
        this.search.path(i).forEach((at) => shown.add(at));
      });
    }
    const rows: HTMLElement[] = [];
    const add = (node: number, depth: number) => {
      if (rows.length >= MOST_ROWS || (filtering && !shown.has(node))) return;
      const isOpen = filtering || this.open.has(this.key(node));
      rows.push(this.row(node, depth, isOpen, filtering && this.matches(node)));
      if (isOpen) this.byPromise(this.search.children[node]).forEach((child) => add(child, depth + 1));
    };
    this.search.roots.forEach((root) => add(root, 0));
    this.rows.replaceChildren(...rows);
    const total = this.search.nodes.length;
    this.count.textContent = filtering ? `${found} of ${total} nodes` : `${total} nodes${rows.length >= MOST_ROWS ? `, the first ${MOST_ROWS} shown` : ""}`;
  }

  private byPromise(nodes: number[]): number[] {
    const { nodes: all } = this.search;
    return [...nodes].sort((x, y) => all[y].best - all[x].best || all[y].sequences - all[x].sequences || x - y);
  }

  private row(node: number, depth: number, isOpen: boolean, found: boolean): HTMLElement {
    const { reached, sequences, best, visits, value, cost, reason, label, parent } = this.search.nodes[node];
    const children = this.search.children[node].length;
    const sequence = this.search.sequenceOf.get(node);
    const toggle = el("span", { class: "twist", click: (event: MouseEvent) => { event.stopPropagation(); this.toggle(node); } }, children > 0 ? (isOpen ? "▾" : "▸") : "");
    return el("div", {
      class: `row ${reached}${node === this.selected ? " selected" : ""}${found ? " found" : ""}`, role: "treeitem", tabindex: 0, "data-node": node,
      "aria-expanded": children > 0 ? String(isOpen) : undefined, "aria-selected": String(node === this.selected), style: `--depth:${depth}`,
      title: `${STAGES[reached].text}${reason ? `\n${reason}` : ""}`, click: () => this.onSelect(node), dblclick: () => this.toggle(node),
    }, toggle, el("i", { class: "state" }), el("span", { class: "change" }, label && parent !== null ? el("b", {}, `${label}: `) : null, this.search.change(node)),
    el("span", { class: "reason" }, reached === "feasible" || !reason ? "" : plain(reason)),
    el("span", { class: "meta" }, sequence ? `#${sequence.number}` : children > 0 ? `${sequences} tried` : ""),
    el("span", { class: "meta visits", title: "visits of the tree search × their mean reward" }, visits !== undefined ? `${visits} × ${percent(value ?? 0)}` : ""),
    el("span", { class: "worth", title: `largest reward ${percent(best)}` }, el("i", { style: `width:${100 * best}%` })),
    el("span", { class: "meta" }, cost !== undefined ? `cost ${short(cost)}` : ""));
  }

  private toggle(node: number): void {
    const key = this.key(node);
    if (!this.open.delete(key)) this.open.add(key);
    this.draw();
  }

  private key_pressed(event: KeyboardEvent): void {
    const row = (event.target as HTMLElement).closest<HTMLElement>("[data-node]");
    if (!row) return;
    const node = Number(row.dataset.node);
    const isOpen = row.getAttribute("aria-expanded");
    const step = event.key === "ArrowDown" ? row.nextElementSibling : event.key === "ArrowUp" ? row.previousElementSibling : null;
    if (step instanceof HTMLElement) step.focus();
    else if (event.key === "Enter") this.onSelect(node);
    else if ((event.key === "ArrowRight" && isOpen === "false") || (event.key === "ArrowLeft" && isOpen === "true")) {
      this.toggle(node);
      this.rows.querySelector<HTMLElement>(`[data-node="${node}"]`)?.focus();
    } else return;
    event.preventDefault();
  }
}
