// Spectrum of one trace: FFT with a Hann window, level in dB over a logarithmic frequency axis, highest peak.
import uPlot from "/uplot.js";
import { el, setText, withUnit } from "./dom.js";
import { axis, watchWidth } from "./scope_plot.js";

const LOWEST_DB = -140, LOWEST_HZ = 20;

/** In-place FFT of a length that is a power of two. */
export function fft(re, im) {
  const n = re.length;
  for (let i = 1, j = 0; i < n; ++i) {
    let bit = n >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i < j) { [re[i], re[j]] = [re[j], re[i]]; [im[i], im[j]] = [im[j], im[i]]; }
  }
  for (let size = 2; size <= n; size *= 2) {
    const half = size / 2, angle = -2 * Math.PI / size;
    for (let k = 0; k < half; ++k) {
      const c = Math.cos(angle * k), s = Math.sin(angle * k);
      for (let a = k; a < n; a += size) {
        const b = a + half, x = re[b] * c - im[b] * s, y = re[b] * s + im[b] * c;
        re[b] = re[a] - x; im[b] = im[a] - y;
        re[a] += x; im[a] += y;
      }
    }
  }
}

/** Level in dB of each frequency k * rate / n, of amplitude 1 = 0 dB; the mean is removed first. */
export function spectrum(values) {
  const n = values.length, mean = values.reduce((a, b) => a + b, 0) / n;
  const re = values.map((x, i) => (x - mean) * 0.5 * (1 - Math.cos(2 * Math.PI * i / n))), im = new Float64Array(n);
  fft(re, im);
  return Array.from({ length: n / 2 }, (_, k) => Math.max(LOWEST_DB, 20 * Math.log10(4 / n * Math.hypot(re[k], im[k]) + 1e-12)));
}

/** Frequency (in bins) and level of the highest peak from a bin on: of a sine between two bins, from the shape of the Hann window. */
export function highestPeak(levels, first = 1) {
  let k = first;
  for (let i = first + 1; i < levels.length - 1; ++i) if (levels[i] > levels[k]) k = i;
  const side = levels[k + 1] > levels[k - 1] ? 1 : -1, ratio = 10 ** ((levels[k + side] - levels[k]) / 20);
  const shift = Math.min(0.5, Math.max(1e-9, (2 * ratio - 1) / (ratio + 1)));
  const loss = Math.sin(Math.PI * shift) / (Math.PI * shift * (1 - shift * shift));
  return [k + side * shift, levels[k] - 20 * Math.log10(loss)];
}

export class SpectrumView {
  #plot = null;
  #levels = [LOWEST_DB, 0];

  constructor() {
    this.readout = el("p.readout", { id: "spectrum_peak" }, "no data");
    this.host = el("div.plot", { role: "img", "aria-label": "Spectrum" });
    this.element = el("div.card", { id: "spectrum", hidden: true }, el("h2", {}, "Spectrum"), this.readout, this.host);
    watchWidth(this.host, (width) => this.#plot?.setSize({ width, height: 220 }));
  }

  rebuild(trace, rate) {
    this.#plot?.destroy();
    this.#plot = null;
    setText(this.readout, "no data");
    if (!trace) return;
    this.unit = trace.unit;
    const labelled = (f) => (this.host.clientWidth > 600 ? /^[125]/ : /^1/).test(f.toExponential());
    const x = axis({ size: 28, filter: (_, splits) => splits, values: (_, splits) => splits.map((f) => (labelled(f) ? withUnit(f, "Hz", 2) : "")) });
    const y = axis({ size: 62, incrs: [20], values: (_, splits) => splits.map((db) => `${db} dB`) });
    const scales = { x: { time: false, distr: 3, range: () => [LOWEST_HZ, rate / 2] }, y: { range: () => this.#levels } };
    const series = [{}, { stroke: trace.colour, width: 1, points: { show: false } }];
    this.#plot = new uPlot({ width: this.host.clientWidth || 300, height: 220, padding: [10, 22, 0, 0], scales, axes: [x, y], series, legend: { show: false }, cursor: { show: false } }, [[], []], this.host);
  }

  show(values, rate) {
    if (!this.#plot) return;
    const levels = spectrum(values), width = rate / values.length, first = Math.ceil(LOWEST_HZ / width);
    const [peak, level] = highestPeak(levels, first);
    const top = Math.ceil((level + 5) / 20) * 20;
    this.#levels = [top - 120, top];
    this.#plot.setData([levels.map((_, k) => k * width).slice(first), levels.slice(first)]);
    setText(this.readout, `highest peak ${withUnit(peak * width, "Hz")}, ${level.toFixed(1)} dB (re amplitude ${withUnit(1, this.unit)}) · resolution ${withUnit(width, "Hz", 3)}`);
  }
}
