// The page: it shows pictures and reports of a session, which works in workers, and sends them what the user does.

import { Overlay } from "./overlay.js";
import { Panel } from "./panel.js";
import { start } from "./session.js";

const find = (id) => document.getElementById(id);
const stage = find("stage");
const picture = find("picture");
const options = new URLSearchParams(location.search);

/** For tests, and for the curious: seconds and counts. */
const figures = { first: 0, whole: 0, counts: {}, report: null };
globalThis.lobes = figures;

const listed = fetch("scenes.json").then((answer) => answer.json());
const cores = navigator.hardwareConcurrency || 2;
// One core is left for the page itself.
const hands = Number(options.get("hands")) || Math.min(8, Math.max(1, cores - 1));
const starting = start(hands, { onReport, onLine: tell, onOpened: () => (find("wait").hidden = true), onGpuLeft, onFault });
starting.catch((error) => onFault(error.message));
const [session, scenes] = await Promise.all([starting, listed]);
scenes.forEach(({ name }, number) => find("scene").add(new Option(name, number)));
Object.assign(figures, {
  radiance: session.radiance,
  isDone: () => !figures.isBusy && session.isHeard(figures.heard) && figures.report?.picture.divisor === 1,
});
const overlay = new Overlay(find("overlay"));
const panel = new Panel(session.send, Math.min(4096, Math.max(0, Number(options.get("columns")) || 0)));

let report = null;
let isPlaying = false;

function onReport(message) {
  report = message.report;
  Object.assign(figures, { report, isBusy: message.isBusy, heard: message.heard, gpu: message.gpu });
  if (message.pixels) show(message.pixels);
  if (message.pixel !== undefined) panel.showPixel(message.pixel, report);
  panel.show(report);
  overlay.draw(report);
  report.lines.forEach((line) => tell(line));
  find("undo").disabled = !report.steps[0];
  find("redo").disabled = !report.steps[1];
  find("play").hidden = !report.duration;
  fit();
  tellStatus(message);
  if (isPlaying && message.pixels) playOn();
}

/** When the last pictures came. */
let times = [];

function show(pixels) {
  const [width, height] = report.picture.size;
  // The browser enlarges coarse ones.
  if (picture.width !== width || picture.height !== height) [picture.width, picture.height] = [width, height];
  picture.getContext("2d").putImageData(new ImageData(new Uint8ClampedArray(pixels.buffer), width, height), 0, 0);
  const now = performance.now();
  const { divisor } = report.picture;
  figures.counts[divisor] = (figures.counts[divisor] ?? 0) + 1;
  figures.first ||= now;
  if (divisor === 1) figures.whole ||= now;
  times = [...times.filter((time) => time > now - 1000), now];
}

function tellStatus({ isBusy, hands, gpu }) {
  const { size, whole, divisor, seconds } = report.picture;
  if (!size[0]) return;
  const parts = [`${whole[0]} × ${whole[1]}`, `${(1000 * seconds).toFixed(0)} ms`];
  if (divisor > 1) parts[0] += `, coarse 1 : ${divisor}`;
  if (times.length > 3) parts.push(`${times.length} pictures a second`);
  else if (isBusy) parts.push("refining");
  if (gpu !== null) parts.push(gpu ? `GPU: ${gpu}` : "GPU");
  else parts.push(hands > 1 ? `${hands} workers` : "1 worker");
  find("status").textContent = parts.join(" · ");
}

/** Shows a line for some seconds. */
function tell(line) {
  const shown = find("line");
  shown.textContent = line;
  shown.classList.add("shown");
  clearTimeout(tell.timer);
  tell.timer = setTimeout(() => shown.classList.remove("shown"), 9000);
}

/** The CPU draws again: of a reason, or since the switch is off. */
function onGpuLeft(line) {
  find("gpu").checked = false;
  if (line) tell(`The CPU draws, since the GPU does not: ${line}`);
}

function onFault(line) {
  find("wait").hidden = false;
  find("wait").textContent = `The page has stopped: ${line}. Load it again.`;
}

// ---- the place of the picture

let view = "";

function fit() {
  const [columns, rows] = report?.picture.whole ?? [16, 9];
  const [width, height] = [stage.clientWidth - 24, stage.clientHeight - 24];
  const scale = Math.min(width / columns, height / rows);
  const size = [columns * scale, rows * scale].map((side) => Math.max(1, Math.floor(side)));
  if (view === `${size}`) return;
  view = `${size}`;
  Object.assign(find("frames").style, {
    width: `${size[0]}px`,
    height: `${size[1]}px`,
    left: `${(stage.clientWidth - size[0]) / 2}px`,
    top: `${(stage.clientHeight - size[1]) / 2}px`,
  });
  overlay.resize(size);
  session.send({ do: "view", size });
}
new ResizeObserver(() => fit()).observe(stage);

// ---- the pointer

/** Pixels that a pointer moves before it drags. */
const SLOP = 3;
const pointers = new Map();
let isDragging = false;
let pinch = 0;

const at = (event) => {
  const box = overlay.canvas.getBoundingClientRect();
  return [event.clientX - box.left, event.clientY - box.top];
};
const distance = ([a, b], [c, d]) => Math.hypot(a - c, b - d);

overlay.canvas.addEventListener("pointerdown", (event) => {
  overlay.canvas.setPointerCapture(event.pointerId);
  pointers.set(event.pointerId, { from: at(event), now: at(event), pans: event.button !== 0 || event.shiftKey });
  find("hint").classList.add("gone");
  if (pointers.size === 2) {
    release();
    pinch = spread();
  }
});
overlay.canvas.addEventListener("pointermove", (event) => {
  const pointer = pointers.get(event.pointerId);
  if (!pointer) return overlay.hover(at(event), report);
  pointer.now = at(event);
  if (pointers.size === 2) {
    const now = spread();
    session.send({ do: "zoom", by: pinch / Math.max(now, 1) });
    pinch = now;
    return;
  }
  if (!isDragging && distance(pointer.from, pointer.now) > SLOP) {
    isDragging = true;
    session.send({ do: "press", at: pointer.from, pans: pointer.pans });
  }
  if (isDragging) session.send({ do: "drag", at: pointer.now });
});
overlay.canvas.addEventListener("pointerup", (event) => {
  const pointer = pointers.get(event.pointerId);
  if (pointer && !isDragging && pointers.size === 1 && !pointer.pans) session.send({ do: "click", at: pointer.from });
  if (pointers.size === 1) release();
  pointers.delete(event.pointerId);
});
overlay.canvas.addEventListener("pointercancel", (event) => {
  release();
  pointers.delete(event.pointerId);
});
overlay.canvas.addEventListener("contextmenu", (event) => event.preventDefault());
overlay.canvas.addEventListener(
  "wheel",
  (event) => {
    event.preventDefault();
    const lines = event.deltaMode === 1 ? 30 : 1;
    session.send({ do: "zoom", by: Math.exp(0.0015 * lines * event.deltaY) });
  },
  { passive: false },
);

function release() {
  if (isDragging) session.send({ do: "release" });
  isDragging = false;
}

function spread() {
  const [a, b] = [...pointers.values()];
  return Math.max(1, distance(a.now, b.now));
}

// ---- keys and buttons

const DEEDS = {
  undo: () => session.send({ do: "undo" }),
  redo: () => session.send({ do: "redo" }),
  frame: () => session.send({ do: "frame" }),
  play: () => {
    isPlaying = !isPlaying;
    find("play").textContent = isPlaying ? "Stop" : "Play";
    if (isPlaying) begin();
  },
};
Object.entries(DEEDS).forEach(([id, deed]) => find(id).addEventListener("click", deed));

addEventListener("keydown", (event) => {
  if (/^(SELECT|INPUT)$/.test(event.target.tagName) && event.target.type !== "range") return;
  const key = event.key.toLowerCase();
  const isCommand = event.ctrlKey || event.metaKey;
  const deed =
    isCommand && (key === "y" || (key === "z" && event.shiftKey)) ? "redo"
    : isCommand && key === "z" ? "undo"
    : !isCommand && key === "f" ? "frame"
    : !isCommand && key === " " && report?.duration && event.target.tagName !== "BUTTON" ? "play"
    : null;
  if (!deed) return;
  event.preventDefault();
  DEEDS[deed]();
});

// ---- WebGPU

find("gpu-row").hidden = !navigator.gpu;
find("gpu").addEventListener("change", ({ target }) => session.setGpu(target.checked));
if (options.has("gpu") && navigator.gpu) {
  find("gpu").checked = true;
  session.setGpu(true);
}

// ---- animation: the next moment is requested when a picture is there

let began = 0;

function begin() {
  began = performance.now() - 1000 * report.time;
  playOn();
}

function playOn() {
  session.send({ do: "seek", time: ((performance.now() - began) / 1000) % report.duration });
}

// ---- scenes and files

async function open(path, files) {
  [isPlaying, find("play").textContent] = [false, "Play"];
  panel.forget();
  find("wait").hidden = false;
  find("wait").textContent = "Opening…";
  session.open(path, panel.columns(), files);
  // The new scene knows nothing of the screen.
  view = "";
  fit();
}

async function openScene({ path, files }) {
  const fetched = files.map(async (name) => {
    const answer = await fetch(`scenes/${name}`);
    if (!answer.ok) throw new Error(`scenes/${name}: ${answer.statusText}`);
    return { name, data: await answer.arrayBuffer() };
  });
  await open(path, await Promise.all(fetched));
}

find("scene").addEventListener("change", () => find("given")?.remove());
find("scene").addEventListener("change", () => openScene(scenes[find("scene").value]).catch((e) => tell(e.message)));

/** The file that a scene is read from, if several are given: the first that fits. */
const MAIN = [/\.toml$/i, /\.gl(tf|b)$/i, /\.(obj|ply)$/i];

async function openFiles(files) {
  const main = MAIN.map((ending) => files.find(({ name }) => ending.test(name))).find((file) => file);
  if (!main) return tell("There is no scene (.toml) or model (.gltf, .glb, .obj, .ply) among the files.");
  const read = files.map(async ({ name, file }) => ({ name, data: await file.arrayBuffer() }));
  await open(main.name, await Promise.all(read));
  find("given")?.remove();
  const given = Object.assign(new Option(main.name.replace(/.*\//, ""), "", true, true), { id: "given", disabled: true });
  find("scene").add(given);
}

find("file").addEventListener("change", async (event) => {
  await openFiles([...event.target.files].map((file) => ({ name: file.name, file })));
  event.target.value = "";
});

/** All files of a dropped entry, with their paths in it. */
async function within(entry, path = "") {
  if (entry.isFile) {
    const file = await new Promise((resolve, reject) => entry.file(resolve, reject));
    return [{ name: path + entry.name, file }];
  }
  const reader = entry.createReader();
  const all = [];
  for (;;) {
    const some = await new Promise((resolve, reject) => reader.readEntries(resolve, reject));
    if (!some.length) break;
    for (const inner of some) all.push(...(await within(inner, `${path}${entry.name}/`)));
  }
  return all;
}

addEventListener("dragover", (event) => {
  event.preventDefault();
  stage.classList.add("over");
});
addEventListener("dragleave", (event) => {
  if (!event.relatedTarget) stage.classList.remove("over");
});
addEventListener("drop", async (event) => {
  event.preventDefault();
  stage.classList.remove("over");
  const entries = [...event.dataTransfer.items].map((item) => item.webkitGetAsEntry?.()).filter((entry) => entry);
  const plain = [...event.dataTransfer.files].map((file) => ({ name: file.name, file }));
  const all = entries.length ? (await Promise.all(entries.map((entry) => within(entry)))).flat() : plain;
  await openFiles(all).catch((error) => tell(error.message));
});

fit();
const first = scenes[Number(options.get("scene")) || 0] ?? scenes[0];
find("scene").value = scenes.indexOf(first);
await openScene(first).catch((error) => tell(error.message));
