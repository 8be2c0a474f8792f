// The package for npm, as npm installs it: its pictures beside the command's, its points beside its pictures, edits, refusals, memory.
// PACKAGE is its folder, and WITH the packages that were there to try it with, "three" and "typescript".

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { cpSync, mkdtempSync, readFileSync, rmSync, statSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import test, { after } from "node:test";
import { pathToFileURL } from "node:url";
import { gunzipSync } from "node:zlib";
import { engine } from "../page/engine.js";
import { comparison } from "./compare.mjs";

const place = (name) => pathToFileURL(join(process.env.PACKAGE, name));
const library = await import(place("index.js"));
const { Camera, EditError, Environment, Light, LobesError, Material, RenderError, Renderer, Scene, SceneError, exposed, init } = library;
assert.throws(() => new Scene(), (error) => error instanceof LobesError && /await init\(\) first/.test(error.message));
await assert.rejects(init(place("nothing.wasm")), /nothing\.wasm/);
await init();
await init();

const work = mkdtempSync(join(tmpdir(), "lobes-package-"));
after(() => rmSync(work, { recursive: true }));
const compare = comparison(work);
const size = [320, 180];
const small = [64, 36];

const CORNERS = [-4, 0, 4, 4, 0, 4, 4, 0, -4, -4, 0, -4];
const SQUARE = [0, 1, 2, 0, 2, 3];
const VIEW = { eye: [1.5, 2, 4], target: [0, 0.4, 0], fov: 40 };

/** A sphere above a floor, under a lamp. */
function still(options = {}) {
  const scene = new Scene({ size: small, camera: new Camera(VIEW.eye, VIEW.target, { fov: VIEW.fov }), ...options });
  scene.addMesh(CORNERS, SQUARE, { name: "floor", visibility: "none", material: Material.lambert(0.6) });
  scene.addSpheres([0, 0.5, 0, 0.5], { name: "sphere", material: Material.metallicRoughness([1, 0.8, 0.3], { roughness: 0.3 }) });
  scene.addLight(Light.sphere([-2, 3, 1], 0.4, { radiance: 40 }));
  return scene;
}

const mean = (numbers) => numbers.reduce((sum, x) => sum + x, 0) / numbers.length;
const files = (...names) => Object.fromEntries(names.map((name) => [name, readFileSync(`scenes/${name}`)]));

test("pictures of files are those of the command", () => {
  for (const [path, given] of [[null], ["lights.toml", files("lights.toml", "assets/moebius.obj")], ["walk.toml", files("walk.toml", "assets/fox.glb")]]) {
    const scene = path ? Scene.load(given, { size }) : Scene.builtin({ size });
    const renderer = new Renderer(scene);
    const found = compare(size, renderer.render(), path && `scenes/${path}`);
    console.log(`package: of ${path ?? "the built-in scene"} the command's picture but for ${found.text}`);
    assert.ok(found.isSame);
    assert.deepEqual(scene.warnings, []);
    [scene, renderer].forEach((item) => item.free());
  }
});

test("pictures are those of the page, bit for bit", async () => {
  const page = await engine(await WebAssembly.compile(gunzipSync(readFileSync(join(process.env.DIST, "lobes.wasm.packed")))));
  page.request({ do: "open", path: null, columns: 160, leads: true });
  for (let task; (task = page.task(1)); page.finish()) page.shade(task, 0, 1);
  const renderer = new Renderer(Scene.builtin({ size: [160, 90] }));
  assert.deepEqual(renderer.render(), page.radiance());
});

test("a scene of arrays is that of the same scene file", () => {
  const vectors = (list) => list.map((v) => `[${v}]`).join(", ");
  const text = `
background = [0.1, 0.2, 0.3]
[image]
width = 96
height = 54
[camera]
eye = [${VIEW.eye}]
target = [${VIEW.target}]
fov = ${VIEW.fov}
[materials]
clay = { model = "lambert", albedo = [0.7, 0.5, 0.4] }
paper = { model = "phong", kd = [0.1, 0.12, 0.2], ks = 0.4, exponent = 80 }
polished = { model = "modified-phong", kd = 0.35, ks = 0.25, exponent = 60 }
copper = { model = "neumann", ks = [0.95, 0.64, 0.54], exponent = 60 }
metal = { model = "lafortune", diffuse = [0.05, 0.04, 0.03], lobes = [{ c = [-1, -1, 1], exponent = 40, scale = [1.2, 0.9, 0.5] }, { matrix = [[-1, 0.1, 0], [0.1, -0.7, 0], [0, 0, 0.9]], exponent = 12, scale = [0.2, 0, 0] }] }
paint = { model = "half-vector", diffuse = [0.02, 0.03, 0.05], lobes = [{ roughness = 0.2, f0 = 0.04 }, { roughness = 0.5, f0 = [0.1, 0.3, 0.5], f90 = [0.5, 0.8, 0.9] }] }
gold = { model = "metallic-roughness", base = [1, 0.77, 0.34], roughness = 0.3, ior = 1.7 }
${[["sphere", "center = [-2.5, 4, 2]\nradius = 0.5\nradiance = [3, 2.5, 2]"], ["sphere", "center = [3, 3, -2]\nradius = 0.1\nflux = [2, 3, 4.5]"],
  ["rectangle", "center = [0, 4, 0]\nu = [0.5, 0, 0]\nv = [0, 0, 0.3]\ntwo_sided = true\nradiance = 5"], ["disc", "center = [0, 4, 1]\nnormal = [0, -1, 0]\nradius = 0.4\nflux = 2"],
  ["polygon", `corners = [${vectors([[-1, 4, -1], [0, 4, -1], [-0.5, 4, 0]])}]\nradiance = 0.5`], ["tube", "from = [-1, 3, -1.5]\nto = [1, 3, -1.5]\nradius = 0.03\nflux = 4"],
  ["point", "center = [1, 2.5, 1]\nradius = 0.02\nintensity = 0.3"], ["spot", "center = [2, 3, 2]\nradius = 0.05\ndirection = [-0.5, -1, -0.5]\nangle = 30\ninner = 20\nintensity = 1"],
  ["sun", "direction = [0.3, -1, -0.4]\nirradiance = [0.3, 0.28, 0.25]"], ["ambient", "radiance = 0.02"]].map(([kind, keys]) => `[[lights]]\nkind = "${kind}"\n${keys}\n`).join("")}
[[objects]]
mesh = "floor.obj"
material = "polished"
visibility = "none"
${["clay", "paper", "copper", "metal", "paint", "gold"].map((material, k) => `[[objects]]\nsphere = { center = [${k - 2.5}, 0.4, 0], radius = 0.4 }\nmaterial = "${material}"\n`).join("")}`;
  const floor = `${[0, 3, 6, 9].map((k) => `v ${CORNERS.slice(k, k + 3).join(" ")}\n`).join("")}f 1 2 3\nf 1 3 4\n`;
  const read = new Renderer(Scene.load({ "all.toml": text, "floor.obj": floor }));
  const scene = new Scene({ size: [96, 54], camera: new Camera(VIEW.eye, VIEW.target, { fov: VIEW.fov }), background: [0.1, 0.2, 0.3] });
  scene.addMesh(Float64Array.from(CORNERS), Uint16Array.from(SQUARE), { visibility: "none", material: Material.modifiedPhong({ kd: 0.35, ks: 0.25, exponent: 60 }) });
  [
    Material.lambert([0.7, 0.5, 0.4]),
    Material.phong({ kd: [0.1, 0.12, 0.2], ks: 0.4, exponent: 80 }),
    Material.neumann({ ks: [0.95, 0.64, 0.54], exponent: 60 }),
    Material.lafortune(
      [
        { c: [-1, -1, 1], exponent: 40, scale: [1.2, 0.9, 0.5] },
        { matrix: [[-1, 0.1, 0], [0.1, -0.7, 0], [0, 0, 0.9]], exponent: 12, scale: [0.2, 0, 0] },
      ],
      { diffuse: [0.05, 0.04, 0.03] },
    ),
    Material.halfVector([{ roughness: 0.2, f0: 0.04 }, { roughness: 0.5, f0: [0.1, 0.3, 0.5], f90: [0.5, 0.8, 0.9] }], { diffuse: [0.02, 0.03, 0.05] }),
    Material.metallicRoughness([1, 0.77, 0.34], { roughness: 0.3, ior: 1.7 }),
  ].forEach((material, k) => scene.addSpheres([k - 2.5, 0.4, 0, 0.4], { material }));
  [
    Light.sphere([-2.5, 4, 2], 0.5, { radiance: [3, 2.5, 2] }),
    Light.sphere([3, 3, -2], 0.1, { flux: [2, 3, 4.5] }),
    Light.rectangle([0, 4, 0], [0.5, 0, 0], [0, 0, 0.3], { radiance: 5, twoSided: true }),
    Light.disc([0, 4, 1], [0, -1, 0], 0.4, { flux: 2 }),
    Light.polygon([[-1, 4, -1], [0, 4, -1], [-0.5, 4, 0]], { radiance: 0.5 }),
    Light.tube([-1, 3, -1.5], [1, 3, -1.5], 0.03, { flux: 4 }),
    Light.point([1, 2.5, 1], { radius: 0.02, intensity: 0.3 }),
    Light.spot([2, 3, 2], [-0.5, -1, -0.5], { radius: 0.05, angle: 30, inner: 20, intensity: 1 }),
    Light.sun([0.3, -1, -0.4], { irradiance: [0.3, 0.28, 0.25] }),
    Light.ambient(0.02),
  ].forEach((light) => scene.addLight(light));
  const made = new Renderer(scene);
  const [a, b] = [read.render(), made.render()];
  const most = a.reduce((most, value, k) => Math.max(most, Math.abs(value - b[k])), 0);
  // Directions of lights were made unit vectors by other roundings.
  assert.ok(mean(a) > 0.05 && most < 1e-5, `${mean(a)} ${most}`);
  const kinds = scene.lights.map(({ kind }) => kind);
  assert.deepEqual(kinds, ["sphere", "sphere", "flat", "flat", "flat", "tube", "sphere", "spot", "sun", "ambient"]);
  // An environment instead: all lamps off, the picture is brighter where the sky is.
  [0, 1, 2, 3, 4, 5, 6, 7, 8, 9].forEach((light) => made.removeLight(light));
  assert.ok(made.render().every((value) => value <= 0.3 + 1e-6), "the background alone");
  const data = Float32Array.from({ length: 3 * 32 }, (_, k) => (k < 48 ? 1 : 0));
  made.setEnvironment(new Environment({ width: 8, height: 4, data }, { strength: 0.5 }));
  assert.ok(mean(made.render()) > 0.05);
});

test("points have the light of a picture at the same places", () => {
  const renderer = new Renderer(still(), { samples: 1 });
  const { beauty, unshadowed, light0 } = renderer.layers(["unshadowed", "lights"]);
  const radiance = renderer.render();
  assert.deepEqual(radiance, beauty);
  assert.deepEqual(beauty, light0);
  let count = 0;
  const lists = { position: [], normal: [], view: [], object: [], at: [] };
  for (let y = 0; y < small[1]; y++) {
    for (let x = 0; x < small[0]; x++) {
      const pick = renderer.pick(x, y);
      if (!pick) continue;
      count++;
      for (const key of ["position", "normal", "view"]) lists[key].push(...pick[key]);
      lists.object.push(pick.object);
      lists.at.push([y * small[0] + x, pick.material]);
    }
  }
  assert.ok(count > 1000 && new Set(lists.object).size === 2);
  for (const material of [0, 1]) {
    const layers = renderer.shadeLayers(lists.position, lists.normal, lists.view, { objects: Int32Array.from(lists.object), material });
    assert.deepEqual(layers.beauty, renderer.shade(Float32Array.from(lists.position), lists.normal, lists.view, { objects: lists.object, material }));
    lists.at.forEach(([pixel, own], k) => {
      if (own !== material) return;
      for (let c = 0; c < 3; c++) {
        assert.ok(Math.abs(layers.beauty[3 * k + c] - radiance[3 * pixel + c]) <= 1e-6 + 1e-5 * radiance[3 * pixel + c], `pixel ${pixel}`);
        assert.ok(Math.abs(layers.unshadowed[3 * k + c] - unshadowed[3 * pixel + c]) <= 1e-6 + 1e-5 * unshadowed[3 * pixel + c]);
      }
    });
  }
  // Irradiance of a sphere light in the open: π radiance (radius / distance)² cosine.
  const [white] = renderer.shade([-2, 0, 1], [0, 2, 0], null, { objects: "floor" });
  assert.ok(Math.abs(white - 40 * (0.4 / 3) ** 2) < 1e-3, `${white}`);
  assert.deepEqual(renderer.visibleFraction([-2, 0, 1], [0, 1, 0], 0), [1, 1, 1]);
  assert.deepEqual(renderer.visibleFraction([0, 0.001, 0], [0, 1, 0], 0), [0, 0, 0]);
  assert.equal(renderer.shade([], []).length, 0);
});

test("parts, sizes and memory of the caller's", () => {
  const renderer = new Renderer(still());
  const whole = renderer.render();
  const [x, y, width, height] = [8, 16, 24, 8];
  const part = renderer.render({ window: [x, y, width, height] });
  for (let row = 0; row < height; row++) {
    const at = 3 * ((y + row) * small[0] + x);
    assert.deepEqual(part.subarray(3 * width * row, 3 * width * (row + 1)), whole.subarray(at, at + 3 * width));
  }
  const memory = new Float32Array(whole.length + 2);
  const out = memory.subarray(1, -1);
  assert.equal(renderer.render({ out }), out);
  assert.deepEqual(out, whole);
  assert.ok(memory[0] === 0 && memory.at(-1) === 0);
  assert.equal(renderer.render({ width: 32, height: 18 }).length, 3 * 32 * 18);
  assert.deepEqual(renderer.size, [32, 18]);
  const { depth, object, normal } = renderer.layers(["depth", "object", "normal"], { width: 64, height: 36 });
  assert.deepEqual([depth.length, object.length, normal.length], [2304, 2304, 6912]);
  const { x: column, y: line } = { x: 32, y: 18 };
  const pick = renderer.pick(column, line);
  assert.equal(object[line * 64 + column], pick.object);
  assert.equal(object[0], -1);
  const bytes = exposed(whole, { width: 64, height: 36, exposure: 1, tone: "linear" });
  assert.ok(bytes.length === 4 * 2304 && bytes[3] === 255 && bytes.some((byte, k) => k % 4 < 3 && byte > 100));
});

test("edits give the picture of a renderer that begins there, and build nothing again for a light", () => {
  const renderer = new Renderer(still());
  const before = renderer.render();
  const { upkeep } = renderer;
  const fresh = (change, scene = still()) => {
    change(scene);
    return new Renderer(scene).render();
  };
  renderer.changeLight(0, { center: [1, 3, 1], size: 0.8 });
  assert.deepEqual(renderer.light(0).center, [1, 3, 1]);
  assert.deepEqual(renderer.light(0).radiance, [10, 10, 10], "the same power");
  const moved = renderer.render();
  assert.notDeepEqual(moved, before);
  for (const key of ["hierarchyBuilds", "silhouetteBuilds", "sphereSets", "sphereUpdates", "pointBands"]) assert.equal(renderer.upkeep[key], upkeep[key], key);
  renderer.setLight(0, Light.sphere([-2, 3, 1], 0.4, { radiance: 40 }));
  assert.deepEqual(renderer.render(), before);

  renderer.setMaterial(0, Material.lambert([0.2, 0.4, 0.6]));
  assert.deepEqual(renderer.stale, ["shading"]);
  assert.notDeepEqual(renderer.render(), before);
  renderer.setMaterial(0, Material.lambert(0.6));
  renderer.setTransform("sphere", { elements: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.5, 0.25, 0, 1] });
  assert.deepEqual(renderer.object("sphere").transform.slice(12), [0.5, 0.25, 0, 1]);
  const shifted = renderer.render();
  const direct = new Scene({ size: small, camera: new Camera(VIEW.eye, VIEW.target, { fov: VIEW.fov }) });
  direct.addMesh(CORNERS, SQUARE, { visibility: "none", material: Material.lambert(0.6) });
  direct.addSpheres([0.5, 0.75, 0, 0.5], { material: Material.metallicRoughness([1, 0.8, 0.3], { roughness: 0.3 }) });
  direct.addLight(Light.sphere([-2, 3, 1], 0.4, { radiance: 40 }));
  assert.deepEqual(shifted, new Renderer(direct).render());
  renderer.setTransform("sphere", [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);

  // Numbers stay where others come and go.
  const second = renderer.addLight(Light.disc([2, 3, 0], [0, -1, 0], 0.3, { radiance: 20 }));
  assert.deepEqual([second, renderer.lights], [1, [0, 1]]);
  assert.deepEqual(renderer.render(), fresh((scene) => scene.addLight(Light.disc([2, 3, 0], [0, -1, 0], 0.3, { radiance: 20 }))));
  renderer.removeLight(0);
  assert.deepEqual(renderer.lights, [1]);
  assert.equal(renderer.light(1).kind, "flat");
  assert.throws(() => renderer.light(0), EditError);
  const box = renderer.addMesh([1, 0, 0, 1.5, 0, 0, 1.5, 1, 0], null, { name: "flag", smooth: true });
  assert.deepEqual([box, renderer.object("flag").number, renderer.object("flag").material], [2, 2, 2]);
  renderer.setMesh("flag", [1, 0, 0, 1.5, 0, 0, 1.5, 0.5, 0], [0, 1, 2]);
  renderer.removeObject("sphere");
  assert.deepEqual(renderer.objects, [0, 2]);
  renderer.setObjectMaterial("flag", renderer.addMaterial(Material.lambert(0.9)));
  renderer.setVisibility("flag", "rays");
  renderer.setVisible("flag", false);
  renderer.setBackground(0.5);
  renderer.setCamera(new Camera([0, 3, 5], [0, 0, 0]));
  renderer.setSettings({ tolerance: 0.02, method: "lobes" });
  assert.deepEqual([renderer.settings.tolerance, renderer.settings.samples], [0.02, null]);
  const last = renderer.render();
  assert.ok(mean(last) > 0.02);
  const other = new Scene({ size: small, camera: new Camera([0, 3, 5], [0, 0, 0]), background: 0.5 });
  other.addMesh(CORNERS, SQUARE, { visibility: "none", material: Material.lambert(0.6) });
  other.addMesh([1, 0, 0, 1.5, 0, 0, 1.5, 0.5, 0], [0, 1, 2], { visibility: "rays", visible: false });
  other.addLight(Light.disc([2, 3, 0], [0, -1, 0], 0.3, { radiance: 20 }));
  assert.deepEqual(last, new Renderer(other, { tolerance: 0.02, method: "lobes" }).render());
});

/** A square of a texture, seen from above, under the same light everywhere. */
function square(material) {
  const scene = new Scene({ size: [32, 32], camera: new Camera([0, 4, 0], [0, 0, 0], { up: [0, 0, -1], fov: 28 }) });
  scene.addMesh([-1, 0, 1, 1, 0, 1, 1, 0, -1, -1, 0, -1], SQUARE, { material, uvs: [0, 1, 1, 1, 1, 0, 0, 0] });
  scene.addLight(Light.ambient(1));
  return new Renderer(scene, { samples: 1 });
}

test("images of arrays lie on surfaces, as those of files do", () => {
  // Red and green above, blue and grey below.
  const corners = [255, 0, 0, 9, 0, 255, 0, 9, 0, 0, 255, 9, 188, 188, 188, 9];
  const corner = (x, y) => corners.slice(4 * (2 * (y >> 2) + (x >> 2))).slice(0, 4);
  const data = Uint8ClampedArray.from(Array.from({ length: 64 }, (_, k) => corner(k % 8, k >> 3)).flat());
  const color = { width: 8, height: 8, data };
  const picture = square(Material.lambert(0.5).withImages({ color })).render();
  const at = (x, y) => Array.from(picture.subarray(3 * (32 * y + x), 3 * (32 * y + x) + 3));
  const grey = 0.5 * ((188 / 255 + 0.055) / 1.055) ** 2.4;
  for (const [x, y, want] of [[8, 8, [0.5, 0, 0]], [24, 8, [0, 0.5, 0]], [8, 24, [0, 0, 0.5]], [24, 24, [grey, grey, grey]]]) {
    at(x, y).forEach((value, c) => assert.ok(Math.abs(value - want[c]) < 0.01, `${x} ${y}: ${at(x, y)}`));
  }
  // Three bytes a texel are the same, and a caller that writes over its array changes nothing.
  const three = { width: 8, height: 8, data: Uint8Array.from(data.filter((_, k) => k % 4 < 3)) };
  const made = Material.lambert(0.5).withImages({ color: three });
  three.data.fill(7);
  assert.deepEqual(square(made).render(), picture);
  // An image of emission is radiance; a renderer takes images as well.
  const shining = square(Material.lambert(0).withImages({ emission: color }));
  assert.ok(Math.abs(shining.render()[3 * (32 * 8 + 8)] - 1) < 0.01);
  shining.setMaterial(0, made);
  assert.deepEqual(shining.render(), picture);
  // Roughness and metallic: one byte, or green and blue; half of a mirror's roughness.
  const metal = Material.metallicRoughness(0.8, { roughness: 0.5 });
  const one = (value) => ({ width: 1, height: 1, data: Uint8Array.of(value) });
  const [lone, packed] = [metal.withImages({ roughness: one(128), metallic: one(64) }), { width: 1, height: 1, data: Uint8Array.of(1, 128, 64) }];
  const images = square(lone).render();
  assert.deepEqual(square(metal.withImages({ roughness: packed, metallic: packed })).render(), images);
  const numbers = Material.metallicRoughness(0.8, { roughness: (0.5 * 128) / 255, metallic: 64 / 255 });
  square(numbers).render().forEach((value, k) => assert.ok(Math.abs(value - images[k]) < 1e-4));
  // A normal that leans reflects less of what comes from above.
  const lamp = (material) => {
    const renderer = square(material);
    renderer.setLight(0, Light.sun([0, -1, 0], { irradiance: 1 }));
    return mean(renderer.render());
  };
  const leaning = { width: 1, height: 1, data: Uint8Array.of(218, 128, 218) };
  const ratio = lamp(Material.lambert(0.5).withImages({ normal: leaning })) / lamp(Material.lambert(0.5));
  assert.ok(Math.abs(ratio - Math.SQRT1_2) < 0.02, `${ratio}`);
  assert.notDeepEqual(square(Material.metallicRoughness(0.1, { clearcoat: 1 })).render(), square(Material.metallicRoughness(0.1)).render());
});

test("the reference is the picture but for its noise, and progress is heard and can stop", () => {
  const renderer = new Renderer(still(), { samples: 1 });
  const heard = [];
  const picture = renderer.render({ progress: (stage, done) => heard.push([stage, done]) });
  assert.ok(heard.length > 0 && heard.every(([stage, done]) => stage === "shading" && done >= 0 && done <= 1), `${heard}`);
  const sampled = [];
  const { beauty, unshadowed, stderr } = renderer.reference({ spp: 256, progress: (stage, done) => sampled.push([stage, done]) });
  assert.ok(sampled.length > 3 && sampled.every(([stage, done], k) => stage === "sampling" && done > (sampled[k - 1]?.[1] ?? 0)));
  assert.equal(sampled.at(-1)[1], 1);
  assert.ok(beauty.every((value, k) => value <= unshadowed[k] + 1e-4));
  const off = mean(picture.map((value, k) => Math.abs(value - beauty[k]))) / mean(beauty);
  const beyond = picture.filter((value, k) => Math.abs(value - beauty[k]) > 5 * stderr[k] + 0.02 * unshadowed[k] + 1e-5).length;
  console.log(`package: of the reference but for ${(100 * off).toFixed(2)} %`);
  assert.ok(off < 0.01 && beyond < 0.005 * picture.length, `${off} ${beyond}`);
  assert.deepEqual(renderer.reference({ spp: 16, seed: 3 }), renderer.reference({ spp: 16, seed: 3 }));
  // An exception stops the work, and comes out as it is; all that was kept stays.
  const stop = new Error("enough");
  for (const deed of [(progress) => renderer.render({ progress }), (progress) => renderer.layers(["depth"], { progress }), (progress) => renderer.reference({ progress })]) {
    let count = 0;
    const listen = () => {
      count += 1;
      throw stop;
    };
    assert.throws(() => deed(listen), (error) => error === stop);
    assert.equal(count, 1);
  }
  assert.throws(() => renderer.render({ progress: () => renderer.size }), /^LobesError: the engine is at work: progress may not call it$/);
  assert.deepEqual(renderer.render(), picture);
  // Coverage is 1 on the floor, 0 above the horizon, and between on outlines.
  const coverage = renderer.coverage();
  assert.deepEqual([coverage.length, coverage[0], coverage.at(-1)], [small[0] * small[1], 0, 1]);
  assert.deepEqual(renderer.coverage({ window: [0, 0, 8, 8] }).length, 64);
  const edges = new Renderer(still()).coverage();
  assert.ok(edges.some((part) => part > 0 && part < 1));
});

test("cameras have projections", () => {
  const renderer = new Renderer(still());
  const perspective = renderer.camera;
  assert.deepEqual([perspective.projection, perspective.height], ["perspective", null]);
  const pictures = [renderer.render()];
  for (const options of [{ projection: "orthographic", height: 2.5 }, { projection: "panoramic" }]) {
    // All of these numbers have single precision.
    const camera = new Camera(VIEW.eye, [0, 0.5, 0], options);
    renderer.setCamera(camera);
    assert.deepEqual(renderer.camera, camera);
    pictures.push(renderer.render());
    const scene = still();
    scene.camera = camera;
    assert.deepEqual(scene.camera, camera);
    assert.deepEqual(new Renderer(scene).render(), pictures.at(-1));
  }
  assert.notDeepEqual(pictures[0], pictures[1]);
  assert.notDeepEqual(pictures[1], pictures[2]);
  renderer.setCamera(perspective);
  assert.deepEqual(renderer.render(), pictures[0]);
});

test("animations play", () => {
  const renderer = Renderer.load(files("walk.toml", "assets/fox.glb"), { size: small, tolerance: 0.02 });
  const begin = renderer.render();
  renderer.seek(0.5);
  assert.equal(renderer.time, 0.5);
  assert.notDeepEqual(renderer.render(), begin);
  renderer.seek(0);
  assert.deepEqual(renderer.render(), begin);
});

test("bad arguments are refused by name, and change nothing", () => {
  const scene = still();
  const renderer = new Renderer(scene);
  const before = renderer.render();
  const refusals = [
    [RangeError, /^points has 4 numbers: expected 3 in each row$/, () => renderer.shade([0, 0, 0, 0], [0, 1, 0])],
    [RangeError, /^points\[1\] is \[0, NaN, 0\]: expected finite numbers$/, () => renderer.shade([0, 0, 0, 0, NaN, 0], [0, 1, 0, 0, 1, 0])],
    [RangeError, /^normals has 1 rows: expected 2, one for each point$/, () => renderer.shade(new Float32Array(6), [0, 1, 0])],
    [RangeError, /^normals\[0\] is \[0, 0, 0\]: expected a direction$/, () => renderer.shade([0, 0, 0], [0, 0, 0])],
    [RangeError, /^views has 2 rows/, () => renderer.shade([0, 0, 0], [0, 1, 0], [0, 1, 0, 0, 1, 0])],
    [RangeError, /^faces has 0 rows/, () => renderer.shade([0, 0, 0], [0, 1, 0], null, { faces: [] })],
    [RangeError, /^objects has 2 rows/, () => renderer.shade([0, 0, 0], [0, 1, 0], null, { objects: [0, 0] })],
    [EditError, /^object 7 is not in the scene$/, () => renderer.shade([0, 0, 0], [0, 1, 0], null, { objects: [7] })],
    [EditError, /^material 9 is not in the scene$/, () => renderer.shade([0, 0, 0], [0, 1, 0], null, { material: 9 })],
    [TypeError, /^points is String: expected a typed array/, () => renderer.shade("here", [0, 1, 0])],
    [TypeError, /^face is no option: expected faces, material, objects$/, () => renderer.shade([0, 0, 0], [0, 1, 0], null, { face: [0, 1, 0] })],
    [TypeError, /^wide is no option/, () => renderer.render({ wide: 3 })],
    [TypeError, /^out is an array: expected a Float32Array$/, () => renderer.render({ out: [] })],
    [RangeError, /^out has 3 numbers: expected 6912/, () => renderer.render({ out: new Float32Array(3) })],
    [RangeError, /^window is \[60, 0, 8, 8\]: expected a part of 64 x 36 pixels$/, () => renderer.render({ window: [60, 0, 8, 8] })],
    [RangeError, /^size is 0: expected a whole number/, () => renderer.render({ width: 0, height: 4 })],
    [TypeError, /^size is undefined: expected a whole number/, () => renderer.render({ width: 8 })],
    [RangeError, /^layer "albedo": expected some of/, () => renderer.layers(["albedo"])],
    [EditError, /^light 3 is not in the scene$/, () => renderer.changeLight(3, { size: 1 })],
    [RangeError, /^size is 0: expected a number above 0$/, () => renderer.changeLight(0, { size: 0 })],
    [RangeError, /^center is \[0, Infinity, 0\]: expected finite numbers$/, () => renderer.changeLight(0, { center: [0, Infinity, 0] })],
    [TypeError, /^light is Object: expected a Light$/, () => renderer.setLight(0, { kind: "sphere" })],
    [EditError, /^no object is named "cube"$/, () => renderer.setVisible("cube", true)],
    [RangeError, /^matrix has 3 numbers: expected 16/, () => renderer.setTransform(0, [1, 2, 3])],
    [RangeError, /^matrix has the last row/, () => renderer.setTransform(0, Array(16).fill(1))],
    [EditError, /sphere/, () => renderer.setTransform("sphere", [1, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1])],
    [RangeError, /^tolerance is -1: expected a number above 0, 1 at most$/, () => renderer.setSettings({ tolerance: -1 })],
    [RangeError, /^method is "magic"/, () => renderer.setSettings({ method: "magic" })],
    [TypeError, /^tolerence is no option/, () => new Renderer(scene, { tolerence: 0.1 })],
    [TypeError, /^scene is Object: expected a Scene$/, () => new Renderer({})],
    [RangeError, /^time is -1/, () => renderer.seek(-1)],
    [RangeError, /^visibility is "magic": expected one of/, () => renderer.setVisibility(0, "magic")],
    [RangeError, /^positions\[0\] is \[NaN, 0, 0\]/, () => scene.addMesh([NaN, 0, 0], [])],
    [RangeError, /^triangles\[1\] names vertex 4, which does not exist: there are 4$/, () => scene.addMesh(CORNERS, [0, 1, 2, 2, 3, 4])],
    [RangeError, /^triangles\[0\] names vertex -1/, () => scene.addMesh(CORNERS, Int32Array.of(-1, 1, 2))],
    [RangeError, /^positions has 4 rows: expected three for each triangle$/, () => scene.addMesh(CORNERS, null)],
    [SceneError, /no triangles/, () => scene.addMesh(CORNERS, [])],
    [RangeError, /^uvs has 4 numbers|^uvs has 2 rows/, () => scene.addMesh(CORNERS, SQUARE, { uvs: [0, 0, 1, 1] })],
    [RangeError, /^normals\[3\] is \[0, 0, 0\]: expected a direction$/, () => scene.addMesh(CORNERS, SQUARE, { normals: [0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0] })],
    [SceneError, /^colour 0 is/, () => scene.addMesh(CORNERS, SQUARE, { colors: Array(12).fill(2) })],
    [RangeError, /^material 5 is not in the scene: there are 2$/, () => scene.addMesh(CORNERS, SQUARE, { material: 5 })],
    [RangeError, /^spheres\[0\]/, () => scene.addSpheres([0, 0, 0, -1])],
    [RangeError, /^radius is 0: expected a number above 0$/, () => Light.sphere([0, 1, 0], 0, { radiance: 1 })],
    [TypeError, /^expected exactly one of radiance, flux$/, () => Light.sphere([0, 1, 0], 1, {})],
    [TypeError, /^options are undefined: expected an object$/, () => Light.sphere([0, 1, 0], 1)],
    [RangeError, /^radiance is \[-1, -1, -1\]: expected finite numbers of at least 0$/, () => Light.ambient(-1)],
    [RangeError, /^angle is 100: expected a number from 0.001 to 90$/, () => Light.spot([0, 1, 0], [0, -1, 0], { intensity: 1, angle: 100 })],
    [RangeError, /corner/, () => scene.addLight(Light.polygon([[0, 0, 0], [1, 0, 0]], { radiance: 1 }))],
    [RangeError, /exponent/, () => scene.addMaterial(Material.phong({ kd: 0.1, exponent: 1e30 }))],
    [TypeError, /^c is no option: expected/, () => Material.halfVector([{ c: 1 }])],
    [RangeError, /^data has 1 rows: expected 2/, () => new Environment({ width: 2, height: 1, data: [1, 1, 1] })],
    [RangeError, /^projection is "fisheye": expected "perspective", "orthographic" or "panoramic"$/, () => new Camera([0, 0, 1], [0, 0, 0], { projection: "fisheye" })],
    [TypeError, /^height is undefined: expected a number$/, () => new Camera([0, 0, 1], [0, 0, 0], { projection: "orthographic" })],
    [RangeError, /^height is 0: expected a number from/, () => new Camera([0, 0, 1], [0, 0, 0], { projection: "orthographic", height: 0 })],
    [TypeError, /^fov is of perspective cameras: this one is panoramic$/, () => new Camera([0, 0, 1], [0, 0, 0], { projection: "panoramic", fov: 30 })],
    [SceneError, /camera eye and target/, () => renderer.setCamera(new Camera([0, 0, 0], [0, 0, 0]))],
    [SceneError, /^scene\.toml:2:\d+: kind: unknown kind of light/, () => Scene.load('[[lights]]\nkind = "lamp"\n')],
    [SceneError, /nothing\.glb/, () => Scene.load({ "a.toml": "" }, { path: "nothing.glb" })],
    [TypeError, /^files are 2, of which 2 may be the scene: path says which$/, () => Scene.load({ "a.toml": "", "b.toml": "" })],
    [TypeError, /^a\.toml is Number/, () => Scene.load({ "a.toml": 3 })],
    [TypeError, /^progress is Number: expected a function$/, () => renderer.render({ progress: 3 })],
    [RangeError, /^spp is 0: expected a whole number from 1/, () => renderer.reference({ spp: 0 })],
    [RangeError, /^roughness is 2: expected a number from 0 to 1$/, () => Material.metallicRoughness(1, { roughness: 2 })],
    [RangeError, /^clearcoat is 2: expected a number from 0 to 1$/, () => Material.metallicRoughness(1, { clearcoat: 2 })],
    [TypeError, /^color is Object: expected \{ width, height, data \} with bytes$/, () => Material.lambert(1).withImages({ color: { width: 1, height: 1, data: [1, 2, 3] } })],
    [RangeError, /^color has 1 bytes: expected 3 or 4 for each of 1 x 1 texels$/, () => Material.lambert(1).withImages({ color: { width: 1, height: 1, data: Uint8Array.of(1) } })],
    [TypeError, /^colour is no option/, () => Material.lambert(1).withImages({ colour: null })],
    [TypeError, /^material has images/, () => renderer.shade([0, 0, 0], [0, 1, 0], null, { material: Material.lambert(1).withImages({ roughness: { width: 1, height: 1, data: Uint8Array.of(1) } }) })],
    [TypeError, /^an environment without light/, () => new Environment(null)],
    [RangeError, /^radiance has 1 rows: expected 2/, () => exposed([1, 1, 1], { width: 2, height: 1 })],
    [RangeError, /magic/, () => exposed([1, 1, 1], { width: 1, height: 1, tone: "magic" })],
  ];
  for (const [kind, line, deed] of refusals) {
    assert.throws(deed, (error) => {
      assert.ok(error instanceof kind && error.name === kind.name && line.test(error.message) && !error.message.includes("\n"), `${line} ${error.name}: ${error.message}`);
      return true;
    });
  }
  assert.deepEqual(renderer.render(), before);
  assert.deepEqual(scene.objects, ["floor", "sphere"]);
  assert.equal(scene.materials.length, 2);
  // More memory than there is: an exception, and all still works.
  assert.throws(() => renderer.render({ width: 30000, height: 30000 }), (error) => error instanceof RenderError || error instanceof SceneError);
  renderer.setSize(...small);
  assert.deepEqual(renderer.render(), before);
});

test("memory is given back", () => {
  const scene = still();
  const renderer = new Renderer(scene);
  scene.free();
  scene.free();
  assert.throws(() => scene.size, (error) => error instanceof EditError && error.message === "the scene was freed");
  assert.ok(mean(renderer.render()) > 0, "the renderer has a copy");
  renderer.free();
  assert.throws(() => renderer.render(), /^EditError: the renderer was freed$/);
  // 1.2 MB of vertices, many times: 240 MB if they stayed.
  const positions = Float32Array.from({ length: 3 * 1e5 }, (_, k) => Math.sin(k));
  const begin = process.memoryUsage().rss;
  for (let k = 0; k < 200; k++) {
    const made = new Scene();
    made.addMesh(positions, [0, 1, 2]);
    made.free();
  }
  assert.ok(process.memoryUsage().rss - begin < 1e8, `${process.memoryUsage().rss - begin}`);
  if (Symbol.dispose) {
    const one = still();
    one[Symbol.dispose]();
    assert.throws(() => one.size, EditError);
  }
});

test("the module is fetched, whatever type the server says it has", async () => {
  const bytes = readFileSync(new URL(place("cosine-lobes.wasm")));
  const server = createServer(({ url }, answer) => {
    const type = url === "/typed.wasm" ? "application/wasm" : "application/octet-stream";
    answer.writeHead(url === "/none.wasm" ? 404 : 200, { "Content-Type": type }).end(bytes);
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  try {
    const at = `http://127.0.0.1:${server.address().port}`;
    for (const name of ["typed.wasm", "untyped.wasm"]) {
      const fresh = await import(`${place("engine.js")}?${name}`);
      await assert.rejects(fresh.init(`${at}/none.wasm`), /none\.wasm: 404/);
      await fresh.init(`${at}/${name}`);
      assert.equal(fresh.call({ do: "builtin" }).number, 1);
    }
    const fresh = await import(`${place("engine.js")}?bytes`);
    await fresh.init(bytes);
    assert.equal(fresh.call({ do: "builtin" }).number, 1);
  } finally {
    server.close();
  }
});

test("the types name what there is", () => {
  const types = readFileSync(new URL(place("index.d.ts")), "utf8");
  for (const [name, value] of Object.entries(library)) {
    assert.match(types, new RegExp(`export (class|function) ${name}\\b`));
    if (!/^class/.test(String(value))) continue;
    const body = types.match(new RegExp(`export class ${name}\\b[^]*?\\n(?=\\})|export class ${name}\\b.*\\{\\}`))[0];
    const members = [...Object.getOwnPropertyNames(value.prototype), ...Object.getOwnPropertyNames(value)];
    const known = (member) => new RegExp(`^ +(static |get |set |readonly )*${member}[(:]`, "m").test(body);
    for (const member of members.filter((member) => !["constructor", "length", "name", "prototype"].includes(member))) assert.ok(known(member), `${name}.${member}`);
    for (const [, member] of body.matchAll(/^ {2}(?:static |get )?(\w+)\(/gm)) assert.ok(member === "constructor" || members.includes(member), `${name}.${member} is not there`);
  }
  const all = JSON.parse(readFileSync(new URL(place("package.json"))));
  const version = readFileSync("Cargo.toml", "utf8").match(/^version = "(.*)"$/m)[1];
  assert.deepEqual([all.name, all.version, all.type, all.license], ["cosine-lobes", version, "module", "MIT OR Apache-2.0"]);
  for (const file of ["README.md", "LICENSE-MIT", "LICENSE-APACHE", "cosine-lobes.wasm"]) assert.ok(statSync(new URL(place(file))).size > 0);
});

const home = dirname(dirname(process.env.PACKAGE));
const has = (name) => (process.env.WITH ?? "").split(" ").includes(name);

test("the types compile", { skip: !(has("typescript") && has("three")) && "npm has no typescript and three" }, () => {
  const file = join(home, "types.mts");
  cpSync("web/tests/package_types.ts", file);
  const options = { noEmit: true, strict: true, target: "es2022", module: "nodenext", lib: ["es2022", "dom", "dom.iterable"], skipLibCheck: true, types: [] };
  writeFileSync(join(home, "tsconfig.json"), JSON.stringify({ compilerOptions: options, files: ["types.mts"] }));
  execFileSync(process.execPath, [join(home, "node_modules/typescript/bin/tsc"), "-p", home], { stdio: "inherit" });
});

test("the first example of the README runs", () => {
  const [, code] = readFileSync(new URL(place("README.md")), "utf8").match(/```js\n([^]*?)```/);
  const file = join(home, "first.mjs");
  writeFileSync(file, `${code}\nconsole.log(picture.length, light.length);\n`);
  assert.equal(execFileSync(process.execPath, [file], { encoding: "utf8" }), `${3 * 640 * 360} 3\n`);
});

test("examples run, and bake vertices of three.js", { skip: !has("three") && "npm has no three" }, async () => {
  console.log(execFileSync(process.execPath, [join(process.env.PACKAGE, "examples/picture.mjs")], { encoding: "utf8" }).trim());
  const { floor, knot } = await import(place("examples/three_bake.mjs"));
  const { position, color } = floor.geometry.attributes;
  assert.equal(color.count, position.count);
  assert.ok(color.array.every((value) => Number.isFinite(value) && value >= 0));
  // At a corner nothing is hidden of the sphere light above; under the knot most of it is.
  const at = (x, z) => Array.from({ length: position.count }, (_, k) => k).sort((a, b) => Math.hypot(position.getX(a) - x, position.getZ(a) - z) - Math.hypot(position.getX(b) - x, position.getZ(b) - z))[0];
  const [open, hidden] = [at(4, 4), at(-0.2, -0.2)].map((k) => color.getX(k));
  const toLight = [1.5 - 4, 4, 1 - 4];
  const lamp = (30 * 0.4 ** 2 * 4) / Math.hypot(...toLight) ** 3;
  assert.ok(open >= 0.999 * lamp && open < 1.5 * lamp, `${open} ${lamp}`);
  assert.ok(hidden < 0.7 * color.getX(at(1.5, 1.8)), `${hidden}`);
  assert.ok(mean(knot.geometry.attributes.color.array) > 0.05);
});
