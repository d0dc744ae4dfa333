// The header: arm by holding, disarm, mute, state of the stream, loss of the connection.
import { byId, el, number, setText, withUnit } from "./dom.js";

const HOLD_MS = 1000;
const UNMUTE_PAUSE_MS = 600;   // a second press that follows at once does not unmute
const OWN_ORDER_MS = 1500;     // a change of the drives within this time after an order from here is its effect

/** Press begins: request; held for one second and answered: arm. Released before: nothing. */
class HoldToArm {
  #began = 0;
  #number = null;
  #timer = 0;
  #held = false;

  constructor(button, connection) {
    this.button = button;
    this.connection = connection;
    button.addEventListener("pointerdown", (event) => { if (event.button === 0) this.#begin(); });
    for (const name of ["pointerup", "pointerleave", "pointercancel", "blur"]) button.addEventListener(name, () => this.cancel());
    button.addEventListener("contextmenu", (event) => event.preventDefault());
    button.addEventListener("keydown", (event) => this.#key(event, true));
    button.addEventListener("keyup", (event) => this.#key(event, false));
    connection.on("answer", (answer) => this.#answered(answer));
    connection.on("lost", () => this.cancel());
  }

  get active() { return this.#began > 0; }

  cancel() {
    clearTimeout(this.#timer);
    this.#began = 0;
    this.#number = null;
    this.#held = false;
    this.connection.keepAlive("arming", false);
  }

  #key(event, down) {
    if (event.key !== " " && event.key !== "Enter") return;
    event.preventDefault();
    if (!down) this.cancel();
    else if (!event.repeat) this.#begin();
  }

  #begin() {
    if (this.active || this.button.getAttribute("aria-disabled") === "true") return;
    if (!this.connection.send({ do: "arm_request" })) return;
    this.connection.keepAlive("arming", true);
    this.#began = performance.now();
    this.#timer = setTimeout(() => { this.#held = true; this.#armIfReady(); }, HOLD_MS);
    this.#draw();
  }

  #answered(answer) {
    if (answer.to !== "arm_request" || !this.active) return;
    if (answer.error) return this.cancel();
    this.#number = answer.number;
    this.#armIfReady();
  }

  #armIfReady() {
    if (!this.#held || this.#number === null) return;
    this.connection.send({ do: "arm", number: this.#number });
    this.connection.keepAlive("owner", true);   // until the next state reports the owner
    this.cancel();
  }

  #draw() {
    const share = this.active ? Math.min(1, (performance.now() - this.#began) / HOLD_MS) : 0;
    byId("arm_fill").style.transform = `scaleX(${share})`;
    if (this.active) requestAnimationFrame(() => this.#draw());
  }
}

export function startDrives(connection) {
  const hold = new HoldToArm(byId("arm"), connection);
  const figures = makeFigures();
  let mutedAt = 0, disarmedAt = -Infinity;

  const mute = () => { if (connection.send({ do: "mute", on: true })) mutedAt = performance.now(); };
  const disarm = () => { if (connection.send({ do: "disarm" })) disarmedAt = performance.now(); };

  /** Says that the drives were disarmed, and why: the reason is a message, before the event or after it. */
  function report({ what, value, text }) {
    if (what === "armed" && value) byId("notice").hidden = true;
    const reason = what === "message" && /^drives disarmed/.test(text);
    if (!(reason || (what === "armed" && !value)) || performance.now() - disarmedAt < OWN_ORDER_MS) return;
    const shown = !byId("notice").hidden && /^drives disarmed/.test(byId("notice").textContent);
    if (reason || text || !shown) notify(text || "drives disarmed");
  }

  function toggleMute() {
    if (!connection.state?.muted) mute();
    else if (performance.now() - mutedAt > UNMUTE_PAUSE_MS) connection.send({ do: "mute", on: false });
  }

  function update(state) {
    const [text, kind] = driveState(state);
    setText(byId("drive_state"), text);
    byId("drive_state").dataset.kind = kind;
    enable(byId("arm"), state.drives && !state.armed);
    enable(byId("disarm"), state.armed);
    setText(byId("arm_label"), hold.active ? "Hold…" : "Hold to arm");
    setText(byId("mute"), state.muted ? "Unmute" : "Mute");
    byId("mute").setAttribute("aria-pressed", String(state.muted));
    document.body.classList.toggle("armed", state.armed);
    document.body.classList.toggle("muted", state.muted);
    updateFigures(figures, state, connection.description);
  }

  byId("mute").addEventListener("click", toggleMute);
  byId("disarm").addEventListener("click", disarm);
  byId("mute").title = "Key m or Escape";
  byId("disarm").title = "Key d";
  connection.on("state", update);
  connection.on("answer", (answer) => { if (answer.error) notify(`${answer.to}: ${answer.error}`); });
  connection.on("event", report);
  connection.on("description", () => online());
  connection.on("lost", (loss) => offline(loss));
  return { mute, disarm };
}

/** The text of the badge and its colour. */
function driveState(state) {
  if (!state.drives) return [state.muted ? "muted" : "no drives", state.muted ? "muted" : "idle"];
  if (state.armed && state.muted) return ["armed, muted", "muted"];
  if (state.armed) return [state.owner ? "armed" : "armed elsewhere", "armed"];
  return [state.muted ? "disarmed, muted" : "disarmed", state.muted ? "muted" : "idle"];
}

function enable(button, on) {
  button.setAttribute("aria-disabled", String(!on));
}

const FIGURES = [["stream", "Stream"], ["latency", "Latency"], ["load", "Load"], ["worst", "Worst load"], ["xruns", "Xruns"], ["lost", "Lost frames"], ["faults", "Faults"]];

function makeFigures() {
  const figures = {};
  for (const [key, title] of FIGURES) {
    figures[key] = el("dd", {}, "–");
    byId("figures").append(el("div", {}, el("dt", {}, title), figures[key]));
  }
  return figures;
}

function updateFigures(figures, state, description) {
  const faults = state.faults.map((fault) => `${fault.node} ${fault.count}`).join(", ");
  show(figures.stream, state.stream, state.stream !== "running");
  show(figures.load, `${number(100 * state.load, 3)} %`, state.load > 0.8);
  show(figures.worst, `${number(100 * state.load_worst, 3)} %`, state.load_worst > 0.9);
  show(figures.xruns, String(state.xruns), state.xruns > 0);
  show(figures.lost, String(state.lost_frames), state.lost_frames > 0);
  show(figures.faults, faults || "none", faults !== "");
  const latency = description?.latency;
  if (latency) show(figures.latency, latency.known === "unknown" ? "unknown" : `${withUnit(latency.seconds, "s", 3)} ${latency.known}`, latency.known === "unknown" && state.drives);
}

function show(element, text, warn) {
  setText(element, text);
  element.classList.toggle("warn", warn);
}

/** A line below the header that stays until it is closed. */
export function notify(text) {
  const close = el("button.plain", { type: "button", "aria-label": "Close the message", onclick: () => { byId("notice").hidden = true; } }, "Close");
  byId("notice").replaceChildren(el("span", {}, text), close);
  byId("notice").hidden = false;
}

function online() {
  document.body.classList.remove("offline");
  byId("banner").hidden = true;
  for (const element of document.querySelectorAll("main, .drive")) element.inert = false;
}

function offline({ wasOpen, pause }) {
  document.body.classList.add("offline");
  setText(byId("drive_state"), "not connected");
  byId("drive_state").dataset.kind = "lost";
  const why = wasOpen ? "Connection to the program lost: the values shown are old." : "No connection: the program has ended, or the link's token is no longer valid.";
  setText(byId("banner"), `${why} Next attempt in ${(pause / 1000).toFixed(1)} s.`);
  byId("banner").hidden = false;
  for (const element of document.querySelectorAll("main, .drive")) element.inert = true;
}
