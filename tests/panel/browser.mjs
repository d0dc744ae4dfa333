// What the browser tests share: the program under test, copies of instruments, and a page of the panel.
//
//   TACTUS          the program; default: build/release/tactus
//   PANEL_MODULES   a node_modules folder with puppeteer-core; default: that of the working folder
//   PANEL_WEB       a folder with pages that replace those in the program, such as remote/panel/web
//   CHROMIUM        the browser; default: /usr/bin/chromium
import { spawn } from "node:child_process";
import { once } from "node:events";
import fs from "node:fs";
import { createRequire } from "node:module";
import os from "node:os";
import path from "node:path";

const modules = path.resolve(process.env.PANEL_MODULES ?? "node_modules");
const puppeteer = createRequire(path.join(modules, "of_tests.js"))("puppeteer-core");

export const pause = (ms) => new Promise((done) => setTimeout(done, ms));

/** Waits until `read()` satisfies `check`, and returns its value. */
export async function until(read, check, what, ms = 15000) {
  const end = Date.now() + ms;
  let value;
  do {
    value = await read();
    if (check(value)) return value;
    await pause(40);
  } while (Date.now() < end);
  throw new Error(`${what}; last: ${JSON.stringify(value)}`);
}

/** `tactus play` with a panel. `text` is all that it printed. */
export class Program {
  text = "";
  #process = null;

  constructor(args) { this.args = args; }

  static async start(...args) {
    const program = new Program(args);
    await program.start();
    return program;
  }

  /** On the port of before where there was one: the link has another token. */
  async start() {
    const panel = this.port ? `--panel=${this.port}` : "--panel";
    const before = this.text.length;
    this.#process = spawn(process.env.TACTUS ?? "build/release/tactus", ["play", ...this.args, "--backend", "loop", panel, "--no-browser", "--duration", "1800 s"]);
    const child = this.#process;
    process.once("exit", () => child.kill("SIGKILL"));
    for (const stream of [this.#process.stdout, this.#process.stderr]) stream.on("data", (data) => { this.text += data; });
    const link = await until(() => this.text.slice(before).match(/(http:\/\/127\.0\.0\.1:(\d+)\/)#(\w+)\s/), (x) => x || this.ended, "link of the panel", 60000);
    if (!link) throw new Error(`the program ended:\n${this.text}`);
    [, this.page, this.port, this.token] = link;
  }

  get url() { return `${this.page}#${this.token}`; }
  get ended() { return this.#process.exitCode !== null || this.#process.signalCode !== null; }

  /** Stops the program like Ctrl-C; returns all that it printed. */
  stop() { return this.#end("SIGINT"); }
  kill() { return this.#end("SIGKILL"); }
  freeze() { this.#process.kill("SIGSTOP"); }
  thaw() { this.#process.kill("SIGCONT"); }

  /** Presses a key in the terminal, and Enter. */
  key(name) { this.#process.stdin.write(`${name}\n`); }

  async #end(signal) {
    if (this.ended) return this.text;
    const closed = once(this.#process, "close");
    this.#process.kill(signal);
    await closed;
    return this.text;
  }
}

const scratch = fs.mkdtempSync(path.join(os.tmpdir(), "panel_test_"));
process.on("exit", () => fs.rmSync(scratch, { recursive: true, force: true }));

/** A copy of a folder of instruments: its edits and presets do not change the original. */
export function copyOf(folder) {
  const copy = path.join(scratch, path.basename(folder));
  fs.cpSync(folder, copy, { recursive: true });
  return copy;
}

/** A folder with one instrument. */
export function instrument(name, text) {
  const folder = path.join(scratch, name);
  fs.mkdirSync(folder);
  fs.writeFileSync(path.join(folder, "instrument.toml"), text);
  return folder;
}

// A page that was replaced has no address of its own, and the browser would refuse its WebSocket.
const REPLACED = process.env.PANEL_WEB ? ["--disable-features=LocalNetworkAccessChecks"] : [];

export const launch = () => puppeteer.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", headless: true, protocolTimeout: 120000, args: ["--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", ...REPLACED] });

// As in remote/panel/panel_server.cpp.
const POLICY = "default-src 'self'; connect-src 'self' ws:; frame-ancestors 'none'; base-uri 'none'; form-action 'none'";
const TYPES = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml" };

/** Pages come from PANEL_WEB, messages from the program. */
async function replacePages(page, folder) {
  const uplot = path.join(modules, "uplot", "dist");
  await page.setRequestInterception(true);
  page.on("request", (request) => {
    const { pathname } = new URL(request.url());
    const file = { "/": path.join(folder, "index.html"), "/uplot.js": path.join(uplot, "uPlot.esm.js"), "/uplot.css": path.join(uplot, "uPlot.min.css") }[pathname] ?? path.join(folder, pathname);
    if (!fs.existsSync(file)) return request.continue();
    request.respond({ contentType: TYPES[path.extname(file)], headers: { "Content-Security-Policy": POLICY }, body: fs.readFileSync(file) });
  });
}

/** A page of the panel in a session of its own; `errors` collects errors of the console and exceptions. */
export async function openPanel(browser, url, { width = 1280, height = 800, theme = "light", touch = false, reducedMotion = false, connected = true } = {}) {
  const context = await browser.createBrowserContext();
  const page = await context.newPage();
  const errors = [];
  page.on("console", (message) => { if (message.type() === "error") errors.push(message.text()); });
  page.on("pageerror", (error) => errors.push(error.stack ?? String(error)));
  if (process.env.PANEL_WEB) await replacePages(page, process.env.PANEL_WEB);
  await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: theme }, ...(reducedMotion ? [{ name: "prefers-reduced-motion", value: "reduce" }] : [])]);
  await page.setViewport({ width, height, hasTouch: touch, isMobile: touch });
  await page.goto(url);
  const ready = () => !document.body.classList.contains("offline") && document.querySelector("#figures dd")?.textContent !== "–";
  if (connected) await page.waitForFunction(ready, { timeout: 30000 }).catch(() => { throw new Error(`no connection: ${errors.join("\n")}`); });
  return { page, errors, close: () => context.close() };
}
