"""Takes made by arithmetic: random graphs, with controls, arm, mute, halts and edits at any frame."""

import json

import random_graphs
from signals import Bits, sensor, write_wav

FRAMES = 12000


def files(text):
    return {"main": "graph.toml", "root": ".", "texts": {"graph.toml": text, "part.toml": random_graphs.part()},
            "sounds": {}}


def names(text, section):
    lines = text.split(f"[{section}]\n")[1].splitlines()
    found = []
    for line in lines:
        if not line or line.startswith("["):
            break
        found.append(line.split(" = ")[0])
    return found


def limits(bits, audio):
    one = {"ceiling": bits.between(0.3, 1), "slew_per_second": bits.between(200, 5e4), "soft_start_s": 0.02,
           "fade_out_s": 0.01, "direct": {"level": 0.3, "time_s": 0.05}}
    if bits.pick(2) == 0:
        one["heat"] = {"watts_at_full_scale": 20, "watts_for_ever": 5, "coil_time_s": 2, "body_time_s": 200,
                       "coil_share": 0.6, "rise_kelvin": 80}
    if bits.pick(2) == 0:
        one["travel"] = {"metres": 0.002, "metres_at_full_scale": 0.01, "resonance_hz": 60, "q": 0.9}
    return {**one, "kind": "audio" if audio else "drive"}


def entry(bits, frame, controls, outputs):
    kind = bits.pick(8)
    if kind < 4 and controls:
        return {"frame": frame, "kind": "control", "index": bits.pick(len(controls)), "value": bits.between(-1, 1)}
    if kind == 4:
        return {"frame": frame, "kind": "mute", "index": bits.pick(outputs + 1) - 1, "value": bits.pick(2)}
    if kind == 5:
        return {"frame": frame, "kind": "halt", "index": -1, "value": 0}
    if kind == 6:
        return {"frame": frame, "kind": "system_delay", "index": 0, "value": bits.pick(2000)}
    return {"frame": frame, "kind": "arm", "index": bits.pick(outputs + 1) - 1, "value": int(bits.pick(4) > 0)}


def make(folder, seed):
    """take.wav and take.jsonl in `folder`; the drives in it are silent."""
    bits = Bits(5000 + seed)
    # Sound files are not in a take; each output is one channel.
    text = next(text for text in (random_graphs.graph(seed + 200 * k, one_lane=True) for k in range(1, 100))
                if "sound.wav" not in text)
    controls = names(text, "controls")
    outputs = names(text, "outputs")
    inputs = ["x0", "x1"]
    audio = ['kind = "audio"' in line for line in text.split("[outputs]\n")[1].splitlines() if " = " in line]
    lines = [{"tactus_take": 1, "program": "tactus", "sample_rate_hz": 48000, "inputs": inputs, "outputs": outputs,
              "controls": controls, "settings": {}, "taps": [], "system_delay_s": 0.001 * bits.pick(20),
              "armed": bits.pick(2) == 0, "soft_start": True, "trusted_sensors": bits.pick(2) == 0, "state": [],
              "guard": [limits(bits, kind) for kind in audio], "rig": "", "left_out": [],
              "input_scales": [1, 1 / 3] if seed % 3 == 0 else [], "padding_frames": 333 if seed % 3 == 0 else 0,
              "files": files(text)}]
    frame = 0
    while True:
        frame += 1 + bits.pick(700)
        if frame >= FRAMES:
            break
        if bits.pick(4) == 0:
            text = random_graphs.edited(text, bits)
            lines.append({"frame": frame, "kind": "edit", "settings": {}, "controls": controls, "files": files(text)})
        else:
            lines.append(entry(bits, frame, controls, len(outputs)))
    lines.append({"frame": FRAMES, "kind": "end", "lost_entries": 0, "rounded_sensors": 0, "why": ""})
    (folder / "take.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
    channels = [sensor(bits, FRAMES) for _ in inputs] + [[0.0] * FRAMES for _ in outputs]
    write_wav(folder / "take.wav", channels, 48000)


def make_sensors(folder, inputs, graph="format = 1\n[inputs]\n{}\n[outputs]\nout = {{ from = 0 }}\n"):
    """A take of 1 s whose inputs have these names, for playing on other instruments."""
    text = graph.format("\n".join(f"{name} = {{}}" for name in inputs))
    header = {"tactus_take": 1, "program": "tactus", "sample_rate_hz": 48000, "inputs": inputs, "outputs": ["out"],
              "controls": [], "settings": {}, "taps": [], "system_delay_s": 0.003, "armed": True, "soft_start": True,
              "trusted_sensors": True, "state": [], "guard": [limits(Bits(1), False)], "rig": "", "left_out": [],
              "input_scales": [], "padding_frames": 0, "files": files(text)}
    end = {"frame": 48000, "kind": "end", "lost_entries": 0, "rounded_sensors": 0, "why": ""}
    (folder / "take.jsonl").write_text(json.dumps(header) + "\n" + json.dumps(end) + "\n")
    write_wav(folder / "take.wav", [sensor(Bits(40 + c), 48000) for c in range(len(inputs))] + [[0.0] * 48000], 48000)
