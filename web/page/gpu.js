// A helper that shades on WebGPU. It follows the leader as other helpers do, and shades whole tasks.

import { calls } from "./engine.js";
import init, { open_gpu, shade_on_gpu, warm_up_gpu } from "./lobes_gpu.js";

onmessage = ({ data: { module, port } }) => {
  const fail = (line) => port.postMessage({ kind: "fault", line });
  // The engine calls this where it panics.
  globalThis.complain = fail;
  let engine;
  /** Why a message was not followed. */
  const work = async (data) => {
    if (data.kind === "open") {
      data.files.forEach(({ name, data }) => engine.putFile(name, new Uint8Array(data)));
      engine.request({ do: "open", path: data.path, columns: data.columns, leads: false });
    } else if (data.kind === "request") {
      // The leader tells the user why one is refused.
      try {
        engine.request(data.request);
      } catch (error) {
        if (error instanceof WebAssembly.RuntimeError) throw error;
      }
    } else if (data.kind === "follow") engine.follow();
    else if (data.kind === "warm") {
      await warm_up_gpu();
      port.postMessage({ kind: "opened", turn: data.turn });
    } else if (data.kind === "shade") {
      const radiance = await engine.shadeBy(shade_on_gpu, data.task, data.part, data.of);
      port.postMessage({ kind: "part", radiance }, [radiance.buffer]);
    }
  };
  const begin = async () => {
    engine = calls(await init({ module_or_path: module }));
    port.postMessage({ kind: "device", name: (await open_gpu()) || "WebGPU" });
  };
  // One after the other: nothing comes between a task and its end.
  let last = begin();
  last.catch((error) => fail(String(error.message ?? error)));
  port.onmessage = ({ data }) => {
    last = last.then(() => work(data));
    last.catch((error) => fail(String(error.message ?? error)));
  };
};
