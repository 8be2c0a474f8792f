// A session in a worker. One leads and makes pictures; others help it by shading rows of theirs.
//
// Everything is done in the order in which it came, so that helpers, which are sent the same, know the same scene.

import { engine as make } from "./engine.js";

let engine;
/** Messages that wait. */
let inbox = [];
/** How many came, those that others replaced included. */
let heard = 0;
let isBusy = false;
/** The leader's helpers: their ports, and whether they have the scene. */
let helpers = [];
/** The helper on WebGPU, where that is switched on: its port, its name, whether it has the scene. It shades alone. */
let gpu = null;
/** All that helpers were sent since the scene was opened, for one that comes later. */
let log = [];
/** The last picture that was shown. */
let shown = "";

onmessage = ({ data }) => {
  if (data.kind === "lead") lead(data);
  else help(data);
};

// ---- helpers

async function help({ module, port }) {
  const engine = await make(module, (line) => port.postMessage({ kind: "fault", line }));
  port.onmessage = ({ data }) => {
    try {
      if (data.kind === "open") {
        open(engine, data, false);
        port.postMessage({ kind: "opened", turn: data.turn });
      } else if (data.kind === "shade") {
        const radiance = engine.shade(data.task, data.part, data.of);
        port.postMessage({ kind: "part", radiance }, [radiance.buffer]);
      } else if (data.kind === "request") engine.request(data.request);
      else engine.follow();
    } catch {
      // The leader tells why, and does this one's part.
      if (data.kind === "shade") port.postMessage({ kind: "part", radiance: new Uint8Array() });
    }
  };
}

// ---- the leader

async function lead({ module, ports }) {
  engine = await make(module, (line) => post({ kind: "fault", line }));
  helpers = ports.map((port) => {
    const helper = { port, isReady: false, turn: 0, parts: null };
    port.onmessage = ({ data }) => {
      if (data.kind === "opened") helper.isReady = data.turn === turn;
      else if (data.kind === "part") helper.parts?.(data.radiance);
      else {
        helper.isReady = false;
        helper.parts?.(new Uint8Array());
      }
    };
    return helper;
  });
  onmessage = ({ data }) => {
    if (data.kind === "radiance") return post({ kind: "radiance", radiance: engine.radiance() });
    put(data);
    run();
  };
}

const post = (message, owned = []) => postMessage(message, owned);

/** How often a scene was opened. */
let turn = 0;

function open(engine, { path, columns, files }, leads) {
  files.forEach(({ name, data }) => engine.putFile(name, new Uint8Array(data)));
  engine.request({ do: "open", path, columns, leads });
}

/** Wishes of the same kind about the same thing, of which only the last one counts. */
const REPLACED = new Set(["drag", "view", "light", "material", "tolerance", "look", "seek", "columns"]);

function put(message) {
  heard += 1;
  const [last, request] = [inbox.at(-1)?.request, message.request];
  const isSame = last && request && last.do === request.do && last.number === request.number;
  if (isSame && request.do === "zoom") last.by *= request.by;
  else if (isSame && REPLACED.has(request.do)) Object.assign(last, request);
  else inbox.push(message);
}

function take(message) {
  if (message.kind === "gpu") switchGpu(message);
  else if (message.kind === "open") {
    turn += 1;
    for (const helper of [...helpers, gpu]) if (helper) helper.isReady = false;
    log = [];
    send({ ...message, turn });
    gpu?.port.postMessage({ kind: "warm", turn });
    open(engine, message, true);
    shown = "";
    post({ kind: "opened" });
  } else {
    send(message);
    engine.request(message.request);
    if (message.request.do === "look") shown = "";
  }
}

/** Sends something to all helpers, and keeps it for later ones. */
function send(message) {
  [...helpers, gpu].forEach((helper) => helper?.port.postMessage(message));
  const { request } = message;
  // Only the last of many places of a drag counts, and a picture between them changes nothing.
  while (REPLACED.has(request?.do) && log.length > 1) {
    const at = log.findLastIndex(({ kind }) => kind !== "follow");
    const before = log[at].request;
    if (before?.do !== request.do || before.number !== request.number) break;
    log.length = at;
    message = { ...message, request: { ...before, ...request } };
  }
  if (message.kind !== "follow" || log.at(-1)?.kind !== "follow") log.push(message);
}

// ---- WebGPU

/** Switches it on, with the port of its worker, or off. */
function switchGpu({ port, line }) {
  if (!port) return leaveGpu(line);
  const helper = { port, name: "", isReady: false, parts: null };
  port.onmessage = ({ data }) => {
    if (helper !== gpu) return;
    if (data.kind === "device") helper.name = data.name;
    else if (data.kind === "part") helper.parts?.(data.radiance);
    else if (data.kind === "fault") leaveGpu(data.line);
    else if (data.turn === turn && !helper.isReady) {
      helper.isReady = true;
      redraw();
    }
  };
  gpu = helper;
  log.forEach((message) => port.postMessage(message));
  if (log.length) port.postMessage({ kind: "warm", turn });
}

/** Lets the CPU draw again, for a reason or since the user wants it. */
function leaveGpu(line = null) {
  const left = gpu;
  gpu = null;
  // No one waits for it any longer.
  left?.parts?.(new Uint8Array());
  redraw();
  post({ kind: "gpu", line });
}

function redraw() {
  engine.redraw();
  // Before anything else is told: the picture that is there is not the last.
  tell(true);
  shown = "";
  run();
}

/** Lets messages in. */
const pause = () =>
  new Promise((resolve) => {
    const { port1, port2 } = new MessageChannel();
    port1.onmessage = () => (port1.close(), resolve());
    port2.postMessage(null);
  });

async function run() {
  if (isBusy) return;
  isBusy = true;
  try {
    for (;;) {
      const waiting = inbox;
      inbox = [];
      for (const message of waiting) attempt(() => take(message));
      const more = await step();
      tell(more);
      await pause();
      if (!more && !inbox.length) break;
    }
  } catch (error) {
    post({ kind: "fault", line: engine.fault() || String(error) });
  }
  isBusy = false;
}

function attempt(work) {
  try {
    work();
  } catch (error) {
    if (error instanceof WebAssembly.RuntimeError) throw error;
    post({ kind: "line", line: error.message });
  }
}

/** Shades what comes next, with all hands; whether there was anything. */
async function step() {
  const onGpu = gpu?.isReady ? gpu : null;
  const ready = onGpu ? [] : helpers.filter((helper) => helper.isReady);
  const of = 1 + ready.length;
  const task = engine.task(of);
  if (!task) return false;
  if (onGpu) {
    const radiance = await new Promise((resolve) => {
      onGpu.parts = resolve;
      onGpu.port.postMessage({ kind: "shade", task, part: 0, of });
    });
    // It was left meanwhile: the picture begins anew.
    if (onGpu !== gpu) return true;
    engine.putPart(0, radiance);
    if (engine.finish()) send({ kind: "follow" });
    return true;
  }
  const parts = ready.map(
    (helper, place) =>
      new Promise((resolve) => {
        helper.parts = resolve;
        helper.port.postMessage({ kind: "shade", task, part: place + 1, of });
      }),
  );
  engine.shade(task, 0, of);
  for (const [place, part] of parts.entries()) {
    const radiance = await part;
    if (radiance.length) engine.putPart(place + 1, radiance);
  }
  if (engine.finish()) send({ kind: "follow" });
  return true;
}

/** How many pixels were taken apart. */
let probes = 0;

/** Tells the page how the scene stands, with the picture where that is new. */
function tell(isBusy) {
  const report = engine.report();
  if (!report) return;
  const { edits, divisor, size } = report.picture;
  const now = `${turn} ${edits} ${divisor} ${size} ${report.exposure}`;
  const message = { kind: "report", report, isBusy: isBusy || inbox.length > 0, heard, hands: 1 + helpers.filter((helper) => helper.isReady).length };
  message.gpu = gpu?.isReady ? gpu.name : null;
  const owned = [];
  if (now !== shown && size[0] > 0) {
    shown = now;
    message.pixels = engine.pixels();
    owned.push(message.pixels.buffer);
  }
  if (report.probes !== probes) {
    probes = report.probes;
    message.pixel = engine.pixel();
  }
  post(message, owned);
}
