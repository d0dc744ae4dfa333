// Level meters of inputs and outputs: bars from -60 dB to full scale, with peak hold.
import { byId, clamp, decibels, el, meterRow, showMeter } from "./dom.js";

const LOWEST_DB = -60, HOLD_MS = 1500, FALL_DB_PER_S = 20;

const share = (db) => clamp(1 - db / LOWEST_DB, 0, 1);

class Meter {
  #peak = LOWEST_DB;
  #peakAt = 0;
  #drawnAt = 0;

  constructor(name) {
    this.mark = el("span.mark");
    this.row = meterRow(name, LOWEST_DB, 0, this.mark);
  }

  show(value) {
    const now = performance.now(), db = decibels(value);
    if (now - this.#peakAt > HOLD_MS) this.#peak -= FALL_DB_PER_S * (now - this.#drawnAt) / 1000;
    if (db >= this.#peak) [this.#peak, this.#peakAt] = [db, now];
    this.#drawnAt = now;
    this.mark.style.left = `${100 * share(this.#peak)}%`;
    const text = this.#peak <= LOWEST_DB ? `< ${LOWEST_DB} dB` : `${this.#peak.toFixed(1)} dB`;
    showMeter(this.row, share(db), Math.max(LOWEST_DB, db), text, value >= 1);
  }
}

export function startLevels(connection) {
  let inputs = [], outputs = [];
  connection.onChange(({ inputs, outputs }) => [inputs, outputs], (description) => {
    inputs = description.inputs.map(({ name }) => new Meter(name));
    outputs = description.outputs.map(({ name }) => new Meter(name));
    const group = (title, meters) => [el("h3", {}, title), ...meters.map((meter) => meter.row.element)];
    byId("levels").replaceChildren(...[["Inputs", inputs], ["Outputs", outputs]].filter(([, meters]) => meters.length).map(([title, meters]) => el("div", {}, ...group(title, meters))));
  });
  connection.on("state", (state) => {
    inputs.forEach((meter, k) => meter.show(state.inputs[k]));
    outputs.forEach((meter, k) => meter.show(state.outputs[k]));
  });
}
