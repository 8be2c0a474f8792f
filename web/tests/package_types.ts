// Compiles, but for the lines that are marked: the types of the package.

import { Camera, Environment, Light, LobesError, Material, Renderer, Scene, exposed, init, type Pick, type Progress, type Settings, type Texels } from "cosine-lobes";
import { BoxGeometry, Color, Matrix4, Vector3 } from "three";

await init();
await init(new URL("file:///somewhere/cosine-lobes.wasm"));
const scene = new Scene({ size: [64, 36], camera: new Camera(new Vector3(0, 1, 5), [0, 0, 0], { fov: 40 }) });
const box = new BoxGeometry();
const number: number = scene.addMesh(box.attributes.position.array as Float32Array, box.index!.array as Uint16Array, {
  normals: box.attributes.normal.array as Float32Array,
  material: Material.lambert(new Color(0.5, 0.4, 0.3), { emission: 0.1 }),
  visibility: "silhouettes",
});
scene.addLight(Light.sun([0, -1, 0], { irradiance: 3 }));
scene.addLight(Light.rectangle([0, 3, 0], [1, 0, 0], [0, 0, 1], { flux: 20, twoSided: true }));
scene.setEnvironment(new Environment({ width: 2, height: 1, data: new Float32Array(6) }));
scene.size = [32, 18];
const settings: Partial<Settings> = { tolerance: 0.01, visibility: "rays" };
const renderer = new Renderer(scene, settings);
const picture: Float32Array = renderer.render({ width: 32, height: 18, window: [0, 0, 8, 8] });
const points: Float32Array = renderer.shade([0, 0, 0], [0, 1, 0], null, { material: 0, objects: "object 0" });
const layers: Record<string, Float32Array> = renderer.layers(["lights", "depth"]);
const listen: Progress = (stage, done) => void [stage === "shading", done.toFixed(2)];
const { beauty, stderr }: Record<string, Float32Array> = renderer.reference({ spp: 16, progress: listen });
const wood: Texels = { width: 1, height: 1, data: new Uint8ClampedArray(4) };
scene.addMaterial(Material.metallicRoughness(0.5, { clearcoat: 0.5 }).withImages({ color: wood, roughness: wood, normalScale: 2 }));
void [renderer.coverage(), renderer.render({ progress: listen }), beauty, stderr, new Environment(null, { ambient: 0.1 })];
const pick: Pick | null = renderer.pick(1, 2);
renderer.setTransform(number, new Matrix4().makeTranslation(1, 0, 0));
renderer.changeLight(0, { center: new Vector3(), size: 2 });
const bytes: ImageData["data"] = exposed(picture, { width: 8, height: 8, tone: "agx" });
const files = Renderer.load({ "a.toml": "", "b.obj": new Uint8Array(1) }, { path: "a.toml", tolerance: 0.02 });
void [points, layers, pick, bytes, files, LobesError];

// @ts-expect-error one of radiance and flux
Light.sphere([0, 0, 0], 1, {});
// @ts-expect-error both of them
Light.sphere([0, 0, 0], 1, { radiance: 1, flux: 1 });
// @ts-expect-error no such visibility
scene.addSpheres([0, 0, 0, 1], { visibility: "magic" });
// @ts-expect-error no such option
renderer.render({ wide: 3 });
// @ts-expect-error images are bytes
Material.lambert(1).withImages({ color: { width: 1, height: 1, data: new Float32Array(4) } });
// @ts-expect-error no such layer
renderer.layers(["albedo"]);
// @ts-expect-error lights are made by its functions
new Light({ kind: "sphere" });
