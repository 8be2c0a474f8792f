// Renders a scene file, or the built-in scene, to linear radiance: node picture.mjs [scene.glb]

import { readFileSync } from "node:fs";
import { Renderer, Scene, init } from "cosine-lobes";

await init();
const path = process.argv[2];
const scene = path ? Scene.load(readFileSync(path), { path }) : Scene.builtin();
const renderer = new Renderer(scene, { tolerance: 0.01 });
scene.free();

const radiance = renderer.render({ width: 320, height: 180 });
console.log(`${radiance.length / 3} pixels in ${renderer.seconds.toFixed(2)} s, exposure ${renderer.exposure().toFixed(2)}`);

// A lamp moves: nothing is built again.
const [x, y, z] = renderer.light(0).center;
renderer.changeLight(0, { center: [x + 0.5, y, z] });
renderer.render({ out: radiance });
console.log(`again in ${renderer.seconds.toFixed(2)} s`);
renderer.free();
