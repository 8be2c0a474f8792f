import { color, direction, flag, number, oneColor, only, positive, vec3 } from "./args.js";
import { tagged } from "./engine.js";

/** Degrees under which the sun is seen. */
const SUN = 0.53;

/** A light. Immutable; angles are in degrees. */
export class Light {
  constructor(fields) {
    Object.assign(this, fields);
    Object.freeze(this);
  }

  /** As the module reads it. */
  toJSON() {
    const { kind, ...rest } = this;
    return tagged(kind, rest);
  }

  static sphere(center, radius, options) {
    only(options, "radiance", "flux");
    return new Light({ kind: "sphere", center: vec3("center", center), radius: positive("radius", radius), ...oneColor(options, "radiance", "flux") });
  }

  static point(center, options) {
    const { intensity, radius = 0.01 } = only(options, "intensity", "radius");
    return new Light({ kind: "point", center: vec3("center", center), radius: positive("radius", radius), intensity: color("intensity", intensity) });
  }

  static spot(center, along, options) {
    const { intensity, angle, inner = 0, radius = 0.01 } = only(options, "intensity", "angle", "inner", "radius");
    number("angle", angle, 1e-3, 90);
    return new Light({
      kind: "spot",
      center: vec3("center", center),
      direction: direction("direction", along),
      radius: positive("radius", radius),
      intensity: color("intensity", intensity),
      angle,
      inner: number("inner", inner, 0, angle),
    });
  }

  static rectangle(center, u, v, options) {
    const { twoSided = false } = only(options, "radiance", "flux", "twoSided");
    return new Light({
      kind: "rectangle",
      center: vec3("center", center),
      u: vec3("u", u),
      v: vec3("v", v),
      twoSided: flag("twoSided", twoSided),
      ...oneColor(options, "radiance", "flux"),
    });
  }

  static disc(center, normal, radius, options) {
    const { twoSided = false } = only(options, "radiance", "flux", "twoSided");
    return new Light({
      kind: "disc",
      center: vec3("center", center),
      normal: direction("normal", normal),
      radius: positive("radius", radius),
      twoSided: flag("twoSided", twoSided),
      ...oneColor(options, "radiance", "flux"),
    });
  }

  static polygon(corners, options) {
    const { twoSided = false } = only(options, "radiance", "flux", "twoSided");
    const all = Array.from(corners, (corner, k) => vec3(`corners[${k}]`, corner));
    return new Light({ kind: "polygon", corners: all, twoSided: flag("twoSided", twoSided), ...oneColor(options, "radiance", "flux") });
  }

  static tube(start, end, radius, options) {
    only(options, "radiance", "flux");
    return new Light({
      kind: "tube",
      start: vec3("start", start),
      end: vec3("end", end),
      radius: positive("radius", radius),
      ...oneColor(options, "radiance", "flux"),
    });
  }

  static sun(along, options) {
    const { angle = SUN } = only(options, "irradiance", "radiance", "angle");
    return new Light({
      kind: "sun",
      direction: direction("direction", along),
      angle: number("angle", angle, 1e-3, 120),
      ...oneColor(options, "irradiance", "radiance"),
    });
  }

  static ambient(radiance) {
    return new Light({ kind: "ambient", radiance: color("radiance", radiance) });
  }
}
