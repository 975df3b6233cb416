// Opens pages in a real headless Chromium, or in Firefox, and keeps account of what goes wrong.
import { spawn } from "node:child_process";
import { existsSync } from "node:fs";
import { pathToFileURL } from "node:url";
import puppeteer from "puppeteer-core";

const CHROMIUM = process.env.CHROMIUM ?? ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].find(existsSync);

export function launch() {
  if (!CHROMIUM) throw new Error("no Chromium found; install it or set CHROMIUM to its path");
  // WebGL without a graphics card; as root, Chromium has no sandbox.
  const args = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", ...(process.getuid?.() === 0 ? ["--no-sandbox"] : [])];
  return puppeteer.launch({ executablePath: CHROMIUM, headless: true, args });
}

const FIREFOX = process.env.FIREFOX ?? ["/usr/bin/firefox-esr", "/usr/bin/firefox"].find(existsSync);
const XVFB = ["/usr/bin/Xvfb"].find(existsSync);

/** What Firefox needs and is not there; empty if all is. Without a display it has no WebGL, so it gets one that nobody sees. */
export const firefoxLacks = [[FIREFOX, "Firefox (or FIREFOX, its path)"], [XVFB, "Xvfb"]].filter(([path]) => !path).map(([, name]) => name).join(" and ");

/** Firefox on a display of its own, drawn by Mesa without a graphics card; `close` ends both. */
export async function launchFirefox() {
  const display = spawn(XVFB, ["-displayfd", "1", "-screen", "0", "1400x900x24", "-nolisten", "tcp"], { stdio: ["ignore", "pipe", "ignore"] });
  try {
    const number = await new Promise((done, fail) => {
      display.stdout.once("data", (text) => done(String(text).trim()));
      display.once("error", fail);
      display.once("exit", (code) => fail(new Error(`Xvfb ended with ${code}`)));
    });
    const browser = await puppeteer.launch({
      browser: "firefox", executablePath: FIREFOX, headless: false, timeout: 120_000, extraPrefsFirefox: { "webgl.force-enabled": true },
      env: { ...process.env, DISPLAY: `:${number}`, LIBGL_ALWAYS_SOFTWARE: "1", WAYLAND_DISPLAY: "" },
    });
    return { browser, close: async () => { await browser.close(); display.kill(); } };
  } catch (error) {
    display.kill();
    throw error;
  }
}

/** A page with lists of its console errors and of its requests beyond itself. */
export async function open(browser, file, theme = "light") { // without a theme: the browser's own
  const page = await browser.newPage();
  const url = pathToFileURL(file).href;
  page.faults = [];
  page.requests = [];
  page.on("console", (message) => { if (["error", "warn"].includes(message.type())) page.faults.push(message.text()); });
  page.on("pageerror", (error) => page.faults.push(error.message));
  page.on("request", (request) => { if (request.url() !== url && !request.url().startsWith("data:")) page.requests.push(request.url()); });
  await page.setViewport({ width: 1280, height: 720 });
  if (theme) await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: theme }]);
  await page.goto(url);
  return page;
}

/** The picture of the scene as numbers: how many pixels are not background, and a sum that changes with the picture. */
export function picture(page, view = 0) {
  return page.evaluate((view) => {
    const stage = window.locotamp.views[view].stage;
    stage.draw();
    const source = stage.renderer.domElement;
    const copy = document.createElement("canvas");
    [copy.width, copy.height] = [source.width, source.height];
    const context = copy.getContext("2d");
    context.drawImage(source, 0, 0);
    const { data } = context.getImageData(0, 0, copy.width, copy.height);
    const background = [data[0], data[1], data[2]];
    let [drawn, sum] = [0, 0];
    for (let i = 0; i < data.length; i += 4) {
      const off = Math.abs(data[i] - background[0]) + Math.abs(data[i + 1] - background[1]) + Math.abs(data[i + 2] - background[2]);
      if (off > 60) drawn += 1;
      sum = (sum * 31 + data[i] + 3 * data[i + 1] + 7 * data[i + 2]) % 1000000007;
    }
    return { background, drawn: drawn / (data.length / 4), sum };
  }, view);
}

export const time = (page) => page.evaluate(() => window.locotamp.player.time);

/** Lets the page draw. */
export const settle = (page) => page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
