// The page in a real browser: it opens, a lamp is dragged by the mouse, a pixel is clicked, a file is dropped, and pictures are
// those of the command. Prints its figures.

import assert from "node:assert/strict";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import test, { after, before } from "node:test";
import { comparison } from "./compare.mjs";
import { serve } from "./server.mjs";

const { DIST, CHROMIUM, MODULES, SHOTS } = process.env;
const { chromium } = createRequire(join(MODULES, "x"))("playwright-core");
const work = mkdtempSync(join(tmpdir(), "lobes-page-"));
const compare = comparison(work);
let server;
let browser;

before(async () => {
  server = await serve(DIST);
  const args = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking"];
  browser = await chromium.launch({
    executablePath: CHROMIUM,
    args: [...args, "--disable-component-update", "--disable-sync"],
  });
});
after(async () => {
  await browser?.close();
  server?.end();
  rmSync(work, { recursive: true });
});

/** A new page that must not complain, nor load anything from elsewhere. */
async function visit(query, viewport = { width: 1280, height: 720 }) {
  const page = await browser.newPage({ viewport });
  const faults = [];
  page.on("pageerror", (error) => faults.push(String(error)));
  page.on("console", (message) => message.type() === "error" && faults.push(message.text()));
  page.on("request", (request) => {
    const url = request.url();
    if (!url.startsWith(server.address) && !/^(blob|data):/.test(url)) faults.push(`loads ${url}`);
  });
  await page.goto(server.address + query);
  return { page, faults };
}

/** Waits for the whole picture with all that was done so far. */
const whole = (page) => page.waitForFunction(() => globalThis.lobes?.isDone?.(), null, { timeout: 120_000, polling: 20 });

const report = (page) => page.evaluate(() => globalThis.lobes.report);

/** Where the light's mark is on the screen. */
async function mark(page, light) {
  const box = await page.locator("#overlay").boundingBox();
  const { at } = (await report(page)).lights[light];
  return [box.x + at[0], box.y + at[1]];
}

/** The difference from the command's picture of a scene. */
async function difference(page, scene) {
  const { size } = (await report(page)).picture;
  const packed = await page.evaluate(async () => {
    const bytes = new Uint8Array((await globalThis.lobes.radiance()).buffer);
    let text = "";
    for (let from = 0; from < bytes.length; from += 1 << 14) text += String.fromCharCode(...bytes.subarray(from, from + (1 << 14)));
    return btoa(text);
  });
  const radiance = new Float32Array(Uint8Array.from(Buffer.from(packed, "base64")).buffer);
  return compare(size, radiance, scene);
}

async function shot(page, name) {
  if (!SHOTS) return;
  // The hint fades.
  await page.waitForTimeout(500);
  await page.screenshot({ path: join(SHOTS, `${name}.png`) });
}

test("the first picture comes soon", async () => {
  const { page, faults } = await visit("");
  await whole(page);
  const { first, whole: all } = await page.evaluate(() => globalThis.lobes);
  const hands = await page.evaluate(() => document.querySelector("#status").textContent);
  console.log(`page: first picture after ${(first / 1000).toFixed(2)} s, the whole one after ${(all / 1000).toFixed(2)} s (${hands})`);
  assert.ok(first < 10_000, "even on a busy machine");
  await shot(page, "first");
  assert.deepEqual(faults, []);
  await page.close();
});

test("a lamp follows the mouse, and its shadow the lamp", async () => {
  const { page, faults } = await visit("?scene=3&hands=2");
  await whole(page);
  const still = await difference(page, "scenes/glossy_spheres.toml");
  const [x, y] = await mark(page, 3);
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let step = 1; step <= 12; step++) await page.mouse.move(x + 12 * step, y + 6 * step);
  await page.mouse.up();
  await whole(page);
  const text = readFileSync("scenes/glossy_spheres.toml", "utf8");
  const { center } = (await report(page)).lights[3];
  const known = text.match(/^center = \[(.*)\]$/m);
  assert.notDeepEqual(center.map((c) => Math.fround(c)), known[1].split(",").map((c) => Math.fround(Number(c))));
  const scene = join(work, "moved.toml");
  writeFileSync(scene, text.replace(known[0], `center = [${center}]`));
  const moved = await difference(page, scene);
  console.log(`page: the command's picture but for ${still.text}; after a drag but for ${moved.text}`);
  assert.ok(still.isSame && moved.isSame);
  assert.ok(!(await difference(page, "scenes/glossy_spheres.toml")).isSame, "the shadow has moved");
  await shot(page, "dragged");
  await page.keyboard.press("Control+z");
  await whole(page);
  assert.ok((await difference(page, "scenes/glossy_spheres.toml")).isSame);
  assert.deepEqual(faults, []);
  await page.close();
});

test("pictures come while a lamp is dragged", async () => {
  const { page, faults } = await visit("?hands=1");
  await page.selectOption("#columns", "480");
  await whole(page);
  const [x, y] = await mark(page, 1);
  await page.mouse.move(x, y);
  await page.mouse.down();
  const count = () => page.evaluate(() => ({ ...globalThis.lobes.counts, now: performance.now() }));
  const from = await count();
  for (let step = 1, end = performance.now() + 4000; performance.now() < end; step++) {
    await page.mouse.move(x - 60 + 60 * Math.cos(step / 20), y + 60 * Math.sin(step / 20));
  }
  const to = await count();
  await page.mouse.up();
  const seconds = (to.now - from.now) / 1000;
  const divisors = ["1", "2", "4", "8"].filter((divisor) => (to[divisor] ?? 0) > (from[divisor] ?? 0));
  const rate = divisors.reduce((sum, divisor) => sum + to[divisor] - (from[divisor] ?? 0), 0) / seconds;
  console.log(`page: ${rate.toFixed(1)} pictures a second at 480 × 270 with one worker (1 : ${divisors.join(", 1 : ")})`);
  assert.ok(rate >= 2, "even on a busy machine");
  assert.deepEqual(faults, []);
  await page.close();
});

test("a clicked pixel is taken apart; sliders and lists change the picture", async () => {
  const { page, faults } = await visit("");
  await whole(page);
  const box = await page.locator("#overlay").boundingBox();
  await page.mouse.click(box.x + 0.5 * box.width, box.y + 0.66 * box.height);
  await page.waitForSelector("#pixel-body:not([hidden])");
  assert.equal(await page.locator("#pixel tbody tr").count(), 2);
  assert.equal(await page.locator("#masks canvas").count(), 2);
  assert.match(await page.locator("#pixel dl").innerText(), /floor[\s\S]*%/);
  const { pixel } = await report(page);
  assert.ok(Math.hypot(pixel[0] - 0.5, pixel[1] - 0.66) < 0.01, `the clicked one, and not ${pixel}`);
  await shot(page, "pixel");
  const before = await report(page);
  await page.locator("#tolerance").fill("0.9");
  await page.selectOption("#strategies", "none");
  await whole(page);
  const now = await report(page);
  assert.ok(now.tolerance > before.tolerance && now.strategy === "none");
  await page.keyboard.press("f");
  await whole(page);
  assert.deepEqual(faults, []);
  await page.close();
});

test("a dropped model is opened, and a broken one is refused", async () => {
  const { page, faults } = await visit("");
  await whole(page);
  const drop = (name, bytes) =>
    page.evaluate(
      ([name, base64]) => {
        const data = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
        const dataTransfer = new DataTransfer();
        dataTransfer.items.add(new File([data], name));
        document.body.dispatchEvent(new DragEvent("drop", { dataTransfer, bubbles: true, cancelable: true }));
      },
      [name, bytes.toString("base64")],
    );
  await drop("fox.glb", readFileSync("scenes/assets/fox.glb"));
  await page.waitForFunction(() => globalThis.lobes.report.duration > 0, null, { timeout: 60_000 });
  await whole(page);
  const found = await difference(page, "scenes/assets/fox.glb");
  console.log(`page: of a dropped model the command's picture but for ${found.text}`);
  assert.ok(found.isSame);
  await shot(page, "dropped");
  await drop("broken.glb", Buffer.from("glTF, but not really"));
  await page.waitForSelector("#line.shown");
  assert.match(await page.locator("#line").innerText(), /broken\.glb/);
  assert.ok((await report(page)).duration > 0, "the scene stays");
  assert.deepEqual(faults, []);
  await page.close();
});

test("a narrow screen has the panel below", async () => {
  const { page, faults } = await visit("?hands=1", { width: 400, height: 800 });
  await whole(page);
  const [picture, panel] = await Promise.all(["#frames", "aside"].map((id) => page.locator(id).boundingBox()));
  assert.ok(picture.width > 300 && panel.y >= picture.y + picture.height);
  await shot(page, "narrow");
  assert.deepEqual(faults, []);
  await page.close();
});
