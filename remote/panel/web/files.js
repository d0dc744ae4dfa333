// Text of the files with line numbers; errors of a live edit beside their lines.
import { byId, el } from "./dom.js";

export function startFiles(connection) {
  const view = byId("file");
  let texts = [], errors = [];
  let shown = "", accepted = null;

  function edited(message) {
    errors = message.errors;
    accepted = errors.length === 0;
    if (errors.length) shown = errors[0].file;
    draw();
  }

  function describe(description) {
    texts = description.text.filter(({ file }, k, all) => all.findIndex((other) => other.file === file) === k);
    draw();
  }

  function draw() {
    if (!texts.some(({ file }) => file === shown)) shown = texts[0]?.file ?? "";
    const tabs = el("div.bar", { role: "group", "aria-label": "Files" }, ...texts.map(fileButton));
    const current = texts.find(({ file }) => file === shown);
    view.replaceChildren(el("div.card", {}, tabs, summary(), current ? listing(current) : el("p.quiet", {}, "No files.")));
    byId("tab_file").classList.toggle("bad", errors.length > 0);
    showError();
  }

  /** Scrolls the text, not the page, to the first error. */
  function showError() {
    const line = view.querySelector(".error_line"), text = view.querySelector(".listing");
    if (line) text.scrollTop = line.offsetTop - text.clientHeight / 2;
  }

  function fileButton({ file }) {
    const count = errors.filter((error) => error.file === file).length;
    return el("button", { type: "button", "aria-pressed": String(file === shown), title: file, onclick: () => { shown = file; draw(); } }, count ? `${shortName(file)} (${count})` : shortName(file));
  }

  /** Without the folder, where only one file has the name. */
  function shortName(file) {
    const name = (path) => path.split(/[\\/]/).at(-1);
    return texts.filter((other) => name(other.file) === name(file)).length > 1 ? file : name(file);
  }

  function summary() {
    if (errors.length) return el("p.edit_state.bad", { role: "status" }, `The last edit has ${errors.length} ${errors.length === 1 ? "error" : "errors"}; the previous version keeps playing.`);
    return el("p.edit_state.quiet", { role: "status" }, accepted ? "The last edit was accepted." : "Edits of these files are compiled while the graph runs; errors are shown here.");
  }

  function listing({ file, text }) {
    const own = errors.filter((error) => error.file === file);
    const rows = text.replace(/\n$/, "").split("\n").flatMap((line, k) => {
      const here = own.filter((error) => error.line === k + 1);
      return [lineRow(k + 1, line, here.length > 0), ...here.map((error) => errorRow(error))];
    });
    const outside = own.filter((error) => !(error.line >= 1)).map((error) => errorRow(error));
    return el("div.listing", { tabIndex: 0, role: "region", "aria-label": `Text of ${file}` }, ...outside, ...rows);
  }

  connection.on("edit", edited);
  connection.onChange(({ text }) => text, describe);
  return { showError };
}

function lineRow(number, text, bad) {
  return el(bad ? "div.line.error_line" : "div.line", {}, el("span.number", {}, String(number)), el("code", {}, text || " "));
}

function errorRow({ line, column, what, remedy }) {
  const place = line >= 1 ? `${line}:${column}` : "file";
  return el("div.error", { role: "note" }, el("b", {}, place), el("span", {}, what, remedy ? el("em", {}, remedy) : ""));
}
