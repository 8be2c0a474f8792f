// Baked rooms as three.js shows them, beside the command's own picture. Prints its figures.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { cpSync, mkdirSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import test, { after, before } from "node:test";
import { exr } from "../../../web/tests/exr.mjs";
import { serve } from "../../../web/tests/server.mjs";

const { CHROMIUM, LOBES, MODULES, SHOTS } = process.env;
const { chromium } = createRequire(join(MODULES, "x"))("playwright-core");
const work = mkdtempSync(join(tmpdir(), "lobes-bake-"));
const here = import.meta.dirname;
const ROOM = join(here, "../room.toml");
const SIZE = [480, 300];
let server;
let browser;

const lobes = (...args) => execFileSync(LOBES, args, { encoding: "utf8" });

before(async () => {
  for (const name of ["page.html", "page.js"]) cpSync(join(here, name), join(work, name));
  const three = join(MODULES, "node_modules/three");
  for (const part of ["build", "examples/jsm/loaders", "examples/jsm/utils"]) {
    mkdirSync(join(work, "three", part), { recursive: true });
    cpSync(join(three, part), join(work, "three", part), { recursive: true });
  }
  lobes("render", ROOM, "--size", SIZE.join("x"), "--samples", "16", "--tolerance", "0.002", "-q", "-o", join(work, "room.exr"));
  server = await serve(work);
  const args = ["--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking"];
  const gl = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"];
  browser = await chromium.launch({ executablePath: CHROMIUM, args: [...args, ...gl] });
});
after(async () => {
  await browser?.close();
  server?.end();
  rmSync(work, { recursive: true });
});

/** Bakes the room, and compares the picture that three.js makes of it with the command's. */
async function compared(name, options) {
  const file = join(work, `${name}.glb`);
  const baked = JSON.parse(lobes("bake", ROOM, "-o", file, "--json", "-q", ...options));
  const page = await browser.newPage();
  const faults = [];
  page.on("pageerror", (error) => faults.push(String(error)));
  page.on("console", (message) => message.type() === "error" && faults.push(message.text()));
  await page.goto(`${server.address}page.html`);
  await page.waitForFunction(() => globalThis.isReady);
  const packed = await page.evaluate(([url, size]) => globalThis.show(url, size, 4), [`${name}.glb`, SIZE]);
  await page.close();
  assert.deepEqual(faults, []);
  const radiance = new Float32Array(Uint8Array.from(Buffer.from(packed, "base64")).buffer);
  // Colours of vertices are darker than the light where they would exceed 1.
  radiance.forEach((value, k) => (radiance[k] = value * baked.scale));
  const shown = join(work, `${name}.exr`);
  writeFileSync(shown, exr(...SIZE, radiance));
  if (SHOTS) {
    for (const part of [shown, file]) cpSync(part, join(SHOTS, part.slice(work.length + 1)));
    lobes("compare", shown, join(work, "room.exr"), "--diff", join(SHOTS, `${name}.diff.png`), "--json");
  }
  return { baked, error: JSON.parse(lobes("compare", shown, join(work, "room.exr"), "--json")) };
}

for (const [name, options, most] of [
  ["emission", ["--density", "40"], 0.02],
  ["lightmap", ["--density", "40", "--as", "lightmap"], 0.02],
  ["both-sides", ["--density", "40", "--both-sides"], 0.02],
  ["vertex-colors", ["--as", "vertex-colors", "--subdivide", "0.02"], 0.02],
]) {
  test(`three.js shows the room by ${name}`, async () => {
    const { baked, error } = await compared(name, options);
    const mean = error.mae / error.reference_mean;
    const percent = (x) => `${(100 * x).toFixed(2)} %`;
    console.log(`${name}: mean error ${percent(mean)}, bias ${percent(error.bias / error.reference_mean)}, ${baked.texels || baked.vertices} texels or vertices, ${JSON.stringify(error)}`);
    assert.ok(mean < most, `mean error ${percent(mean)}`);
  });
}
