// The simulated world: one pad per gesture, and the delay of the system with its verdict.
import { byId, clamp, el, number, select, setText, withUnit } from "./dom.js";

const SEND_MS = 20, DELAY_PAUSE_MS = 120, MOST_DELAY_S = 0.1;
const DRAGS = [["y", "vertical position"], ["x", "horizontal position"], ["vx", "horizontal speed"], ["vy", "vertical speed"]];

/** Press: trigger. Drag: value from the position in the pad, or from the speed: one pad per second is the highest value. */
class Pad {
  #at = null;
  #speed = 0;
  #sentAt = 0;
  #later = 0;
  #value = 0;

  constructor(gesture, connection) {
    this.gesture = gesture;
    this.connection = connection;
    this.bounded = gesture.low !== undefined && gesture.high !== undefined;
    this.drag = select(`Drag of ${gesture.name}`, DRAGS, () => {});
    if (this.bounded && gesture.low < 0) this.drag.value = "vx";
    this.range = el("input.short", { type: "number", min: 0, step: "any", value: number(this.bounded ? Math.max(-gesture.low, gesture.high) : 1), "aria-label": `Highest value of ${gesture.name}` });
    this.text = el("output.figure", {}, "–");
    this.dot = el("span.dot");
    this.surface = el("div.surface", { tabIndex: 0, role: "slider", "aria-label": `${gesture.name}: Space triggers, arrow keys change the value`, "aria-valuenow": 0 }, this.dot);
    this.element = el("div.pad", {}, el("div.bar", {}, el("b", {}, gesture.name), this.text), this.surface,
      el("div.bar", {}, this.drag, el("label.bar", {}, "up to", this.range, gesture.unit ?? "")));
    this.#addHandlers();
  }

  #addHandlers() {
    this.surface.addEventListener("pointerdown", (event) => this.#press(event));
    this.surface.addEventListener("pointermove", (event) => { if (this.#at) this.#move(event); });
    for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) this.surface.addEventListener(name, () => this.#release());
    this.surface.addEventListener("keydown", (event) => this.#key(event));
  }

  get #low() { return this.bounded && this.gesture.low >= 0 ? this.gesture.low : -this.#high; }
  get #high() { return Math.abs(this.range.valueAsNumber) || 1; }

  #trigger() {
    this.connection.send({ do: "trigger", name: this.gesture.name });
    this.surface.classList.add("struck");
    setTimeout(() => this.surface.classList.remove("struck"), 120);
  }

  #place(event) {
    const box = this.surface.getBoundingClientRect();
    return { x: clamp((event.clientX - box.left) / box.width, 0, 1), y: clamp(1 - (event.clientY - box.top) / box.height, 0, 1), time: event.timeStamp };
  }

  #press(event) {
    this.surface.setPointerCapture(event.pointerId);
    this.#at = this.#place(event);
    this.#speed = 0;
    this.#showDot();
    if (this.gesture.kind !== "value") this.#trigger();
    this.#watch();
  }

  #move(event) {
    if (this.gesture.kind === "trigger") return;
    const place = this.#place(event), drag = this.drag.value, seconds = Math.max(1e-3, (place.time - this.#at.time) / 1000);
    const along = drag.endsWith("x") ? "x" : "y";
    if (drag.startsWith("v")) {
      this.#speed += (1 - Math.exp(-seconds / 0.04)) * ((place[along] - this.#at[along]) / seconds - this.#speed);
      this.#set(this.#speed * this.#high);
    } else this.#set(this.#low + place[along] * (this.#high - this.#low));
    this.#at = place;
    this.#showDot();
  }

  /** While it is pressed: a pointer that rests has no speed. */
  #watch() {
    if (!this.#at) return;
    if (this.drag.value.startsWith("v") && performance.now() - this.#at.time > 60 && this.#speed !== 0) {
      this.#speed = 0;
      this.#set(0);
    }
    requestAnimationFrame(() => this.#watch());
  }

  #release() {
    if (!this.#at) return;
    this.#at = null;
    if (this.drag.value.startsWith("v") && this.#value !== 0) this.#set(0);
  }

  #key(event) {
    if ((event.key === " " || event.key === "Enter") && !event.repeat) { event.preventDefault(); return this.#trigger(); }
    const sense = { ArrowUp: 1, ArrowRight: 1, ArrowDown: -1, ArrowLeft: -1 }[event.key];
    if (!sense) return;
    event.preventDefault();
    this.#set(this.#value + sense * (this.#high - this.#low) / (event.shiftKey ? 200 : 20));
  }

  /** Sends at most every 20 ms; the last value is always sent. */
  #set(value) {
    this.#value = clamp(value, this.#low, this.#high);
    setText(this.text, withUnit(Math.abs(this.#value) < 1e-9 ? 0 : this.#value, this.gesture.unit ?? "", 3));
    this.surface.setAttribute("aria-valuenow", number(this.#value));
    clearTimeout(this.#later);
    this.#later = setTimeout(() => {
      this.#sentAt = performance.now();
      this.connection.send({ do: "gesture", name: this.gesture.name, value: this.#value });
    }, Math.max(0, this.#sentAt + SEND_MS - performance.now()));
  }

  #showDot() {
    this.dot.style.left = `${100 * this.#at.x}%`;
    this.dot.style.top = `${100 * (1 - this.#at.y)}%`;
  }
}

function startDelay(connection) {
  let later = 0, moved = false;
  const text = el("output.figure", { id: "delay_value" }, "–");
  const verdict = el("span.verdict", { id: "verdict", role: "status" }, "no verdict yet");
  const slider = el("input", { type: "range", id: "delay_slider", min: 0, max: MOST_DELAY_S, step: 0.0005, value: 0, "aria-label": "System delay", oninput: changed });

  function show(seconds) {
    setText(text, withUnit(seconds, "s", 3));
    slider.setAttribute("aria-valuetext", withUnit(seconds, "s", 3));
    slider.style.setProperty("--at", clamp(seconds / MOST_DELAY_S, 0, 1));
  }

  function changed() {
    moved = true;
    show(slider.valueAsNumber);
    setText(verdict, "computing the verdict…");
    verdict.dataset.stable = "";
    clearTimeout(later);
    later = setTimeout(() => connection.send({ do: "delay", seconds: slider.valueAsNumber }), DELAY_PAUSE_MS);
  }

  connection.on("description", ({ delay }) => {
    byId("delay").parentElement.hidden = delay === undefined;
    if (moved || delay === undefined) return;
    slider.valueAsNumber = delay;
    show(delay);
  });
  connection.on("verdict", (answer) => {
    setText(verdict, `${withUnit(answer.delay, "s", 3)}: ${answer.text}`);
    verdict.dataset.stable = String(answer.stable);
  });
  byId("delay").append(slider, text, verdict);
}

export function startWorld(connection) {
  startDelay(connection);
  connection.onChange(({ gestures }) => gestures, ({ gestures }) => {
    byId("pads").parentElement.hidden = gestures.length === 0;
    byId("pads").replaceChildren(...gestures.map((gesture) => new Pad(gesture, connection).element));
  });
}
