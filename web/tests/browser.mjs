// Chromium with the page of web/dist, and what tests look at.

import { mkdtempSync, rmSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { comparison } from "./compare.mjs";
import { serve } from "./server.mjs";

const { DIST, CHROMIUM, MODULES, SHOTS } = process.env;
const { chromium } = createRequire(join(MODULES, "x"))("playwright-core");

/** A browser with further flags, a server, and a folder for both; `end` ends them. */
export async function launch(...flags) {
  const work = mkdtempSync(join(tmpdir(), "lobes-page-"));
  const server = await serve(DIST);
  const args = ["--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking"];
  const browser = await chromium.launch({
    executablePath: CHROMIUM,
    args: [...args, "--disable-component-update", "--disable-sync", ...flags],
  });
  const end = async () => {
    await browser.close();
    server.end();
    rmSync(work, { recursive: true });
  };
  const compare = comparison(work);
  return {
    browser,
    work,
    end,
    visit: (query, viewport) => visit({ browser, server }, query, viewport),
    difference: (page, scene) => difference(compare, page, scene),
  };
}

/** A new page that must not complain, nor load anything from elsewhere. */
async function visit({ browser, server }, query, viewport = { width: 1280, height: 720 }) {
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
export const whole = (page) => page.waitForFunction(() => globalThis.lobes?.isDone?.(), null, { timeout: 240_000, polling: 20 });

export const report = (page) => page.evaluate(() => globalThis.lobes.report);

/** Where the light's mark is on the screen. */
export async function mark(page, light) {
  const box = await page.locator("#overlay").boundingBox();
  const { at } = (await report(page)).lights[light];
  return [box.x + at[0], box.y + at[1]];
}

/** The difference from the command's picture of a scene. */
async function difference(compare, page, scene) {
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

/** Pictures a second while a lamp is dragged around its place for some seconds, and their divisors. */
export async function dragRate(page, light, seconds) {
  const [x, y] = await mark(page, light);
  await page.mouse.move(x, y);
  await page.mouse.down();
  const count = () => page.evaluate(() => ({ ...globalThis.lobes.counts, now: performance.now() }));
  const from = await count();
  for (let step = 1, end = performance.now() + 1000 * seconds; performance.now() < end; step++) {
    await page.mouse.move(x - 60 + 60 * Math.cos(step / 20), y + 60 * Math.sin(step / 20));
  }
  const to = await count();
  await page.mouse.up();
  const divisors = ["1", "2", "4", "8", "16"].filter((divisor) => (to[divisor] ?? 0) > (from[divisor] ?? 0));
  const pictures = divisors.reduce((sum, divisor) => sum + to[divisor] - (from[divisor] ?? 0), 0);
  return { rate: (1000 * pictures) / (to.now - from.now), divisors: `1 : ${divisors.join(", 1 : ")}` };
}

/** Keeps a picture of the page where that is wanted. */
export async function shot(page, name) {
  if (!SHOTS) return;
  // The hint fades.
  await page.waitForTimeout(500);
  await page.screenshot({ path: join(SHOTS, `${name}.png`) });
}
