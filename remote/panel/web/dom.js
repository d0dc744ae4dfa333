// Elements and numbers. Text always becomes a text node; nothing is ever parsed as HTML.

/**
 * Creates an element: el("button.wide", { type: "button", onclick: f, "aria-label": "x" }, "text", child).
 * @returns {HTMLElement}
 */
export function el(tag, attributes = {}, ...children) {
  const [name, ...classes] = tag.split(".");
  const element = document.createElement(name);
  if (classes.length) element.className = classes.join(" ");
  set(element, attributes);
  element.append(...children);
  return element;
}

/** Creates an SVG element. */
export function svg(name, attributes = {}, ...children) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", name);
  set(element, attributes);
  element.append(...children);
  return element;
}

function set(element, attributes) {
  for (const [key, value] of Object.entries(attributes)) {
    if (typeof value === "function") element.addEventListener(key.slice(2), value);
    else if (key in element && !(element instanceof SVGElement)) element[key] = value;
    else element.setAttribute(key, value);
  }
}

/** @returns {HTMLElement} */
export const byId = (id) => document.getElementById(id);

/** Writes text only if it differs: a write costs a layout. */
export function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

/** A row with a name, a bar and a figure; `more` are further parts of the bar. */
export function meterRow(name, low, high, ...more) {
  const fill = el("span.fill"), figure = el("span.figure");
  const bar = el("div.meter", { role: "meter", "aria-label": name, "aria-valuemin": low, "aria-valuemax": high }, fill, ...more);
  return { element: el("div.level", {}, el("span.name", { title: name }, name), bar, figure), bar, fill, figure };
}

/** Shows a share of the bar, its value, and text beside it. */
export function showMeter({ bar, fill, figure }, share, value, text, over) {
  fill.style.transform = `scaleX(${clamp(share, 0, 1)})`;
  bar.classList.toggle("over", over);
  bar.setAttribute("aria-valuenow", Math.round(value));
  setText(figure, text);
}

/** A labelled select; `options` are [value, text] or { group, options }. */
export function select(label, options, onchange) {
  const box = el("select", { "aria-label": label, onchange: () => onchange(box.value) });
  fillSelect(box, options);
  return box;
}

export function fillSelect(box, options) {
  const old = box.value;
  box.replaceChildren(...options.map(optionElement));
  if (old && [...box.options].some((option) => option.value === old)) box.value = old;
}

function optionElement(option) {
  if (option.group !== undefined) return el("optgroup", { label: option.group }, ...option.options.map(optionElement));
  return el("option", { value: option[0] }, option[1]);
}

export const clamp = (x, low, high) => Math.min(high, Math.max(low, x));
export const decibels = (x) => 20 * Math.log10(Math.max(x, 1e-9));

/** A number with four significant digits, without trailing zeros. */
export function number(x, digits = 4) {
  if (!Number.isFinite(x)) return "–";
  const size = Math.abs(x);
  if (size !== 0 && (size < 1e-4 || size >= 1e6)) return x.toExponential(2);
  return String(Number(x.toPrecision(digits)));
}

const PREFIXES = [[1e6, "M"], [1e3, "k"], [1, ""], [1e-3, "m"], [1e-6, "µ"], [1e-9, "n"]];

/** A number with the prefix of its size: 0.0034 V is "3.4 mV". Units that take no prefix stay as they are. */
export function withUnit(x, unit, digits = 4) {
  if (!Number.isFinite(x)) return "–";
  if (unit === "full scale") return `${number(x, digits)} FS`;
  const plain = !unit || unit === "dB" || unit.includes(" ") || unit.startsWith("1/") || x === 0;
  if (plain) return `${number(x, digits)} ${unit}`.trim();
  const [scale, prefix] = PREFIXES.find(([s]) => Math.abs(x) >= s * 0.99999) ?? PREFIXES.at(-1);
  return `${number(x / scale, digits)} ${prefix}${unit}`;
}

/** Time of day with milliseconds, of seconds since 1970. */
export function clock(seconds) {
  const date = new Date(seconds * 1000);
  return `${date.toTimeString().slice(0, 8)}.${String(date.getMilliseconds()).padStart(3, "0")}`;
}

/** True where a letter belongs to the text that is being typed; a number has no letters m and d. */
export function typesText(target) {
  return target.matches?.("input[type=text], select, textarea") ?? false;
}
