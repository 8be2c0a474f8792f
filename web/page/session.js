// Starts the workers, and passes messages on.

/** The compiled engine. It is kept packed, since not every server packs what it sends. */
async function compiled() {
  const answer = await fetch("lobes.wasm.packed");
  if (!answer.ok) throw new Error(`lobes.wasm.packed: ${answer.status} ${answer.statusText}`);
  const bytes = answer.body.pipeThrough(new DecompressionStream("gzip"));
  return WebAssembly.compileStreaming(new Response(bytes, { headers: { "Content-Type": "application/wasm" } }));
}

/** On its way before the page asks for it. */
const arriving = compiled();
// Who starts a session hears of it.
arriving.catch(() => {});

/** A session with so many workers. */
export async function start(hands, { onReport, onLine, onOpened, onFault }) {
  const make = () => new Worker("worker.js", { type: "module" });
  const leader = make();
  const pairs = Array.from({ length: hands - 1 }, () => ({ worker: make(), channel: new MessageChannel() }));
  leader.onmessage = ({ data }) => {
    if (data.kind === "report") onReport(data);
    else if (data.kind === "opened") onOpened();
    else if (data.kind === "radiance") waiting.shift()?.(data.radiance);
    else if (data.kind === "fault") onFault(data.line);
    else if (data.kind === "line") {
      onOpened();
      onLine(data.line);
    }
  };
  /** Those who wait for radiance. */
  const waiting = [];
  leader.onerror = (event) => onFault(event.message);
  const module = await arriving;
  const ports = pairs.map(({ channel }) => channel.port2);
  leader.postMessage({ kind: "lead", module, ports }, ports);
  for (const { worker, channel } of pairs) worker.postMessage({ kind: "help", module, port: channel.port1 }, [channel.port1]);
  let sent = 0;
  const post = (message) => {
    sent += 1;
    leader.postMessage(message);
  };
  return {
    /** Whether all that was sent has been heard. */
    isHeard: (heard) => heard === sent,
    send: (request) => post({ kind: "request", request }),
    /** Linear radiance of the newest picture, three floats a pixel. */
    radiance: () => new Promise((resolve) => (waiting.push(resolve), leader.postMessage({ kind: "radiance" }))),
    open: (path, columns, files) => post({ kind: "open", path, columns, files }),
  };
}
