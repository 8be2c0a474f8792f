// The WebAssembly module, as functions of JavaScript values.

/** Makes an engine of a compiled module; `complain` is told why a call has failed. */
export async function engine(module, complain) {
  let fault = "";
  const page = {
    now: () => performance.now() / 1000,
    complain: (text, length) => {
      fault = decode(new Uint8Array(wasm.memory.buffer, text, length));
      complain?.(fault);
    },
    // Of the library, which a page does not use.
    progress: () => 0,
  };
  const { exports: wasm } = await WebAssembly.instantiate(module, { page });
  return { ...calls(wasm), fault: () => fault };
}

const decode = (bytes) => new TextDecoder().decode(bytes);

/** The functions of an instance, of JavaScript values. */
export function calls(wasm) {
  const give = (bytes) => {
    // Memory may grow, and its buffer is another one then.
    const at = wasm.reserve(bytes.length);
    new Uint8Array(wasm.memory.buffer, at, bytes.length).set(bytes);
  };
  const encode = (value) => new TextEncoder().encode(JSON.stringify(value));
  // A copy: the next call writes over it.
  const bytes = () => new Uint8Array(wasm.memory.buffer, wasm.reply(), wasm.reply_length()).slice();
  const parsed = () => (wasm.reply_length() ? JSON.parse(decode(bytes())) : null);
  const after = (call, read) => (call(), read());

  return {
    /** Gives a file, before the request that opens it. */
    putFile(name, data) {
      const path = new TextEncoder().encode(name);
      const all = new Uint8Array(path.length + data.length);
      all.set(path);
      all.set(data, path.length);
      give(all);
      wasm.put_file(path.length);
    },
    /** Does what is requested; throws a line for the user where that is not possible. */
    request(wish) {
      give(encode(wish));
      wasm.request();
      if (wasm.reply_length()) throw new Error(decode(bytes()));
    },
    /** The rows that so many hands shade next; null where all is done. */
    task: (hands) => after(() => wasm.task(hands), parsed),
    /** The radiance of one part of a task, as bytes. */
    shade: (task, part, of) => after(() => (give(encode(task)), wasm.shade(part, of)), bytes),
    /** The same by a function that is done later. */
    async shadeBy(shade, task, part, of) {
      give(encode(task));
      await shade(part, of);
      return bytes();
    },
    /** Takes the radiance of a part that another one has shaded. */
    putPart: (part, radiance) => (give(radiance), wasm.put_part(part)),
    finish: () => wasm.finish(),
    follow: () => wasm.follow(),
    /** Makes the picture anew: another one shades from now on. */
    redraw: () => wasm.redraw(),
    report: () => after(wasm.report, parsed),
    pixel: () => after(wasm.pixel, parsed),
    pixels: () => after(wasm.pixels, bytes),
    radiance: () => after(wasm.radiance, () => new Float32Array(bytes().buffer)),
    bytes: () => wasm.memory.buffer.byteLength,
  };
}
