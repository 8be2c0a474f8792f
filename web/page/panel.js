// The panel beside the picture: sliders and lists that show a report and send requests.

const find = (id) => document.getElementById(id);

const STRATEGIES = [
  ["silhouettes", "exact silhouettes"],
  ["spheres", "spheres"],
  ["shadow-map", "shadow maps"],
  ["rays", "shadow rays"],
  ["none", "none"],
];
/** Columns of pictures that may be chosen. */
const COLUMNS = [480, 640, 960, 1280, 1920];

/** A slider from 0 to 1 for numbers between two bounds, by factors or by steps. */
class Slider {
  constructor(id, { low, high, isLinear = false, text }, send) {
    Object.assign(this, { input: find(id), output: document.querySelector(`output[for="${id}"]`), low, high, isLinear, text });
    this.input.addEventListener("input", () => {
      this.output.value = this.text(this.value());
      send(this.value());
    });
    this.input.addEventListener("change", () => send(null));
  }

  value() {
    const part = Number(this.input.value);
    return this.isLinear ? this.low + part * (this.high - this.low) : this.low * (this.high / this.low) ** part;
  }

  show(value) {
    this.output.value = this.text(value);
    // The user's hand is before ours.
    if (this.input.matches(":active")) return;
    const part = this.isLinear ? (value - this.low) / (this.high - this.low) : Math.log(value / this.low) / Math.log(this.high / this.low);
    this.input.value = Math.min(1, Math.max(0, part));
  }
}

const digits = (value, count = 3) => Number(value.toPrecision(count)).toString();
const hex = (color) => `#${color.map((c) => Math.round(255 * Math.min(1, Math.max(0, c)) ** (1 / 2.2)).toString(16).padStart(2, "0")).join("")}`;
const linear = (text) => [1, 3, 5].map((place) => (parseInt(text.slice(place, place + 2), 16) / 255) ** 2.2);

export class Panel {
  /** With so many columns of the picture, if the page was opened with a number of them. */
  constructor(send, columns) {
    const rest = () => send({ do: "rest" });
    // The value of a slider that moves; once more, without one, when it rests.
    const moves = (wish) => (value) => (value === null ? rest() : send(wish(value)));
    const light = (what) => ({ do: "light", number: this.number, ...what });
    this.light = {
      size: new Slider("size", { low: 1e-3, high: 1, text: (v) => digits(v) }, moves((size) => light({ size }))),
      radiance: new Slider("radiance", { low: 1e-1, high: 1e4, text: (v) => digits(v) }, moves((radiance) => light({ radiance }))),
    };
    find("light-color").addEventListener("input", ({ target }) => send(light({ color: linear(target.value) })));
    find("light-color").addEventListener("change", rest);
    find("on").addEventListener("change", ({ target }) => (send(light({ on: target.checked })), rest()));
    this.gloss = new Slider("gloss", { low: 1, high: 1e4, text: (v) => digits(v) }, moves((gloss) => ({ do: "material", gloss })));
    find("color").addEventListener("input", ({ target }) => send({ do: "material", color: linear(target.value) }));
    find("color").addEventListener("change", rest);
    this.tolerance = new Slider(
      "tolerance",
      { low: 5e-4, high: 0.05, text: (v) => `${digits(100 * v, 2)} %` },
      moves((value) => ({ do: "tolerance", value })),
    );
    for (const [id, wish, first] of [["strategy", "strategy", "as it suits"], ["strategies", "strategies", "as each object says"]]) {
      find(id).add(new Option(first, ""));
      STRATEGIES.forEach(([value, name]) => find(id).add(new Option(name, value)));
      find(id).addEventListener("change", ({ target }) => send({ do: wish, name: target.value || null }));
    }
    find("projection").addEventListener("change", ({ target }) => send({ do: "projection", name: target.value }));
    [...new Set([...(columns ? [columns] : []), ...COLUMNS])].forEach((count) => find("columns").add(new Option(`${count} wide`, count)));
    find("columns").value = columns || ((navigator.hardwareConcurrency || 2) > 4 ? 960 : 640);
    find("columns").addEventListener("change", () => send({ do: "columns", count: this.columns() }));
    const look = () => {
      const exposure = Number(find("exposure").value) + this.metered;
      document.querySelector('output[for="exposure"]').value = exposure.toFixed(1);
      send({ do: "look", exposure, tone: find("tone").value });
    };
    find("exposure").addEventListener("input", look);
    find("tone").addEventListener("change", look);
  }

  /** Columns of pictures. */
  columns() {
    return Number(find("columns").value);
  }

  /** Another scene comes. */
  forget() {
    find("exposure").value = 0;
    find("tone").value = "soft";
    this.showPixel(null);
  }

  show(report) {
    const light = report.lights.find(({ number }) => number === report.light);
    find("light").hidden = !light;
    if (light) this.showLight(light, report.extent);
    find("object").hidden = !report.object;
    if (report.object) this.showObject(report.object);
    this.tolerance.show(report.tolerance);
    find("strategies").value = report.strategy ?? "";
    find("projection").value = report.projection;
    this.metered = report.metered;
    document.querySelector('output[for="exposure"]').value = report.exposure.toFixed(1);
  }

  showLight({ number, kind, size, radiance, color, moves }, extent) {
    this.number = number;
    find("light").querySelector("span").textContent = `Light ${number}: ${kind}${moves ? " (moves)" : ""}`;
    find("size-row").hidden = size === null;
    const isAngle = kind === "sun";
    [this.light.size.low, this.light.size.high] = isAngle ? [1e-3, 0.8] : [1e-3 * extent, extent];
    if (size !== null) this.light.size.show(size);
    if (radiance > 0) this.light.radiance.show(radiance);
    find("on").checked = radiance > 0;
    if (radiance > 0 && document.activeElement !== find("light-color")) find("light-color").value = hex(color);
    find("light").querySelectorAll("input").forEach((input) => (input.disabled = moves || (radiance === 0 && input.id !== "on")));
  }

  showObject({ name, parts, material, strategy, taken, exponent, roughness, color, moves }) {
    find("object").querySelector("span").textContent = name || "Object";
    const count = parts === 1 ? "" : ` · ${parts.toLocaleString("en")} parts`;
    find("object").querySelector(".note").textContent = `${material}${count}${moves ? " · the animation moves it" : ""}`;
    const value = exponent ?? roughness;
    find("gloss-row").hidden = value === null;
    if (value !== null) {
      const isRoughness = exponent === null;
      Object.assign(this.gloss, isRoughness ? { low: 0.02, high: 1, isLinear: true } : { low: 1, high: 1e4, isLinear: false });
      find("gloss-row").querySelector("label").textContent = isRoughness ? "roughness" : "exponent";
      this.gloss.show(value);
    }
    find("color-row").hidden = color === null;
    if (color !== null && document.activeElement !== find("color")) find("color").value = hex(color);
    find("strategy").options[0].textContent = `as it suits: ${taken}`;
    find("strategy").value = strategy ?? "";
  }

  showPixel(pixel, report) {
    find("pixel-body").hidden = !pixel;
    find("pixel").querySelector(".note").hidden = !!pixel;
    find("pixel").querySelector("span").textContent = pixel ? `Pixel ${pixel.pixel.join(", ")}` : "Pixel";
    if (!pixel) return;
    const vector = (v, count = 3) => v.map((x) => digits(x, count)).join(", ");
    const bright = ([r, g, b]) => 0.2126 * r + 0.7152 * g + 0.0722 * b;
    const [own, want] = [bright(pixel.radiance), bright(pixel.reference)];
    const rows = [
      ["object", `${pixel.object || "–"} · ${pixel.material}`],
      ["point", vector(pixel.point)],
      ["radiance", vector(pixel.radiance)],
      ["reference", vector(pixel.reference)],
      ["its error", `± ${digits(Math.max(...pixel.deviation), 2)}`],
      ["difference", want > 0 ? `${(100 * (own / want - 1)).toFixed(2)} %` : digits(own - want)],
    ];
    const make = (name, text) => Object.assign(document.createElement(name), { textContent: text });
    find("pixel-body").querySelector("dl").replaceChildren(...rows.flatMap(([name, text]) => [make("dt", name), make("dd", text)]));
    const line = ({ number, kind, unshadowed, visible, radiance }) => {
      const row = document.createElement("tr");
      const cells = [`${number} ${kind}`, unshadowed.toFixed(4), `${(100 * visible).toFixed(1)} %`, radiance.toFixed(4)];
      row.append(...cells.map((text) => make("td", text)));
      return row;
    };
    find("pixel-body").querySelector("tbody").replaceChildren(...pixel.lights.slice(0, 8).map(line));
    const masked = pixel.lights.filter(({ mask }) => mask);
    find("masks").replaceChildren(...masked.map((part) => mask(part, report?.lights.find(({ number }) => number === part.number)?.color)));
  }
}

/** A light as the point sees it. */
function mask({ number, mask: { size, sides, samples } }, color = [1, 1, 1]) {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = size;
  canvas.style.aspectRatio = sides[0] > 0 && sides[1] > 0 ? `${sides[0]} / ${sides[1]}` : "1";
  const lit = color.map((c) => 255 * c ** (1 / 2.2));
  const colors = [[38, 38, 42], lit, [4, 6, 14]];
  const image = new ImageData(...size);
  for (let k = 0; k < samples.length; k++) image.data.set([...colors[samples[k]], 255], 4 * k);
  canvas.getContext("2d").putImageData(image, 0, 0);
  const figure = document.createElement("figure");
  figure.append(canvas, Object.assign(document.createElement("figcaption"), { textContent: `light ${number}, as seen there` }));
  return figure;
}
