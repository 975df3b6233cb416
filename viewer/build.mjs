// Builds dist/page.html: one file with style and script inside and a place for the data, which crates/view fills.
// The same sources and versions give the same bytes.
import { build } from "esbuild";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";

const bundle = await build({
  entryPoints: ["src/main.ts", "src/style.css"],
  outdir: "unused",
  write: false,
  bundle: true,
  minify: true,
  format: "iife",
  target: ["chrome111", "firefox113"],
  legalComments: "inline",
  charset: "utf8",
  logLevel: "warning",
});
const text = (end) => bundle.outputFiles.find((file) => file.path.endsWith(end)).text.trim();

const template = readFileSync("page.html", "utf8");
const page = template
  .replace("/*STYLE*/", () => text(".css"))
  .replace("/*SCRIPT*/", () => text(".js").replaceAll("</script", "<\\/script"));
if (page.split("__LOCOTAMP_DATA__").length !== 2) throw new Error("the page needs exactly one place for the data");
mkdirSync("dist", { recursive: true });
writeFileSync("dist/page.html", page);
console.log(`dist/page.html: ${(page.length / 1024).toFixed(0)} kB`);
