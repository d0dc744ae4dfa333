// The oscilloscope: choice of signals, time base, trigger, run and hold, values at the cursors.
import { clamp, el, fillSelect, number, select, setText, withUnit } from "./dom.js";
import { notify } from "./drives.js";
import { AutoRange, MOST_BINS, parseChunk, TraceBuffer } from "./scope_data.js";
import { colour, ScopePlot } from "./scope_plot.js";
import { SpectrumView } from "./spectrum.js";

const MOST_TRACES = 8, FRAME_MS = 33, SPECTRUM_MS = 100, SPECTRUM_FRAMES = 8192;
const SPANS_S = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10];
const EVENTS = ["any", "trigger", "guard", "armed", "muted", "message"];

export class Scope {
  #id = 0;
  #traces = [];                 // { name, unit, colour, auto, half, range }
  #selected = 0;
  #mode = "run";                // run, single or hold
  #span = 0.1;
  #pre = 0.25;
  #trigger = { kind: "free", signal: "", level: 0 };
  #events = [];
  #buffer = null;
  #searched = 0;                // bins before this one were searched for a trigger
  #screen = null;               // what is drawn: { data, range, marks }; stays until the next trigger
  #visible = false;
  #dirty = true;
  #drawnAt = 0;
  #spectrumAt = 0;

  constructor(connection) {
    this.connection = connection;
    this.plot = new ScopePlot(() => this.#showValues());
    this.spectrum = new SpectrumView();
    this.element = el("div.scope", {}, el("div.card", {}, this.#makeBar(), this.plot.element, this.#makeTable()), this.spectrum.element);
    connection.on("description", (description) => this.#describe(description));
    connection.on("scope", (answer) => this.#accepted(answer));
    connection.on("chunk", (buffer) => this.#receive(parseChunk(buffer)));
    connection.on("event", (event) => { this.#events.push(event); this.#events.splice(0, this.#events.length - 500); });
  }

  /** Adds a signal to the traces. */
  add(name) {
    const signal = this.connection.description?.signals.find((entry) => entry.name === name);
    if (!signal || this.#traces.some((trace) => trace.name === name)) return;
    if (this.#traces.length === MOST_TRACES) return notify(`The scope shows at most ${MOST_TRACES} signals: remove one first.`);
    this.#traces.push({ name, unit: signal.unit, auto: true, half: 1, range: new AutoRange() });
    this.#changed();
  }

  /** With the simulated plant: its signals, those with a unit first, unless traces were chosen already. */
  preferPlant() {
    if (this.chosen || !this.connection.description) return;
    this.chosen = true;
    this.#traces = [];
    const plant = this.connection.description.signals.filter(({ name }) => name.startsWith("plant/"));
    for (const { name } of [...plant.filter(({ unit }) => unit), ...plant.filter(({ unit }) => !unit)].slice(0, 4)) this.add(name);
  }

  setVisible(on) {
    if (on === this.#visible) return;
    this.#visible = on;
    if (this.#mode !== "hold") this.#order();
    else if (on) this.#rebuild();
    else this.connection.send({ do: "scope", id: ++this.#id, signals: [], bin: 1 });
    if (on) requestAnimationFrame((now) => this.#loop(now));
  }

  recolour() {
    if (this.#visible) this.#rebuild();
  }

  // ---- parts of the page

  #makeBar() {
    const mode = (name, text) => el("button", { type: "button", id: `scope_${name}`, onclick: () => this.#setMode(name) }, text);
    this.buttons = { run: mode("run", "Run"), single: mode("single", "Single"), hold: mode("hold", "Hold") };
    this.status = el("span.scope_status", { id: "scope_status", role: "status" });
    const span = select("Time per screen", SPANS_S.map((s) => [s, withUnit(s, "s")]), (value) => { this.#span = Number(value); this.#order(); });
    span.value = this.#span;
    const kind = select("Trigger", [["free", "free-running"], ["rising", "level, rising"], ["falling", "level, falling"], ["event", "event"]], (value) => this.#setTrigger({ kind: value }));
    this.source = select("Signal of the trigger", [], (value) => this.#setTrigger({ signal: value }));
    this.eventKind = select("Event of the trigger", EVENTS.map((what) => [what, what === "any" ? "any event" : what]), () => this.#setTrigger({}));
    this.level = el("input.short", { type: "number", step: "any", value: "0", id: "trigger_level", "aria-label": "Level of the trigger", onchange: () => this.#setTrigger({ level: this.level.valueAsNumber || 0 }) });
    const pre = select("Share of the screen before the trigger", [0, 0.1, 0.25, 0.5, 0.75, 0.9].map((share) => [share, `${share * 100} % before`]), (value) => { this.#pre = Number(value); this.#dirty = true; });
    pre.value = this.#pre;
    span.id = "scope_span";
    kind.id = "scope_trigger";
    this.source.id = "trigger_signal";
    this.eventKind.id = "trigger_event";
    pre.id = "scope_pre";
    this.pre = pre;
    this.cursorsOn = this.#check("Cursors", true, () => { this.plot.showCursors(this.cursorsOn.checked); this.#showValues(); });
    this.stackedOn = this.#check("Stacked", false, () => this.#rebuild());
    this.spectrumOn = this.#check("Spectrum", false, () => { this.spectrum.element.hidden = !this.spectrumOn.checked; this.#order(); });
    this.choice = select("Add a signal", [], (name) => { this.chosen = true; this.add(name); this.choice.value = ""; });
    this.choice.id = "scope_add";
    const group = (...children) => el("div.group", {}, ...children);
    const bar = el("div.bar", {}, group(...Object.values(this.buttons)), span, group(kind, this.eventKind, this.source, this.level, pre),
      el("div.group.checks", {}, ...[this.cursorsOn, this.stackedOn, this.spectrumOn].map((box) => box.parentElement)), this.choice);
    this.#setTrigger({});
    this.#setMode("run");
    return bar;
  }

  #check(text, on, change) {
    const box = el("input", { type: "checkbox", checked: on, id: `scope_${text.toLowerCase()}`, onchange: change });
    el("label.check", {}, box, text);
    return box;
  }

  #makeTable() {
    this.rows = el("tbody");
    const head = ["Signal", "Scale", "A", "B", "B − A", ""].map((title) => el("th", { scope: "col" }, title));
    this.times = el("p.readout", { id: "cursor_times" });
    return el("div", {}, el("div.bar.under", {}, this.times, this.status), el("table.traces", {}, el("thead", {}, el("tr", {}, ...head)), this.rows));
  }

  #makeRow(trace, k) {
    const choose = el("button.signal", { type: "button", "aria-pressed": String(k === this.#selected), title: "Axis and spectrum of this signal", onclick: () => { this.#selected = k; this.#rebuild(); } },
      el("i", { className: `swatch c${k}` }), trace.name);
    const half = el("input.short", { type: "number", min: 0, step: "any", value: number(trace.half), disabled: trace.auto, "aria-label": `Half of the scale of ${trace.name}`, onchange: () => { trace.half = Math.abs(half.valueAsNumber) || 1; this.#dirty = true; } });
    const auto = el("input", { type: "checkbox", checked: trace.auto, "aria-label": `Automatic scale of ${trace.name}`, onchange: () => {
      trace.auto = auto.checked;
      half.disabled = trace.auto;
      if (!trace.auto) half.value = number(trace.half = Math.max(Math.abs(trace.range.low), Math.abs(trace.range.high)));
      this.#dirty = true;
    } });
    const remove = el("button.plain", { type: "button", "aria-label": `Remove ${trace.name}`, onclick: () => { this.chosen = true; this.#traces.splice(k, 1); this.#changed(); } }, "✕");
    trace.cells = [el("td.figure"), el("td.figure"), el("td.figure")];
    return el("tr", {}, el("th", { scope: "row" }, choose), el("td.scale", {}, el("label.check", {}, auto, "auto"), el("label.check", {}, "±", half)), ...trace.cells, el("td", {}, remove));
  }

  // ---- orders to the program

  #describe(description) {
    fillSelect(this.choice, [["", "Add a signal…"], ...groupsOf(description)]);
    this.choice.value = "";
    const known = new Map(description.signals.map((signal) => [signal.name, signal]));
    const before = this.#traces.length;
    this.#traces = this.#traces.filter(({ name }) => known.has(name));
    if (this.#mode === "hold" && this.#traces.length === before) return;
    if (!this.#traces.length && !this.chosen) for (const name of firstSignals(description)) this.add(name);
    if (this.element.closest("#world_scope")) this.preferPlant();
    this.#changed();
  }

  #changed() {
    this.#selected = clamp(this.#selected, 0, Math.max(0, this.#traces.length - 1));
    fillSelect(this.source, this.#traces.map(({ name }) => [name, name]));
    this.#trigger.signal = this.source.value;
    this.#order();
  }

  /** Asks for the traces; bins are as short as a screen of MOST_BINS allows, and of one frame for the spectrum. */
  #order() {
    const { description } = this.connection;
    if (!description) return;
    if (this.#mode === "hold") return this.#setMode("run");
    const frames = this.#span * description.sample_rate;
    const bin = this.spectrumOn.checked ? 1 : Math.max(1, Math.ceil(frames / MOST_BINS));
    const capacity = Math.ceil((2.5 * frames + description.sample_rate) / bin) + SPECTRUM_FRAMES;
    this.#buffer = new TraceBuffer(this.#traces.length, bin, capacity);
    this.#searched = 0;
    this.#screen = null;
    const signals = this.#visible ? this.#traces.map(({ name }) => name) : [];
    this.connection.send({ do: "scope", id: ++this.#id, signals, bin });
    this.#rebuild();
  }

  #accepted({ id, refused }) {
    if (id !== this.#id || !refused?.length) return;
    for (const { name, why } of refused) notify(`${name} is not shown: ${why}`);
    this.#traces = this.#traces.filter(({ name }) => !refused.some((entry) => entry.name === name));
    this.#changed();
  }

  #receive(chunk) {
    if (!chunk || chunk.id !== this.#id || this.#mode === "hold" || chunk.values.length !== this.#buffer?.traces) return;
    this.#buffer.write(chunk);
    this.#dirty = true;
  }

  // ---- modes, trigger and drawing

  #setMode(mode) {
    const wasHeld = this.#mode === "hold";
    this.#mode = mode;
    for (const [name, button] of Object.entries(this.buttons)) button.setAttribute("aria-pressed", String(name === mode));
    if (mode !== "hold" && wasHeld) this.#order();
    if (mode === "single") this.#searched = this.#buffer?.end ?? 0;
    this.#dirty = true;
  }

  #setTrigger(change) {
    Object.assign(this.#trigger, change);
    const { kind } = this.#trigger, level = kind === "rising" || kind === "falling";
    this.source.hidden = this.level.hidden = !level;
    this.eventKind.hidden = kind !== "event";
    this.pre.hidden = kind === "free";
    this.#searched = this.#buffer?.end ?? 0;
    this.#screen = null;
    this.#dirty = true;
  }

  #rebuild() {
    this.#traces.forEach((trace, k) => { trace.colour = colour(`t${k}`); });
    this.plot.rebuild(this.#traces, this.#selected, this.stackedOn.checked);
    this.plot.showCursors(this.cursorsOn.checked);
    this.spectrum.rebuild(this.#traces[this.#selected], this.connection.description?.sample_rate ?? 48000);
    this.rows.replaceChildren(...this.#traces.map((trace, k) => this.#makeRow(trace, k)));
    this.#dirty = true;
  }

  #loop(now) {
    if (!this.#visible) return;
    requestAnimationFrame((next) => this.#loop(next));
    if (!this.#dirty || now - this.#drawnAt < FRAME_MS || !this.#buffer) return;
    this.#drawnAt = now;
    this.#dirty = false;
    this.#draw(now);
  }

  /** The newest complete screen; null while the trigger did not occur. */
  #nextScreen() {
    const count = Math.max(2, Math.round(this.#span * this.connection.description.sample_rate / this.#buffer.bin));
    if (this.#trigger.kind === "free") return { from: this.#buffer.end - count, count, zero: this.#buffer.end };
    const before = Math.round(this.#pre * count), after = count - before;
    this.#searched = Math.min(this.#searched, this.#buffer.end);
    let found = null;
    for (let next = this.#findTrigger(this.#searched); next >= 0 && next + after <= this.#buffer.end; next = this.#findTrigger(this.#searched)) {
      found = { from: next - before, count, zero: next };
      this.#searched = next + Math.max(1, after);
      if (this.#mode === "single") break;
    }
    return found;
  }

  #findTrigger(from) {
    const { kind, signal, level } = this.#trigger, buffer = this.#buffer;
    if (kind === "event") {
      const wanted = this.eventKind.value;
      const indices = this.#events.filter(({ what }) => wanted === "any" || what === wanted).map(({ frame }) => buffer.indexOf(frame));
      return indices.find((index) => index >= Math.max(from, buffer.first)) ?? -1;
    }
    const trace = this.#traces.findIndex(({ name }) => name === signal);
    return trace < 0 ? -1 : buffer.crossing(trace, kind === "rising", level, from, buffer.end);
  }

  #draw(now) {
    const rate = this.connection.description.sample_rate;
    if (this.#mode !== "hold") {
      const next = this.#nextScreen();
      if (next) this.#screen = this.#capture(next, rate);
      const complete = this.#trigger.kind !== "free" || this.#buffer.end >= (next?.count ?? Infinity);
      if (next && this.#mode === "single" && complete) this.#setMode("hold");
    }
    this.#showStatus();
    if (this.spectrumOn.checked && now - this.#spectrumAt > SPECTRUM_MS) this.#drawSpectrum(now, rate);
    if (!this.#screen) return this.plot.draw([[], ...this.#traces.map(() => [])], [0, this.#span], this.#traces.map(() => [-1, 1]));
    const { data, range, marks } = this.#screen;
    this.plot.marks = marks;
    this.plot.draw(data, range, this.#traces.map((trace, k) => this.#scaleOf(trace, data[k + 1], now)));
    this.#showValues();
  }

  #capture({ from, count, zero }, rate) {
    const seconds = this.#buffer.bin / rate;
    return { data: this.#buffer.screen(from, count, zero, rate), range: [(from - zero) * seconds, (from - zero + count) * seconds], marks: this.#marks(from, count, zero, rate) };
  }

  #scaleOf(trace, points, now) {
    if (!trace.auto) return [-trace.half, trace.half];
    trace.range.follow(points, now);
    return [trace.range.low, trace.range.high];
  }

  #marks(from, count, zero, rate) {
    const { kind, signal, level } = this.#trigger;
    const frames = this.#events.map(({ frame }) => frame).filter((frame) => frame >= this.#buffer.frameOf(from) && frame <= this.#buffer.frameOf(from + count));
    const trace = this.#traces.findIndex(({ name }) => name === signal);
    const levelMark = (kind === "rising" || kind === "falling") && trace >= 0 ? { value: level, trace } : null;
    return { times: frames.map((frame) => (frame - this.#buffer.frameOf(zero)) / rate), zero: kind !== "free", level: levelMark };
  }

  #drawSpectrum(now, rate) {
    this.#spectrumAt = now;
    const values = this.#traces.length ? this.#buffer.last(this.#selected, SPECTRUM_FRAMES) : null;
    if (values) this.spectrum.show(values, rate);
  }

  #showStatus() {
    const waiting = this.#trigger.kind !== "free" && this.#mode !== "hold" && !this.#screen;
    setText(this.status, this.#mode === "hold" ? "held" : waiting || this.#mode === "single" ? "waiting for the trigger" : "running");
    this.status.dataset.mode = this.#mode;
  }

  /** Values of each trace at the cursors, and their time difference. */
  #showValues() {
    const on = this.cursorsOn.checked && this.#screen !== null;
    this.times.hidden = !this.cursorsOn.checked;
    if (!on) return this.#traces.forEach(({ cells }) => cells?.forEach((cell) => setText(cell, "–")));
    this.plot.placeCursors();
    const times = [0, 1].map((k) => this.plot.timeOf(k)), difference = times[1] - times[0];
    setText(this.times, `A ${withUnit(times[0], "s")} · B ${withUnit(times[1], "s")} · B − A ${withUnit(difference, "s")} · 1 / (B − A) ${difference ? withUnit(1 / Math.abs(difference), "Hz") : "–"}`);
    this.#traces.forEach((trace, k) => {
      const bins = times.map((time) => this.#valueAt(k, time));
      bins.forEach((bin, c) => setText(trace.cells[c], binText(bin, trace.unit)));
      const middle = bins.map(([low, high]) => 0.5 * (low + high));
      setText(trace.cells[2], withUnit(middle[1] - middle[0], trace.unit, 3));
    });
  }

  /** [lowest, highest] of the bin at a time of the screen. */
  #valueAt(k, time) {
    const [x, y] = [this.#screen.data[0], this.#screen.data[k + 1]], [begin, end] = this.#screen.range;
    const i = clamp(Math.round((time - begin) / (end - begin) * x.length), 0, x.length - 1);
    if (y[i] === null || y[i] === undefined) return [NaN, NaN];
    if (!this.#screen.data.pairs) return [y[i], y[i]];
    return [y[i & ~1], y[i | 1]];
  }
}

/** Inputs, outputs, nodes, controls and plant, as groups of options. */
function groupsOf({ signals, controls, graph }) {
  const inputs = new Set(graph.nodes.filter(({ type }) => type === "input").map(({ path }) => path)), settings = new Set(controls.map(({ name }) => name));
  const groups = { inputs: [], outputs: [], nodes: [], controls: [], "simulated plant": [] };
  for (const { name } of signals) {
    const group = name.startsWith("plant/") ? "simulated plant" : name.startsWith("out/") ? "outputs" : inputs.has(name) ? "inputs" : settings.has(name) ? "controls" : "nodes";
    groups[group].push([name, name]);
  }
  return Object.entries(groups).filter(([, options]) => options.length).map(([group, options]) => ({ group, options }));
}

/** The first input and the first output, or else the first signals. */
function firstSignals(description) {
  const [input, output] = ["inputs", "outputs"].map((name) => groupsOf(description).find(({ group }) => group === name)?.options[0][0]);
  const found = [input, output].filter(Boolean);
  return found.length ? found : description.signals.slice(0, 2).map(({ name }) => name);
}

function binText([low, high], unit) {
  const near = high - low < 0.03 * Math.max(Math.abs(low), Math.abs(high));
  return near ? withUnit(0.5 * (low + high), unit, 3) : `${withUnit(low, unit, 2)} … ${withUnit(high, unit, 2)}`;
}
