/**
 * Soft shadows and direct lighting by sums of cosine lobes, in Node and in browsers: pictures of scenes, and light at points.
 *
 * Units are those of the scene: radiance in W·m⁻²·sr⁻¹, flux in W, intensity in W·sr⁻¹, irradiance in W·m⁻². Colours are linear, three
 * numbers or one for grey. Angles are in degrees. Everything that is refused throws: `TypeError` and `RangeError` name the argument,
 * a `LobesError` has the one-line message of the library.
 */

/** Three numbers: an array, or anything that gives three when it is iterated, as `Vector3` and `Color` of three.js do. */
export type Vec3 = Iterable<number>;

/** A linear colour: three numbers of at least 0, or one for grey. */
export type Color = number | Iterable<number>;

/** Numbers in rows; float32 arrays are taken as they are, others are converted. */
export type Numbers = Float32Array | Float64Array | readonly number[];

/** Whole numbers. */
export type Integers = Uint32Array | Uint16Array | Uint8Array | Int32Array | readonly number[];

/** An image of bytes, the upper row first, as `ImageData` and the images of three.js are. */
export interface Texels {
  readonly width: number;
  readonly height: number;
  readonly data: Uint8Array | Uint8ClampedArray;
}

/**
 * Hears of the work: "spheres" are fitted, the paper's "tables" computed, pixels are in "shading", the reference is "sampling"; `done` is in
 * [0, 1]. It must not call the library. An exception of it stops the work and comes out of the call; everything that is kept stays.
 */
export type Progress = (stage: "spheres" | "tables" | "shading" | "sampling", done: number) => void;

/** How an object blocks light. */
export type Visibility = "silhouettes" | "spheres" | "shadow-map" | "rays" | "none";

/** A scene file or a model with the files that it names, by their paths; or the bytes of one file, or its text. */
export type Files = Uint8Array | ArrayBuffer | string | Record<string, Uint8Array | ArrayBuffer | string> | Map<string, Uint8Array | ArrayBuffer | string>;

/**
 * Loads the WebAssembly module, once for a thread; to be awaited before all else. Without a source it is `cosine-lobes.wasm` beside this
 * file, read by Node or fetched.
 *
 * @param source The module, its bytes, a response that has them, or where they are.
 */
export function init(source?: WebAssembly.Module | ArrayBuffer | Uint8Array | Response | URL | string): Promise<void>;

/** Any error of the library. */
export class LobesError extends Error {}

/** A scene, a file of one, or a part of it is refused. */
export class SceneError extends LobesError {}

/** An edit is refused; the renderer stays the same. Also thrown where something is used that was freed. */
export class EditError extends LobesError {}

/** A picture could not be made. */
export class RenderError extends LobesError {}

/** How a camera maps the scene to its picture. A panoramic one shows all directions by longitude and latitude. */
export type Projection = "perspective" | "orthographic" | "panoramic";

/** A camera. Immutable. */
export class Camera {
  /**
   * @param options.up roughly up; [0, 1, 0] if left out.
   * @param options.projection "perspective" if left out.
   * @param options.fov of a perspective camera the full vertical field of view in degrees, 0.001 to 179.9; 35 if left out.
   * @param options.height of an orthographic camera the height of the picture in units of the scene; required.
   */
  constructor(eye: Vec3, target: Vec3, options?: { up?: Vec3; projection?: Projection; fov?: number | null; height?: number | null });
  readonly eye: readonly number[];
  readonly target: readonly number[];
  readonly up: readonly number[];
  readonly projection: Projection;
  readonly fov: number | null;
  readonly height: number | null;
}

type Radiant = { radiance: Color; flux?: undefined } | { radiance?: undefined; flux: Color };

/** A light. Immutable. */
export class Light {
  private constructor(fields: object);
  readonly kind: string;
  toJSON(): unknown;
  /** A sphere. */
  static sphere(center: Vec3, radius: number, options: Radiant): Light;
  /** A small sphere, by its intensity; `radius` is 0.01 if left out. */
  static point(center: Vec3, options: { intensity: Color; radius?: number }): Light;
  /** A small sphere that shines into a cone: fully within `inner` degrees of the axis (0 if left out), not at all beyond `angle` (90 at most). */
  static spot(center: Vec3, direction: Vec3, options: { intensity: Color; angle: number; inner?: number; radius?: number }): Light;
  /** A rectangle, `center` ± `u` ± `v`, that shines toward `u` × `v`. */
  static rectangle(center: Vec3, u: Vec3, v: Vec3, options: Radiant & { twoSided?: boolean }): Light;
  /** A disc that shines toward its normal. */
  static disc(center: Vec3, normal: Vec3, radius: number, options: Radiant & { twoSided?: boolean }): Light;
  /** A convex polygon that shines to the side from which its corners are seen counter-clockwise. */
  static polygon(corners: Iterable<Vec3>, options: Radiant & { twoSided?: boolean }): Light;
  /** A tube with round ends. */
  static tube(start: Vec3, end: Vec3, radius: number, options: Radiant): Light;
  /** A light at infinity that shines along `direction`, seen under `angle` degrees: 0.53, those of the sun, if left out. */
  static sun(direction: Vec3, options: ({ irradiance: Color; radiance?: undefined } | { irradiance?: undefined; radiance: Color }) & { angle?: number }): Light;
  /** The same radiance from everywhere, which nothing hides. */
  static ambient(radiance: Color): Light;
}

type Glossy = { kd?: Color; ks?: Color; exponent: number; emission?: Color };

/** How a surface reflects light, and what it emits. Immutable. */
export class Material {
  private constructor(fields: object);
  readonly model: string;
  toJSON(): unknown;
  readonly emission: readonly number[];
  /**
   * The material with images, which its own values multiply. They lie by the `uvs` of meshes, v downward, and repeat. `color`, `specular` and
   * `emission` are sRGB; they and the `normal` map have three or four bytes a texel, of which the fourth has no say. `roughness` and
   * `metallic` have one, or as in glTF several, of which roughness is green and metallic blue. `normalScale` multiplies x and y of the
   * normal map. A material without emission emits what its image says.
   */
  withImages(images: {
    color?: Texels | null;
    specular?: Texels | null;
    emission?: Texels | null;
    normal?: Texels | null;
    roughness?: Texels | null;
    metallic?: Texels | null;
    normalScale?: number;
  }): Material;
  /** Ideally diffuse. */
  static lambert(albedo: Color, options?: { emission?: Color }): Material;
  /** The paper's Phong model, without a cosine on the specular term. */
  static phong(options: Glossy): Material;
  /** Normalised Phong. */
  static modifiedPhong(options: Glossy): Material;
  /** Metals after Neumann et al. */
  static neumann(options: Glossy): Material;
  /** Lafortune: each lobe by three numbers `c`, or by the rows of a 3 × 3 `matrix`. */
  static lafortune(
    lobes: Iterable<{ exponent: number; scale: Color; c?: Vec3; matrix?: readonly (readonly number[])[] }>,
    options?: { diffuse?: Color; emission?: Color },
  ): Material;
  /** Lobes about the half vector; `f90` is 1 if left out. */
  static halfVector(lobes: Iterable<{ roughness: number; f0: Color; f90?: Color }>, options?: { diffuse?: Color; emission?: Color }): Material;
  /**
   * glTF's metallic–roughness model, both 1 if left out; its coat has a refractive index (1.5 if left out), or reflects `f0` at normal
   * incidence. A clear coat of a weight, 0 if left out, lies over all.
   */
  static metallicRoughness(
    base: Color,
    options?: { metallic?: number; roughness?: number; ior?: number; f0?: Color; clearcoat?: number; clearcoatRoughness?: number; emission?: Color },
  ): Material;
}

/** Light from all around. Immutable. */
export class Environment {
  /**
   * @param radiance one radiance, or an image in latitude and longitude: three numbers a pixel, the top row first; null: `ambient` alone.
   * @param options.strength a factor of it; 1 if left out.
   * @param options.up where the top of the image is; [0, 1, 0] if left out.
   * @param options.turn degrees by which it is turned about `up`.
   * @param options.patches patches along each side of a cube around the scene, 1 to 16; 2 if left out.
   * @param options.ambient more radiance from everywhere, which objects hide but which is not seen behind them; none if left out.
   */
  constructor(
    radiance: Color | { width: number; height: number; data: Numbers } | null,
    options?: { strength?: Color; up?: Vec3; turn?: number; patches?: number; ambient?: Color },
  );
}

/** What an object is but its shape. */
export interface ObjectOptions {
  /** A material, or the number of one; grey if left out. */
  material?: Material | number;
  /** `object` and its number if left out. */
  name?: string;
  /** Whether the camera sees it; true if left out. */
  visible?: boolean;
  /** How it blocks light; if left out meshes by silhouettes, and spheres as what they are. */
  visibility?: Visibility;
}

/** Arrays of a mesh beside its positions and triangles, as many rows as there are vertices. */
export interface MeshArrays {
  /** Three numbers a vertex, of any length but 0. Without them faces are flat, unless the mesh is `smooth`. */
  normals?: Numbers | null;
  /** Two numbers a vertex. */
  uvs?: Numbers | null;
  /** Three linear numbers in [0, 1] a vertex: factors of the material's colour. */
  colors?: Numbers | null;
  /** Whether normals are made that are smooth; false if left out. */
  smooth?: boolean;
}

/** Options of a mesh. */
export interface MeshOptions extends ObjectOptions, MeshArrays {
  /** For the visibility "spheres": how many are fitted to it (64 if left out), or rows of x, y, z and radius. */
  spheres?: number | Numbers;
}

/** The numbers of a light. */
export interface LightState {
  /** Its kind: sphere, flat, tube, sun, spot, environment, ambient … */
  kind: string;
  /** Its middle; null of suns, skies and ambient light. */
  center: [number, number, number] | null;
  /** The unit direction in which it shines; null of those that shine to all sides. */
  direction: [number, number, number] | null;
  /** Its radius, or that of a circle around it; of a sun half its angle, in radians. */
  size: number | null;
  radiance: [number, number, number];
}

/**
 * Everything that a picture is made of: objects, materials, lights, a camera. Objects, lights and materials are numbers, in the order in
 * which they came. Its memory is that of the module: `free` gives it back, or the garbage collector at some time.
 */
export class Scene {
  /** An empty scene; its pictures have 960 × 540 pixels unless `size` says otherwise. */
  constructor(options?: { size?: readonly [number, number]; camera?: Camera; background?: Color });
  /**
   * Loads a scene file (.toml) or a model (.glb, .gltf, .obj, .ply), as the command does: a model gets a floor, lights and, where it has
   * none, a camera.
   *
   * @param options.path which of the files is the scene; may be left out where one alone can be it. Of bytes alone it says their kind: without
   * it they are a .glb, a .ply or, else, a scene file.
   * @param options.clip the clip of a glTF file that is played: its name or number.
   */
  static load(files: Files, options?: { path?: string; clip?: string; size?: readonly [number, number] }): Scene;
  /** The scene that needs no file. */
  static builtin(options?: { size?: readonly [number, number] }): Scene;
  /**
   * Adds a mesh, and returns its number. Triangles without an area are left out.
   *
   * @param positions three numbers a vertex.
   * @param triangles three numbers of vertices for each triangle; null: each three vertices are one.
   */
  addMesh(positions: Numbers, triangles: Integers | null, options?: MeshOptions): number;
  /** Adds exact spheres, rows of x, y, z and radius, and returns their number as one object. */
  addSpheres(spheres: Numbers, options?: ObjectOptions): number;
  /** Adds a material, and returns its number. */
  addMaterial(material: Material): number;
  /** Adds a light, and returns its number. */
  addLight(light: Light): number;
  /** Replaces the environment, or takes it away. */
  setEnvironment(environment: Environment | null): void;
  /** Checks everything that a renderer relies on; throws a `SceneError`. */
  validate(): void;
  get camera(): Camera;
  set camera(camera: Camera);
  /** Width and height of pictures. */
  get size(): [number, number];
  set size(size: readonly [number, number]);
  /** Radiance where the camera sees nothing. */
  get background(): [number, number, number];
  set background(background: Color);
  /** The lights, those of the environment included. */
  get lights(): LightState[];
  /** The names of the objects. */
  get objects(): string[];
  /** The names of the materials' models. */
  get materials(): string[];
  /** The number of triangles. */
  get triangles(): number;
  /** Seconds of the animation; 0 if nothing moves. */
  get duration(): number;
  /** One line for each thing that was left out or replaced while loading. */
  get warnings(): string[];
  /** Gives its memory back. Renderers of it stay. Also `Symbol.dispose`, where there is one. */
  free(): void;
}

/** How a renderer makes its pictures; the defaults are those of `lobes render`. */
export interface Settings {
  /** Mean error of penumbrae, as a fraction, above 0, 1 at most; 0.005. */
  tolerance: number;
  /** Depth of the masks, 1 to 6; null: as the tolerance takes it. */
  depth: number | null;
  /** How all objects block light; null or "scene": each as it says. */
  visibility: Visibility | "scene" | null;
  /** "moments", "lobes" or "paper". */
  method: "moments" | "lobes" | "paper";
  /** Camera rays of each pixel; null: one, and eight where an outline crosses it. */
  samples: number | null;
  /** Whether the tolerance is relative to each pixel's own radiance; false. */
  ownRadiance: boolean;
  /** Whether visible fractions are interpolated between pixels where that is safe, under eight lights and more; false. */
  interpolate: boolean;
  /** Contributions of less radiance are dropped; 0. */
  threshold: number;
  /** Texels along a side of shadow maps; null: what the light's width takes. */
  mapResolution: number | null;
  /** Whether visible points are kept for a next picture that sees the same; true. */
  keepPoints: boolean;
}

/** The surface that a pixel shows. */
export interface Pick {
  object: number;
  name: string;
  /** The light whose surface it is; null if none. */
  light: number | null;
  material: number;
  position: [number, number, number];
  normal: [number, number, number];
  /** The unit direction toward the eye. */
  view: [number, number, number];
  distance: number;
}

/** An object of a renderer. */
export interface ObjectState {
  number: number;
  name: string;
  material: number;
  /** The matrix that has moved it, column by column. */
  transform: number[];
}

type PartOptions = {
  /** Width and height of pictures from now on; both or none. */
  width?: number;
  height?: number;
  /** A part of the picture alone: left column, upper row, width, height. Its pixels are those of the whole picture, bit for bit. */
  window?: readonly [number, number, number, number] | null;
};

type PointOptions = {
  /** Normals of the triangles, where `normals` are smooth ones. */
  faces?: Numbers | null;
  /** A material, or the number of one of the scene; white and diffuse if left out, so that π times the result is the irradiance. */
  material?: Material | number;
  /** The object that the points are on, or a number for each, −1 for none. */
  objects?: number | string | Integers | null;
};

/**
 * Turns a scene, which it copies, into pictures, and keeps what the next picture can use: an edit is checked first, and the next picture
 * makes again only what the edit has made stale. Lights, objects and materials are numbers: those of the scene at first, new ones for what
 * is added; no number is used twice. Objects may be named as well.
 *
 * Everything is computed on the calling thread, which waits: in a page by a worker.
 */
export class Renderer {
  constructor(scene: Scene, settings?: Partial<Settings>);
  /** As `new Renderer(Scene.load(files, …), settings)`. */
  static load(files: Files, options?: { path?: string; clip?: string; size?: readonly [number, number] } & Partial<Settings>): Renderer;
  /** Renders the picture: linear radiance, three numbers a pixel, the top row first. With `out` into that array. */
  render(options?: PartOptions & { out?: Float32Array; progress?: Progress | null }): Float32Array;
  /**
   * Renders the picture with its layers: "beauty", and by `names` "unshadowed", "lights" (as "light0", "light1" …), "normal" (three numbers a
   * pixel), "depth" and "object" (one; −1 where there is none).
   */
  layers(
    names?: Iterable<"unshadowed" | "lights" | "normal" | "depth" | "object">,
    options?: PartOptions & { progress?: Progress | null },
  ): Record<string, Float32Array>;
  /** The fraction of each pixel that shows a surface: one number a pixel; the rest shows the background. */
  coverage(options?: PartOptions): Float32Array;
  /**
   * The same picture by Monte Carlo, with shadow rays on the true surfaces: "beauty", "unshadowed", and "stderr", the standard error of
   * "beauty", three numbers a pixel.
   *
   * @param options.spp samples of each light for each camera ray; 1024 if left out.
   * @param options.seed chooses the samples; 0 if left out.
   */
  reference(options?: {
    width?: number;
    height?: number;
    spp?: number;
    seed?: number;
    progress?: Progress | null;
  }): { beauty: Float32Array; unshadowed: Float32Array; stderr: Float32Array };
  /**
   * The radiance that points reflect toward `views` (their normals if left out), three numbers a point, in their order: at the points of a
   * picture what the picture has, without emission.
   *
   * @param points three numbers a point; `normals` and `views` three as well, of any length but 0.
   */
  shade(points: Numbers, normals: Numbers, views?: Numbers | null, options?: PointOptions): Float32Array;
  /** As `shade`: "beauty", "unshadowed", and "light0", "light1" …, the part of each light. */
  shadeLayers(points: Numbers, normals: Numbers, views?: Numbers | null, options?: PointOptions): Record<string, Float32Array>;
  /** The visible fraction of a light for a white diffuse surface at a point, for red, green and blue. */
  visibleFraction(point: Vec3, normal: Vec3, light: number): [number, number, number];
  /** The surface at the centre of a pixel; null where the camera sees nothing. */
  pick(x: number, y: number): Pick | null;
  /** The exposure, in stops, that shows the scene well. */
  exposure(): number;
  /** Moves the animation to a time in seconds. */
  seek(time: number): void;
  /** The numbers of the lights, those of the environment included. */
  get lights(): number[];
  /** The numbers of the objects. */
  get objects(): number[];
  /** The numbers of the materials. */
  get materials(): number[];
  /** Width and height of pictures. */
  get size(): [number, number];
  get camera(): Camera;
  get time(): number;
  /** The kinds of results that edits have made stale since the last picture. */
  get stale(): string[];
  /** How often the data that is kept between pictures was built or updated so far. */
  get upkeep(): Record<string, number>;
  /** Seconds of the last picture. */
  get seconds(): number;
  get settings(): Readonly<Settings>;
  setSettings(changes: Partial<Settings>): void;
  light(light: number): LightState;
  /** Replaces a light. A light that moves rebuilds nothing. */
  setLight(light: number, replacement: Light): void;
  /** Changes a light's numbers: with another `size` its power stays. Numbers that its kind has not are left out. */
  changeLight(light: number, changes: { center?: Vec3; direction?: Vec3; size?: number; radiance?: Color }): void;
  addLight(light: Light): number;
  removeLight(light: number): void;
  /** Replaces the environment, or takes it away. */
  setEnvironment(environment: Environment | null): void;
  object(object: number | string): ObjectState;
  addMesh(positions: Numbers, triangles: Integers | null, options?: MeshOptions): number;
  addSpheres(spheres: Numbers, options?: ObjectOptions): number;
  /** Gives an object another mesh, in world space. */
  setMesh(object: number | string, positions: Numbers, triangles: Integers | null, options?: MeshArrays): void;
  removeObject(object: number | string): void;
  /** Moves an object from the place at which it was added, by a 4 × 4 matrix, column by column, or a `Matrix4` of three.js. */
  setTransform(object: number | string, matrix: Numbers | { elements: ArrayLike<number> }): void;
  /** Shows an object to the camera, or hides it. */
  setVisible(object: number | string, visible: boolean): void;
  /** Sets how an object blocks light; null for the usual way. */
  setVisibility(object: number | string, visibility: Visibility | null): void;
  addMaterial(material: Material): number;
  setMaterial(material: number, replacement: Material): void;
  /** Gives an object another material. */
  setObjectMaterial(object: number | string, material: number): void;
  setCamera(camera: Camera): void;
  setSize(width: number, height: number): void;
  setBackground(background: Color): void;
  /** Gives its memory back. Also `Symbol.dispose`, where there is one. */
  free(): void;
}

/**
 * A picture as a screen shows it, for `ImageData`: four bytes a pixel, brighter by `exposure` stops, through a tone map ("soft" if left out).
 * Its type is that of an array with its own memory, in all versions of TypeScript.
 */
export function exposed(
  radiance: Numbers,
  options: { width: number; height: number; exposure?: number; tone?: "soft" | "linear" | "neutral" | "agx" },
): ReturnType<Uint8ClampedArray["slice"]>;
