// Starts the panel: connection, views, tabs, theme and keys.
import { Connection } from "./connection.js";
import { byId, el, typesText } from "./dom.js";
import { startBodies } from "./bodies.js";
import { startControls } from "./controls.js";
import { startDrives } from "./drives.js";
import { startEvents } from "./events.js";
import { startFiles } from "./files.js";
import { startGraph } from "./graph.js";
import { startGuard } from "./guard.js";
import { startLevels } from "./levels.js";
import { startPresets } from "./presets.js";
import { Scope } from "./scope.js";
import { startWorld } from "./world.js";

const VIEWS = [["play", "Play"], ["scope", "Scope"], ["graph", "Graph"], ["file", "File"], ["bodies", "Bodies"], ["world", "World"]];
const THEMES = ["auto", "light", "dark"];

const connection = new Connection();
const drives = startDrives(connection);
startPresets(connection);
startControls(connection);
startLevels(connection);
startGuard(connection);
startEvents(connection);
const scope = new Scope(connection);
const graph = startGraph(connection, (signal) => { scope.add(signal); show("scope"); });
const files = startFiles(connection);
startWorld(connection);
const bodies = startBodies(connection);

/** Shows one view; the scope is part of two of them and moves to the one that is visible. */
function show(view) {
  for (const [name] of VIEWS) {
    byId(name).hidden = name !== view;
    const tab = byId(`tab_${name}`);
    tab.setAttribute("aria-selected", String(name === view));
    tab.tabIndex = name === view ? 0 : -1;
  }
  if (view === "scope" || view === "world") byId(view === "world" ? "world_scope" : "scope_home").append(scope.element);
  if (view === "world") scope.preferPlant();
  scope.setVisible(view === "scope" || view === "world");
  graph.setVisible(view === "graph");
  bodies.setVisible(view === "bodies");
  if (view === "file") files.showError();
  sessionStorage.setItem("view", view);
}

function makeTabs() {
  const tabs = VIEWS.map(([name, title]) => el("button", { type: "button", id: `tab_${name}`, role: "tab", "aria-controls": name, onclick: () => show(name) }, title));
  byId("tabs").append(...tabs);
  byId("tabs").addEventListener("keydown", (event) => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    const shown = tabs.filter((tab) => !tab.hidden);
    const next = shown.at((shown.indexOf(event.target) + step) % shown.length);
    next.focus();
    next.click();
  });
}

function startTheme() {
  const systemIsDark = matchMedia("(prefers-color-scheme: dark)");
  let theme = localStorage.getItem("theme") ?? "auto";

  function apply() {
    document.documentElement.dataset.theme = theme === "auto" ? (systemIsDark.matches ? "dark" : "light") : theme;
    byId("theme_name").textContent = `Theme: ${theme}`;
    byId("theme").setAttribute("aria-label", `Theme: ${theme}`);
    scope.recolour();
  }

  byId("theme").addEventListener("click", () => {
    theme = THEMES[(THEMES.indexOf(theme) + 1) % THEMES.length];
    localStorage.setItem("theme", theme);
    apply();
  });
  systemIsDark.addEventListener("change", apply);
  apply();
}

/** Escape mutes always; m and d only where they are not typed into a field. */
function onKey(event) {
  if (event.repeat || event.ctrlKey || event.metaKey || event.altKey) return;
  if (event.key === "Escape") drives.mute();
  if (typesText(event.target)) return;
  if (event.key === "m") drives.mute();
  if (event.key === "d") drives.disarm();
}

function describe(description) {
  document.title = `${description.name} – Tactus`;
  byId("name").textContent = description.name;
  byId("device").textContent = `${description.device} · ${description.sample_rate / 1000} kHz · ${description.block} frames`;
  byId("device").title = description.file;
  const simulated = description.gestures.length > 0 || description.signals.some(({ name }) => name.startsWith("plant/"));
  for (const [view, there] of [["world", simulated], ["bodies", (description.worlds ?? []).length > 0]]) {
    byId(`tab_${view}`).hidden = !there;
    if (!there && !byId(view).hidden) show("play");
  }
}

makeTabs();
startTheme();
addEventListener("keydown", onKey);
connection.on("description", describe);
const remembered = sessionStorage.getItem("view");
show(VIEWS.some(([name]) => name === remembered) ? remembered : "play");
connection.start();
