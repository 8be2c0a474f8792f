// Pictures of the engine beside those of the command.

import { execFileSync } from "node:child_process";
import { writeFileSync } from "node:fs";
import { join } from "node:path";
import { exr } from "./exr.mjs";

/** The most that a picture may differ: as root of the mean square, and as 99th percentile of each pixel's own radiance. */
const MOST = 1e-3;

/**
 * Compares radiance with the command's picture of a scene, or of the built-in one, in a folder for both. Browsers have a sine of their
 * own, so that single rays on outlines meet another surface than the command's: the largest difference says nothing.
 */
export const comparison = (folder) => (size, radiance, scene) => {
  const [ours, theirs] = ["ours.exr", "theirs.exr"].map((name) => join(folder, name));
  writeFileSync(ours, exr(...size, radiance));
  const lobes = (...args) => execFileSync(process.env.LOBES, args);
  lobes("render", ...(scene ? [scene] : []), "--size", size.join("x"), "-o", theirs, "--quiet");
  const { rmse, max, own } = JSON.parse(lobes("compare", ours, theirs, "--json"));
  const few = (x) => x.toExponential(1);
  const text = `${few(rmse)} (root of the mean square), ${few(own.p99)} of its own in 99 of 100 pixels, ${few(max)} at most`;
  return { text, isSame: rmse <= MOST && own.p99 <= MOST };
};
