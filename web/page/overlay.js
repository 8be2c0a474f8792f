// Drawn before the picture: lamps, the handles of what is selected, the pixel that is looked into.

const AXES = ["#f05a50", "#78d25a", "#5a96ff"];
const CHOSEN = "#ffd250";

export class Overlay {
  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
  }

  resize([width, height]) {
    const scale = devicePixelRatio || 1;
    [this.canvas.width, this.canvas.height] = [width * scale, height * scale];
    this.size = [width, height];
    if (this.report) this.draw(this.report);
  }

  draw(report) {
    this.report = report;
    const { context, size } = this;
    if (!size) return;
    const scale = this.canvas.width / size[0];
    context.setTransform(scale, 0, 0, scale, 0, 0);
    context.clearRect(0, 0, ...size);
    this.lines(report.edges, "#ffd25099", 1);
    report.lights.forEach((light) => light.at && this.lamp(light, light.number === report.light));
    if (report.handles) this.handles(report.handles, report.light !== null);
    if (report.pixel) this.cross(report.pixel.map((part, k) => part * size[k]));
  }

  /** The pointer's shape, over what may be dragged. */
  hover(at, report) {
    const near = (place, reach) => place && Math.hypot(place[0] - at[0], place[1] - at[1]) < reach;
    const grips = report?.handles;
    const isNear =
      report?.lights.some((light) => !light.moves && near(light.at, 13)) ||
      (grips && [grips.middle, grips.aim, ...grips.tips].some((place) => near(place, 10)));
    this.canvas.style.cursor = isNear ? "grab" : "crosshair";
  }

  lines(all, color, width) {
    const { context } = this;
    context.beginPath();
    for (const [from, to] of all) {
      context.moveTo(...from);
      context.lineTo(...to);
    }
    [context.strokeStyle, context.lineWidth] = [color, width];
    context.stroke();
  }

  disc([x, y], radius, fill, edge, width = 1.5) {
    const { context } = this;
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    if (fill) [context.fillStyle, ] = [fill], context.fill();
    if (edge) {
      [context.strokeStyle, context.lineWidth] = [edge, width];
      context.stroke();
    }
  }

  /** A disc of the light's colour with rays. */
  lamp({ at, color, radiance }, isChosen) {
    const shown = color.map((part) => Math.round(255 * part ** (1 / 2.2)));
    const fill = radiance > 0 ? `rgb(${shown})` : "#3c3c3c";
    const rays = (from, to) =>
      Array.from({ length: 8 }, (_, k) => {
        const turn = [Math.cos((k * Math.PI) / 4), Math.sin((k * Math.PI) / 4)];
        return [from, to].map((length) => [at[0] + length * turn[0], at[1] + length * turn[1]]);
      });
    this.context.lineCap = "round";
    this.lines(rays(8, 11.5), "#000000b0", 4);
    this.lines(rays(8, 11.5), fill, 1.8);
    this.disc(at, 5.5, fill, isChosen ? CHOSEN : "#000000d0", isChosen ? 2.5 : 1.5);
  }

  handles({ middle, tips, circle, aim }, isLight) {
    const { context } = this;
    if (circle) this.disc(middle, circle, null, `${CHOSEN}d0`, 1.5);
    tips.forEach((tip, axis) => {
      if (!tip) return;
      const length = Math.hypot(tip[0] - middle[0], tip[1] - middle[1]);
      const along = [0, 1].map((k) => (tip[k] - middle[k]) / length);
      const place = (back, side) => [tip[0] - back * along[0] - side * along[1], tip[1] - back * along[1] + side * along[0]];
      this.lines([[[0, 1].map((k) => middle[k] + 0.25 * (tip[k] - middle[k])), place(8, 0)]], AXES[axis], 2);
      context.beginPath();
      [tip, place(11, 4.5), place(11, -4.5)].forEach((point, k) => (k ? context.lineTo(...point) : context.moveTo(...point)));
      context.fillStyle = AXES[axis];
      context.fill();
    });
    if (aim) {
      this.lines([[middle, aim]], `${CHOSEN}a0`, 1);
      this.disc(aim, 5, CHOSEN, "#000");
    }
    if (!isLight) this.disc(middle, 6, "#ffffff40", "#fff");
  }

  /** A cross with a gap, which leaves the pixel itself to be seen. */
  cross([x, y]) {
    const arms = [[1, 0], [-1, 0], [0, 1], [0, -1]].map(([a, b]) => [4, 12].map((length) => [x + length * a, y + length * b]));
    this.lines(arms, "#000000b0", 3);
    this.lines(arms, "#fff", 1);
  }
}
