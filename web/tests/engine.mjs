// The engine in Node, as the page's workers call it: the same pictures as the command, whole, in parts and after edits.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import test, { after } from "node:test";
import { gunzipSync } from "node:zlib";
import { engine as make } from "../page/engine.js";
import { comparison } from "./compare.mjs";

const module = await WebAssembly.compile(gunzipSync(readFileSync(join(process.env.DIST, "lobes.wasm.packed"))));
const work = mkdtempSync(join(tmpdir(), "lobes-web-"));
after(() => rmSync(work, { recursive: true }));

const size = [320, 180];
const start = () => make(module, (line) => assert.fail(line));
const open = (engine, path = null, leads = true) => engine.request({ do: "open", path, columns: size[0], leads });
const put = (engine, ...names) => names.forEach((name) => engine.putFile(name, readFileSync(`scenes/${name}`)));

/** Makes pictures until there is no more to do; gives the tasks. */
function run(engine, helpers = []) {
  const tasks = [];
  for (let task; (task = engine.task(1 + helpers.length)); tasks.push(task)) {
    engine.shade(task, 0, 1 + helpers.length);
    helpers.forEach((helper, k) => engine.putPart(k + 1, helper.shade(task, k + 1, 1 + helpers.length)));
    if (engine.finish()) helpers.forEach((helper) => helper.follow());
  }
  return tasks;
}

const compare = comparison(work);
const difference = (engine, scene) => compare(size, engine.radiance(), scene);

const drag = (engine, light, by) => {
  const from = engine.report().lights[light].at;
  engine.request({ do: "press", at: from, pans: false });
  engine.request({ do: "drag", at: from.map((c, k) => c + by[k]) });
};

test("pictures come soon, in processor time, which other programs change less", async () => {
  const seconds = (work) => {
    const before = process.cpuUsage();
    work();
    const { user, system } = process.cpuUsage(before);
    return (user + system) / 1e6;
  };
  const engine = await start();
  const step = () => {
    const task = engine.task(1);
    engine.shade(task, 0, 1);
    engine.finish();
    engine.pixels();
    engine.report();
    return task.divisor;
  };
  const first = seconds(() => {
    engine.request({ do: "open", path: null, columns: 640, leads: true });
    step();
  });
  engine.request({ do: "columns", count: 480 });
  engine.request({ do: "view", size: [960, 540] });
  run(engine);
  drag(engine, 1, [0, 0]);
  const [x, y] = engine.report().lights[1].at;
  const divisors = new Set();
  const move = (k) => {
    engine.request({ do: "drag", at: [x - 60 + 60 * Math.cos(k / 10), y + 60 * Math.sin(k / 10)] });
    divisors.add(step());
  };
  for (let k = 0; k < 20; k++) move(k);
  const each = seconds(() => Array.from({ length: 40 }, (_, k) => move(k))) / 40;
  console.log(
    `engine: ${first.toFixed(2)} s to the first picture; ${(1000 * each).toFixed(0)} ms for each at 480 × 270 while a lamp is dragged ` +
      `(1 : ${[...divisors].join(", 1 : ")}), ${(1 / each).toFixed(0)} a second on one core`,
  );
  assert.ok(first < 10 && each < 0.4, "even where all cores are busy");
});

test("pictures are those of the command", async () => {
  for (const [path, files] of [[null, []], ["lights.toml", ["assets/moebius.obj"]], ["walk.toml", ["assets/fox.glb"]]]) {
    const engine = await start();
    if (path) put(engine, path, ...files);
    open(engine, path);
    run(engine);
    const found = difference(engine, path && `scenes/${path}`);
    console.log(`engine: of ${path ?? "the built-in scene"} the command's picture but for ${found.text}`);
    assert.ok(found.isSame);
    assert.deepEqual(engine.report().lines, []);
    const stats = JSON.parse(execFileSync(process.env.LOBES, ["render", ...(path ? [`scenes/${path}`] : []), "--size", "64x36", "-o", join(work, "x.png"), "--json"]));
    assert.ok(Math.abs(engine.report().exposure - stats.exposure) < 0.11, `${engine.report().exposure} ${stats.exposure}`);
  }
});

test("every scene of the page's list opens without a complaint", async () => {
  for (const { path, files } of JSON.parse(readFileSync("web/page/scenes.json"))) {
    const engine = await start();
    put(engine, ...files);
    engine.request({ do: "open", path, columns: 64, leads: true });
    run(engine);
    const { lines, picture } = engine.report();
    assert.deepEqual(lines, [], path);
    assert.equal(picture.divisor, 1);
    assert.ok(engine.radiance().some((value) => value > 0));
  }
});

test("a dragged light's picture is that of the command", async () => {
  const engine = await start();
  put(engine, "glossy_spheres.toml");
  open(engine, "glossy_spheres.toml");
  run(engine);
  engine.request({ do: "view", size });
  drag(engine, 3, [90, 60]);
  const [first] = run(engine);
  assert.ok(first.divisor >= 1);
  engine.request({ do: "release" });
  const text = readFileSync("scenes/glossy_spheres.toml", "utf8");
  const before = text.match(/^center = .*$/m)[0];
  const { center } = engine.report().lights[3];
  const scene = join(work, "moved.toml");
  writeFileSync(scene, text.replace(before, `center = [${center}]`));
  const found = difference(engine, scene);
  console.log(`engine: after a drag but for ${found.text}`);
  assert.ok(found.isSame);
  assert.ok(!difference(engine, "scenes/glossy_spheres.toml").isSame, "the shadow has moved");
  // Taken back, all is as before.
  engine.request({ do: "undo" });
  run(engine);
  assert.ok(difference(engine, "scenes/glossy_spheres.toml").isSame);
});

test("hands that share a picture make the same one", async () => {
  const [alone, ...all] = await Promise.all(Array.from({ length: 4 }, start));
  [alone, ...all].forEach((engine) => {
    open(engine, null, engine === alone || engine === all[0]);
    engine.request({ do: "view", size });
  });
  const both = (deed) => [alone, ...all].forEach(deed);
  for (const deed of [(engine) => engine, (engine) => drag(engine, 0, [60, 90]), (engine) => engine.request({ do: "zoom", by: 0.9 })]) {
    both(deed);
    run(alone);
    run(all[0], all.slice(1));
    assert.deepEqual(all[0].radiance(), alone.radiance());
  }
});

test("a pixel is taken apart", async () => {
  const engine = await start();
  open(engine);
  engine.request({ do: "view", size });
  run(engine);
  engine.request({ do: "click", at: [160.5, 116.5] });
  const pixel = engine.pixel();
  assert.deepEqual(pixel.pixel, [160, 116]);
  assert.equal(pixel.object, engine.report().object.name);
  for (const { unshadowed, visible, radiance, mask } of pixel.lights) {
    // Of a surface that is nearly diffuse.
    assert.ok(Math.abs(radiance - unshadowed * visible) <= 0.05 * unshadowed, `${radiance} ${unshadowed} ${visible}`);
    assert.equal(mask.samples.length, mask.size[0] * mask.size[1]);
  }
  const gap = pixel.radiance.map((c, k) => Math.abs(c - pixel.reference[k]));
  assert.ok(gap.every((c, k) => c <= 4 * pixel.deviation[k] + 0.01 * pixel.reference[k]), `${gap}`);
  const at = 3 * (116 * size[0] + 160);
  const shown = engine.radiance().slice(at, at + 3);
  pixel.radiance.forEach((c, k) => assert.ok(Math.abs(c - shown[k]) <= 1e-6 + 1e-3 * c));
});

test("settings, lights and sizes change pictures; strategies agree", async () => {
  const engine = await start();
  engine.request({ do: "open", path: null, columns: 160, leads: true });
  run(engine);
  const before = engine.radiance();
  const now = () => (run(engine), engine.radiance());
  const mean = (a, b) => a.reduce((sum, value, k) => sum + Math.abs(value - b[k]), 0) / a.length;
  const most = (a, b) => a.reduce((most, value, k) => Math.max(most, Math.abs(value - b[k])), 0);
  engine.request({ do: "strategies", name: "silhouettes" });
  const exact = mean(now(), before);
  engine.request({ do: "strategies", name: "none" });
  const none = mean(now(), before);
  assert.ok(exact > 0 && none > 4 * exact, `${exact} ${none}`);
  engine.request({ do: "strategies", name: null });
  assert.deepEqual(now(), before);
  engine.request({ do: "projection", name: "orthographic" });
  assert.ok(most(now(), before) > 0.05 && engine.report().projection === "orthographic");
  engine.request({ do: "undo" });
  assert.deepEqual(now(), before);
  engine.request({ do: "light", number: 0, size: 0.2 });
  assert.ok(most(now(), before) > 0.05);
  assert.ok(Math.abs(engine.report().lights[0].size - 0.2) < 1e-6);
  engine.request({ do: "columns", count: 80 });
  run(engine);
  assert.deepEqual(engine.report().picture.size, [80, 45]);
  assert.equal(engine.pixels().length, 4 * 80 * 45);
});

test("files that cannot be read are refused, and the scene stays", async () => {
  const engine = await start();
  open(engine);
  assert.throws(() => engine.request({ do: "open", path: "nothing.glb", columns: 64, leads: true }), /nothing\.glb/);
  engine.putFile("bad.toml", new TextEncoder().encode("[[lights]]\nkind = \"lamp\"\n"));
  assert.throws(() => engine.request({ do: "open", path: "bad.toml", columns: 64, leads: true }), /bad\.toml:2/);
  assert.throws(() => engine.request({ do: "strategies", name: "magic" }), /magic/);
  run(engine);
  assert.deepEqual(engine.report().picture.size, size);
});
