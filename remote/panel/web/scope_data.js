// Scope data: binary frames, ring buffers of bins, search for a trigger, points of a screen.

const HEADER_BYTES = 24;
export const MOST_BINS = 4000;

/** @returns {{id: number, bin: number, count: number, frame: number, values: Float32Array[]} | null} */
export function parseChunk(buffer) {
  const view = new DataView(buffer);
  if (buffer.byteLength < HEADER_BYTES || view.getUint8(0) !== 1) return null;
  const traces = view.getUint8(1), bin = view.getUint32(8, true), count = view.getUint32(12, true);
  const length = count * (bin > 1 ? 2 : 1);
  if (buffer.byteLength < HEADER_BYTES + 4 * traces * length) return null;
  const values = Array.from({ length: traces }, (_, k) => new Float32Array(buffer, HEADER_BYTES + 4 * k * length, length));
  return { id: view.getUint32(4, true), bin, count, frame: view.getFloat64(16, true), values };
}

/** The last `capacity` bins of each trace: lowest and highest value. Bin numbers count from the first frame; lost bins are NaN. */
export class TraceBuffer {
  end = 0;
  #origin = null;

  constructor(traces, bin, capacity) {
    Object.assign(this, { traces, bin, capacity });
    this.low = Array.from({ length: traces }, () => new Float32Array(capacity).fill(NaN));
    this.high = bin === 1 ? this.low : this.low.map(() => new Float32Array(capacity).fill(NaN));
  }

  get first() { return Math.max(0, this.end - this.capacity); }
  frameOf(index) { return (this.#origin ?? 0) + index * this.bin; }
  indexOf(frame) { return Math.floor((frame - (this.#origin ?? 0)) / this.bin); }

  write({ frame, count, values }) {
    const backwards = this.#origin !== null && frame < this.frameOf(this.first);   // the stream was restarted
    if (this.#origin === null || backwards) [this.#origin, this.end] = [frame, 0];
    const begin = Math.round((frame - this.#origin) / this.bin);
    const stride = this.bin > 1 ? 2 : 1;
    for (let t = 0; t < this.traces; ++t) {
      this.#fill(t, this.end, begin);
      for (let i = 0; i < count; ++i) {
        const at = (begin + i) % this.capacity;
        this.low[t][at] = values[t][i * stride];
        if (stride === 2) this.high[t][at] = values[t][i * stride + 1];
      }
    }
    this.end = Math.max(this.end, begin + count);
  }

  #fill(t, from, to) {
    for (let i = Math.max(from, to - this.capacity); i < to; ++i) this.low[t][i % this.capacity] = this.high[t][i % this.capacity] = NaN;
  }

  /** First bin in [from, to) where the trace crosses the level; -1 if there is none. With bins of several frames: the envelope. */
  crossing(trace, rising, level, from, to) {
    const data = rising ? this.high[trace] : this.low[trace], sign = rising ? 1 : -1;
    for (let i = Math.max(from, this.first + 1); i < to; ++i) {
      const before = data[(i - 1) % this.capacity], now = data[i % this.capacity];
      if (sign * (before - level) < 0 && sign * (now - level) >= 0) return i;
    }
    return -1;
  }

  /** Data for uPlot: seconds from `zero`, then each trace; two points per bin where a bin has several frames; null where frames were lost. */
  screen(from, count, zero, rate) {
    const merge = Math.ceil(count / MOST_BINS), seconds = this.bin / rate;
    const pairs = this.bin > 1 || merge > 1;
    const data = Object.assign([[], ...this.low.map(() => [])], { pairs });
    for (let i = from; i < from + count; i += merge) {
      const x = (i - zero) * seconds;
      data[0].push(x);
      if (pairs) data[0].push(x + 0.5 * merge * seconds);
      for (let t = 0; t < this.traces; ++t) this.#push(data[t + 1], t, i, merge, pairs);
    }
    return data;
  }

  #push(points, t, from, merge, pairs) {
    let low = Infinity, high = -Infinity;
    for (let i = Math.max(from, this.first); i < Math.min(from + merge, this.end); ++i) {
      low = Math.min(low, this.low[t][i % this.capacity]);
      high = Math.max(high, this.high[t][i % this.capacity]);
    }
    const known = low <= high;
    points.push(known ? low : null);
    if (pairs) points.push(known ? high : null);
  }

  /** The last `count` values before `end`, or null if some are missing (bins of one frame only). */
  last(trace, count, end = this.end) {
    if (this.bin !== 1 || end - count < this.first) return null;
    const values = Float64Array.from({ length: count }, (_, i) => this.low[trace][(end - count + i) % this.capacity]);
    return values.some(Number.isNaN) ? null : values;
  }
}

/** A range that follows the data: it grows at once and shrinks after a second. */
export class AutoRange {
  low = -1;
  high = 1;
  #wideSince = -1;

  follow(points, now) {
    let low = Infinity, high = -Infinity;
    for (const y of points) if (y !== null) { low = Math.min(low, y); high = Math.max(high, y); }
    if (!(low <= high)) return;
    const [nextLow, nextHigh] = niceRange(low, high);
    const fits = low >= this.low && high <= this.high, small = nextHigh - nextLow < 0.6 * (this.high - this.low);
    if (fits && !small) this.#wideSince = -1;
    else if (fits && this.#wideSince < 0) this.#wideSince = now;
    if (fits && !(small && now - this.#wideSince > 1000)) return;
    [this.low, this.high, this.#wideSince] = [nextLow, nextHigh, -1];
  }
}

/** The range of data widened to multiples of 1, 2 or 5 times a power of ten. */
export function niceRange(low, high) {
  const span = Math.max(high - low, 1e-9 + 1e-3 * Math.max(Math.abs(low), Math.abs(high)));
  const power = 10 ** Math.floor(Math.log10(span / 4)), step = power * [1, 2, 5, 10].find((k) => k * power >= span / 4);
  const [floor, ceil] = [Math.floor(low / step) * step, Math.ceil(high / step) * step];
  return floor < ceil ? [floor, ceil] : [floor - step, ceil + step];
}
