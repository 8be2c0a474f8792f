// Soft shadows and direct lighting by sums of cosine lobes: scenes of files or of arrays, pictures, and light at points.

import { color, deed, direction, flag, isList, kind, matrix, number, numbersFor, only, positive, rows, rowsFor, size, text, triangles, vec3, whole } from "./args.js";
import { EditError, LobesError, RenderError, SceneError, call, floats, free, held, hold, init } from "./engine.js";
import { Light } from "./light.js";
import { Material } from "./material.js";

export { EditError, Light, LobesError, Material, RenderError, SceneError, init };

/** A camera: perspective, orthographic or panoramic. Immutable. */
export class Camera {
  constructor(eye, target, options = {}) {
    const { up = [0, 1, 0], projection = "perspective", fov, height } = only(options, "up", "projection", "fov", "height");
    if (!["perspective", "orthographic", "panoramic"].includes(projection)) {
      throw new RangeError(`projection is ${JSON.stringify(projection)}: expected "perspective", "orthographic" or "panoramic"`);
    }
    this.eye = vec3("eye", eye);
    this.target = vec3("target", target);
    this.up = vec3("up", up);
    this.projection = projection;
    this.fov = ofKind("fov", fov ?? undefined, projection, "perspective", 35, 0.001, 179.9);
    this.height = ofKind("height", height ?? undefined, projection, "orthographic", undefined, 1e-9, 1e9);
    Object.freeze(this);
  }
}

/** A number that cameras of one projection have; null for others. */
function ofKind(name, value, projection, wanted, usual, least, most) {
  if (projection === wanted) return number(name, value ?? usual, least, most);
  if (value !== undefined) throw new TypeError(`${name} is of ${wanted} cameras: this one is ${projection}`);
  return null;
}

const cameraOf = ({ eye, target, up, projection, fov, height }) => new Camera(eye, target, { up, projection, fov, height });

/** Light from all around: one radiance, or an image in latitude and longitude. Immutable. */
export class Environment {
  constructor(radiance, options = {}) {
    const { strength = 1, up = [0, 1, 0], turn = 0, patches = 2, ambient } = only(options, "strength", "up", "turn", "patches", "ambient");
    if (radiance === null && ambient === undefined) throw new TypeError("an environment without light: expected radiance or ambient");
    const isImage = radiance !== null && typeof radiance === "object" && "data" in radiance;
    this.radiance = isImage || radiance === null ? null : color("radiance", radiance);
    this.image = isImage ? image(radiance) : null;
    this.ambient = color("ambient", ambient ?? 0);
    this.strength = color("strength", strength);
    this.up = direction("up", up);
    this.turn = number("turn", turn);
    this.patches = whole("patches", patches, 1, 16);
    Object.freeze(this);
  }
}

function image({ width, height, data }) {
  whole("width", width, 1, 65536);
  whole("height", height, 1, 65536);
  // A copy: the caller's array may change.
  return { width, height, data: rowsFor("data", data, 3, width * height).slice() };
}

function of(Class, name, value) {
  if (value instanceof Class) return value;
  throw new TypeError(`${name} is ${kind(value)}: expected a ${Class.name}`);
}

const environmentOf = (value) => (value === null ? null : of(Environment, "environment", value));

/** A material, the number of one, or none. */
function materialOf(value) {
  if (value === undefined || value === null) return null;
  if (value instanceof Material) return { own: value };
  if (Number.isInteger(value)) return { number: value };
  throw new TypeError(`material is ${kind(value)}: expected a Material or a number`);
}

/** The same for points, which have no texture coordinates. */
function withoutImages(material) {
  if (material?.own?.images) throw new TypeError("material has images: points have no coordinates for them");
  return material;
}

/** An object by its number or its name. */
function keyOf(value) {
  if (typeof value === "string") return { name: value };
  if (Number.isInteger(value)) return { number: value };
  throw new TypeError(`object is ${kind(value)}: expected a number or a name`);
}

function indexOf(name, value) {
  if (Number.isInteger(value)) return value;
  throw new TypeError(`${name} is ${kind(value)}: expected a number`);
}

function meshOf(positions, indices, { normals, uvs, colors, smooth = false }) {
  const points = rows("positions", positions, 3);
  const count = points.length / 3;
  if (normals && smooth) throw new TypeError("normals are given: smooth has no say");
  return {
    positions: points,
    indices: triangles("triangles", indices, count),
    normals: normals ? rowsFor("normals", normals, 3, count) : null,
    uvs: uvs ? rowsFor("uvs", uvs, 2, count) : null,
    colors: colors ? rowsFor("colors", colors, 3, count) : null,
    smooth: flag("smooth", smooth),
  };
}

const MESH = ["normals", "uvs", "colors", "smooth"];
const MANNER = ["material", "name", "visible", "visibility"];

function mannerOf({ name = null, visible = true, visibility = null, spheres = 64 }) {
  return {
    name: name === null ? null : text("name", name),
    visible: flag("visible", visible),
    visibility: visibility === null ? null : text("visibility", visibility),
    spheres: isList(spheres) ? { rows: rows("spheres", spheres, 4) } : { count: whole("spheres", spheres, 0, 100000) },
  };
}

/** The commands that add a mesh and spheres. */
function addMesh(positions, indices, options = {}) {
  only(options, ...MESH, ...MANNER, "spheres");
  return { do: "addMesh", mesh: meshOf(positions, indices, options), manner: mannerOf(options), material: materialOf(options.material) };
}

function addSpheres(spheres, options = {}) {
  only(options, ...MANNER);
  return { do: "addSpheres", rows: rows("spheres", spheres, 4), manner: mannerOf(options), material: materialOf(options.material) };
}

const ENDINGS = [".toml", ".glb", ".gltf", ".obj", ".ply"];

const bytesOf = (name, value) => {
  if (typeof value === "string") return new TextEncoder().encode(value);
  if (value instanceof ArrayBuffer) return new Uint8Array(value);
  if (ArrayBuffer.isView(value)) return new Uint8Array(value.buffer, value.byteOffset, value.byteLength);
  throw new TypeError(`${name} is ${kind(value)}: expected a Uint8Array, an ArrayBuffer or a string`);
};

/** Files by their names, and the name of the one that is the scene. */
function filesOf(files, path) {
  if (typeof files === "string" || files instanceof ArrayBuffer || ArrayBuffer.isView(files)) {
    const bytes = bytesOf("files", files);
    const begins = (magic) => new TextDecoder().decode(bytes.subarray(0, magic.length)) === magic;
    const name = path ?? (begins("glTF") ? "model.glb" : begins("ply") ? "model.ply" : "scene.toml");
    return [name, [[name, bytes]]];
  }
  if (files === null || typeof files !== "object") throw new TypeError(`files are ${kind(files)}: expected bytes, or an object of them`);
  const all = files instanceof Map ? [...files] : Object.entries(files);
  const ending = (known) => all.map(([name]) => name).filter((name) => name.toLowerCase().endsWith(known));
  const scenes = ENDINGS.map(ending).find((names) => names.length > 0) ?? [];
  if (path === undefined && scenes.length !== 1) throw new TypeError(`files are ${all.length}, of which ${scenes.length} may be the scene: path says which`);
  return [path ?? scenes[0], all.map(([name, bytes]) => [name, bytesOf(name, bytes)])];
}

/** Does something with a scene. */
const inScene = (scene, then) => call({ do: "scene", number: held(scene, "scene"), then });

/** Everything that a picture is made of: objects, materials, lights, a camera. */
export class Scene {
  constructor(options = {}) {
    only(options, "size", "camera", "background");
    hold(this, call({ do: "newScene" }).number);
    for (const name of ["size", "camera", "background"]) if (options[name] !== undefined) this[name] = options[name];
  }

  static #of(number, size) {
    const scene = Object.create(Scene.prototype);
    hold(scene, number);
    if (size !== undefined) scene.size = size;
    return scene;
  }

  static load(files, options = {}) {
    const { path, clip = null, size } = only(options, "path", "clip", "size");
    const [name, all] = filesOf(files, path === undefined ? undefined : text("path", path));
    return Scene.#of(call({ do: "load", path: name, clip, files: all }).number, size);
  }

  static builtin(options = {}) {
    const { size } = only(options, "size");
    return Scene.#of(call({ do: "builtin" }).number, size);
  }

  addMesh(positions, indices, options) {
    return inScene(this, addMesh(positions, indices, options)).number;
  }

  addSpheres(spheres, options) {
    return inScene(this, addSpheres(spheres, options)).number;
  }

  addMaterial(material) {
    return inScene(this, { do: "addMaterial", material: of(Material, "material", material) }).number;
  }

  addLight(light) {
    return inScene(this, { do: "addLight", light: of(Light, "light", light) }).number;
  }

  setEnvironment(environment) {
    inScene(this, { do: "setEnvironment", environment: environmentOf(environment) });
  }

  validate() {
    inScene(this, { do: "validate" });
  }

  get camera() {
    return cameraOf(inScene(this, { do: "state" }).camera);
  }

  set camera(camera) {
    inScene(this, { do: "setCamera", camera: of(Camera, "camera", camera) });
  }

  get size() {
    return inScene(this, { do: "state" }).size;
  }

  set size(value) {
    inScene(this, { do: "setSize", size: size("size", value) });
  }

  get background() {
    return inScene(this, { do: "state" }).background;
  }

  set background(background) {
    inScene(this, { do: "setBackground", background: color("background", background) });
  }

  get lights() {
    return inScene(this, { do: "state" }).lights;
  }

  get objects() {
    return inScene(this, { do: "state" }).objects;
  }

  get materials() {
    return inScene(this, { do: "state" }).materials;
  }

  get triangles() {
    return inScene(this, { do: "state" }).triangles;
  }

  get duration() {
    return inScene(this, { do: "state" }).duration;
  }

  get warnings() {
    return inScene(this, { do: "state" }).warnings;
  }

  free() {
    free(this);
  }
}

const SETTINGS = {
  tolerance: 0.005,
  depth: null,
  visibility: null,
  method: "moments",
  samples: null,
  ownRadiance: false,
  interpolate: false,
  threshold: 0,
  mapResolution: null,
  keepPoints: true,
};

/** Settings with changes, of the right types; the module checks their ranges. */
function settingsOf(before, changes) {
  const given = { ...only(changes, ...Object.keys(SETTINGS)) };
  for (const [name, value] of Object.entries(given)) {
    if (value === undefined) delete given[name];
    else if (value === null && SETTINGS[name] === null) continue;
    else if (name === "tolerance" || name === "threshold") number(name, value);
    else if (name === "ownRadiance" || name === "interpolate" || name === "keepPoints") flag(name, value);
    else if (name === "method" || name === "visibility") text(name, value);
    else whole(name, value, 0, 2 ** 31);
  }
  return Object.freeze({ ...before, ...given });
}

const windowOf = (value) => {
  if (value === undefined || value === null) return null;
  if (!isList(value) || value.length !== 4) throw new TypeError(`window is ${kind(value)}: expected [x, y, width, height]`);
  return Array.from(value, (side) => whole("window", side, 0, 65536));
};

/** Turns a scene, of which it has a copy, into pictures, and keeps what the next picture can use. */
export class Renderer {
  #settings;

  constructor(scene, settings = {}) {
    of(Scene, "scene", scene);
    this.#settings = settingsOf(SETTINGS, settings);
    hold(this, call({ do: "newRenderer", scene: held(scene, "scene"), settings: this.#settings }).number);
  }

  static load(files, options = {}) {
    const { path, clip, size, ...settings } = options;
    settingsOf(SETTINGS, settings);
    const scene = Scene.load(files, { path, clip, size });
    try {
      return new Renderer(scene, settings);
    } finally {
      scene.free();
    }
  }

  #do(then, read, progress) {
    return call({ do: "renderer", number: held(this, "renderer"), then }, read, progress);
  }

  get #state() {
    return this.#do({ do: "state" });
  }

  #resize({ width, height }) {
    if (width === undefined && height === undefined) return;
    const [before, after] = [this.size, size("size", [width, height])];
    if (after.some((side, k) => side !== before[k])) this.#do({ do: "setSize", size: after });
  }

  render(options = {}) {
    const { window, out, progress } = only(options, "width", "height", "window", "out", "progress");
    const [part, listener] = [windowOf(window), deed("progress", progress)];
    if (out !== undefined && !(out instanceof Float32Array)) throw new TypeError(`out is ${kind(out)}: expected a Float32Array`);
    this.#resize(options);
    if (out !== undefined) {
      const [width, height] = part ? part.slice(2) : this.size;
      if (out.length !== 3 * width * height) throw new RangeError(`out has ${out.length} numbers: expected ${3 * width * height}, three for each pixel`);
    }
    const read = (_, array) => {
      if (out === undefined) return floats(array());
      new Uint8Array(out.buffer, out.byteOffset, out.byteLength).set(array());
      return out;
    };
    return this.#do({ do: "render", window: part, listens: listener !== null }, read, listener);
  }

  layers(names = ["unshadowed", "lights", "normal", "depth"], options = {}) {
    const { window, progress } = only(options, "width", "height", "window", "progress");
    const [part, listener] = [windowOf(window), deed("progress", progress)];
    const wanted = Array.from(names, (name) => text("names", name));
    this.#resize(options);
    return this.#do({ do: "layers", names: wanted, window: part, listens: listener !== null }, arraysOf, listener);
  }

  coverage(options = {}) {
    const { window } = only(options, "width", "height", "window");
    const part = windowOf(window);
    this.#resize(options);
    return this.#do({ do: "coverage", window: part }, (_, array) => floats(array()));
  }

  reference(options = {}) {
    const { spp = 1024, seed = 0, progress } = only(options, "width", "height", "spp", "seed", "progress");
    const listener = deed("progress", progress);
    const ask = { do: "reference", spp: whole("spp", spp, 1, 2 ** 24), seed: whole("seed", seed, 0, 2 ** 32 - 1), listens: listener !== null };
    this.#resize(options);
    return this.#do(ask, arraysOf, listener);
  }

  #points(points, normals, views, options) {
    const { faces, material, objects } = only(options, "faces", "material", "objects");
    const all = rows("points", points, 3);
    const count = all.length / 3;
    const optional = (name, value) => (value === undefined || value === null ? null : rowsFor(name, value, 3, count));
    return {
      points: all,
      normals: rowsFor("normals", normals, 3, count),
      views: optional("views", views),
      faces: optional("faces", faces),
      material: withoutImages(materialOf(material)),
      objects: objects === undefined || objects === null ? null : isList(objects) ? { each: numbersFor("objects", objects, count) } : { all: keyOf(objects) },
    };
  }

  shade(points, normals, views, options = {}) {
    return this.#do({ do: "shade", ...this.#points(points, normals, views, options), layers: false }, (_, array) => floats(array()));
  }

  shadeLayers(points, normals, views, options = {}) {
    return this.#do({ do: "shade", ...this.#points(points, normals, views, options), layers: true }, arraysOf);
  }

  visibleFraction(point, normal, light) {
    return this.#do({ do: "visibleFraction", point: vec3("point", point), normal: direction("normal", normal), light: indexOf("light", light) });
  }

  pick(x, y) {
    return this.#do({ do: "pick", pixel: [whole("x", x, 0, 2 ** 31), whole("y", y, 0, 2 ** 31)] });
  }

  exposure() {
    return this.#do({ do: "exposure" });
  }

  seek(time) {
    this.#do({ do: "seek", time: number("time", time, 0) });
  }

  get lights() {
    return this.#state.lights;
  }

  get objects() {
    return this.#state.objects;
  }

  get materials() {
    return this.#state.materials;
  }

  get size() {
    return this.#state.size;
  }

  get camera() {
    return cameraOf(this.#state.camera);
  }

  get time() {
    return this.#state.time;
  }

  get stale() {
    return this.#state.stale;
  }

  get upkeep() {
    return this.#state.upkeep;
  }

  get seconds() {
    return this.#state.seconds;
  }

  get settings() {
    return this.#settings;
  }

  setSettings(changes) {
    const settings = settingsOf(this.#settings, changes);
    this.#do({ do: "setSettings", settings });
    this.#settings = settings;
  }

  light(light) {
    return this.#do({ do: "light", light: indexOf("light", light) });
  }

  setLight(light, replacement) {
    this.#do({ do: "setLight", light: indexOf("light", light), new: of(Light, "light", replacement) });
  }

  changeLight(light, changes) {
    const { center, direction: along, size, radiance } = only(changes, "center", "direction", "size", "radiance");
    const given = (value, read) => (value === undefined ? null : read(value));
    this.#do({
      do: "changeLight",
      light: indexOf("light", light),
      changes: {
        center: given(center, (v) => vec3("center", v)),
        direction: given(along, (v) => direction("direction", v)),
        size: given(size, (x) => positive("size", x)),
        radiance: given(radiance, (c) => color("radiance", c)),
      },
    });
  }

  addLight(light) {
    return this.#do({ do: "addLight", light: of(Light, "light", light) }).number;
  }

  removeLight(light) {
    this.#do({ do: "removeLight", light: indexOf("light", light) });
  }

  setEnvironment(environment) {
    this.#do({ do: "setEnvironment", environment: environmentOf(environment) });
  }

  object(object) {
    return this.#do({ do: "object", object: keyOf(object) });
  }

  addMesh(positions, indices, options) {
    return this.#do(addMesh(positions, indices, options)).number;
  }

  addSpheres(spheres, options) {
    return this.#do(addSpheres(spheres, options)).number;
  }

  setMesh(object, positions, indices, options = {}) {
    only(options, ...MESH);
    this.#do({ do: "setMesh", object: keyOf(object), mesh: meshOf(positions, indices, options) });
  }

  removeObject(object) {
    this.#do({ do: "removeObject", object: keyOf(object) });
  }

  setTransform(object, columns) {
    this.#do({ do: "setTransform", object: keyOf(object), matrix: matrix("matrix", columns) });
  }

  setVisible(object, visible) {
    this.#do({ do: "setVisible", object: keyOf(object), visible: flag("visible", visible) });
  }

  setVisibility(object, visibility) {
    this.#do({ do: "setVisibility", object: keyOf(object), visibility: visibility === null ? null : text("visibility", visibility) });
  }

  addMaterial(material) {
    return this.#do({ do: "addMaterial", material: of(Material, "material", material) }).number;
  }

  setMaterial(material, replacement) {
    this.#do({ do: "setMaterial", material: indexOf("material", material), new: of(Material, "material", replacement) });
  }

  setObjectMaterial(object, material) {
    this.#do({ do: "setObjectMaterial", object: keyOf(object), material: indexOf("material", material) });
  }

  setCamera(camera) {
    this.#do({ do: "setCamera", camera: of(Camera, "camera", camera) });
  }

  setSize(width, height) {
    this.#do({ do: "setSize", size: size("size", [width, height]) });
  }

  setBackground(background) {
    this.#do({ do: "setBackground", background: color("background", background) });
  }

  free() {
    free(this);
  }
}

// Browsers and Node before 24 may have no such symbol.
if (Symbol.dispose) {
  for (const Class of [Scene, Renderer]) Object.defineProperty(Class.prototype, Symbol.dispose, { value: Class.prototype.free });
}

/** Arrays by their names. */
function arraysOf(head, array) {
  return Object.fromEntries(Object.entries(head).map(([name, span]) => [name, floats(array(span))]));
}

/** A picture as a screen shows it, four bytes a pixel. */
export function exposed(radiance, options) {
  const { width, height, exposure = 0, tone = "soft" } = only(options, "width", "height", "exposure", "tone");
  const sides = size("size", [width, height]);
  const pixels = rowsFor("radiance", radiance, 3, width * height);
  const command = { do: "exposed", radiance: pixels, size: sides, exposure: number("exposure", exposure), tone: text("tone", tone) };
  return call(command, (_, array) => new Uint8ClampedArray(array().slice().buffer));
}
