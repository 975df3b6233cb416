// The pages in a real browser. LOCOTAMP names the built command, which makes plans and pages here.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, statSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { after, before, test } from "node:test";
import { firefoxLacks, launch, launchFirefox, open, picture, settle, time } from "./browser.mjs";

const repository = resolve(import.meta.dirname ?? new URL(".", import.meta.url).pathname, "../..");
const folder = mkdtempSync(join(tmpdir(), "locotamp-pages-"));
const pageFile = (name) => join(folder, `${name}.html`);
let browser;

function locotamp(...words) {
  const command = process.env.LOCOTAMP ?? join(repository, "target/release/locotamp");
  execFileSync(command, words, { cwd: repository, stdio: ["ignore", "ignore", "inherit"] });
}

before(async () => {
  const squeeze = ["scenes/sequences/boxes/squeeze.toml", "--no-refine", "--no-explain", "-q"];
  locotamp("solve", "lift-box", "--sequence", ...squeeze, "--out", join(folder, "squeeze"));
  locotamp("plan", "crates/scene/tests/scenes/hopper.toml", "-q", "--out", join(folder, "hopper"));
  const [one, other] = ["squeeze", "hopper"].map((name) => join(folder, name, "plan.json"));
  locotamp("view", one, "--out", pageFile("one"));
  locotamp("view", one, other, "--out", pageFile("two"));
  meshed(other);
  browser = await launch();
});

/** A page of the plan with a mesh on its first link: an octahedron 0.6 m wide, cut open at the top, mirrored along y. */
function meshed(file) {
  const plan = JSON.parse(readFileSync(file, "utf8"));
  const mesh = '<visual><geometry><mesh filename="package://it/octahedron.obj" scale="0.3 -0.3 0.3"/></geometry><material name="x"><color rgba="0 0.8 0.2 1"/></material></visual>';
  plan.robot.urdf = plan.robot.urdf.replace("</link>", `${mesh}</link>`);
  writeFileSync(join(folder, "meshed.json"), JSON.stringify(plan));
  const corners = ["1 0 0", "0 1 0", "-1 0 0", "0 -1 0", "0 0 1", "0 0 -1"].map((x) => `v ${x}`);
  const faces = ["1 2 5", "2 3 5", "3 4 5", "2 1 6", "3 2 6", "4 3 6", "1 4 6"].map((x) => `f ${x}`);
  writeFileSync(join(folder, "octahedron.obj"), [...corners, ...faces, ""].join("\n"));
  locotamp("view", join(folder, "meshed.json"), "--meshes", folder, "--out", pageFile("meshed"));
}

after(async () => {
  await browser?.close();
  rmSync(folder, { recursive: true });
});

/** Runs a test on a fresh page, which must stay without errors and requests. */
async function on(name, theme, body) {
  const page = await open(browser, pageFile(name), theme);
  await settle(page);
  await body(page);
  assert.deepEqual(page.faults, [], "errors on the console");
  assert.deepEqual(page.requests, [], "requests of the network");
  await page.close();
}

const cursor = (page) => page.evaluate(() => Number(document.querySelector(".cursor").dataset.x));
const angles = (page) => page.evaluate(() => window.locotamp.views[0].stage.robot.joints.map((joint) => joint.quaternion.toArray().map((x) => x.toFixed(4)).join()).join(" "));

test("the scene is drawn, in light and dark", async () => {
  const backgrounds = [];
  for (const theme of ["light", "dark"]) {
    await on("one", theme, async (page) => {
      const { drawn, background } = await picture(page);
      assert.ok(drawn > 0.05 && drawn < 0.9, `${(100 * drawn).toFixed(1)} % of the picture differ from the background`);
      backgrounds.push(background[0]);
    });
  }
  assert.ok(backgrounds[0] > 200 && backgrounds[1] < 60, `backgrounds ${backgrounds}`);
});

test("the camera looks from where the data says, the vertical up, and turns about it", () => on("one", "light", async (page) => {
  const look = () => page.evaluate(() => {
    const { stage, plan } = window.locotamp.views[0];
    const [x, y, z] = stage.camera.position.clone().sub(stage.controls.target).normalize().toArray();
    const up = stage.camera.up.clone().applyQuaternion(stage.camera.quaternion.clone().invert());
    return { azimuth: Math.atan2(y, x), elevation: Math.asin(z), side: up.x, view: plan.raw.view };
  });
  const { azimuth, elevation, side, view } = await look();
  assert.ok(Math.abs(azimuth - view[0]) < 1e-3 && Math.abs(elevation - view[1]) < 1e-3, `${azimuth}, ${elevation}, expected ${view}`);
  assert.ok(Math.abs(side) < 1e-6, "the vertical is upright in the picture");
  await page.mouse.move(400, 250);
  await page.mouse.down();
  await page.mouse.move(500, 250);
  await page.mouse.up();
  const turned = await look();
  assert.ok(turned.azimuth < azimuth - 0.1, "dragging sideways turns");
  assert.ok(Math.abs(turned.elevation - elevation) < 1e-3 && Math.abs(turned.side) < 1e-6, "about the vertical");
}));

test("playing moves time and picture, and pausing stops them", () => on("one", "light", async (page) => {
  const first = await picture(page);
  await page.click(".play");
  await page.waitForFunction(() => window.locotamp.player.time > 0.3);
  await page.click(".play");
  const [moved, stopped] = [await picture(page), await time(page)];
  assert.notEqual(moved.sum, first.sum, "the picture changes");
  await settle(page);
  assert.equal(await time(page), stopped);
  assert.equal((await picture(page)).sum, moved.sum, "a paused picture stays");
}));

test("scrubbing moves charts and robot", () => on("one", "light", async (page) => {
  const [x, pose, { sum }] = [await cursor(page), await angles(page), await picture(page)];
  await page.$eval(".scrubber", (input) => { input.value = 8000; input.dispatchEvent(new Event("input")); });
  await settle(page);
  assert.ok((await cursor(page)) > x + 300, "the cursor of the charts");
  assert.notEqual(await angles(page), pose, "the robot's joints");
  assert.notEqual((await picture(page)).sum, sum, "the picture");
  assert.match(await page.$eval(".clock", (clock) => clock.textContent), /^1\.\d\d \/ 2\.\d\d s$/);
}));

test("a click on the chart goes to that time", () => on("one", "light", async (page) => {
  const box = await (await page.$(".stack canvas")).boundingBox();
  await page.mouse.click(box.x + 0.7 * box.width, box.y + 40);
  const [there, duration] = [await time(page), await page.evaluate(() => window.locotamp.player.duration)];
  assert.ok(there > 0.5 * duration && there < 0.9 * duration, `${there} of ${duration}`);
  await page.mouse.move(box.x + 0.75 * box.width, box.y + 40);
  const tip = await page.$eval(".tip", (tip) => getComputedStyle(tip).display + tip.textContent);
  assert.match(tip, /^block.*phase 3 of 3: lift/);
  await page.mouse.move(box.x + 0.75 * box.width, box.y + box.height + 40);
  assert.match(await page.$eval(".tip", (tip) => tip.textContent), /: \d+ %/, "values with their unit");
}));

test("the cost is drawn by term over time, and its areas and ends add up to the cost", () => on("one", "light", async (page) => {
  const { area, sums, cost } = await page.evaluate(() => {
    const { raw, time, costRates } = window.locotamp.plans[0];
    let area = 0;
    for (let t = 0; t + 1 < time.length; t++) for (let i = 0; i < costRates.columns; i++) area += costRates.at(t, i) * (time[t + 1] - time[t]);
    const sum = (terms) => terms.reduce((sum, [, cost]) => sum + cost, 0);
    return { area: area + sum(raw.costs.end), sums: sum(raw.costs.terms) + sum(raw.costs.end), cost: raw.cost };
  });
  assert.ok(cost > 1 && Math.abs(sums - cost) < 1e-4 * cost, `${sums} and ${cost}`);
  assert.ok(Math.abs(area - cost) < 2e-3 * cost, `${area} and ${cost}`);
  const chart = await page.$('.stack canvas[aria-label^="Cost per second"]');
  await chart.evaluate((canvas) => canvas.scrollIntoView({ block: "center" }));
  const box = await chart.boundingBox();
  await page.mouse.move(box.x + 0.5 * box.width, box.y + 40);
  assert.match(await page.$eval(".tip", (tip) => tip.textContent), /time: 1 \/s, \d+(\.\d+)? in all/);
  const tip = await (await page.$(".tip")).boundingBox();
  assert.ok(tip.y >= 0 && tip.y + tip.height < box.y + 40 && tip.y + tip.height > box.y, "beside the pointer, however far the charts are scrolled");
  await page.mouse.click(box.x + 0.5 * box.width, box.y + 40);
  assert.ok((await time(page)) > 0.5, "a click goes to the time");
  assert.match(await page.$eval(".panel", (panel) => panel.textContent), /of which.*time \d/);
}));

test("everything can be done with keys", () => on("one", "light", async (page) => {
  const node = () => page.evaluate(() => { const app = window.locotamp; return app.plans[0].at(app.player.time); });
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("ArrowLeft");
  assert.deepEqual(await node(), { node: 1, share: 0 });
  await page.keyboard.down("Shift");
  await page.keyboard.press("ArrowRight");
  await page.keyboard.up("Shift");
  assert.equal((await node()).node, 16, "the second phase begins at node 16");
  assert.match(await page.$eval(".caption", (caption) => caption.textContent), /squeeze.*\+ left hand on box left/);
  await page.keyboard.press("End");
  assert.equal(await time(page), await page.evaluate(() => window.locotamp.player.duration));
  await page.keyboard.press("Home");
  assert.equal(await time(page), 0);
  await page.keyboard.press("-");
  await page.keyboard.press("l");
  assert.deepEqual(await page.evaluate(() => [window.locotamp.player.speed, window.locotamp.player.loop]), [0.5, false]);
  await page.keyboard.press("Space");
  await page.waitForFunction(() => window.locotamp.player.playing && window.locotamp.player.time > 0.05);
  await page.keyboard.press("Space");
  const { sum } = await picture(page);
  await page.keyboard.press("w");
  assert.notEqual((await picture(page)).sum, sum, "forces switched off");
  await page.keyboard.press("t");
  assert.equal(await page.evaluate(() => document.documentElement.dataset.theme), "dark");
  await page.keyboard.press("?");
  assert.ok(await page.$("dialog[open]"));
  await page.keyboard.press("Escape");
  assert.equal(await page.$("dialog[open]"), null);
}));

test("the robot stands where the plan says: every contact's surfaces lie in one plane", () => on("one", "light", async (page) => {
  const worst = await page.evaluate(() => {
    const app = window.locotamp;
    const { plan, stage } = app.views[0];
    let worst = 0;
    for (const phase of plan.phases) {
      for (let node = phase.start; node < phase.end; node++) {
        stage.show(plan.time[node] + 1e-9);
        for (const contact of phase.contacts) {
          const a = stage.contacts.worldFromInterface(contact.a);
          const b = stage.contacts.worldFromInterface(contact.b).invert();
          worst = Math.max(worst, Math.abs(b.multiply(a).elements[14]));
        }
      }
    }
    return worst;
  });
  assert.ok(worst > 0 && worst < 5e-4, `${worst} m apart`);
}));

test("meshes are drawn as the files have them", () => on("meshed", "light", async (page) => {
  const found = await page.evaluate(() => {
    const { stage } = window.locotamp.views[0];
    const meshes = [];
    stage.robot.root.traverse((part) => { if (part.isMesh && part.scale.y < 0) meshes.push(part); });
    const [{ geometry, material, matrixWorld }] = meshes;
    const { position, normal } = geometry.attributes;
    let [width, out] = [0, 1];
    for (let i = 0; i < position.count; i++) {
      const place = [position.getX(i), position.getY(i), position.getZ(i)];
      const side = [normal.getX(i), normal.getY(i), normal.getZ(i)];
      width = Math.max(width, 2 * Math.abs(place[0]));
      out = Math.min(out, (place[0] * side[0] + place[1] * side[1] + place[2] * side[2]) / 0.3);
    }
    return { count: meshes.length, width, out, corners: position.count, color: material.color.getHexString(), mirrored: matrixWorld.determinant() < 0 };
  });
  assert.equal(found.count, 1);
  assert.ok(Math.abs(found.width - 0.6) < 1e-4, `${found.width} m wide`);
  assert.equal(found.corners, 21, "seven triangles");
  assert.ok(found.out > 0.56 && found.out < 0.59, `normals of an octahedron, ${found.out}`);
  assert.equal(found.color, "00cc33");
  assert.ok(found.mirrored);
  // It hides nearly everything of this small robot, and is green.
  const green = await page.evaluate(() => {
    const stage = window.locotamp.views[0].stage;
    stage.draw();
    const source = stage.renderer.domElement;
    const copy = Object.assign(document.createElement("canvas"), { width: source.width, height: source.height });
    const context = copy.getContext("2d");
    context.drawImage(source, 0, 0);
    const { data } = context.getImageData(0, 0, copy.width, copy.height);
    let count = 0;
    for (let i = 0; i < data.length; i += 4) if (data[i + 1] > 1.5 * data[i] && data[i + 1] > 1.3 * data[i + 2]) count += 1;
    return count / (data.length / 4);
  });
  assert.ok(green > 0.02, `${(100 * green).toFixed(2)} % of the picture are green`);
}));

test("what limits the motion and where the checker found most is a click away", () => on("one", "light", async (page) => {
  const text = await page.$eval(".panel", (panel) => panel.textContent);
  assert.match(text, /Accepted by the checker/);
  assert.match(text, /Joint torque\d+ %/);
  await page.click(".use");
  const there = await time(page);
  assert.ok(there > 0, "goes to the time of the largest use");
  await page.click(".checks summary");
  const rows = await page.$$(".checks[open] button.check");
  assert.ok(rows.length > 5);
  await rows[0].click();
  assert.notEqual(await time(page), there);
}));

test("several plans are shown by tab and side by side in step", () => on("two", "dark", async (page) => {
  assert.deepEqual(await page.$$eval(".tab", (tabs) => tabs.map((tab) => tab.textContent)), ["squeeze", "hopper", "Side by side"]);
  await page.keyboard.press("2");
  assert.equal(await page.$eval(".tab[aria-selected=true]", (tab) => tab.textContent), "hopper");
  await page.keyboard.press("s");
  await settle(page);
  assert.equal((await page.$$("canvas.stage")).length, 2);
  const before = [await picture(page, 0), await picture(page, 1)];
  await page.evaluate(() => window.locotamp.player.seek(0.2));
  for (const view of [0, 1]) assert.notEqual((await picture(page, view)).sum, before[view].sum, `picture ${view}`);
}));

test("a picture takes few draw calls and triangles, and playing draws no chart anew", () => on("one", "light", async (page) => {
  const most = await page.evaluate(() => {
    const { player, views: [{ stage }] } = window.locotamp;
    const most = { calls: 0, triangles: 0 };
    for (let i = 0; i <= 20; i++) {
      player.seek((player.duration * i) / 20);
      stage.draw();
      // Of the shadows too.
      const { calls, triangles } = stage.renderer.info.render;
      [most.calls, most.triangles] = [Math.max(most.calls, calls), Math.max(most.triangles, triangles)];
    }
    return most;
  });
  assert.ok(most.calls > 20 && most.calls <= 130, `${most.calls} draw calls`);
  assert.ok(most.triangles > 10_000 && most.triangles <= 100_000, `${most.triangles} triangles`);
  await page.evaluate(() => {
    window.chartsDrawn = 0;
    for (const canvas of document.querySelectorAll(".stack canvas")) {
      const context = canvas.getContext("2d");
      for (const name of ["stroke", "fill", "fillRect", "fillText"]) context[name] = () => { window.chartsDrawn += 1; };
    }
    window.locotamp.player.seek(0);
    window.locotamp.player.toggle();
  });
  await page.waitForFunction(() => window.locotamp.player.time > 0.4);
  assert.equal(await page.evaluate(() => window.chartsDrawn), 0);
  await page.keyboard.press("t");
  assert.ok((await page.evaluate(() => window.chartsDrawn)) > 20, "another theme draws them");
}));

test("Firefox draws and plays the page, too", { skip: firefoxLacks ? `there is no ${firefoxLacks}` : false }, async () => {
  const firefox = await launchFirefox();
  try {
    const page = await open(firefox.browser, pageFile("one"), null);
    await page.waitForFunction(() => window.locotamp?.views[0].stage !== undefined);
    const [first, pose, x] = [await picture(page), await angles(page), await cursor(page)];
    assert.ok(first.drawn > 0.05 && first.drawn < 0.9, `${(100 * first.drawn).toFixed(1)} % of the picture differ from the background`);
    await page.keyboard.press(" ");
    await page.waitForFunction(() => window.locotamp.player.time > 0.3);
    await page.keyboard.press(" ");
    assert.notEqual((await picture(page)).sum, first.sum, "the picture");
    assert.notEqual(await angles(page), pose, "the robot's joints");
    assert.ok((await cursor(page)) > x, "the cursor of the charts");
    const box = await (await page.$(".stack canvas")).boundingBox();
    await page.mouse.click(box.x + 0.7 * box.width, box.y + 40);
    const [there, duration] = [await time(page), await page.evaluate(() => window.locotamp.player.duration)];
    assert.ok(there > 0.5 * duration && there < 0.9 * duration, `a click goes to ${there} of ${duration}`);
    assert.deepEqual([page.faults, page.requests], [[], []]);
  } finally {
    await firefox.close();
  }
});

test("a page with damaged data says what is wrong", async () => {
  const whole = readFileSync(pageFile("one"), "utf8");
  const data = /(<script id="data" type="application\/json">)([\s\S]*?)(<\/script>)/;
  const json = whole.match(data)[2];
  const damaged = (change) => { const page = JSON.parse(json); change(page); return JSON.stringify(page); };
  const cases = [
    [json.slice(0, 500), /not JSON/],
    [damaged((page) => { page.format = "other/3"; }), /format "other\/3", expected "locotamp\.page\/1"/],
    [damaged((page) => { page.plans = []; }), /no plan in the page/],
    [damaged((page) => { delete page.plans[0].interfaces; }), /squeeze: the key "interfaces" is missing/],
    [damaged((page) => { page.plans[0].q.data.length -= 36; }), /squeeze: q has 48 rows, expected 49/],
    [damaged((page) => { page.plans[0].tau.data[3] = "x"; }), /squeeze: tau: entry 3 is no number/],
    [damaged((page) => { page.plans[0].robot.shapes[0].mesh = 0; }), /squeeze: shape 1 of the robot has mesh 1, the page has 0/],
    [damaged((page) => { page.meshes = [{ size: [3, 1], low: [0, 0, 0], step: [1, 1, 1], places: "AAAA", faces: "AAABAAIA" }]; }), /mesh 1: 1 coordinates and 3 corners, expected 9 and 3/],
    [damaged((page) => { page.plans[0].phases.pop(); }), /squeeze: phases have 32 intervals, time has 48/],
  ];
  for (const [text, message] of cases) {
    writeFileSync(pageFile("damaged"), whole.replace(data, (_, open, __, close) => open + text + close));
    const page = await open(browser, pageFile("damaged"));
    assert.match(await page.$eval("[role=alert]", (alert) => alert.textContent), message);
    assert.deepEqual(page.faults, []);
    await page.close();
  }
});

test("a page is small and names nothing of the machine that made it", () => {
  assert.ok(statSync(pageFile("two")).size < 1_500_000);
  for (const name of ["two", "meshed"]) {
    const text = readFileSync(pageFile(name), "utf8");
    assert.ok(!text.includes(folder) && !text.includes(repository));
  }
});
