// Arguments: numbers, vectors and arrays, each refused by its name.

const kind = (value) => (value === null ? "null" : Array.isArray(value) ? "an array" : (value?.constructor?.name ?? typeof value));

const show = (values) => `[${Array.from(values).join(", ")}]`;

/** Refuses options that mean nothing. */
export function only(options, ...names) {
  if (options === null || typeof options !== "object") throw new TypeError(`options are ${kind(options)}: expected an object`);
  for (const name of Object.keys(options)) {
    if (!names.includes(name)) throw new TypeError(`${name} is no option: expected ${names.join(", ")}`);
  }
  return options;
}

export function number(name, value, least = -Infinity, most = Infinity) {
  if (typeof value !== "number") throw new TypeError(`${name} is ${kind(value)}: expected a number`);
  if (Number.isFinite(value) && value >= least && value <= most) return value;
  const range = Number.isFinite(most) ? `a number from ${least} to ${most}` : Number.isFinite(least) ? `a number of at least ${least}` : "a finite number";
  throw new RangeError(`${name} is ${value}: expected ${range}`);
}

/** A number above 0. */
export function positive(name, value) {
  if (typeof value !== "number") throw new TypeError(`${name} is ${kind(value)}: expected a number`);
  if (Math.fround(value) > 0 && Number.isFinite(Math.fround(value))) return value;
  throw new RangeError(`${name} is ${value}: expected a number above 0`);
}

export function whole(name, value, least, most) {
  if (Number.isInteger(value) && value >= least && value <= most) return value;
  throw new (typeof value === "number" ? RangeError : TypeError)(`${name} is ${typeof value === "number" ? value : kind(value)}: expected a whole number from ${least} to ${most}`);
}

export function text(name, value) {
  if (typeof value === "string") return value;
  throw new TypeError(`${name} is ${kind(value)}: expected a string`);
}

export function flag(name, value) {
  if (typeof value === "boolean") return value;
  throw new TypeError(`${name} is ${kind(value)}: expected true or false`);
}

/** A function, or none. */
export function deed(name, value) {
  if (value === undefined || value === null) return null;
  if (typeof value === "function") return value;
  throw new TypeError(`${name} is ${kind(value)}: expected a function`);
}

/** Three finite numbers: an array, or anything that is iterated, as vectors and colours of three.js are. */
export function vec3(name, value) {
  if (typeof value?.[Symbol.iterator] !== "function" || typeof value === "string") throw new TypeError(`${name} is ${kind(value)}: expected three numbers`);
  const all = [...value];
  if (all.length !== 3) throw new RangeError(`${name} has ${all.length} numbers: expected three`);
  if (all.every((x) => typeof x === "number" && Number.isFinite(Math.fround(x)))) return all;
  throw new RangeError(`${name} is ${show(all)}: expected finite numbers`);
}

/** A vector of any length but 0, as a unit vector. */
export function direction(name, value) {
  const v = vec3(name, value);
  const length = Math.hypot(...v);
  if (length > 0) return v.map((x) => x / length);
  throw new RangeError(`${name} is ${show(v)}: expected a direction`);
}

/** Three numbers of at least 0, or one for grey. */
export function color(name, value) {
  const all = typeof value === "number" ? [value, value, value] : vec3(name, value);
  if (all.every((x) => x >= 0 && Number.isFinite(Math.fround(x)))) return all;
  throw new RangeError(`${name} is ${show(all)}: expected finite numbers of at least 0`);
}

/** The one of some options that is given; its name and its colour. */
export function oneColor(options, ...names) {
  const given = names.filter((name) => options[name] !== undefined);
  if (given.length !== 1) throw new TypeError(`expected exactly one of ${names.join(", ")}`);
  return { [given[0]]: color(given[0], options[given[0]]) };
}

const isList = (value) => Array.isArray(value) || (ArrayBuffer.isView(value) && !(value instanceof DataView));

/** Rows of finite numbers as float32. */
export function rows(name, value, width) {
  if (!isList(value)) throw new TypeError(`${name} is ${kind(value)}: expected a typed array or an array of numbers`);
  if (value.length % width !== 0) throw new RangeError(`${name} has ${value.length} numbers: expected ${width} in each row`);
  const all = value instanceof Float32Array ? value : Float32Array.from(value);
  const wrong = all.findIndex((x) => !Number.isFinite(x));
  if (wrong < 0) return all;
  const row = Math.floor(wrong / width);
  throw new RangeError(`${name}[${row}] is ${show(all.subarray(width * row, width * (row + 1)))}: expected finite numbers`);
}

/** The same, with as many rows as there are points. */
export function rowsFor(name, value, width, count) {
  const all = rows(name, value, width);
  if (all.length === width * count) return all;
  throw new RangeError(`${name} has ${all.length / width} rows: expected ${count}, one for each point`);
}

/** Three numbers of vertices for each triangle; without a list each three vertices are one. */
export function triangles(name, value, vertices) {
  if (value === null || value === undefined) {
    if (vertices % 3 !== 0) throw new RangeError(`positions has ${vertices} rows: expected three for each triangle`);
    return Uint32Array.from({ length: vertices }, (_, i) => i);
  }
  if (!isList(value)) throw new TypeError(`${name} is ${kind(value)}: expected a typed array or an array of numbers`);
  if (value.length % 3 !== 0) throw new RangeError(`${name} has ${value.length} numbers: expected 3 in each row`);
  for (let k = 0; k < value.length; k++) {
    if (!(Number.isInteger(value[k]) && value[k] >= 0 && value[k] < vertices)) {
      throw new RangeError(`${name}[${Math.floor(k / 3)}] names vertex ${value[k]}, which does not exist: there are ${vertices}`);
    }
  }
  return value instanceof Uint32Array ? value : Uint32Array.from(value);
}

/** Whole numbers, one for each point. */
export function numbersFor(name, value, count) {
  if (value.length !== count) throw new RangeError(`${name} has ${value.length} rows: expected ${count}, one for each point`);
  const wrong = value.findIndex((x) => !Number.isInteger(x));
  if (wrong >= 0) throw new RangeError(`${name}[${wrong}] is ${value[wrong]}: expected whole numbers`);
  return value instanceof Int32Array ? value : Int32Array.from(value);
}

/** A 4 × 4 matrix, column by column, as `Matrix4.elements` of three.js. */
export function matrix(name, value) {
  const all = Array.from(value?.elements ?? value ?? []);
  if (all.length !== 16) throw new RangeError(`${name} has ${all.length} numbers: expected 16, column by column`);
  if (all.every((x) => typeof x === "number" && Number.isFinite(Math.fround(x)))) return all;
  throw new RangeError(`${name}: expected finite numbers`);
}

/** The rows of a 3 × 3 matrix. */
export function matrix3(name, value) {
  if (!Array.isArray(value) || value.length !== 3) throw new TypeError(`${name} is ${kind(value)}: expected three rows of three numbers`);
  return value.map((row, k) => vec3(`${name}[${k}]`, row));
}

/** An image of bytes, as `ImageData` and the images of three.js are: so many a texel, one of several numbers. A copy. */
export function texels(name, value, widths) {
  const { width, height, data } = value ?? {};
  if (!(data instanceof Uint8Array || data instanceof Uint8ClampedArray)) throw new TypeError(`${name} is ${kind(value)}: expected { width, height, data } with bytes`);
  const count = whole(`${name}.width`, width, 1, 65536) * whole(`${name}.height`, height, 1, 65536);
  if (!widths.includes(data.length / count)) throw new RangeError(`${name} has ${data.length} bytes: expected ${widths.join(" or ")} for each of ${width} x ${height} texels`);
  return { width, height, data: data.slice() };
}

export function size(name, value) {
  if (!Array.isArray(value) || value.length !== 2) throw new TypeError(`${name} is ${kind(value)}: expected [width, height]`);
  return value.map((side) => whole(name, side, 1, 65536));
}

export { isList, kind };
