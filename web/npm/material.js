import { color, matrix3, number, only, positive, texels, vec3 } from "./args.js";
import { tagged } from "./engine.js";

/** Images of colours or directions, and of one number a texel. */
const COLORS = ["color", "specular", "emission", "normal"];
const NUMBERS = ["roughness", "metallic"];

const black = (name, value) => (value === undefined ? [0, 0, 0] : color(name, value));

function glossy(model, options) {
  const { kd, ks, exponent, emission } = only(options, "kd", "ks", "exponent", "emission");
  return new Material({ model, kd: black("kd", kd), ks: black("ks", ks), exponent: positive("exponent", exponent), emission: black("emission", emission) });
}

/** How a surface reflects light, and what it emits. Immutable. */
export class Material {
  constructor(fields) {
    Object.assign(this, fields);
    Object.freeze(this);
  }

  /** As the module reads it. */
  toJSON() {
    const { model, emission, images = null, ...rest } = this;
    return { model: tagged(model, rest), emission, images };
  }

  /** The material with images, which its own values multiply. */
  withImages(options) {
    const { normalScale = 1, ...given } = only(options, ...COLORS, ...NUMBERS, "normalScale");
    const images = { ...this.images, normalScale: number("normalScale", normalScale, 0, 1e3) };
    for (const name of [...COLORS, ...NUMBERS]) {
      if (given[name] !== undefined && given[name] !== null) images[name] = texels(name, given[name], NUMBERS.includes(name) ? [1, 3, 4] : [3, 4]);
    }
    return new Material({ ...this, images });
  }

  static lambert(albedo, options = {}) {
    const { emission } = only(options, "emission");
    return new Material({ model: "lambert", albedo: color("albedo", albedo), emission: black("emission", emission) });
  }

  static phong(options) {
    return glossy("phong", options);
  }

  static modifiedPhong(options) {
    return glossy("modifiedPhong", options);
  }

  static neumann(options) {
    return glossy("neumann", options);
  }

  static lafortune(lobes, options = {}) {
    const { diffuse, emission } = only(options, "diffuse", "emission");
    const all = Array.from(lobes, (lobe) => {
      const { exponent, scale, c, matrix } = only(lobe, "exponent", "scale", "c", "matrix");
      if ((c === undefined) === (matrix === undefined)) throw new TypeError("expected exactly one of c, matrix");
      const [x, y, z] = c === undefined ? [] : vec3("c", c);
      const rows = c === undefined ? matrix3("matrix", matrix) : [[x, 0, 0], [0, y, 0], [0, 0, z]];
      return { exponent: positive("exponent", exponent), scale: color("scale", scale), matrix: rows };
    });
    return new Material({ model: "lafortune", diffuse: black("diffuse", diffuse), lobes: all, emission: black("emission", emission) });
  }

  static halfVector(lobes, options = {}) {
    const { diffuse, emission } = only(options, "diffuse", "emission");
    const all = Array.from(lobes, (lobe) => {
      const { roughness, f0, f90 = 1 } = only(lobe, "roughness", "f0", "f90");
      return { roughness: number("roughness", roughness, 0, 1), f0: color("f0", f0), f90: color("f90", f90) };
    });
    return new Material({ model: "halfVector", diffuse: black("diffuse", diffuse), lobes: all, emission: black("emission", emission) });
  }

  static metallicRoughness(base, options = {}) {
    const keys = ["metallic", "roughness", "ior", "f0", "clearcoat", "clearcoatRoughness", "emission"];
    const { metallic = 1, roughness = 1, ior, f0, clearcoat = 0, clearcoatRoughness = 0, emission } = only(options, ...keys);
    if (ior !== undefined && f0 !== undefined) throw new TypeError("expected one of ior, f0");
    const ofIor = (ior) => Array(3).fill(((number("ior", ior, 1, 1e6) - 1) / (ior + 1)) ** 2);
    return new Material({
      model: "metallicRoughness",
      base: color("base", base),
      metallic: number("metallic", metallic, 0, 1),
      roughness: number("roughness", roughness, 0, 1),
      f0: ior !== undefined ? ofIor(ior) : f0 !== undefined ? color("f0", f0) : null,
      clearcoat: number("clearcoat", clearcoat, 0, 1),
      clearcoatRoughness: number("clearcoatRoughness", clearcoatRoughness, 0, 1),
      emission: black("emission", emission),
    });
  }
}
