// The page of a search in a real browser, from a small journal written here and a solution of the built command.
import assert from "node:assert/strict";
import { execFileSync, spawn } from "node:child_process";
import { appendFileSync, cpSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { after, before, test } from "node:test";
import { launch, open, settle } from "./browser.mjs";

const repository = resolve(new URL(".", import.meta.url).pathname, "../..");
const command = process.env.LOCOTAMP ?? join(repository, "target/release/locotamp");
const folder = mkdtempSync(join(tmpdir(), "locotamp-search-"));
const run = join(folder, "run");
let browser;

const feet = ["left_foot on ground_top", "right_foot on ground_top"];
const sequence = (number, reached, states, more) => ({ kind: "sequence", number, at: 2 * number, labels: states.map((_, i) => `step_${i}`), states, reached, iterations: 9, seconds: 1.5, reward: 0, ...more });
const reason = "contact distance of left_hand on box_left: 3.09e-2 m off, in phase 2";
const LINES = [
  { kind: "run", format: "locotamp.journal/1", scene: "lift-box", search: "tree", seed: 4, fingerprint: "0", max_phases: 9 },
  { kind: "state", states: [["left_foot on box_left"]], possible: false, reason: "contact bounds of left_foot on box_left: 1.7e-3 m off", seconds: 0.1 },
  { kind: "prefix", states: [feet, feet.slice(0, 1)], possible: false, reason: "clearance of box and leg: 2e-2 m off", seconds: 0.1 },
  sequence(1, "keyframes", [feet, [...feet, "left_hand on box_left"]], { reason }),
  sequence(2, "feasible", [feet, [...feet, "left_hand on box_left", "right_hand on box_right"], [...feet, "right_hand on box_right"]], { cost: 4.5, violation: 1e-9, reward: 0.8, visits: [7, 3], values: [0.1875, 0.4] }),
];

before(async () => {
  mkdirSync(join(run, "plans"), { recursive: true });
  writeFileSync(join(run, "journal.jsonl"), LINES.map((line) => `${JSON.stringify(line)}\n`).join(""));
  execFileSync(command, ["plan", "crates/scene/tests/scenes/hopper.toml", "-q", "--out", join(folder, "hopper")], { cwd: repository, stdio: "ignore" });
  cpSync(join(folder, "hopper/plan.json"), join(run, "plans/0002.json"));
  execFileSync(command, ["view", run, "--out", join(folder, "search.html")]);
  browser = await launch();
});

after(async () => {
  await browser?.close();
  rmSync(folder, { recursive: true });
});

const rows = (page) => page.$$eval(".row", (rows) => rows.map((row) => row.textContent));

test("the tree says what was tried, how far it got and why not further", async () => {
  const page = await open(browser, join(folder, "search.html"));
  await settle(page);
  const panel = await page.$eval(".panel", (panel) => panel.textContent);
  assert.match(panel, /^solved/, "the best solution is selected");
  assert.match(panel, /Solved1, best cost 4\.5/);
  assert.match(panel, /contacts: no room: left foot on box left1/, "reasons are counted");
  const [found] = (await rows(page)).filter((row) => row.includes("stay 3.1 cm apart"));
  assert.match(found, /step 1: \+ left hand on box leftout of reach: left hand on box left stay 3\.1 cm apart, in phase 2#1/);
  assert.ok((await rows(page)).some((row) => /− right foot on ground top.*collision: box and leg, 2 cm too close/.test(row)));
  await page.type("input[type=search]", "apart");
  assert.equal((await rows(page)).length, 2, "the match and what leads to it");
  await page.$eval("input[type=search]", (input) => { input.value = ""; input.dispatchEvent(new Event("input")); });
  await page.select(".filter select", "refused");
  assert.match(await page.$eval(".count", (count) => count.textContent), /^1 of 5 nodes$/);
  await page.click(".row.refused");
  assert.match(await page.$eval(".detail", (detail) => detail.textContent), /refused.*clearance of box and leg: 2e-2 m off/);
  assert.deepEqual([page.faults, page.requests], [[], []]);
  await page.close();
});

test("a search without a plan says first which goal was not reached and where motions fail", async () => {
  const goal = "box_bottom on shelf_top";
  const hold = "left_hand holds box_left";
  const lifted = [feet, [...feet, hold], [...feet.slice(1), hold]];
  const failed = { failed_phase: 2, violation: 0.3, reason: "equations of motion of base: 4.5e1 N m off, in phase 3; what limits it most is more" };
  const lines = [
    { ...LINES[0], goal: [goal] },
    { kind: "state", states: [[...feet.slice(0, 1), hold, goal]], possible: false, reason: "contact bounds of left_hand on box_left: 1.95 m off", seconds: 0.1 },
    sequence(1, "optimised", lifted, failed),
    sequence(2, "optimised", [feet, ...lifted.slice(1), [hold]], { ...failed, violation: 0.1 }),
    sequence(3, "alike", [feet, [feet[0], hold]], { reason: "sequences 1, 2 have no motion at the contacts of phase 2 (step_1)" }),
  ];
  const lost = join(folder, "lost");
  mkdirSync(lost);
  writeFileSync(join(lost, "journal.jsonl"), lines.map((line) => `${JSON.stringify(line)}\n`).join(""));
  execFileSync(command, ["view", lost, "--out", join(folder, "lost.html")]);
  const page = await open(browser, join(folder, "lost.html"));
  const panel = await page.$eval(".panel", (panel) => panel.textContent);
  assert.match(panel, /^✕No plan3 sequences tried, 2 as far as the full optimisation/);
  const found = await page.$$eval(".finding", (findings) => findings.map((finding) => finding.textContent));
  assert.equal(found.length, 2);
  assert.match(found[0], /^The goal “box bottom on shelf top” was never reached1 sets? of contacts refused, such as .*: out of reach: left hand on box left stay 1\.9 m apart/);
  assert.match(found[1], /^All of 2 motions fail at “step 2”; all fail with left hand holds box leftnearest to a plan is sequence 2: forces cannot carry the motion: 45 N m missing at base, in phase 3$/);
  assert.match(panel, /left out: others failed at step 11/);
  await page.click(".finding:nth-of-type(2), .finding ~ .finding");
  assert.ok((await rows(page)).length > 0, "a click looks for it in the tree");
  assert.deepEqual([page.faults, page.requests], [[], []]);
  await page.close();
});

test("nodes of the search's tree show visits and value, others none", async () => {
  const page = await open(browser, join(folder, "search.html"));
  await settle(page);
  assert.deepEqual(await page.$$eval(".row .visits", (cells) => cells.map((cell) => cell.textContent).filter(Boolean)), ["7 × 19 %", "3 × 40 %"]);
  const detail = () => page.$eval(".detail", (detail) => detail.textContent);
  assert.doesNotMatch(await detail(), /Visits/, "a state that only the walk behind the tree came to");
  await page.click(".row");
  assert.match(await detail(), /Sequences through it2.*Largest reward80 %.*Visits of the search7Value, their mean reward19 %/);
  await page.close();
});

test("the motion of a solved node plays, and one comes back", async () => {
  const page = await open(browser, join(folder, "search.html"));
  await page.click(".show");
  await page.keyboard.press("Space");
  await page.waitForFunction(() => window.locotamp.player.time > 0.02);
  await page.keyboard.press("Escape");
  assert.equal(await page.evaluate(() => window.locotamp.player.playing), false);
  assert.equal((await rows(page)).length > 0 && (await page.$eval("#motion", (motion) => motion.hidden)), true);
  await page.keyboard.press("Space");
  assert.equal(await page.evaluate(() => window.locotamp.player.playing), false, "keys of a hidden motion do nothing");
  assert.deepEqual([page.faults, page.requests], [[], []]);
  await page.close();
});

test("locotamp watch serves the page, which follows the search", async () => {
  const server = spawn(command, ["watch", run], { stdio: ["ignore", "pipe", "inherit"] });
  try {
    const url = await new Promise((done) => server.stdout.once("data", (text) => done(String(text).trim())));
    assert.match(url, /^http:\/\/127\.0\.0\.1:\d+$/);
    const page = await browser.newPage();
    const others = [];
    page.on("request", (request) => { if (!request.url().startsWith(url) && !request.url().startsWith("data:")) others.push(request.url()); });
    await page.goto(url);
    assert.match(await page.$eval(".run", (run) => run.textContent), /lift-box.*live$/);
    const more = sequence(3, "optimised", [feet, [...feet, "right_hand on box_right"]], { reason: "friction cone of right_hand on box_right: 12 N off" });
    appendFileSync(join(run, "journal.jsonl"), `${JSON.stringify(more)}\n`);
    await page.waitForFunction(() => window.locotampSearch.search.raw.sequences.length === 3, { timeout: 10000 });
    assert.match(await page.$eval(".panel", (panel) => panel.textContent), /no motion: would slide, not enough friction: right hand on box right1/);
    assert.deepEqual(others, []);
    await page.close();
  } finally {
    server.kill();
  }
});

test("a folder without a journal and a broken journal are refused with their place", () => {
  const refused = (path) => {
    try {
      execFileSync(command, ["view", path, "--out", join(folder, "none.html")], { stdio: "pipe" });
    } catch (error) {
      assert.equal(error.status, 2);
      return String(error.stderr);
    }
    return assert.fail("it was not refused");
  };
  assert.match(refused(folder), /there is no journal\.jsonl; is it the folder of a run/);
  const broken = join(folder, "broken");
  mkdirSync(broken);
  writeFileSync(join(broken, "journal.jsonl"), `${readFileSync(join(run, "journal.jsonl"), "utf8").split("\n")[0]}\nnonsense\n`);
  assert.match(refused(broken), /journal\.jsonl: line 2 is no line of a journal/);
});
