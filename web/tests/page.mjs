// The page in a real browser: it opens, a lamp is dragged by the mouse, a pixel is clicked, a file is dropped, and pictures are
// those of the command. Prints its figures.

import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import test, { after, before } from "node:test";
import { dragRate, launch, mark, report, shot, whole } from "./browser.mjs";

let work, visit, difference, end;

before(async () => ({ work, visit, difference, end } = await launch("--disable-gpu")));
after(() => end?.());

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
  const { rate, divisors } = await dragRate(page, 1, 4);
  console.log(`page: ${rate.toFixed(1)} pictures a second at 480 × 270 with one worker (${divisors})`);
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
