// Browser tests of the panel against the program: each uses one function as a player does, and checks what the page then shows and, where
// the program prints something about it, its output.
//
//   node tests/panel/panel_test.mjs [WORD]…    all tests, or those with a WORD in "SETTING: NAME"; from the root of the repository
//
// Variables of the environment: browser.mjs. Instruments that a test edits, or saves presets of, are copies.
import assert from "node:assert/strict";
import fs from "node:fs";
import path from "node:path";
import { copyOf, instrument, launch, openPanel, pause, Program, until } from "./browser.mjs";

/** Signals whose values are known. */
const BENCH = `format = 1
name   = "panel bench"
about  = "Signals whose values are known."

[inputs]
microphone = { unit = "full scale" }

[controls]
amplitude = { value = 0.25, range = [0, 0.9], smooth = "0 ms", about = "amplitude of the sine" }
frequency = { value = "1 kHz", range = ["100 Hz", "4 kHz"], smooth = "0 ms", about = "frequency of the sine" }
overload  = { value = 0, range = [0, 1], smooth = "0 ms", about = "1: values that are non-finite" }
ringing   = { value = "28 ms", range = ["8 ms", "31 ms"], about = "constant during playback" }

[nodes]
tone   = { type = "sine", frequency = "frequency", level = "amplitude" }
echo   = { type = "delay", in = "tone + 0.5 * echo", time = "10 ms", interpolation = "none" }
large  = "tone * exp(2000 * overload)"
smooth = { type = "one_pole", in = "large", cutoff = "20 kHz" }
hit    = { type = "onset", in = "microphone", threshold = "-34 dB", hold = "15 ms", ringing = "ringing", mask_time = "0.7 * ringing" }
unused = { type = "sine", frequency = "5 Hz" }
a_name_of_more_than_forty_characters_in_the_graph = "0.5 * echo"

[outputs]
woofer = { from = "smooth + 0.001 * hit.envelope" }
sound  = { from = "a_name_of_more_than_forty_characters_in_the_graph", kind = "audio" }
`;

/** A ball that goes round on a hinge, 2 m/s at 0.3 m, above a floor; a block is absent. */
const ROUND = `format = 1
name   = "round"

[worlds.hall]
ball  = { type = "sphere", radius = "6 cm", mass = "30 g", x = "30 cm", vy = "2 m/s" }
axis  = { type = "hinge", on = "ball", axis = [0, 0, 1] }
floor = { type = "plane", normal = [0, 0, 1], offset = "-20 cm" }
block = { type = "box", width = "6 cm", depth = "6 cm", height = "12 cm", mass = 1, present = 0, z = "30 cm", remote = "yes" }

[outputs]
out = { from = "hall.ball.x / 1 m", kind = "audio" }
`;

const SETTINGS = {
  drum: () => Program.start(path.join(copyOf("instruments/haptic_drum"), "instrument.toml")),
  bench: () => Program.start(path.join(instrument("bench", BENCH), "instrument.toml")),
  bodies: () => Program.start(path.join(instrument("round", ROUND), "instrument.toml")),
  world: () => Program.start("instruments/haptic_drum/scene.toml", "--listen"),
  cellomobo: () => Program.start("instruments/cellomobo/scene.toml", "--listen"),
};

const tests = [];
const test = (name, run) => tests.push({ name, run, setting: name.split(":")[0] });

// ---- what the tests share

const text = (page, selector) => page.$eval(selector, (e) => e.textContent);
const texts = (page, selector) => page.$$eval(selector, (all) => all.map((e) => e.textContent));
const visible = (page, selector) => page.$eval(selector, (e) => e.getClientRects().length > 0);
const show = (page, view) => page.evaluate((id) => document.getElementById(id).click(), `tab_${view}`);
const figure = (page, title) => page.$$eval("#figures div", (rows, wanted) => rows.find((r) => r.firstChild.textContent === wanted).lastChild.textContent, title);
const close = (a, b, tolerance) => Math.abs(a - b) <= tolerance;
const printed = (program, pattern, what, from = 0) => until(() => program.text.slice(from).match(pattern), (x) => x !== null, `${what ?? pattern} in the output of the program`);

async function centre(page, selector) {
  const box = await (await page.$(selector)).boundingBox();
  return [box.x + box.width / 2, box.y + box.height / 2];
}

/** A row of the controls: its limits and values as the page shows them. */
async function controlRow(page, name) {
  const index = (await texts(page, ".control .name span")).indexOf(name);
  assert.ok(index >= 0, `there is no control ${name}`);
  const row = `.control:nth-child(${index + 1})`;
  const field = await page.$eval(`${row} .value`, (f) => ({ low: Number(f.min), high: Number(f.max), value: f.valueAsNumber }));
  return { row, ...field, name, now: () => page.$eval(`${row} .value`, (f) => f.valueAsNumber) };
}

async function enter(page, selector, value) {
  await page.click(selector, { clickCount: 3 });
  await page.keyboard.type(String(value));
  await page.keyboard.press("Enter");
}

/** After the last touch the row follows the program again: what it then shows is the program's value. */
async function reported(control) {
  await pause(700);
  return control.now();
}

const setField = (page, selector, value) => page.$eval(selector, (f, v) => { f.value = v; f.dispatchEvent(new Event("change")); }, String(value));

async function setControl(page, name, value) {
  const control = await controlRow(page, name);
  await setField(page, `${control.row} .value`, value);
  await pause(700);
  await until(control.now, (x) => close(x, value, 1e-3 * (control.high - control.low)), `${name} = ${value}`);
}

const driveState = (page) => text(page, "#drive_state");

/** Presses the arm button and holds it until the page reports that the drives are armed. */
async function arm(page) {
  await page.mouse.move(...await centre(page, "#arm"));
  await page.mouse.down();
  await until(() => driveState(page), (x) => x.startsWith("armed"), "armed");
  await page.mouse.up();
}

async function disarm(page) {
  await page.click("#disarm");
  await until(() => driveState(page), (x) => x.startsWith("disarmed"), "disarmed");
}

const muted = (page) => page.$eval("#mute", (b) => b.getAttribute("aria-pressed") === "true");

async function unmute(page) {
  await pause(700);
  await page.click("#mute");
  await until(() => muted(page), (x) => !x, "unmuted");
}

const scopeRows = (page) => page.$$eval(".traces tbody tr", (rows) => rows.map((r) => ({ name: r.querySelector(".signal").textContent, cells: [...r.querySelectorAll("td.figure")].map((c) => c.textContent) })));
const scopeSignals = (page) => page.$$eval("#scope_add option", (all) => all.map((o) => o.value).filter(Boolean));

/** Shows these signals and no other ones. */
async function choose(page, ...names) {
  await show(page, "scope");
  while (await page.$(".traces tbody .plain")) await page.click(".traces tbody .plain");
  for (const name of names) await page.select("#scope_add", name);
  return until(() => scopeRows(page), (x) => x.length === names.length && x.every((r) => r.cells.every((c) => /\d/.test(c))), `values of ${names}`);
}

/** "-12.3 m" is -0.0123. */
function amount(written) {
  const [, figures, prefix] = written.match(/^(-?[\d.]+(?:e[-+]\d+)?)\s*([Mkmµn]?)/);
  return Number(figures) * { M: 1e6, k: 1e3, m: 1e-3, "µ": 1e-6, n: 1e-9, "": 1 }[prefix];
}

/** Moves a cursor to a share of the screen in percent. */
async function moveCursor(page, k, percent) {
  const handle = (await page.$$(".cursor"))[k];
  await handle.focus();
  const now = () => handle.evaluate((c) => Number(c.getAttribute("aria-valuenow")));
  for (let rest = percent - await now(); Math.abs(rest) > 0.06; rest = percent - await now()) {
    const fine = Math.abs(rest) < 0.95;
    if (fine) await page.keyboard.down("Shift");
    await page.keyboard.press(rest > 0 ? "ArrowRight" : "ArrowLeft");
    if (fine) await page.keyboard.up("Shift");
  }
}

/** Frequency and level of the highest peak, as written. */
async function spectrumPeak(page) {
  const [, frequency, level] = (await text(page, "#spectrum_peak")).match(/highest peak (.*?Hz), (.*?) dB/) ?? [];
  return frequency ? { frequency: amount(frequency), level: Number(level) } : { frequency: NaN, level: NaN };
}

async function overlaps(page) {
  return page.$$eval("[data-node] .box", (all) => {
    const boxes = all.map((b) => b.getBoundingClientRect());
    return boxes.filter((a, i) => boxes.some((b, j) => j > i && a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom)).length;
  });
}

const chooseNode = (page, id) => page.evaluate((node) => document.querySelector(`[data-node="${CSS.escape(node)}"]`).dispatchEvent(new MouseEvent("click")), id);

// ---- connection

test("drum: the token leaves the address; the description is shown", async ({ page }) => {
  assert.equal(await page.evaluate(() => location.hash), "");
  assert.equal(await text(page, "#name"), "haptic drum");
  assert.match(await text(page, "#device"), /^loop:cable · 48 kHz · 64 frames$/);
  assert.equal(await figure(page, "Latency"), "unknown");
  assert.equal(await figure(page, "Stream"), "running");
  assert.deepEqual((await texts(page, ".control .name span")).slice(0, 3), ["roll_rate", "strength", "hand_leads"]);
  assert.ok(!await visible(page, "#tab_world"), "no world on a sound card");
});

test("drum: a wrong token is refused, and the page says so", async ({ program, browser }) => {
  const { page, close: end } = await openPanel(browser, `${program.page}#wrong`, { connected: false });
  await until(() => text(page, "#banner"), (x) => /token/.test(x), "banner");
  assert.ok(await page.$eval("main", (m) => m.inert));
  await end();
});

test("drum: at most eight browsers", async ({ page, program }) => {
  const accepted = await page.evaluate(async (token) => {
    const sockets = Array.from({ length: 9 }, () => new WebSocket(`ws://${location.host}/session?token=${token}`));
    const results = await Promise.all(sockets.map((socket) => new Promise((done) => { socket.onopen = () => done(1); socket.onerror = () => done(0); })));
    sockets.forEach((socket) => socket.close());
    return results.reduce((a, b) => a + b);
  }, program.token);
  assert.equal(accepted, 7);
});

test("drum: a program that stalls is reported; it disarms, and the connection returns", async ({ page, program }) => {
  await arm(page);
  const before = program.text.length;
  program.freeze();
  await until(() => visible(page, "#banner"), (x) => x, "banner");
  assert.match(await text(page, "#banner"), /Connection to the program lost/);
  assert.ok(await page.$eval("main", (m) => m.inert) && await page.$eval(".drive", (m) => m.inert));
  program.thaw();
  await until(() => visible(page, "#banner"), (x) => !x, "banner gone", 30000);
  assert.ok(!await page.$eval("main", (m) => m.inert));
  await until(() => driveState(page), (x) => x === "disarmed", "disarmed");
  await printed(program, /drives disarmed/, "reason", before);
});

test("restart: the program ends and starts with another token", async ({ browser }) => {
  const program = await SETTINGS.drum();
  const { page, close: end } = await openPanel(browser, program.url);
  await program.kill();
  await until(() => visible(page, "#banner"), (x) => x, "banner");
  await program.start();
  await until(() => text(page, "#banner"), (x) => /No connection: .*token is no longer valid/.test(x), "the token is named");
  await page.goto(program.url);
  await until(() => visible(page, "#banner"), (x) => !x, "the new link connects");
  assert.equal(await text(page, "#name"), "haptic drum");
  await end();
  assert.match(await program.stop(), /panel +\d+ messages, 0 refused, 0 changes/);
});

// ---- controls

test("drum: number field, slider keys, wheel, limits and reset", async ({ page }) => {
  const control = await controlRow(page, "roll_rate"), slider = `${control.row} [type=range]`;
  assert.deepEqual([control.low, control.high, control.value], [8, 25, 20]);
  await enter(page, `${control.row} .value`, 12.5);
  assert.equal(await reported(control), 12.5, "value of the field");
  await page.focus(slider);
  await page.keyboard.press("ArrowUp");
  const up = await reported(control);
  assert.ok(up > 12.5, "arrow key raises");
  await page.hover(slider);
  await page.mouse.wheel({ deltaY: 120 });
  assert.ok(await reported(control) < up, "wheel lowers");
  await enter(page, `${control.row} .value`, 99);
  assert.equal(await reported(control), 25, "limited to the range");
  const box = await (await page.$(`${control.row} .name`)).boundingBox();
  await page.mouse.click(box.x + 20, box.y + 10, { count: 2 });
  assert.equal(await reported(control), 20, "double click: value of the file");
  await page.focus(slider);
  await page.keyboard.press("PageUp");
  await pause(100);
  await page.keyboard.press("Delete");
  assert.equal(await reported(control), 20, "Delete: value of the file");
});

test("drum: controls in ms and dB keep their unit", async ({ page }) => {
  for (const [name, unit, value] of [["hold", "ms", 42], ["sensitivity", "dB", -20.5]]) {
    const control = await controlRow(page, name);
    assert.equal(await text(page, `${control.row} .unit`), unit);
    await enter(page, `${control.row} .value`, value);
    assert.ok(close(await reported(control), value, 1e-3), name);
    await page.focus(`${control.row} [type=range]`);
    await page.keyboard.press("Delete");
    assert.ok(close(await reported(control), control.value, 1e-3), `${name} of the file`);
  }
});

test("drum: dragging a slider; a second browser follows", async ({ page, open }) => {
  const control = await controlRow(page, "strength");
  const other = await open();
  const theirs = await controlRow(other.page, "strength");
  await page.bringToFront();
  const slider = await (await page.$(`${control.row} [type=range]`)).boundingBox();
  await page.mouse.move(slider.x + slider.width - 2, slider.y + slider.height / 2);
  await page.mouse.down();
  await page.mouse.move(slider.x + 0.5 * slider.width, slider.y + slider.height / 2, { steps: 8 });
  await page.mouse.up();
  const value = await reported(control);
  assert.ok(close(value, 0.5, 0.03), String(value));
  await until(theirs.now, (x) => x === value, "the second browser shows it");
  await page.mouse.click(slider.x + 10, slider.y + slider.height / 2, { count: 2 });
  assert.equal(await reported(control), 1, "double click on the slider");
  await other.close();
});

test("drum: tapers, in numbers", async ({ page }) => {
  const result = await page.evaluate(async () => {
    const { toPosition, toValue, step } = await import("/taper.js");
    const log = { taper: "logarithmic", low: 10, high: 1000 }, linear = { taper: "linear", low: -60, high: 0 }, zero = { taper: "logarithmic", low: 0, high: 8 };
    return [toValue(log, 0.5), toPosition(log, 100), toValue(linear, 0.25), toPosition(linear, -15), toValue(zero, 0.5), toValue(log, 0), toValue(log, 1), step(linear, -30, 0.01), step(log, 100, 0.01)];
  });
  const wanted = [100, 0.5, -45, 0.75, 4, 10, 1000, -29.4, 104.7];
  result.forEach((x, k) => assert.ok(close(x, wanted[k], 0.02), `${k}: ${x}`));
});

test("drum: constant controls are disabled", async ({ page }) => {
  for (const name of ["ringing", "deaf_below"]) {
    const { row } = await controlRow(page, name);
    assert.ok(await page.$$eval(`${row}.constant :is(input, button)`, (all) => all.length > 0 && all.every((e) => e.disabled)), name);
  }
  assert.equal(await page.$$eval(".control.constant", (all) => all.length), 2);
});

/** Without a MIDI sequencer the program says so, and the button no longer waits. */
test("drum: learn waits, and can be cancelled", async ({ page }) => {
  const { row } = await controlRow(page, "strength"), button = `${row} .learn`;
  await page.click(button);
  const answer = await until(() => texts(page, ".log .message"), (x) => x.some((t) => /no MIDI|move the MIDI controller for strength/.test(t)), "answer of the program");
  await pause(500);
  if (await page.$eval(button, (b) => b.getAttribute("aria-pressed")) === "true") await page.click(button);
  else assert.match(await text(page, "#notice"), /no MIDI/, answer.join());
  await until(() => page.$eval(button, (b) => b.getAttribute("aria-pressed")), (x) => x === "false", "cancelled");
});

test("drum: presets: save under a name, change, recall with a ramp", async ({ page, program }) => {
  const control = await controlRow(page, "strength");
  await enter(page, `${control.row} .value`, 0.7);
  assert.equal(await reported(control), 0.7);
  await page.type("#preset_name", "test preset");
  await page.click("#preset_save");
  await until(() => page.$$eval("#preset option", (all) => all.map((o) => o.value)), (x) => x.includes("test preset"), "preset in the list");
  const saved = fs.readFileSync(path.join(path.dirname(program.args[0]), "presets/test preset.toml"), "utf8");
  assert.match(saved, /strength\s*=\s*0\.7\b/);
  await enter(page, `${control.row} .value`, 0);
  assert.equal(await reported(control), 0);
  await page.select("#preset", "test preset");
  await setField(page, "#preset_ramp", 1);
  await page.click("#preset_recall");
  await until(control.now, (x) => x > 0.05 && x < 0.65, "a value of the ramp");
  await until(control.now, (x) => close(x, 0.7, 1e-3), "value of the preset");
  await enter(page, `${control.row} .value`, 1);
  assert.equal(await reported(control), 1);
});

// ---- drives

test("drum: a short press does not arm; holding does, and stays armed; disarm", async ({ page, program }) => {
  const before = program.text.length;
  await page.mouse.move(...await centre(page, "#arm"));
  await page.mouse.down();
  await pause(600);
  await page.mouse.up();
  await pause(900);
  assert.equal(await driveState(page), "disarmed");
  await arm(page);
  await pause(2000);
  assert.equal(await driveState(page), "armed", "signs of life keep it armed");
  await printed(program, /drives armed by a remote client/, undefined, before);
  await disarm(page);
  await printed(program, /drives disarmed by a remote client/, undefined, before);
  await until(() => texts(page, ".log .armed"), (x) => x.length >= 2 && x.every((t) => /armed/.test(t)), "events");
});

test("drum: holding the edge of the arm button arms too", async ({ page }) => {
  const box = await (await page.$("#arm")).boundingBox();
  for (const x of [box.x + 4, box.x + box.width - 4]) {
    await page.mouse.move(x, box.y + box.height / 2);
    await page.mouse.down();
    await until(() => driveState(page), (x) => x === "armed", `armed at ${x}`);
    await page.mouse.up();
    await disarm(page);
  }
});

test("drum: arm by keyboard, disarm with d", async ({ page }) => {
  await page.focus("#arm");
  await page.keyboard.down("Space");
  await pause(500);
  await page.keyboard.up("Space");
  await pause(900);
  assert.equal(await driveState(page), "disarmed");
  await page.keyboard.down("Enter");
  await until(() => driveState(page), (x) => x === "armed", "armed");
  await page.keyboard.up("Enter");
  await page.keyboard.press("d");
  await until(() => driveState(page), (x) => x === "disarmed", "disarmed");
});

test("drum: leaving the button while holding does not arm", async ({ page }) => {
  await page.mouse.move(...await centre(page, "#arm"));
  await page.mouse.down();
  await pause(400);
  await page.mouse.move(10, 400);
  await pause(1000);
  await page.mouse.up();
  assert.equal(await driveState(page), "disarmed");
});

test("drum: the page stays alive in the background", async ({ page }) => {
  await arm(page);
  const other = await page.browserContext().newPage();
  await other.bringToFront();
  await pause(3000);
  await other.close();
  await page.bringToFront();
  assert.equal(await driveState(page), "armed");
  await disarm(page);
});

test("drum: closing the page disarms; a second page sees it and why", async ({ open, page, program }) => {
  const owner = await open();
  await arm(owner.page);
  await until(() => driveState(page), (x) => x === "armed elsewhere", "seen by the second page");
  const before = program.text.length;
  await owner.close();
  await until(() => driveState(page), (x) => x === "disarmed", "disarmed");
  await printed(program, /drives disarmed/, undefined, before);
  await until(() => text(page, "#notice"), (x) => /drives disarmed/i.test(x), "notice");
  assert.ok(await visible(page, "#notice"));
});

test("drum: a page that hangs disarms", async ({ open, page, program }) => {
  const owner = await open();
  await arm(owner.page);
  const before = program.text.length;
  const session = await owner.page.createCDPSession();
  await session.send("Debugger.enable");
  await session.send("Debugger.pause");
  await until(() => driveState(page), (x) => x === "disarmed", "disarmed");
  await printed(program, /drives disarmed: the remote client that had armed them was silent for 0\.5 s/, undefined, before);
  await until(() => text(page, "#notice"), (x) => /silent for 0\.5 s/.test(x), "reason in the notice");
  await session.send("Debugger.resume");
  await owner.close();
});

test("drum: another page disarms and mutes", async ({ open, page }) => {
  const owner = await open();
  await arm(owner.page);
  await page.bringToFront();
  await until(() => driveState(page), (x) => x === "armed elsewhere", "armed elsewhere");
  assert.equal(await page.$eval("#arm", (b) => b.getAttribute("aria-disabled")), "true");
  await page.keyboard.press("m");
  await until(() => driveState(owner.page), (x) => x === "armed, muted", "muted for the owner");
  await unmute(page);
  await disarm(page);
  await until(() => text(owner.page, "#notice"), (x) => /disarmed/.test(x), "notice of the owner");
  await owner.close();
});

test("drum: mute: button, m and Escape, never by typing; unmute by the button", async ({ page, program }) => {
  await page.click("#mute");
  await until(() => muted(page), (x) => x, "muted by the button");
  await printed(program, /muted by a remote client/);
  await page.click("#mute");
  await pause(200);
  assert.ok(await muted(page), "a second press at once does not unmute");
  await unmute(page);
  await page.keyboard.press("m");
  await until(() => muted(page), (x) => x, "muted by m");
  await unmute(page);
  await page.focus(".control .value:enabled");
  await page.keyboard.press("m");
  await until(() => muted(page), (x) => x, "muted by m in a number field");
  await unmute(page);
  await page.focus("#preset_name");
  await page.keyboard.type("md");
  await pause(300);
  assert.ok(!await muted(page), "typing does not mute");
  await page.keyboard.press("Escape");
  await until(() => muted(page), (x) => x, "muted by Escape in a field");
  await unmute(page);
});

test("drum: mute is always in sight, also on a phone after scrolling", async ({ open }) => {
  const { page, close: end } = await open({ width: 360, height: 740, touch: true });
  await page.evaluate(() => scrollTo(0, document.body.scrollHeight));
  const box = await until(() => page.$eval("#mute", (b) => { const r = b.getBoundingClientRect(); return [r.top, r.bottom, r.width, r.height]; }), (x) => x[1] < 300, "in sight");
  assert.ok(box[0] >= 0 && box[2] >= 90 && box[3] >= 44, JSON.stringify(box));
  await end();
});

test("bench: the guard: limits, a stage that acts, its counts", async ({ page, program }) => {
  const outputs = await page.$$eval("#guard .output", (all) => all.map((o) => ({ name: o.querySelector("h3").firstChild.textContent, stages: o.querySelectorAll(".stages li").length, limits: o.querySelector("p").textContent })));
  assert.deepEqual(outputs.map(({ name, stages }) => [name, stages]), [["woofer", 7], ["sound", 7]]);
  assert.match(outputs[0].limits, /ceiling.0\.5 · slew.6300 · DC.level.0\.15/);
  assert.equal(await page.$$eval("#guard .level", (all) => all.filter((e) => e.getClientRects().length).length), 0, "unknown heat and excursion are hidden");
  await setControl(page, "amplitude", 0.9);
  await arm(page);
  await until(() => texts(page, "#guard .output:first-child .acts span"), (x) => x.includes("ceiling"), "the ceiling acts");
  await until(() => texts(page, "#guard .output:first-child .acted"), (x) => x.some((t) => /^ceiling[1-9]/.test(t)), "count");
  await until(() => page.$$eval("#levels .level", (rows) => rows.filter((r) => r.textContent.startsWith("woofer")).map((r) => parseFloat(r.querySelector(".figure").textContent))[0]), (x) => close(x, -6, 0.3), "a ceiling of 0.5 is -6 dB");
  await disarm(page);
  await setControl(page, "amplitude", 0.25);
  await until(() => texts(page, "#guard .acts"), (x) => x.length === 0, "no stage acts any more");
});

test("bench: a fault names its node, on top and in the graph", async ({ page, program }) => {
  assert.equal(await figure(page, "Faults"), "none");
  await setControl(page, "overload", 1);
  await until(() => figure(page, "Faults"), (x) => /large \d+/.test(x), "fault");
  await printed(program, /large: non-finite output/);
  await until(() => texts(page, ".log .message"), (x) => x.some((t) => /large: non-finite output/.test(t)), "message in the list");
  await setControl(page, "overload", 0);
  await show(page, "graph");
  await until(() => page.$eval("[data-node=large]", (n) => n.classList.contains("fault")), (x) => x, "fault in the graph");
});

test("bench: levels of inputs and outputs; a drive that is disarmed is silent", async ({ page }) => {
  const rows = await until(() => texts(page, "#levels .level"), (x) => x.length === 3 && x.every((t) => /dB/.test(t)), "levels");
  assert.ok(rows[0].startsWith("microphone") && rows[1].startsWith("woofer"));
  await until(() => texts(page, "#levels .level"), (x) => /< -60 dB/.test(x[1]), "silent");
});

test("drum: events: list with times, and the lane", async ({ page }) => {
  await page.keyboard.press("m");
  const item = await until(() => texts(page, ".log .muted"), (x) => x.length > 0, "event in the list");
  assert.match(item[0], /^\d\d:\d\d:\d\d\.\d\d\dmuted/);
  await until(() => page.$$eval(".lane .muted", (all) => all.length), (x) => x > 0, "mark in the lane");
  await unmute(page);
  await until(() => texts(page, ".log li"), (x) => x.some((t) => /unmuted/.test(t)), "unmuted in the list");
});

// ---- scope

test("drum: scope: all signals can be chosen; up to eight traces, removal", async ({ page }) => {
  await show(page, "scope");
  const names = await scopeSignals(page);
  assert.equal(new Set(names).size, names.length);
  assert.ok(names.includes("cone.position") && names.includes("out/woofer") && names.length > 80, String(names.length));
  const rows = await choose(page, ...names.slice(0, 4), ...names.slice(-4));
  assert.equal(new Set(rows.map((r) => r.name)).size, 8);
  await page.select("#scope_add", names[5]);
  assert.match(await text(page, "#notice"), /at most 8/);
  await page.click(".traces tbody tr:last-child .plain");
  await until(() => scopeRows(page), (x) => x.length === 7, "removed");
});

test("bench: scope: a sine has its amplitude and period at the cursors", async ({ page }) => {
  await choose(page, "tone", "out/sound");
  await page.select("#scope_span", "0.002");
  await page.select("#scope_trigger", "rising");
  await page.select("#trigger_signal", "tone");
  // Its zero is 0.5 ms after the left edge: the maximum at 0.75 ms, the minimum half a period later.
  await moveCursor(page, 0, 37.5);
  await moveCursor(page, 1, 62.5);
  await until(() => text(page, "#cursor_times"), (x) => /^A 250 µs · B 750 µs · B − A 500 µs · 1 \/ \(B − A\) 2 kHz/.test(x), "times of the cursors");
  // A frame is 7.5 degrees of the sine: at most 0.9 % less.
  const at = async (name) => (await scopeRows(page)).find((r) => r.name === name).cells.map(amount);
  await until(() => at("tone"), ([a, b]) => close(a, 0.25, 0.003) && close(b, -0.25, 0.003), "0.25 and -0.25");
  // The echo of 10 periods adds to the tone: 0.25 / (1 - 0.5), of which the output is half.
  await until(() => at("out/sound"), ([a, b]) => close(a, 0.25, 0.003) && close(b, -0.25, 0.003), "output");
  await page.select("#scope_pre", "0.5");
  await until(() => text(page, "#cursor_times"), (x) => x.startsWith("A -250 µs"), "half before the trigger");
  await until(() => at("tone"), ([a, b]) => close(a, -0.25, 0.003) && close(b, 0.25, 0.003), "half a period earlier");
  await page.select("#scope_trigger", "falling");
  await until(() => at("tone"), ([a, b]) => close(a, 0.25, 0.003) && close(b, -0.25, 0.003), "falling");
  await setField(page, "#trigger_level", 30);
  await until(() => text(page, "#scope_status"), (x) => x === "waiting for the trigger", "waiting");
});

test("bench: scope: with long screens the lowest and the highest value of a bin", async ({ page }) => {
  await choose(page, "tone");
  for (const span of ["0.001", "0.1", "1", "10"]) {
    await page.select("#scope_span", span);
    await until(() => scopeRows(page), ([r]) => /\d/.test(r.cells[1]), `values of ${span} s`, 30000);
  }
  // 120 frames are 2.5 periods.
  const cell = await until(async () => (await scopeRows(page))[0].cells[1], (x) => x.includes("…"), "range");
  const [low, high] = cell.split("…").map((t) => amount(t.trim()));
  assert.ok(close(low, -0.25, 0.01) && close(high, 0.25, 0.01), cell);
});

test("bench: scope: an event as trigger", async ({ page }) => {
  await choose(page, "tone");
  await page.select("#scope_trigger", "event");
  await page.select("#trigger_event", "muted");
  assert.deepEqual(await page.$$eval("#trigger_event option", (all) => all.map((o) => o.value)), ["any", "guard", "armed", "muted", "message"]);
  await until(() => text(page, "#scope_status"), (x) => x === "waiting for the trigger", "waiting");
  await page.keyboard.press("Escape");
  await until(() => text(page, "#scope_status"), (x) => x === "running", "event found");
  assert.match((await scopeRows(page))[0].cells[0], /\d/);
  await unmute(page);
});

test("bench: spectrum: frequency and level of a sine, of an echo by theory", async ({ page }) => {
  await choose(page, "tone", "echo");
  await page.click("#scope_spectrum");
  // 20 log10(0.25) = -12.04 dB
  await until(() => spectrumPeak(page), (x) => close(x.frequency, 1000, 1) && close(x.level, -12.04, 0.1), "1 kHz, -12.0 dB");
  // The echo of 10 periods: 0.25 / (1 - 0.5)
  await page.click(".traces tbody tr:nth-child(2) .signal");
  await until(() => spectrumPeak(page), (x) => close(x.frequency, 1000, 1) && close(x.level, -6.02, 0.1), "echo: -6.0 dB");
  // Of 10.5 periods: 0.25 / (1 + 0.5)
  await show(page, "play");
  await setControl(page, "frequency", 1.05);
  await show(page, "scope");
  await until(() => spectrumPeak(page), (x) => close(x.frequency, 1050, 1) && close(x.level, -15.56, 0.15), "echo of 1050 Hz: -15.6 dB");
  await show(page, "play");
  await setControl(page, "frequency", 1);
});

test("bench: scope: hold freezes, single takes one screen, run continues", async ({ page }) => {
  await choose(page, "tone", "echo");
  const picture = () => page.$eval(".scope canvas", (c) => c.toDataURL());
  await until(() => text(page, "#scope_status"), (x) => x === "running", "running");
  await page.click("#scope_hold");
  await until(() => text(page, "#scope_status"), (x) => x === "held", "held");
  const held = await picture();
  await pause(500);
  assert.equal(await picture(), held, "held");
  await page.click("#scope_run");
  await until(picture, (x) => x !== held, "running again");
  await page.click("#scope_single");
  await until(() => text(page, "#scope_status"), (x) => x === "held", "single ends in hold");
  await page.click("#scope_run");
  await until(() => text(page, "#scope_status"), (x) => x === "running", "running");
});

test("bench: scope: a browser that is busy loses frames, which are a gap", async ({ page }) => {
  await choose(page, "tone");
  await page.select("#scope_span", "0.05");
  await page.evaluate(() => { const end = performance.now() + 2000; while (performance.now() < end); });
  await until(async () => [await text(page, "#scope_status"), (await scopeRows(page))[0].cells[0]], ([status, cell]) => status === "running" && /\d/.test(cell), "running again");
  const gaps = await page.evaluate(async () => {
    const { TraceBuffer } = await import("/scope_data.js");
    const buffer = new TraceBuffer(1, 1, 100);
    buffer.write({ frame: 1000, count: 10, values: [new Float32Array(10).fill(1)] });
    buffer.write({ frame: 1020, count: 10, values: [new Float32Array(10).fill(2)] });
    const screen = buffer.screen(0, 30, 0, 48000)[1];
    buffer.write({ frame: 40, count: 5, values: [new Float32Array(5).fill(3)] });   // the stream was restarted
    return [...screen, ...buffer.screen(0, 5, 0, 48000)[1]];
  });
  assert.deepEqual(gaps.slice(8, 22), [1, 1, ...Array(10).fill(null), 2, 2]);
  assert.deepEqual(gaps.slice(30), Array(5).fill(3));
});

test("bench: scope: the browser that asks last has it, and the other one is told", async ({ page, open }) => {
  await choose(page, "tone");
  const other = await open();
  await choose(other.page, "echo");
  await until(() => text(page, "#notice"), (x) => /another panel has taken the scope/.test(x), "notice");
  await page.bringToFront();
  await choose(page, "tone", "echo");
  await until(() => text(other.page, "#notice"), (x) => /another panel has taken the scope/.test(x), "notice of the other one");
  await other.close();
  await until(() => text(page, "#scope_status"), (x) => x === "running", "running");
  await page.select("#scope_span", "0.02");
  await until(() => scopeRows(page), (x) => x.length === 2 && x.every((r) => /\d/.test(r.cells[0])), "data");
});

test("bench: scope: cursors by mouse, scale by hand, stacked traces", async ({ page }) => {
  await choose(page, "tone", "echo");
  const read = async () => Number(await page.$eval(".cursor", (c) => c.getAttribute("aria-valuenow")));
  const before = await read(), [x, y] = await centre(page, ".cursor");
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 200, y, { steps: 5 });
  await page.mouse.up();
  assert.ok(await read() > before + 10);
  await page.click("#scope_cursors");
  assert.ok(!await visible(page, ".cursor"));
  await page.click(".traces tbody .scale input[type=checkbox]");
  assert.ok(!await page.$eval(".traces tbody .scale input[type=number]", (f) => f.disabled));
  await setField(page, ".traces tbody .scale input[type=number]", 0.25);
  await page.click("#scope_stacked");
  await until(() => page.$eval(".traces tbody .scale input[type=number]", (f) => f.valueAsNumber), (v) => v === 0.25, "scale kept");
});

test("bench: spectrum: the FFT against a sine between two bins", async ({ page }) => {
  const [peak, level, dc] = await page.evaluate(async () => {
    const { spectrum, highestPeak } = await import("/spectrum.js");
    const levels = spectrum(Float64Array.from({ length: 8192 }, (_, i) => 3 + 0.5 * Math.sin(2 * Math.PI * 1234.5 * i / 48000)));
    return [...highestPeak(levels), levels[0]];
  });
  assert.ok(close(peak * 48000 / 8192, 1234.5, 0.02) && close(level, -6.02, 0.01), `${peak} ${level}`);
  assert.ok(dc < -40, "mean removed");
});

// ---- graph

test("bench: graph: feedback, what is left out, long names, details", async ({ page }) => {
  await show(page, "graph");
  assert.equal(await overlaps(page), 0, "no node covers another");
  assert.ok(await page.$$eval(".edge.back", (all) => all.length) >= 1, "feedback");
  assert.match(await text(page, "#left_out"), /unused.*reaches no output/);
  const wide = await page.$$eval("[data-node]", (all) => all.filter((n) => n.querySelector(".path").getBBox().width > n.querySelector(".box").getBBox().width - 12).map((n) => n.dataset.node));
  assert.deepEqual(wide, [], "names fit into their boxes");
  await chooseNode(page, "echo");
  const details = await text(page, "#node_details");
  assert.match(details, /instrument\.toml, line \d+/);
  assert.match(details, /Feedback loop 1: .*echo.*delay 480 frames \(10 ms\)/);
  assert.match(details, /Delay|delay/);
  await until(() => page.$eval("[data-node=tone] .level", (bar) => Number(bar.getAttribute("width"))), (x) => x > 50, "bar of the level");
  // 0.25 / (1 - 0.5)
  await until(() => text(page, "#node_details [data-signal=echo]"), (x) => /\d/.test(x) && close(amount(x), 0.5, 0.005), "live level");
  await page.evaluate(() => document.querySelector("[data-node=smooth]").focus());
  await page.keyboard.press("Enter");
  assert.match(await text(page, "#node_details"), /one_pole/);
});

test("drum: graph: all nodes, zoom and fit, show in scope", async ({ page }) => {
  await show(page, "graph");
  assert.equal(await page.$$eval("[data-node]", (all) => all.length), 65);
  assert.equal(await overlaps(page), 0, "no node covers another");
  assert.match(await text(page, "#left_out"), /hearing.*is always 0\.0004/);
  const width = () => page.$eval(".picture", (p) => Number(p.getAttribute("width")));
  const before = await width();
  await page.click("[aria-label='Zoom in']");
  assert.ok(await width() > before);
  await page.click("[aria-label=Fit]");
  assert.ok(await width() <= await page.$eval(".frame", (f) => f.clientWidth));
  await chooseNode(page, "cone");
  assert.deepEqual(await page.$$eval("#node_details [data-signal]", (all) => all.map((c) => c.dataset.signal)), ["cone.out", "cone.velocity", "cone.position"]);
  await until(() => texts(page, "#node_details [data-signal]"), (x) => x.every((t) => /\d/.test(t)), "live levels");
  const list = await text(page, "#node_details p + p, #node_details");
  assert.ok(list.length < 4000, "the loop is listed once");
  await page.evaluate(() => document.querySelector("#node_details [data-signal='cone.position']").parentElement.querySelector("button").click());
  await until(() => scopeRows(page), (x) => x.some((r) => r.name === "cone.position"), "trace");
  assert.ok(await visible(page, ".scope"));
});

test("cellomobo: graph: two loops, the plant and its parts", async ({ page }) => {
  await show(page, "graph");
  assert.equal(await overlaps(page), 0, "no node covers another");
  assert.ok(await page.$("[data-node='plant/plant.bowing.rub']") ?? await page.$("[data-node^='plant/']"), "nodes of the plant");
  await chooseNode(page, "bow.expected");
  assert.match(await text(page, "#node_details"), /bow_direction\.toml, line \d+/);
  await until(() => texts(page, "#node_details [data-signal]"), (x) => x.every((t) => /\d/.test(t)), "live levels");
});

test("cellomobo: every file once, with its text", async ({ page }) => {
  await show(page, "file");
  assert.deepEqual(await texts(page, "#file .bar button"), ["scene.toml", "instrument.toml", "bow_direction.toml", "fingerboard.toml", "plant.toml"]);
  await page.click("#file .bar button:nth-child(4)");
  assert.match(await text(page, "#file .listing"), /finger/);
});

// ---- files

test("drum: file: text with line numbers", async ({ page, program }) => {
  await show(page, "file");
  const lines = await texts(page, ".listing .number");
  assert.equal(lines.length, fs.readFileSync(program.args[0], "utf8").trimEnd().split("\n").length);
  assert.deepEqual(await texts(page, "#file .bar button"), ["instrument.toml"]);
});

test("bench: file: errors of an edit beside their lines, with remedy; gone when accepted", async ({ page, program }) => {
  await show(page, "file");
  const file = program.args[0], before = fs.readFileSync(file, "utf8");
  const broken = before.replace('cutoff = "20 kHz"', 'cutoff = "20 kHz", abuot = 1').replace('in = "large"', 'in = "larg"');
  const line = broken.split("\n").findIndex((l) => l.startsWith("smooth")) + 1;
  fs.writeFileSync(file, broken);
  await until(() => texts(page, ".error"), (x) => x.length > 0 && x.join().includes("larg"), "errors");
  assert.equal(await text(page, ".error_line .number"), String(line));
  assert.match(await text(page, ".error_line code"), /larg"/, "the text with the error is shown");
  assert.match((await texts(page, ".error")).join(), new RegExp(`${line}:\\d+.*large`), "remedy: a name that is alike");
  assert.match(await text(page, ".edit_state"), /error.*the previous version keeps playing/);
  assert.ok(await page.$eval("#tab_file", (t) => t.classList.contains("bad")), "the tab is marked");
  assert.equal(await figure(page, "Stream"), "running");
  fs.writeFileSync(file, before.replace("amplitude of the sine", "<img src=x onerror=alert(1)>").replace("[nodes]", "[nodes]\nhalf = \"0.5 * tone\"").replace("0.001 * hit.envelope", "0.001 * hit.envelope + 0 * half"));
  await until(() => texts(page, ".error"), (x) => x.length === 0, "no errors");
  await until(() => text(page, ".edit_state"), (x) => /accepted/.test(x), "accepted");
  await until(() => text(page, ".listing"), (x) => x.includes("<img src=x"), "new text");
  assert.equal(await page.$(".listing img"), null, "text, not HTML");
  fs.writeFileSync(file, before);
  await until(() => text(page, ".listing"), (x) => !x.includes("<img"), "text of before");
});

test("bench: file: an edit adds a control and a signal; traces, values and focus stay", async ({ page, program }) => {
  const file = program.args[0], before = fs.readFileSync(file, "utf8");
  await choose(page, "tone", "echo");
  await show(page, "play");
  await setControl(page, "amplitude", 0.5);
  const { row } = await controlRow(page, "frequency");
  await page.focus(`${row} [type=range]`);
  fs.writeFileSync(file, before.replace("[nodes]", 'share = { value = 0.3, range = [0, 1], about = "new" }\n\n[nodes]').replace('large  = "tone', 'large  = "share * tone'));
  await until(() => texts(page, ".control .name span"), (x) => x.includes("share"), "new control");
  assert.equal(await (await controlRow(page, "amplitude")).now(), 0.5, "value stays");
  assert.equal(await page.evaluate(() => document.activeElement.getAttribute("aria-label")), "frequency", "focus stays");
  await show(page, "scope");
  await until(() => scopeRows(page), (x) => x.map((r) => r.name).join() === "tone,echo" && x.every((r) => /\d/.test(r.cells[0])), "traces stay");
  await until(() => scopeSignals(page), (x) => x.includes("share"), "new signal");
  fs.writeFileSync(file, before);
  await until(() => scopeSignals(page), (x) => !x.includes("share"), "gone");
  await show(page, "play");
  await setControl(page, "amplitude", 0.25);
});

// ---- bodies

const placeOf = (page, body) => page.$$eval("#bodies_table tr", (rows, name) => [...rows.find((r) => r.cells[0].textContent === name).cells].slice(1).map((c) => c.textContent), body);

/** How many pixels of the canvas have a colour of the theme, and where they are on average. */
const drawn = (page, name) => page.$eval("#bodies_canvas", (canvas, variable) => {
  const probe = document.createElement("canvas").getContext("2d");
  probe.fillStyle = getComputedStyle(document.documentElement).getPropertyValue(`--${variable}`).trim();
  probe.fillRect(0, 0, 1, 1);
  const [r, g, b] = probe.getImageData(0, 0, 1, 1).data;
  const { data, width } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let count = 0, x = 0;
  for (let k = 0; k < data.length; k += 4)
    if (data[k + 3] > 100 && Math.abs(data[k] - r) + Math.abs(data[k + 1] - g) + Math.abs(data[k + 2] - b) < 12) { ++count; x += (k / 4) % width; }
  return { count, x: count ? x / count : null, width };
}, name);

test("bodies: the ball goes round in the table and on the canvas", async ({ page }) => {
  await show(page, "bodies");
  await until(() => placeOf(page, "ball"), ([x, y]) => close(Math.hypot(Number(x), Number(y)), 0.3, 0.002), "the radius");
  assert.deepEqual(await placeOf(page, "block"), ["–", "–", "–"], "the block is absent");
  assert.deepEqual(await placeOf(page, "floor"), ["–", "–", "–"], "a plane has no place");
  await until(() => drawn(page, "grid"), ({ count }) => count > 50, "the floor is drawn");
  await page.select("#bodies select[aria-label=View]", "front");
  const sides = new Set();
  await until(async () => {
    const { count, x, width } = await drawn(page, "accent");
    if (count > 100) sides.add(Math.sign(Math.round((x - width / 2) / 20)));
    return sides;
  }, (seen) => seen.has(-1) && seen.has(1), "the ball on both sides");
});

test("bodies: a body that becomes present is drawn", async ({ page }) => {
  await show(page, "play");
  await setControl(page, "hall_block_present", 1);
  await show(page, "bodies");
  await until(() => placeOf(page, "block"), (place) => place.join() === "0.000,0.000,0.300", "its place");
  await show(page, "play");
  await setControl(page, "hall_block_present", 0);
});

test("bodies: keys and mouse turn the picture, and Fit brings it back", async ({ page }) => {
  await show(page, "bodies");
  await page.select("#bodies select[aria-label=View]", "top");
  await page.focus("#bodies_canvas");
  await page.keyboard.press("ArrowLeft");
  assert.equal(await page.$eval("#bodies select[aria-label=View]", (s) => s.value), "free");
  for (let k = 0; k < 20; ++k) await page.keyboard.press("+");
  const [fit] = await page.$$("#bodies button");
  await fit.click();
  await until(() => drawn(page, "accent"), ({ count }) => count > 100, "the ball is seen again");
});

test("drum: without a world there is no such view", async ({ page }) => {
  assert.ok(!await visible(page, "#tab_bodies"));
});

// ---- world

test("world: no drives; the plant's signals are chosen for the scope", async ({ page }) => {
  assert.equal(await driveState(page), "no drives");
  assert.equal(await page.$eval("#arm", (b) => b.getAttribute("aria-disabled")), "true");
  await show(page, "world");
  const rows = await until(() => scopeRows(page), (x) => x.length > 0 && x.every((r) => /\d/.test(r.cells[0])), "traces");
  assert.ok(rows.every((r) => r.name.startsWith("plant/")), JSON.stringify(rows));
  assert.ok(await visible(page, "#world .scope"));
});

test("world: a press strikes, a drag sets the value of the plant", async ({ page }) => {
  await show(page, "world");
  assert.deepEqual(await texts(page, "#pads .pad b"), ["strike"]);
  await page.select("#pads .pad select", "y");
  const surface = "#pads .pad .surface";
  await choose(page, "plant/strike", "plant/plant.drum.stick.position");
  await page.select("#scope_trigger", "rising");
  await page.select("#trigger_signal", "plant/strike");
  await setField(page, "#trigger_level", 0.5);
  await until(() => text(page, "#scope_status"), (x) => x === "waiting for the trigger", "waiting");
  await show(page, "world");
  await page.focus(surface);
  await page.keyboard.press("Space");
  await until(() => text(page, "#scope_status"), (x) => x === "running", "the strike triggers");
  await page.select("#scope_trigger", "free");
  await page.evaluate(() => document.querySelector("#pads .surface").scrollIntoView({ block: "center" }));
  const box = await (await page.$(surface)).boundingBox();
  await page.mouse.move(box.x + 50, box.y + box.height - 2);
  await page.mouse.down();
  await page.mouse.move(box.x + 60, box.y + 0.25 * box.height, { steps: 6 });
  await page.mouse.up();
  const value = await page.$eval(surface, (s) => Number(s.getAttribute("aria-valuenow")));
  assert.ok(close(value, 0.5, 0.03), String(value));
  const strike = async () => amount((await scopeRows(page)).find((r) => r.name === "plant/strike").cells[1]);
  await until(strike, (x) => close(x, value, 0.01), "value in the plant");
  await page.focus(surface);
  await page.keyboard.press("ArrowDown");
  await until(strike, (x) => close(x, value - 0.1, 0.01), "arrow key");
  for (let k = 0; k < 4; ++k) await page.keyboard.press("ArrowDown");
  await until(strike, (x) => close(x, value - 0.5, 0.01), "back");
});

test("world: a drag by speed returns to zero", async ({ page }) => {
  await show(page, "world");
  const surface = "#pads .pad .surface";
  await page.select("#pads .pad select", "vx");
  const box = await (await page.$(surface)).boundingBox();
  await page.mouse.move(box.x + 10, box.y + 50);
  await page.mouse.down();
  await page.$eval(surface, (s) => {
    window.highest = 0;
    new MutationObserver(() => { window.highest = Math.max(window.highest, Number(s.getAttribute("aria-valuenow"))); }).observe(s, { attributes: true });
  });
  await page.mouse.move(box.x + 170, box.y + 50, { steps: 30 });
  await page.mouse.up();
  await until(() => page.evaluate(() => window.highest), (x) => x > 0.02, "a speed");
  await until(() => page.$eval(surface, (s) => Number(s.getAttribute("aria-valuenow"))), (x) => x === 0, "zero");
});

test("world: signals of instrument and plant in one screen", async ({ page }) => {
  const rows = await choose(page, "plant/plant.drum.stick.position", "hit.envelope", "cone.position", "plant/out/instrument.microphone");
  assert.deepEqual(rows.map((r) => r.name), ["plant/plant.drum.stick.position", "hit.envelope", "cone.position", "plant/out/instrument.microphone"]);
  assert.match(rows[0].cells[0], /mm?$/);
  // The microphone of the plant is the input of the instrument, a delay of 20 ms apart at most: the same highest level.
  await choose(page, "microphone", "plant/out/instrument.microphone");
  await page.select("#scope_span", "2");
  await until(() => scopeRows(page), (x) => x.every((r) => r.cells.every((c) => /\d/.test(c))), "two seconds");
  const ranges = await page.$$eval(".traces tbody tr .scale input[type=checkbox]", (boxes) => boxes.map((b) => { b.click(); return b.closest("tr").querySelector("input[type=number]").valueAsNumber; }));
  assert.ok(close(ranges[0], ranges[1], 0.3 * ranges[0]), ranges.join());
});

test("world: strokes that the drum detects are in the lane of the events, with their level", async ({ page }) => {
  await show(page, "play");
  const titles = await until(() => texts(page, ".lane .trigger title"), (x) => x.length >= 5, "strokes in the lane", 20000);
  assert.ok(titles.every((t) => /^[a-z_.]+: [0-9.e+-]+$/.test(t)), titles.join("; "));
  assert.ok(titles.some((t) => t.startsWith("hit")), titles.join("; "));
  assert.equal((await texts(page, ".log .trigger")).length, 0);
});

test("world: the delay slider asks for a verdict", async ({ page }) => {
  await show(page, "world");
  assert.ok(await visible(page, "#delay_slider"));
  assert.match(await text(page, "#delay_value"), /20 ms/);
  await page.focus("#delay_slider");
  await page.keyboard.press("ArrowRight");
  await until(() => text(page, "#verdict"), (x) => /computing/.test(x), "computing");
  const verdict = await until(() => text(page, "#verdict"), (x) => /20\.5 ms: (stable|undecided|unstable)/.test(x), "verdict", 60000);
  assert.match(verdict, /^20\.5 ms: stable/);
});

test("world: what controls are for is shown", async ({ page }) => {
  await show(page, "play");
  assert.ok((await texts(page, ".control .name small")).includes("strokes per second"));
});

test("world: a control changes the roll", async ({ page }) => {
  await setControl(page, "roll_rate", 10);
  await choose(page, "asked");
  await until(async () => amount((await scopeRows(page))[0].cells[1]), (x) => close(x, 0.1, 0.002), "intervals of 100 ms");
  await show(page, "play");
  await setControl(page, "roll_rate", 20);
});

test("cellomobo: the world of an instrument that nobody plays by hand: plant signals, no pads", async ({ page }) => {
  assert.ok(await visible(page, "#tab_world"));
  await show(page, "world");
  const rows = await until(() => scopeRows(page), (x) => x.length > 0 && x.every((r) => /\d/.test(r.cells[0])), "traces");
  assert.ok(rows.every((r) => r.name.startsWith("plant/")), JSON.stringify(rows));
  assert.ok(!await visible(page, "#pads"));
});

test("cellomobo: names, units and levels", async ({ page }) => {
  const control = await controlRow(page, "polarity");
  assert.deepEqual([control.low, control.high, control.value], [-1, 1, 1]);
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), "not too wide");
  assert.ok(!(await text(page, "#levels")).includes("Inputs"), "no inputs");
  assert.equal((await texts(page, "#levels .level")).length, 2);
});

// ---- page

test("drum: tabs by keyboard", async ({ page }) => {
  await page.focus("#tab_play");
  await page.keyboard.press("ArrowRight");
  assert.ok(await visible(page, "#scope"));
  assert.equal(await page.$eval("#tab_scope", (t) => t.getAttribute("aria-selected")), "true");
  await page.keyboard.press("ArrowLeft");
  assert.ok(await visible(page, "#play"));
});

test("drum: phone: arm by holding a finger, a slider by touch", async ({ open }) => {
  const { page, close: end } = await open({ width: 390, height: 844, touch: true });
  await page.touchscreen.touchStart(...await centre(page, "#arm"));
  await pause(500);
  await page.touchscreen.touchEnd();
  await pause(900);
  assert.equal(await driveState(page), "disarmed", "a short touch does not arm");
  await page.touchscreen.touchStart(...await centre(page, "#arm"));
  await until(() => driveState(page), (x) => x === "armed", "armed");
  await page.touchscreen.touchEnd();
  await page.tap("#disarm");
  await until(() => driveState(page), (x) => x === "disarmed", "disarmed");
  const control = await controlRow(page, "roll_rate");
  const slider = await (await page.$(`${control.row} [type=range]`)).boundingBox();
  await page.touchscreen.tap(slider.x + slider.width - 3, slider.y + slider.height / 2);
  assert.ok(close(await reported(control), 25, 0.5), "slider");
  await setControl(page, "roll_rate", 20);
  await end();
});

test("world: phone: a pad by touch", async ({ open }) => {
  const { page, close: end } = await open({ width: 390, height: 844, touch: true });
  await show(page, "world");
  await page.select("#pads .pad select", "y");
  const box = await (await page.$("#pads .surface")).boundingBox();
  await page.touchscreen.touchStart(box.x + 50, box.y + box.height - 5);
  for (let k = 1; k < 8; ++k) await page.touchscreen.touchMove(box.x + 50, box.y + box.height - 5 - 14 * k);
  await page.touchscreen.touchEnd();
  await until(() => page.$eval("#pads .surface", (s) => Number(s.getAttribute("aria-valuenow"))), (x) => x > 0, "pad");
  await page.focus("#pads .surface");
  for (let k = 0; k < 25; ++k) await page.keyboard.press("ArrowDown");
  await end();
});

test("drum: theme follows the system, and the button sets it", async ({ open }) => {
  const { page, close: end } = await open({ theme: "dark" });
  const back = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  const dark = await back();
  await page.click("#theme");
  const light = await back();
  assert.notEqual(light, dark);
  await page.click("#theme");
  assert.equal(await back(), dark);
  await end();
});

for (const setting of ["bench", "bodies", "world", "cellomobo"])
  test(`${setting}: 360 px without horizontal scrolling; touch targets of 40 px; every field has a name`, async ({ open }) => {
    const { page, close: end } = await open({ width: 360, height: 740, touch: true, reducedMotion: true });
    for (const view of ["play", "scope", "graph", "file", "bodies", "world"]) {
      if (await page.$eval(`#tab_${view}`, (t) => t.hidden)) continue;
      await show(page, view);
      await pause(300);
      assert.ok(await page.evaluate(() => document.documentElement.scrollWidth) <= 360, `${view} is too wide`);
      const small = await page.$$eval("button, select, input:not([type=checkbox]), label.check", (all) => all.filter((e) => e.getClientRects().length)
        .map((e) => [e.id || e.textContent || e.ariaLabel, e.getBoundingClientRect()]).filter(([, r]) => r.height < 39.5 || r.width < 39.5).map(([n, r]) => `${n} ${Math.round(r.width)}x${Math.round(r.height)}`));
      assert.deepEqual(small, [], `small targets in ${view}`);
      const nameless = await page.evaluate(() => [...document.querySelectorAll("button, input, select, [tabindex='0']")].filter((e) => !e.getAttribute("aria-label") && !e.textContent.trim() && !e.labels?.length).map((e) => e.outerHTML.slice(0, 80)));
      assert.deepEqual(nameless, [], `without a name in ${view}`);
    }
    await page.keyboard.press("Tab");
    assert.notEqual(await page.evaluate(() => getComputedStyle(document.activeElement).outlineStyle), "none", "the focus is visible");
    await end();
  });

// ---- runner

const words = process.argv.slice(2);
const browser = await launch();
const results = { passed: 0, failed: 0 };

async function run({ name, run }, program) {
  const others = [];
  let opened = null;
  const open = async (options) => { others.push(await openPanel(browser, program.url, options)); return others.at(-1); };
  const began = Date.now();
  try {
    if (program) opened = await openPanel(browser, program.url);
    await run({ ...opened, program, browser, open });
    const errors = (opened?.errors ?? []).filter((text) => !/WebSocket connection to/.test(text));   // the browser logs each refused connection
    assert.deepEqual(errors, [], "errors on the console");
    results.passed += 1;
    console.log(`ok   ${name} ${((Date.now() - began) / 1000).toFixed(1)} s`);
  } catch (error) {
    results.failed += 1;
    console.log(`FAIL ${name}\n     ${String(error.stack).replaceAll("\n", "\n     ")}`);
    if (opened?.errors.length) console.log(`     console: ${opened.errors.join("\n     ")}`);
    program?.thaw();
  }
  for (const { close: end } of [opened, ...others].filter(Boolean)) await end().catch(() => {});
}

for (const setting of new Set(tests.map((t) => t.setting))) {
  const chosen = tests.filter((t) => t.setting === setting && (!words.length || words.some((word) => t.name.includes(word))));
  if (!chosen.length) continue;
  const program = SETTINGS[setting] ? await SETTINGS[setting]() : null;
  for (const one of chosen) await run(one, program);
  if (!program) continue;
  const report = await program.stop();
  const counts = report.match(/panel +\d+ messages.*/)?.[0];
  console.log(`     ${setting}: ${counts}`);
  if (!counts) { results.failed += 1; console.log(`FAIL ${setting}: no report\n${report.slice(-2000)}`); }
}
console.log(results);
await browser.close();
process.exit(results.failed ? 1 : 0);
