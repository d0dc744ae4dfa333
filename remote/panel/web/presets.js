// Presets: recall with a ramp, save under a name.
import { byId, el, fillSelect } from "./dom.js";

export function startPresets(connection) {
  const choice = el("select", { "aria-label": "Preset", id: "preset" });
  const ramp = el("input.short", { type: "number", id: "preset_ramp", min: 0, max: 60, step: 0.1, value: "0.5", "aria-label": "Ramp of the preset in seconds" });
  const recall = el("button", { type: "button", id: "preset_recall", onclick: () => connection.send({ do: "preset_recall", name: choice.value, ramp: Math.max(0, ramp.valueAsNumber || 0) }) }, "Recall");
  const name = el("input", { type: "text", id: "preset_name", placeholder: "new name", maxLength: 60, "aria-label": "Name of the preset to save" });
  const form = el("form.bar", { onsubmit: save }, name, el("button", { type: "submit", id: "preset_save" }, "Save"));

  function save(event) {
    event.preventDefault();
    const text = name.value.trim() || choice.value;
    if (text && connection.send({ do: "preset_save", name: text })) name.value = "";
  }

  byId("presets").append(choice, recall, el("label.bar", {}, "ramp", ramp, "s"), form);
  connection.on("description", ({ presets }) => {
    fillSelect(choice, presets.length ? presets.map((preset) => [preset, preset]) : [["", "no presets"]]);
    choice.disabled = recall.disabled = presets.length === 0;
  });
}
