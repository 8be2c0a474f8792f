// Starts the workers, and passes messages on.

/** A compiled engine. It is kept packed, since not every server packs what it sends. */
async function compiled(name) {
  const answer = await fetch(name);
  if (!answer.ok) throw new Error(`${name}: ${answer.status} ${answer.statusText}`);
  const bytes = answer.body.pipeThrough(new DecompressionStream("gzip"));
  return WebAssembly.compileStreaming(new Response(bytes, { headers: { "Content-Type": "application/wasm" } }));
}

/** On its way before the page asks for it. */
const arriving = compiled("lobes.wasm.packed");
// Who starts a session hears of it.
arriving.catch(() => {});

/** The engine with WebGPU, once it was wanted. */
let arrivingForGpu = null;

/** A session with so many workers. */
export async function start(hands, { onReport, onLine, onOpened, onGpuLeft, onFault }) {
  const make = () => new Worker("worker.js", { type: "module" });
  const leader = make();
  const pairs = Array.from({ length: hands - 1 }, () => ({ worker: make(), channel: new MessageChannel() }));
  leader.onmessage = ({ data }) => {
    if (data.kind === "report") onReport(data);
    else if (data.kind === "opened") onOpened();
    else if (data.kind === "radiance") waiting.shift()?.(data.radiance);
    else if (data.kind === "gpu") {
      gpu?.terminate();
      gpu = null;
      onGpuLeft(data.line);
    } else if (data.kind === "fault") onFault(data.line);
    else if (data.kind === "line") {
      onOpened();
      onLine(data.line);
    }
  };
  /** The worker that shades on WebGPU. */
  let gpu = null;
  /** Those who wait for radiance. */
  const waiting = [];
  leader.onerror = (event) => onFault(event.message);
  const module = await arriving;
  const ports = pairs.map(({ channel }) => channel.port2);
  leader.postMessage({ kind: "lead", module, ports }, ports);
  for (const { worker, channel } of pairs) worker.postMessage({ kind: "help", module, port: channel.port1 }, [channel.port1]);
  let sent = 0;
  const post = (message, owned = []) => {
    sent += 1;
    leader.postMessage(message, owned);
  };
  return {
    /** Whether all that was sent has been heard. */
    isHeard: (heard) => heard === sent,
    send: (request) => post({ kind: "request", request }),
    /** Linear radiance of the newest picture, three floats a pixel. */
    radiance: () => new Promise((resolve) => (waiting.push(resolve), leader.postMessage({ kind: "radiance" }))),
    /** Lets WebGPU draw, or the CPU again. The engine for it is loaded at the first time. */
    async setGpu(isOn) {
      if (!isOn) return gpu && post({ kind: "gpu", port: null });
      try {
        arrivingForGpu ??= compiled("lobes_gpu.wasm.packed");
        const module = await arrivingForGpu;
        if (gpu) return;
        const { port1, port2 } = new MessageChannel();
        gpu = new Worker("gpu.js", { type: "module" });
        gpu.onerror = (event) => post({ kind: "gpu", port: null, line: event.message || "its worker does not start" });
        gpu.postMessage({ module, port: port1 }, [port1]);
        post({ kind: "gpu", port: port2 }, [port2]);
      } catch (error) {
        arrivingForGpu = null;
        onGpuLeft(error.message);
      }
    },
    open: (path, columns, files) => post({ kind: "open", path, columns, files }),
  };
}
