// The rigid bodies of worlds, drawn live, with a table of their places.
import { byId, clamp, el, select, setText } from "./dom.js";
import { Pen } from "./pen.js";
import { watchWidth } from "./scope_plot.js";
import { Camera, between } from "./solid.js";

const VIEWS = [["front", "Front", 0, 0], ["side", "Side", Math.PI / 2, 0], ["top", "Top", 0, Math.PI / 2], ["free", "Free", 0.6, 0.35]];
const RADIANS_PER_PIXEL = 0.008, ZOOM_PER_PIXEL = 0.0015, KEY_PIXELS = 12;

/** A body of a state: position, quaternion, size; null where it is absent. */
const poseOf = (numbers) => numbers && { position: numbers.slice(0, 3), turn: numbers.slice(3, 7), size: numbers.slice(7, 10) };

const mixed = (from, to, part) => from && to ? { position: from.position.map((value, k) => value + part * (to.position[k] - value)), turn: between(from.turn, to.turn, part), size: to.size } : to;

class BodiesView {
  #worlds = [];
  #chosen = 0;
  #states = [];     // the last two: { at, world }
  #visible = false;
  #fitted = false;
  #camera = new Camera();

  constructor(connection) {
    this.connection = connection;
    this.canvas = el("canvas.bodies", { id: "bodies_canvas", tabIndex: 0, role: "img", "aria-label": "Bodies, seen from the chosen side: arrow keys turn, plus and minus zoom" });
    this.world = select("World", [], (value) => { this.#chosen = Number(value); this.#fitted = false; this.#listBodies(); });
    this.side = select("View", VIEWS.map(([id, text]) => [id, text]), (value) => this.#look(value));
    this.side.value = "free";
    this.table = el("tbody", { id: "bodies_table" });
    const fit = el("button", { type: "button", onclick: () => { this.#fitted = false; } }, "Fit");
    byId("bodies").append(el("div.card", {}, el("h2", {}, "Bodies"), el("div.bar", {}, this.world, this.side, fit), this.canvas),
      el("div.card", {}, el("h2", {}, "Places"), el("table", {}, el("thead", {}, el("tr", {}, el("th", { scope: "col" }, "body"), ...["x [m]", "y [m]", "z [m]"].map((title) => el("th.figure", { scope: "col" }, title)))), this.table)));
    watchWidth(this.canvas.parentElement, (width) => this.#resize(width));
    this.#addHandlers();
  }

  describe({ worlds = [] }) {
    this.#worlds = worlds;
    this.#states = [];
    this.#fitted = false;
    this.#chosen = clamp(this.#chosen, 0, Math.max(0, worlds.length - 1));
    this.world.replaceChildren(...worlds.map(({ name }, k) => el("option", { value: String(k) }, name)));
    this.world.value = String(this.#chosen);
    this.world.hidden = worlds.length < 2;
    this.#listBodies();
    if (this.#visible) this.#order();
  }

  /** The program sends bodies only while they are seen. */
  setVisible(visible) {
    const before = this.#visible;
    this.#visible = visible;
    if (before !== visible) this.#order();
    if (visible && !before) requestAnimationFrame(() => this.#draw());
  }

  opened() { if (this.#visible) this.#order(); }

  update({ bodies }) {
    if (!bodies || bodies.length !== this.#worlds.length) return;
    this.#states = [...this.#states.slice(-1), { at: performance.now(), bodies }];
    this.#showPlaces(bodies[this.#chosen]);
  }

  #order() { if (this.#worlds.length) this.connection.send({ do: "bodies", on: this.#visible }); }

  #listBodies() {
    const { bodies = [] } = this.#worlds[this.#chosen] ?? {};
    this.rows = bodies.map(({ name }) => el("tr", {}, el("th", { scope: "row" }, name), ...[0, 1, 2].map(() => el("td.figure", {}, "–"))));
    this.table.replaceChildren(...this.rows);
  }

  #showPlaces({ bodies }) {
    bodies.forEach((numbers, k) => {
      const plane = this.#worlds[this.#chosen].bodies[k]?.shape === "plane";
      for (let axis = 0; axis < 3; ++axis) setText(this.rows[k].cells[axis + 1], numbers && !plane ? numbers[axis].toFixed(3) : "–");
    });
  }

  #look(id) {
    const [, , yaw, pitch] = VIEWS.find(([name]) => name === id);
    [this.#camera.yaw, this.#camera.pitch] = [yaw, pitch];
  }

  #addHandlers() {
    let last = null;
    this.canvas.addEventListener("pointerdown", (event) => { this.canvas.setPointerCapture(event.pointerId); last = event; });
    this.canvas.addEventListener("pointermove", (event) => {
      if (!last) return;
      this.#turn(event.clientX - last.clientX, event.clientY - last.clientY);
      last = event;
    });
    for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) this.canvas.addEventListener(name, () => { last = null; });
    this.canvas.addEventListener("wheel", (event) => { event.preventDefault(); this.#zoom(event.deltaY); }, { passive: false });
    this.canvas.addEventListener("keydown", (event) => this.#key(event));
  }

  #turn(x, y) {
    this.#camera.yaw += RADIANS_PER_PIXEL * x;
    this.#camera.pitch = clamp(this.#camera.pitch + RADIANS_PER_PIXEL * y, -Math.PI / 2, Math.PI / 2);
    this.side.value = "free";
  }

  #zoom(pixels) { this.#camera.scale = clamp(this.#camera.scale * Math.exp(-ZOOM_PER_PIXEL * pixels), 1, 1e6); }

  #key(event) {
    const [x, y] = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key] ?? [0, 0];
    const zoom = { "+": -1, "-": 1 }[event.key] ?? 0;
    if (!x && !y && !zoom) return;
    event.preventDefault();
    this.#turn(KEY_PIXELS * x, KEY_PIXELS * y);
    this.#zoom(10 * KEY_PIXELS * zoom);
  }

  #resize(width) {
    const ratio = devicePixelRatio, height = innerWidth < 700 ? 280 : Math.max(300, Math.round(innerHeight * 0.5));
    Object.assign(this.canvas.style, { width: `${width}px`, height: `${height}px` });
    [this.canvas.width, this.canvas.height] = [width * ratio, height * ratio];
  }

  /** One state behind: bodies move on straight lines between two of them. */
  #now() {
    const [before, last] = [this.#states.at(-2) ?? this.#states.at(-1), this.#states.at(-1)];
    if (!last) return null;
    const part = last === before ? 1 : clamp((performance.now() - last.at) / (last.at - before.at), 0, 1);
    const [from, to] = [before, last].map(({ bodies }) => bodies[this.#chosen]);
    return { bodies: to.bodies.map((numbers, k) => mixed(poseOf(from.bodies[k]), poseOf(numbers), part)), handles: to.handles };
  }

  #draw() {
    if (!this.#visible) return;
    requestAnimationFrame(() => this.#draw());
    const now = this.#now(), world = this.#worlds[this.#chosen];
    if (!now || !world) return;
    const context = this.canvas.getContext("2d"), ratio = devicePixelRatio;
    const [width, height] = [this.canvas.width / ratio, this.canvas.height / ratio];
    const solids = world.bodies.map((look, k) => ({ ...look, pose: now.bodies[k] })).filter(({ pose }) => pose);
    const moving = solids.filter(({ shape }) => shape !== "plane");
    if (!this.#fitted) this.#fit(moving, width, height);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    const pen = new Pen(context, this.#camera, width, height);
    for (const plane of solids) if (plane.shape === "plane") pen.grid(plane);
    for (const solid of pen.sorted(moving)) pen.solid(solid);
    for (const handle of now.handles) pen.handle(handle, now.bodies[handle[3]]);
  }

  #fit(solids, width, height) {
    const around = ({ pose: { position, size } }) => [-1, 1].map((sign) => position.map((value) => value + sign * Math.max(...size)));
    this.#camera.fit(solids.flatMap(around), width, height);
    this.#fitted = solids.length > 0;
  }
}

export function startBodies(connection) {
  const view = new BodiesView(connection);
  connection.onChange(({ worlds }) => worlds ?? [], (description) => view.describe(description));
  connection.on("description", () => view.opened());
  connection.on("state", (state) => view.update(state));
  return view;
}
