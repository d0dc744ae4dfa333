// Draws solids in space on a canvas.
import { colour } from "./scope_plot.js";
import { circlesOf, endsOf, facesOf, gridOf, lightness } from "./solid.js";

/** With one camera, on one picture. */
export class Pen {
  constructor(context, camera, width, height) {
    Object.assign(this, { context, camera, at: camera.projection(width, height), eye: camera.axes()[2] });
    [this.fill, this.fixed, this.line, this.gridLine, this.back] = ["accent", "quiet", "text", "grid", "card"].map(colour);
    this.reach = Math.hypot(width, height) / camera.scale / 2;
  }

  /** From the farthest to the nearest. */
  sorted(solids) {
    return solids.map((solid) => [this.at(solid.pose.position)[2], solid]).sort((a, b) => a[0] - b[0]).map(([, solid]) => solid);
  }

  solid(solid) {
    const { context } = this;
    context.fillStyle = solid.moves ? this.fill : this.fixed;
    context.strokeStyle = this.line;
    context.lineWidth = 1;
    if (solid.shape === "box") this.#box(solid);
    if (solid.shape === "sphere") this.#ball(solid.pose);
    if (solid.shape === "capsule") this.#capsule(solid.pose);
  }

  #box(solid) {
    for (const { points, normal } of facesOf("box", solid.pose)) {
      const light = lightness(normal, this.eye);
      if (light === 0) continue;   // it faces away
      this.#path(points, true);
      for (const [style, alpha] of [[this.back, 1], [solid.moves ? this.fill : this.fixed, 0.45 + 0.55 * light]]) {
        Object.assign(this.context, { fillStyle: style, globalAlpha: alpha });
        this.context.fill();
      }
      this.context.globalAlpha = 1;
      this.context.stroke();
    }
  }

  #ball(pose) {
    const [x, y] = this.at(pose.position), { context } = this;
    context.beginPath();
    context.arc(x, y, this.camera.scale * pose.size[0], 0, 2 * Math.PI);
    context.fill();
    context.stroke();
    context.globalAlpha = 0.35;
    const depth = this.at(pose.position)[2], inFront = (point) => this.at(point)[2] >= depth;
    for (const circle of circlesOf(pose))
      circle.slice(1).forEach((point, k) => { if (inFront(point) && inFront(circle[k])) { this.#path([circle[k], point], false); context.stroke(); } });
    context.globalAlpha = 1;
  }

  #capsule(pose) {
    const { context } = this, width = 2 * this.camera.scale * pose.size[0];
    context.lineCap = "round";
    for (const [style, wide] of [[this.line, width + 2], [context.fillStyle, width]]) {
      context.strokeStyle = style;
      context.lineWidth = wide;
      this.#path(endsOf(pose), false);
      context.stroke();
    }
    context.lineCap = "butt";
  }

  grid({ normal, offset }) {
    this.context.strokeStyle = this.gridLine;
    this.context.lineWidth = 1;
    for (const line of gridOf(normal, offset, this.camera.centre, this.reach)) { this.#path(line, false); this.context.stroke(); }
  }

  /** A cross, and a line to the body that it holds. */
  handle([x, y, z], held) {
    const { context } = this, [a, b] = this.at([x, y, z]);
    context.strokeStyle = colour("bad");
    context.lineWidth = 2;
    context.beginPath();
    context.moveTo(a - 6, b); context.lineTo(a + 6, b);
    context.moveTo(a, b - 6); context.lineTo(a, b + 6);
    context.stroke();
    if (held) { this.#path([[x, y, z], held.position], false); context.stroke(); }
  }

  #path(points, closed) {
    this.context.beginPath();
    points.forEach((point, k) => { const [x, y] = this.at(point); if (k) this.context.lineTo(x, y); else this.context.moveTo(x, y); });
    if (closed) this.context.closePath();
  }
}
