// The plot of the scope: uPlot with one scale per trace, marks of trigger and events, two cursors.
import uPlot from "/uplot.js";
import { clamp, el, withUnit } from "./dom.js";

/** Colour of a trace, or of another part of the panel, in the current theme. */
export const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

/** An axis in the colours of the theme. */
export function axis(more) {
  return { stroke: colour("quiet"), grid: { stroke: colour("grid"), width: 1 }, ticks: { stroke: colour("grid"), width: 1, size: 4 }, font: "11px system-ui, sans-serif", ...more };
}

/** Calls `resize(width)` when the width of the host changes. */
export function watchWidth(host, resize) {
  new ResizeObserver(([entry]) => { if (entry.contentRect.width > 0) resize(Math.floor(entry.contentRect.width)); }).observe(host);
}

export class ScopePlot {
  cursors = [0.3, 0.7];          // share of the screen
  marks = { times: [], level: null };
  #plot = null;
  #range = [0, 1];
  #scales = [];

  constructor(onCursor) {
    this.element = el("div.plot", { role: "group", "aria-label": "Oscilloscope" });
    this.handles = ["A", "B"].map((name, k) => this.#makeHandle(name, k, onCursor));
    watchWidth(this.element, (width) => this.#plot?.setSize({ width, height: this.#height() }));
  }

  #height() { return innerWidth < 700 ? 240 : Math.max(260, Math.round(innerHeight * 0.42)); }

  /** A new plot for these traces; `selected` has the axis. */
  rebuild(traces, selected, stacked) {
    this.#plot?.destroy();
    this.#scales = traces.map(() => [-1, 1]);
    const scales = { x: { time: false, range: () => this.#range } };
    traces.forEach((_, k) => { scales[`t${k}`] = { range: () => this.#placed(k, stacked) }; });
    const own = (splits) => splits.map((y) => (y >= this.#scales[selected][0] - 1e-12 && y <= this.#scales[selected][1] + 1e-12 ? y : null));
    const axes = [axis({ size: 28, values: (_, splits) => splits.map((x) => withUnit(x, "s", 3)) })];
    if (traces.length) axes.push(axis({ scale: `t${selected}`, size: 62, stroke: traces[selected].colour, filter: (_, splits) => own(splits), values: (_, splits) => splits.map((y) => (y === null ? "" : withUnit(y, traces[selected].unit, 3))) }));
    else axes.push({ show: false });
    const series = traces.map((trace, k) => ({ scale: `t${k}`, stroke: trace.colour, width: 1, points: { show: false } }));
    const options = { width: this.element.clientWidth || 300, height: this.#height(), padding: [10, 22, 0, traces.length ? 0 : 22], scales, axes, series: [{}, ...series], legend: { show: false }, cursor: { show: false }, hooks: { draw: [(plot) => this.#drawMarks(plot, selected)] } };
    this.#plot = new uPlot(options, [[], ...traces.map(() => [])], this.element);
    this.#plot.over.append(...this.handles);
    this.placeCursors();
  }

  /** With stacked traces each has a strip of its own, the first at the top. */
  #placed(k, stacked) {
    const [low, high] = this.#scales[k], count = stacked ? this.#scales.length : 1, place = stacked ? k : 0;
    return [low - (count - 1 - place) * (high - low), high + place * (high - low)];
  }

  draw(data, range, scales) {
    this.#range = range;
    this.#scales = scales;
    this.#plot?.setData(data);
  }

  timeOf(cursor) { return this.#range[0] + this.cursors[cursor] * (this.#range[1] - this.#range[0]); }

  placeCursors() {
    this.handles.forEach((handle, k) => {
      handle.style.left = `${100 * this.cursors[k]}%`;
      handle.setAttribute("aria-valuenow", (100 * this.cursors[k]).toFixed(1));
      handle.setAttribute("aria-valuetext", withUnit(this.timeOf(k), "s"));
    });
  }

  showCursors(on) { for (const handle of this.handles) handle.hidden = !on; }

  #makeHandle(name, k, onCursor) {
    const move = (share) => { this.cursors[k] = clamp(share, 0, 1); this.placeCursors(); onCursor(); };
    const handle = el("div.cursor", { role: "slider", tabIndex: 0, "aria-label": `Cursor ${name}`, "aria-valuemin": 0, "aria-valuemax": 100 }, el("span", {}, name));
    handle.addEventListener("pointerdown", (event) => { handle.setPointerCapture(event.pointerId); handle.focus(); event.preventDefault(); });
    handle.addEventListener("pointermove", (event) => {
      if (!handle.hasPointerCapture(event.pointerId)) return;
      const box = this.#plot.over.getBoundingClientRect();
      move((event.clientX - box.left) / box.width);
    });
    handle.addEventListener("keydown", (event) => {
      const sense = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (!sense) return;
      event.preventDefault();
      move(this.cursors[k] + sense * (event.shiftKey ? 0.001 : 0.01));
    });
    return handle;
  }

  #drawMarks(plot, selected) {
    const { ctx, bbox } = plot, ratio = devicePixelRatio;
    ctx.save();
    ctx.lineWidth = ratio;
    ctx.fillStyle = ctx.strokeStyle = colour("warn");
    for (const time of this.marks.times) this.#triangle(ctx, plot.valToPos(time, "x", true), bbox.top, 5 * ratio);
    ctx.setLineDash([4 * ratio, 4 * ratio]);
    if (this.marks.zero) this.#line(ctx, plot.valToPos(0, "x", true), bbox.top, null, bbox.top + bbox.height);
    const { level } = this.marks;
    if (level) this.#line(ctx, bbox.left, clamp(plot.valToPos(level.value, `t${level.trace}`, true), bbox.top, bbox.top + bbox.height), bbox.left + bbox.width, null);
    ctx.restore();
  }

  #triangle(ctx, x, y, size) {
    ctx.beginPath();
    ctx.moveTo(x - size, y);
    ctx.lineTo(x + size, y);
    ctx.lineTo(x, y + 1.6 * size);
    ctx.fill();
  }

  #line(ctx, x, y, toX, toY) {
    ctx.beginPath();
    ctx.moveTo(x, y);
    ctx.lineTo(toX ?? x, toY ?? y);
    ctx.stroke();
  }
}
