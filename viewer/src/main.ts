// Starts the page, or says in plain words why it cannot.

import { App } from "./app";
import { readPage } from "./data";
import { el } from "./dom";
import { Search } from "./search/data";
import { SearchApp } from "./search/search_app";

declare global {
  interface Window { locotamp?: App; locotampSearch?: SearchApp }
}

const root = document.getElementById("app")!;
try {
  const text = document.getElementById("data")?.textContent ?? "";
  // The names are for the browser's console, and for the tests.
  if (/^\s*\{\s*"format"\s*:\s*"locotamp\.search-page\/1"/.test(text)) window.locotampSearch = new SearchApp(new Search(JSON.parse(text)), root);
  else window.locotamp = new App(readPage(text), root);
} catch (error) {
  root.replaceChildren(el("div", { class: "failure", role: "alert" }, el("h1", {}, "This page cannot be shown"),
    el("p", {}, (error as Error).message), el("p", {}, "Write it again with ", el("code", {}, "locotamp view PLAN --out FILE"), ".")));
}
