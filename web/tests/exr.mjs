// The simplest OpenEXR file: floats, not compressed (https://openexr.com/en/latest/OpenEXRFileLayout.html).

/** The file of linear RGB, row by row from the top. */
export function exr(width, height, radiance) {
  const text = (value) => Buffer.from(`${value}\0`);
  const ints = (...values) => Buffer.from(Int32Array.from(values).buffer);
  const attribute = (name, type, value) => Buffer.concat([text(name), text(type), ints(value.length), value]);
  const channel = (name) => Buffer.concat([text(name), ints(2, 0, 1, 1)]);
  const box = ints(0, 0, width - 1, height - 1);
  const one = Buffer.from(Float32Array.of(1).buffer);
  const header = Buffer.concat([
    ints(20000630, 2),
    attribute("channels", "chlist", Buffer.concat([channel("B"), channel("G"), channel("R"), Buffer.of(0)])),
    attribute("compression", "compression", Buffer.of(0)),
    attribute("dataWindow", "box2i", box),
    attribute("displayWindow", "box2i", box),
    attribute("lineOrder", "lineOrder", Buffer.of(0)),
    attribute("pixelAspectRatio", "float", one),
    attribute("screenWindowCenter", "v2f", Buffer.from(Float32Array.of(0, 0).buffer)),
    attribute("screenWindowWidth", "float", one),
    Buffer.of(0),
  ]);
  const line = 8 + 12 * width;
  const offsets = BigUint64Array.from({ length: height }, (_, row) => BigInt(header.length + 8 * height + row * line));
  const rows = Array.from({ length: height }, (_, row) => {
    const values = new Float32Array(3 * width);
    // Channel by channel, in the order of their names.
    for (let k = 0; k < 3; k++) for (let x = 0; x < width; x++) values[k * width + x] = radiance[3 * (row * width + x) + 2 - k];
    return Buffer.concat([ints(row, 12 * width), Buffer.from(values.buffer)]);
  });
  return Buffer.concat([header, Buffer.from(offsets.buffer), ...rows]);
}
