// The event lane of the last ten seconds and the list of the last events.
import { byId, clock, el, svg } from "./dom.js";

const LANE_S = 10, LONGEST_LIST = 200, WIDTH = 1000, HEIGHT = 37;
const KINDS = ["message", "guard", "armed", "muted", "trigger"];

export function startEvents(connection) {
  const recent = [];
  const marks = svg("g");
  const lane = svg("svg", { class: "lane", viewBox: `0 0 ${WIDTH} ${HEIGHT}`, preserveAspectRatio: "none", role: "img", "aria-label": "Events of the last ten seconds" }, ...seconds(), marks);
  const list = el("ol.log", { "aria-label": "Events, newest first", tabIndex: 0 });
  byId("events").append(lane, el("div.axis", {}, el("span", {}, "-10 s"), el("span", {}, "-5 s"), el("span", {}, "now")), list);

  function add(event) {
    recent.push(event);
    if (event.what === "trigger") return;  // up to 25 a second: the lane shows them
    const kind = KINDS.includes(event.what) ? event.what : "message";
    list.prepend(el(`li.${kind}`, { title: `frame ${event.frame}` }, el("time", {}, clock(event.time)), el("b", {}, event.what), el("span", {}, textOf(event))));
    while (list.children.length > LONGEST_LIST) list.lastChild.remove();
  }

  function draw(state) {
    const rate = connection.description.sample_rate;
    const old = ({ frame }) => Math.abs(state.frame - frame) / rate > LANE_S;
    while (recent.length && old(recent[0])) recent.shift();
    marks.replaceChildren(...recent.slice(-400).map((event) => mark(event, (state.frame - event.frame) / rate)));
  }

  connection.on("event", add);
  connection.on("state", (state) => { if (connection.description && lane.getClientRects().length) draw(state); });
}

/** Changes of the switches come without a text. */
function textOf({ what, text, value }) {
  if (text) return text;
  if (what === "armed") return value ? "drives armed" : "drives disarmed";
  return what === "muted" ? (value ? "muted" : "unmuted") : "";
}

function mark(event, age) {
  const x = WIDTH * (1 - age / LANE_S), row = Math.max(0, KINDS.indexOf(event.what));
  const title = event.what === "trigger" ? `${event.text}: ${event.value.toPrecision(3)}` : textOf(event);
  return svg("rect", { class: event.what, x: x - 2, y: 2 + row * 6.8, width: 4, height: 5.8 }, svg("title", {}, title));
}

function seconds() {
  return Array.from({ length: LANE_S - 1 }, (_, k) => svg("line", { x1: (k + 1) * WIDTH / LANE_S, x2: (k + 1) * WIDTH / LANE_S, y1: 0, y2: HEIGHT }));
}
