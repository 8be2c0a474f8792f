// The switch "GPU" of the page: WebGPU draws the same picture, follows what is dragged, and leaves the drawing to the CPU where it
// cannot. Chromium has WebGPU on any machine, on a device of software that is far slower than the CPU's own path: pictures are small.

import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import test, { after, before } from "node:test";
import { dragRate, launch, mark, report, shot, whole } from "./browser.mjs";

let browser, work, visit, difference, end;

before(async () => ({ browser, work, visit, difference, end } = await launch("--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader")));
after(() => end?.());

const line = (page) => page.locator("#line").innerText();

/** Waits until WebGPU draws, and its picture is there; the line of the page where it does not. */
async function drawsOnGpu(page) {
  const answer = await page.waitForFunction(() => globalThis.lobes?.gpu || document.querySelector("#line").textContent, null, { timeout: 240_000, polling: 20 });
  assert.equal(await page.evaluate(() => document.querySelector("#line").textContent), "");
  await whole(page);
  return answer.jsonValue();
}

/** Waits until the CPU draws again, and its picture is there. */
async function drawsOnCpu(page) {
  await page.waitForFunction(() => globalThis.lobes.gpu === null && !document.querySelector("#gpu").checked, null, { timeout: 60_000, polling: 20 });
  await whole(page);
}

test("WebGPU draws the command's pictures", async () => {
  for (const [number, scene] of [[0, null], [3, "scenes/glossy_spheres.toml"]]) {
    const { page, faults } = await visit(`?scene=${number}&hands=1&columns=128`);
    await whole(page);
    const began = await page.evaluate(() => performance.now());
    await page.locator("#gpu").click();
    const name = await drawsOnGpu(page);
    const seconds = ((await page.evaluate(() => performance.now())) - began) / 1000;
    const found = await difference(page, scene);
    console.log(`page: WebGPU (${name}) draws the command's picture of ${scene ?? "the built-in scene"} but for ${found.text}, ${seconds.toFixed(1)} s after the switch`);
    assert.ok(found.isSame);
    assert.match(await page.locator("#status").innerText(), /GPU/);
    if (!scene) await shot(page, "gpu");
    await page.locator("#gpu").click();
    await drawsOnCpu(page);
    assert.ok((await difference(page, scene)).isSame);
    assert.deepEqual(faults, []);
    await page.close();
  }
});

test("what was edited before, and what is edited then, is in WebGPU's picture", async () => {
  const { page, faults } = await visit("?scene=3&hands=2&columns=160");
  await whole(page);
  const drag = async (by) => {
    const [x, y] = await mark(page, 3);
    await page.mouse.move(x, y);
    await page.mouse.down();
    for (let step = 1; step <= 12; step++) await page.mouse.move(x + by[0] * step, y + by[1] * step);
    await page.mouse.up();
    await whole(page);
  };
  const text = readFileSync("scenes/glossy_spheres.toml", "utf8");
  const moved = async () => {
    const { center } = (await report(page)).lights[3];
    const scene = join(work, "moved.toml");
    writeFileSync(scene, text.replace(/^center = .*$/m, `center = [${center}]`));
    return difference(page, scene);
  };
  await drag([12, 6]);
  await page.locator("#gpu").click();
  await drawsOnGpu(page);
  const first = await moved();
  assert.ok(first.isSame, `a replica that came later knows the edit: ${first.text}`);
  await drag([-6, 3]);
  const found = await moved();
  console.log(`page: after a drag under WebGPU but for ${found.text}`);
  assert.ok(found.isSame);
  assert.ok(!(await difference(page, "scenes/glossy_spheres.toml")).isSame, "the shadow has moved");
  await page.locator("#tolerance").fill("0.2");
  await page.keyboard.press("Control+z");
  await page.keyboard.press("Control+z");
  await page.keyboard.press("Control+z");
  await whole(page);
  assert.ok((await difference(page, "scenes/glossy_spheres.toml")).isSame, "all steps are taken back");
  assert.ok(await page.evaluate(() => globalThis.lobes.gpu), "by WebGPU");
  assert.deepEqual(faults, []);
  await page.close();
});

test("pictures come while a lamp is dragged under WebGPU", async () => {
  const { page, faults } = await visit("?scene=3&hands=1&columns=128&gpu");
  await drawsOnGpu(page);
  const { rate, divisors } = await dragRate(page, 3, 8);
  console.log(`page: ${rate.toFixed(1)} pictures a second at 128 × 72 by WebGPU on software (${divisors})`);
  assert.ok(rate > 0, "even on a busy machine");
  assert.ok(await page.evaluate(() => globalThis.lobes.gpu));
  assert.deepEqual(faults, []);
  await page.close();
});

test("the CPU draws on when the device is lost", async () => {
  const { page } = await visit("?scene=3&hands=1&columns=160");
  await whole(page);
  await page.locator("#gpu").click();
  await drawsOnGpu(page);
  // All devices are lost with the process that has them.
  const session = await browser.newBrowserCDPSession();
  await session.send("Browser.crashGpuProcess");
  const [x, y] = await mark(page, 3);
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 30, y + 20);
  await page.mouse.up();
  await page.waitForSelector("#line.shown", { timeout: 60_000 });
  assert.match(await line(page), /The CPU draws, since the GPU does not: .*lost/);
  await drawsOnCpu(page);
  await page.keyboard.press("Control+z");
  await whole(page);
  assert.ok((await difference(page, "scenes/glossy_spheres.toml")).isSame);
  await page.close();
});

test("without an adapter the CPU draws, and says so", async () => {
  const other = await launch("--disable-gpu");
  try {
    const { page, faults } = await other.visit("?scene=3&hands=1&columns=160");
    await whole(page);
    if (await page.locator("#gpu-row").isHidden()) {
      assert.ok(await page.evaluate(() => !navigator.gpu), "no switch without WebGPU");
    } else {
      await page.locator("#gpu").click();
      await page.waitForSelector("#line.shown", { timeout: 60_000 });
      assert.match(await line(page), /The CPU draws, since the GPU does not: the browser has no adapter/);
      await drawsOnCpu(page);
      assert.ok((await other.difference(page, "scenes/glossy_spheres.toml")).isSame);
    }
    assert.deepEqual(faults, []);
  } finally {
    await other.end();
  }
});
