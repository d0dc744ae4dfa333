// The graph as a picture: nodes, edges, feedback loops, live levels; details of one node.
import { byId, clamp, el, setText, svg, withUnit } from "./dom.js";
import { layOut, THIN } from "./layout.js";

const SIZE = { width: 124, height: 40, gapX: 42, gapY: 16 };
const MARGIN = 24, LEVEL_RANGE_DB = 60, READABLE = 0.8, SMALLEST = 0.05, PLANT_GAP = 60;

export function startGraph(connection, showInScope) {
  const picture = svg("svg", { class: "picture", role: "group", "aria-label": "Graph of the instrument" });
  const frame = el("div.frame", { tabIndex: 0, role: "region", "aria-label": "Graph, scrollable" }, picture);
  const details = el("aside.card.details", { "aria-live": "polite", id: "node_details" }, el("p.quiet", {}, "Choose a node for its documentation, ports and levels."));
  const zoomBar = el("div.bar", {}, ...[["−", 0.8, "Zoom out"], ["+", 1.25, "Zoom in"], ["Fit", 0, "Fit"]].map(([text, by, label]) =>
    el("button", { type: "button", "aria-label": label, onclick: () => zoom(by) }, text)), legend());
  const leftOut = el("ul", { id: "left_out" }), leftOutBox = el("div.left_out", {}, el("h3", {}, "Left out"), leftOut);
  byId("graph").append(el("div.card", {}, el("h2", {}, "Graph"), zoomBar, frame, leftOutBox), details);

  let boxes = new Map(), edges = [], size = { width: 1, height: 1 }, scale = 1;
  let highest = [], selected = null, visible = false;

  function zoom(by) {
    scale = clamp(by ? scale * by : fitting(), SMALLEST, 3);
    picture.setAttribute("width", (size.width + 2 * MARGIN) * scale);
    picture.setAttribute("height", (size.height + 2 * MARGIN) * scale);
  }

  const fitting = () => Math.min(1, (frame.clientWidth - 2) / (size.width + 2 * MARGIN));

  /** As large as fits, but readable. */
  function firstZoom() {
    scale = Math.max(READABLE, fitting());
    zoom(1);
  }

  function describe(description) {
    highest = [];
    const model = makeModel(description);
    const layout = layOutBoth(model);
    size = layout;
    edges = layout.routes.map((route, k) => ({ source: model.sources[k], ends: model.edges[k], element: drawEdge(route) }));
    boxes = new Map(model.vertices.map((vertex) => [vertex.id, drawNode(vertex, layout.places.get(vertex.id), choose)]));
    leftOut.replaceChildren(...description.graph.nodes.filter(isAlone).map(({ path, left_out }) => el("li", {}, el("b", {}, path), ` ${left_out}`)));
    leftOutBox.hidden = leftOut.children.length === 0;
    picture.setAttribute("viewBox", `${-MARGIN} ${-MARGIN} ${size.width + 2 * MARGIN} ${size.height + 2 * MARGIN}`);
    picture.replaceChildren(arrowHead(), ...(layout.plant === null ? [] : [svg("text", { x: 0, y: layout.plant, class: "part" }, "simulated plant")]), ...edges.map(({ element }) => element), ...[...boxes.values()].map(({ element }) => element));
    if (visible) firstZoom();
    if (selected && boxes.has(selected)) choose(selected);
  }

  function choose(id) {
    boxes.get(selected)?.element.setAttribute("aria-pressed", "false");
    selected = id;
    boxes.get(id).element.setAttribute("aria-pressed", "true");
    for (const { ends, element } of edges) element.classList.toggle("near", ends.includes(id));
    details.replaceChildren(...detailsOf(boxes.get(id).vertex, connection.description, showInScope));
  }

  function update(state) {
    if (!visible) return;
    for (const { element, vertex } of boxes.values()) {
      const fault = state.faults.find(({ node }) => node === vertex.id);
      element.classList.toggle("fault", fault !== undefined);
    }
    if (state.levels?.length === connection.description.signals.length) showLevels(state.levels);   // after an edit the levels come later
  }

  /** Levels are shown relative to the highest so far of each signal, over 60 dB. */
  function showLevels(levels) {
    const share = new Map();
    connection.description.signals.forEach(({ name }, k) => {
      highest[k] = Math.max(highest[k] ?? 0, levels[k]);
      share.set(name, highest[k] > 0 && levels[k] > 0 ? clamp(1 + 20 * Math.log10(levels[k] / highest[k]) / LEVEL_RANGE_DB, 0, 1) : 0);
    });
    for (const { bar, vertex } of boxes.values()) bar.setAttribute("width", (SIZE.width - 12) * Math.max(0, ...vertex.signals.map((name) => share.get(name) ?? 0)));
    for (const { source, element } of edges) element.style.strokeOpacity = 0.3 + 0.7 * Math.max(0, ...source.map((name) => share.get(name) ?? 0));
    for (const cell of details.querySelectorAll("[data-signal]")) {
      const k = connection.description.signals.findIndex(({ name }) => name === cell.dataset.signal);
      if (k >= 0) setText(cell, withUnit(levels[k], connection.description.signals[k].unit, 3));
    }
  }

  function setVisible(on) {
    if (visible === on) return;
    visible = on;
    connection.send({ do: "levels", on });
    if (on) firstZoom();
  }

  connection.onChange(({ graph }) => [graph], describe);
  connection.on("description", () => { if (visible) connection.send({ do: "levels", on: true }); });
  connection.on("state", update);
  return { setVisible };
}

/** The instrument, and below it the simulated plant. */
function layOutBoth({ vertices, edges }) {
  const ids = vertices.map(({ id }) => id), ofPlant = (id) => id.startsWith("plant/");
  const [instrument, plant] = [false, true].map((wanted) => layOut(ids.filter((id) => ofPlant(id) === wanted), edges.filter(([, to]) => ofPlant(to) === wanted), SIZE));
  if (!plant.places.size) return { ...instrument, plant: null };
  const below = instrument.height + PLANT_GAP;
  for (const place of plant.places.values()) place.y += below;
  const routes = edges.map(([from, to]) => [...instrument.routes, ...plant.routes].find((route) => route.from === from && route.to === to));
  return { places: new Map([...instrument.places, ...plant.places]), routes, width: Math.max(instrument.width, plant.width), height: below + plant.height, plant: below - PLANT_GAP / 3 };
}

/** A node that was left out and of which no connection is known: it is listed below the picture. */
const isAlone = (node) => node.left_out !== "" && node.inputs.length === 0 && node.outputs.length === 0;

/** Vertices (inputs, nodes, outputs) and edges between them, with the signals that each edge carries. */
function makeModel({ graph, signals }) {
  const vertices = graph.nodes.filter((node) => !isAlone(node)).map((node) => ({ id: node.path, type: node.type, node, signals: node.outputs }));
  const owner = new Map();
  for (const { id, signals: own } of vertices) for (const key of [id, ...own]) if (!owner.has(key)) owner.set(key, id);
  const edges = [], sources = [];
  for (const vertex of vertices) {
    const ports = vertex.node.inputs.map(({ from }) => from);
    for (const [from, carried] of origins(ports, owner)) {
      edges.push([from, vertex.id]);
      sources.push(carried.filter((name) => signals.some((signal) => signal.name === name)));
    }
  }
  return { vertices, edges, sources };
}

/** Vertices that these ports read: a whole name, or names inside an expression. */
function origins(ports, owner) {
  const found = new Map();
  for (const port of ports) {
    const names = owner.has(port) ? [port] : String(port).match(/[A-Za-z_][\w./]*/g) ?? [];
    for (const name of names) if (owner.has(name)) found.set(owner.get(name), [...(found.get(owner.get(name)) ?? []), name]);
  }
  return found;
}

function drawNode(vertex, { x, y }, choose) {
  const { id, node, type } = vertex;
  const open = () => choose(id);
  const bar = svg("rect", { class: "level", x: 6, y: SIZE.height - 7, width: 0, height: 3 });
  const room = SIZE.width - 16;
  const title = id;
  const note = [node?.left_out && `left out: ${node.left_out}`, node?.loop >= 0 && `feedback loop ${node.loop + 1}`].filter(Boolean).join(", ");
  const element = svg("g", { class: `node ${["input", "output"].includes(type) ? type : ""} ${node?.left_out ? "left_out" : ""} ${node?.loop >= 0 ? "loop" : ""}`, transform: `translate(${x} ${y})`, tabindex: 0, role: "button",
    "aria-pressed": "false", "aria-label": `${title}, ${type}${note ? `, ${note}` : ""}`, "data-node": id, onclick: open,
    onkeydown: (event) => { if (event.key === "Enter" || event.key === " ") { event.preventDefault(); open(); } } },
  svg("title", {}, note || `${title}: ${type}`), svg("rect", { class: "box", width: SIZE.width, height: SIZE.height, rx: 4 }),
  svg("text", { x: 8, y: 15, class: "path" }, fitted(title, node?.loop >= 0 ? room - 22 : room, 600, 12)), svg("text", { x: 8, y: 28, class: "type" }, fitted(type, room, 400, 10.5)), bar);
  if (node?.loop >= 0) element.append(svg("text", { x: SIZE.width - 8, y: 15, class: "mark", "text-anchor": "end" }, `↻${node.loop + 1}`));
  return { element, vertex, bar };
}

const pen = document.createElement("canvas").getContext("2d");

/** The text, or as much of its end as is no wider than `width`: paths differ there. */
function fitted(text, width, weight, size) {
  pen.font = `${weight} ${size}px ${getComputedStyle(document.body).fontFamily}`;
  if (pen.measureText(text).width <= width) return text;
  let first = 1;
  while (first < text.length - 1 && pen.measureText(`…${text.slice(first)}`).width > width) ++first;
  return `…${text.slice(first)}`;
}

function drawEdge({ points, back, from, to }) {
  const middle = SIZE.height / 2;
  const begin = { x: points[0].x + SIZE.width, y: points[0].y + middle }, last = points.at(-1), end = { x: last.x - 5, y: last.y + middle };
  const path = back ? backPath(begin, end, from === to) : forwardPath(begin, points.slice(1, -1).map(({ x, y }) => ({ x, y: y + THIN / 2 })), end);
  return svg("path", { class: back ? "edge back" : "edge", d: path, "marker-end": "url(#arrow)", "data-edge": `${from} ${to}` });
}

function forwardPath(begin, between, end) {
  let path = `M${begin.x} ${begin.y}`, at = begin;
  for (const { x, y } of [...between, end]) {
    const half = (x - at.x) / 2;
    path += `C${at.x + half} ${at.y} ${x - half} ${y} ${x} ${y}`;
    at = { x: x === end.x ? x : x + SIZE.width, y };
    if (x !== end.x) path += `H${at.x}`;
  }
  return path;
}

/** Feedback: below both nodes and back to the left. */
function backPath(begin, end, self) {
  const low = Math.max(begin.y, end.y) + SIZE.height / 2 + (self ? 8 : 12);
  return `M${begin.x} ${begin.y}C${begin.x + 28} ${begin.y} ${begin.x + 28} ${low} ${begin.x - 8} ${low}H${end.x + 8}C${end.x - 28} ${low} ${end.x - 28} ${end.y} ${end.x} ${end.y}`;
}

function arrowHead() {
  return svg("defs", {}, svg("marker", { id: "arrow", viewBox: "0 0 6 6", refX: 1, refY: 3, markerUnits: "userSpaceOnUse", markerWidth: 8, markerHeight: 8, orient: "auto" }, svg("path", { d: "M0 0 6 3 0 6z", class: "arrow" })));
}

function legend() {
  return el("p.quiet.legend", {}, "dashed: feedback · ↻: in a feedback loop · bar: level relative to the highest so far, 60 dB");
}

function detailsOf(vertex, description, showInScope) {
  const { node, id, type, signals } = vertex;
  const head = [el("h2", {}, vertex.title ?? id, el("small", {}, type))];
  if (node?.left_out) head.push(el("p.bad", {}, `Left out: ${node.left_out}`));
  if (node) head.push(el("p", {}, node.about));
  if (node?.loop >= 0) head.push(loopText(description, node.loop));
  if (node) head.push(el("p.quiet", {}, `${node.file}, line ${node.line}`));
  const sources = new Map();
  for (const { port, from } of node?.inputs ?? []) sources.set(port, [...(sources.get(port) ?? []), from]);
  const ports = [...sources].map(([port, from]) => el("tr", {}, el("th", { scope: "row" }, port), el("td", {}, from.join(", "))));
  if (ports.length) head.push(el("h3", {}, "Inputs"), el("table", {}, el("tbody", {}, ...ports)));
  const rows = signals.map((name) => el("tr", {}, el("th", { scope: "row" }, name), el("td.figure", { "data-signal": name }, "–"),
    el("td", {}, el("button", { type: "button", onclick: () => showInScope(name) }, "Show in scope"))));
  if (rows.length) head.push(el("h3", {}, "Signals and their levels"), el("table", {}, el("tbody", {}, ...rows)));
  return head;
}

function loopText({ graph, sample_rate }, k) {
  const { paths, delay_frames } = graph.loops[k];
  const nodes = [...new Set(paths)];
  return el("p", {}, `Feedback loop ${k + 1}: ${nodes.join(", ")}; delay ${delay_frames} ${delay_frames === 1 ? "frame" : "frames"} (${withUnit(delay_frames / sample_rate, "s", 3)}).`);
}
