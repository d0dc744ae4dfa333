// One row per control: name, slider, number field, unit, learn button.
import { byId, clamp, el, number, setText } from "./dom.js";
import { notify } from "./drives.js";
import { step, toPosition, toValue } from "./taper.js";

const QUIET_MS = 400;     // a control that was just moved here does not follow the program
const SLIDER_STEPS = 1000;
const STEPS = { ArrowUp: 0.01, ArrowRight: 0.01, ArrowDown: -0.01, ArrowLeft: -0.01, PageUp: 0.1, PageDown: -0.1 };

class ControlRow {
  #movedAt = -Infinity;
  #pending = null;

  constructor(control, order) {
    this.control = control;
    this.order = order;
    this.value = control.value;
    this.slider = el("input", { type: "range", min: 0, max: SLIDER_STEPS, step: "any", "aria-label": control.name, oninput: () => this.move(toValue(control, this.slider.value / SLIDER_STEPS)) });
    this.field = el("input.value", { type: "number", step: "any", min: control.low, max: control.high, inputMode: "decimal", "aria-label": `${control.name}, value`, onchange: () => this.#enter() });
    this.learn = el("button.learn", { type: "button", title: "Binds the next controller that moves; press again to cancel", onclick: () => this.#toggleLearn() });
    const unit = el("span.unit", {}, control.unit);
    const name = el("div.name", { title: "Double click: value of the file" }, el("span", {}, control.name), control.about ? el("small", {}, control.about) : "");
    this.element = el("div.control", { role: "group", "aria-label": control.name }, name, this.slider, this.field, unit, this.learn);
    if (control.trigger) this.element.append(el("button", { type: "button", onclick: () => order({ do: "trigger", name: control.name }) }, "Trigger"));
    for (const place of [name, this.slider]) place.addEventListener("dblclick", () => this.reset());
    this.element.addEventListener("keydown", (event) => this.#key(event));
    this.element.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
    this.slider.style.setProperty("--home", clamp(toPosition(control, control.value), 0, 1));
    this.slider.title = "Arrow keys and wheel: fine steps, with Shift finer. Double click or Delete: value of the file.";
    for (const input of [this.slider, this.field, this.learn]) input.disabled = control.constant;
    if (control.constant) this.element.classList.add("constant");
    this.show(control.value);
  }

  /** Takes what a later description may change without a new row. */
  describe(control) {
    this.control = control;
    this.learning(false);
    this.learn.classList.toggle("bound", sourceOf(control) !== "");
  }

  learning(on) {
    this.waiting = on;
    setText(this.learn, this.control.constant ? "constant" : on ? "waiting…" : sourceOf(this.control) || "Learn");
    this.learn.setAttribute("aria-pressed", String(on));
    this.learn.setAttribute("aria-label", `Learn a controller for ${this.control.name}` + (sourceOf(this.control) ? `, now ${sourceOf(this.control)}` : ""));
  }

  reset() {
    if (!this.control.constant) this.move(this.control.value);
  }

  /** Sets the value from here: at most one order every 16 ms. */
  move(value) {
    const { low, high, constant } = this.control;
    if (constant) return;
    value = clamp(value, low, high);
    this.#movedAt = performance.now();
    this.show(value, true);
    if (this.#pending === null) setTimeout(() => this.#flush(), 16);
    this.#pending = value;
  }

  #flush() {
    this.order({ do: "set", name: this.control.name, value: this.#pending });
    this.#pending = null;
  }

  /** Shows the program's value unless the control is being moved here. */
  follow(value) {
    if (performance.now() - this.#movedAt > QUIET_MS && value !== this.value) this.show(value);
  }

  show(value, mine = false) {
    this.value = value;
    const position = clamp(toPosition(this.control, value), 0, 1);
    if (document.activeElement !== this.field || mine) this.field.value = number(value);
    this.slider.value = position * SLIDER_STEPS;
    this.slider.style.setProperty("--at", position);
    this.slider.setAttribute("aria-valuetext", `${number(value)} ${this.control.unit}`);
  }

  #enter() {
    const value = this.field.valueAsNumber;
    if (Number.isFinite(value)) this.move(value);
    else this.show(this.value, true);
  }

  #key(event) {
    if (event.target === this.slider && (event.key === "Delete" || event.key === "Backspace")) return this.reset();
    if (event.target === this.field && event.key === "Enter") return this.#enter();
    const vertical = event.key.endsWith("Up") || event.key.endsWith("Down");
    if (!(event.key in STEPS) || (event.target === this.field && !vertical) || event.target === this.learn) return;
    event.preventDefault();
    this.move(step(this.control, this.value, STEPS[event.key] * (event.shiftKey ? 0.1 : 1)));
  }

  #wheel(event) {
    if (!this.element.contains(document.activeElement)) return;
    event.preventDefault();
    const sense = Math.sign(event.deltaY || event.deltaX);
    this.move(step(this.control, this.value, -0.005 * sense * (event.shiftKey ? 0.2 : 1)));
  }

  #toggleLearn() {
    const on = !this.waiting;
    this.order({ do: "learn", name: on ? this.control.name : "" });
    this.learning(on);
  }
}

/** What moves it: a MIDI controller, an OSC address, an axis or a button, or several of them. */
function sourceOf({ midi, osc, hid }) {
  return [midi, osc, hid].filter(Boolean).join(", ");
}

/** True where a row can show either of them. */
function same(one, other) {
  const text = ({ midi, osc, hid, ...rest }) => JSON.stringify(rest);
  return text(one) === text(other);
}

export function startControls(connection) {
  let rows = [];

  function order(message) {
    if (message.do === "learn") for (const row of rows) if (row.control.name !== message.name) row.learning(false);
    connection.send(message);
  }

  function build({ controls }) {
    const focused = document.activeElement, before = rows;
    rows = controls.map((control) => before.find((row) => same(row.control, control)) ?? new ControlRow(control, order));
    byId("controls").replaceChildren(...rows.map((row) => row.element));
    if (focused.isConnected) focused.focus();
    if (!rows.length) byId("controls").append(el("p.quiet", {}, "The file has no controls."));
  }

  connection.onChange(({ controls }) => controls.map(({ midi, osc, hid, ...rest }) => rest), build);
  connection.on("description", ({ controls }) => controls.forEach((control, k) => rows[k].describe(control)));
  connection.on("state", (state) => rows.forEach((row, k) => row.follow(state.controls[k])));
  connection.on("event", ({ what, text }) => {
    if (what !== "message" || !text.startsWith("no MIDI") || !rows.some((row) => row.waiting)) return;
    rows.forEach((row) => row.learning(false));
    notify(text);
  });
  connection.on("lost", () => rows.forEach((row) => row.learning(false)));
}
