// Starts the page, or says in plain words why it cannot.

import { App } from "./app";
import { readPage } from "./data";
import { el } from "./dom";

declare global {
  interface Window { locotamp?: App }
}

const root = document.getElementById("app")!;
try {
  const text = document.getElementById("data")?.textContent ?? "";
  const plans = readPage(text);
  // For the browser's console, and for the tests.
  window.locotamp = new App(plans, root);
} catch (error) {
  root.replaceChildren(el("div", { class: "failure", role: "alert" }, el("h1", {}, "This page cannot be shown"),
    el("p", {}, (error as Error).message), el("p", {}, "Write it again with ", el("code", {}, "locotamp view PLAN --out FILE"), ".")));
}
