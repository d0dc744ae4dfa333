// The drive guard of each output: limits, stages that acted, heat and excursion.
import { byId, el, meterRow, setText, showMeter } from "./dom.js";

/** Words for names of stages and limits. */
const WORDS = { nonfinite: "non-finite", direct: "DC", travel: "excursion", direct_level: "DC level", direct_time: "DC time" };
const wordFor = (name) => WORDS[name] ?? name.replaceAll("_", " ");

const RECENT_MS = 1000, HIGH_SHARE = 0.8;

/** Share of a limit in a meter; null hides it. */
function showShare(row, value) {
  row.element.hidden = value === null || value === undefined;
  if (!row.element.hidden) showMeter(row, value, 100 * value, `${Math.round(100 * value)} %`, value >= HIGH_SHARE);
}

class Stage {
  #count = -1;
  #actedAt = -Infinity;

  constructor(name) {
    this.name = wordFor(name);
    this.figure = el("b");
    this.element = el("li", {}, el("span", {}, this.name), this.figure);
  }

  show(count) {
    if (this.#count >= 0 && count > this.#count) this.#actedAt = performance.now();
    this.#count = count;
    const recent = performance.now() - this.#actedAt < RECENT_MS;
    this.element.classList.toggle("acts", recent);
    this.element.classList.toggle("acted", count > 0);
    this.element.title = `${this.name}: ${count} frames` + (recent ? ", acts now" : "");
    setText(this.figure, count > 9999 ? `${Math.round(count / 1000)}k` : String(count));
  }
}

class OutputGuard {
  constructor(output, stages) {
    this.stages = stages.map((name) => new Stage(name));
    this.meters = ["heat, coil", "heat, body", "excursion"].map((name) => meterRow(name, 0, 100));
    const limits = output.limits.map(({ name, value }) => `${wordFor(name)} ${value}`.replaceAll(" ", "\u00a0")).join(" · ");
    const sources = output.limits.map(({ name, value, source }) => `${name} ${value}: ${source}`).join("\n");
    const kind = output.drive ? "drive" : "sound";
    this.element = el("section.output", {}, el("h3", {}, output.name, el("small", {}, kind)), el("p.quiet", { title: sources }, limits || "no limits"),
      ...this.meters.map(({ element }) => element),
      el("ul.stages", { "aria-label": `Frames in which a stage acted on ${output.name}` }, ...this.stages.map((stage) => stage.element)));
  }

  show(counts, heat, excursion) {
    this.stages.forEach((stage, k) => stage.show(counts[k] ?? 0));
    [heat?.coil, heat?.body, excursion].forEach((value, k) => showShare(this.meters[k], value));
  }
}

export function startGuard(connection) {
  let outputs = [];
  connection.onChange(({ outputs, guard_stages }) => [outputs, guard_stages], (description) => {
    outputs = description.outputs.map((output) => new OutputGuard(output, description.guard_stages));
    byId("guard").replaceChildren(...outputs.map((output) => output.element));
  });
  connection.on("state", (state) => outputs.forEach((output, k) => output.show(state.guard[k] ?? [], state.heat[k], state.excursion[k])));
}
