// The WebAssembly module: one for all scenes and renderers of this thread.

/** Any error of the library; its message is one line. */
export class LobesError extends Error {
  static {
    this.prototype.name = "LobesError";
  }
}

/** A scene, a file of one, or a part of it is refused. */
export class SceneError extends LobesError {
  static {
    this.prototype.name = "SceneError";
  }
}

/** An edit is refused; the renderer stays the same. */
export class EditError extends LobesError {
  static {
    this.prototype.name = "EditError";
  }
}

/** A picture could not be made. */
export class RenderError extends LobesError {
  static {
    this.prototype.name = "RenderError";
  }
}

const CLASSES = { SceneError, EditError, RenderError, RangeError, TypeError };

let wasm = null;
let starting = null;
/** Why the module works no more. */
let stopped = null;
/** The line of its last panic. */
let fault = "";
/** Whether a call is under way. */
let isBusy = false;
/** Who hears of its progress, and the exception with which that has stopped it. */
let listener = null;
let thrown = null;

async function compiled(source) {
  if (source instanceof WebAssembly.Module) return source;
  if (source instanceof ArrayBuffer || ArrayBuffer.isView(source)) return WebAssembly.compile(source);
  let answer = source;
  if (!(typeof Response === "function" && source instanceof Response)) {
    const url = source === undefined ? new URL("./cosine-lobes.wasm", import.meta.url) : new URL(source, import.meta.url);
    if (url.protocol === "file:") {
      // By a name that bundlers do not follow.
      const files = "node:fs/promises";
      const { readFile } = await import(/* webpackIgnore: true */ /* @vite-ignore */ files);
      return WebAssembly.compile(await readFile(url));
    }
    answer = await fetch(url);
  }
  if (!answer.ok) throw new LobesError(`${answer.url}: ${answer.status} ${answer.statusText}`);
  // Not every server knows the type.
  const isWasm = answer.headers.get("Content-Type")?.startsWith("application/wasm");
  return isWasm ? WebAssembly.compileStreaming(answer) : WebAssembly.compile(await answer.arrayBuffer());
}

async function start(source) {
  const text = (at, length) => new TextDecoder().decode(new Uint8Array(wasm.memory.buffer, at >>> 0, length));
  const page = {
    now: () => performance.now() / 1000,
    complain: (at, length) => (fault = text(at, length)),
    progress(at, length, done) {
      // No exception may pass through the module.
      try {
        listener?.(text(at, length), done);
        return 0;
      } catch (error) {
        thrown = { error };
        return 1;
      }
    },
  };
  wasm = (await WebAssembly.instantiate(await compiled(source), { page })).exports;
}

/** Loads the module, once. */
export function init(source) {
  starting ??= start(source).catch((error) => {
    // Another call may have a better source.
    starting = null;
    throw error;
  });
  return starting;
}

/** A choice as the module reads it: its name, with what belongs to it. */
export function tagged(name, rest) {
  return Object.keys(rest).length > 0 ? { [name]: rest } : name;
}

const ofCommand = ({ do: name, ...rest }) => tagged(name, rest);

/**
 * Does a command, whose typed arrays go beside its JSON; `read` gets the answer's JSON, and a function that gives its arrays. `progress`
 * hears of the work, and stops it by throwing.
 */
export function call(command, read = (head) => head, progress = null) {
  if (!wasm) throw new LobesError("the module is not loaded: await init() first");
  if (stopped) throw new RenderError(stopped);
  if (isBusy) throw new LobesError("the engine is at work: progress may not call it");
  const arrays = [];
  let length = 0;
  const json = new TextEncoder().encode(
    JSON.stringify(ofCommand(command), (key, value) => {
      if (key === "then") return ofCommand(value);
      if (!ArrayBuffer.isView(value)) return value;
      const span = { at: length, bytes: value.byteLength };
      arrays.push([length, value]);
      length += value.byteLength;
      return span;
    }),
  );
  [isBusy, listener, thrown] = [true, progress, null];
  try {
    const at = wasm.library_reserve(json.length + length) >>> 0;
    // Memory may have grown, and its buffer is another one then.
    const memory = new Uint8Array(wasm.memory.buffer);
    memory.set(json, at);
    for (const [place, array] of arrays) memory.set(new Uint8Array(array.buffer, array.byteOffset, array.byteLength), at + json.length + place);
    const isDone = wasm.library_call(json.length);
    if (thrown) throw thrown.error;
    const part = (isArrays) => new Uint8Array(wasm.memory.buffer, wasm.library_answer(isArrays) >>> 0, wasm.library_answer_length(isArrays));
    const head = JSON.parse(new TextDecoder().decode(part(false)));
    if (!isDone) throw new CLASSES[head.class](head.line);
    const bytes = part(true);
    return read(head, ({ at, bytes: count } = { at: 0, bytes: bytes.length }) => bytes.subarray(at, at + count));
  } catch (error) {
    if (!(error instanceof WebAssembly.RuntimeError)) throw error;
    stopped = `the engine has stopped: ${fault.split("\n").join(" ") || "out of memory"}`;
    throw new RenderError(stopped, { cause: error });
  } finally {
    isBusy = false;
    if (!stopped) wasm.library_forget();
  }
}

/** The numbers of scenes and renderers that are not freed. */
const numbers = new WeakMap();
const unreachable = new FinalizationRegistry((number) => stopped || call({ do: "free", number }));

export function hold(object, number) {
  numbers.set(object, number);
  unreachable.register(object, number, object);
}

/** Frees it; nothing where it is freed. */
export function free(object) {
  const number = numbers.get(object);
  if (number === undefined) return;
  numbers.delete(object);
  unreachable.unregister(object);
  if (!stopped) call({ do: "free", number });
}

/** The number of what a command is for. */
export function held(object, kind) {
  const number = numbers.get(object);
  if (number === undefined) throw new EditError(`the ${kind} was freed`);
  return number;
}

/** A copy of float32 numbers, which has its own memory. */
export const floats = (bytes) => new Float32Array(bytes.slice().buffer);
