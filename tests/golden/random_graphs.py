"""Seeded random graph files from the declarations in node_types.json. Every loop is bounded: what is wired
back is limited to +-0.5 first. The same idea in C++: tests/conformance/random_graph.h."""

import json
import pathlib
import re

from signals import Bits

HERE = pathlib.Path(__file__).parent
TYPES = json.loads((HERE / "node_types.json").read_text())

SETTINGS = {"sample.file": '"sound.wav"', "curve.points": '[["0 s", 0], ["10 ms", 1]]',
            "map.points": "[[-1, 0.1], [0, 0.5], [1, 1]]",
            "proxy.heights": "[0, 0.002, -0.001, 0.001]",
            "terrain.points": "[[-0.01, 0], [-0.003, 0.002], [0.001, -0.001], [0.01, 0]]"}
BOXES = {"s": (0.0005, 0.02), "ms": (0.0005, 0.02), "Hz": (20, 8000), "m": (-0.01, 0.01), "N/m": (0, 1000)}


def number(value):
    return f"{value:.6g}"


def limited(signal):
    return f"max(-1, min(1, {signal}))"


def is_free(port):
    return port["unit"] == "any" or port["unit"].startswith("=")


def typical_range(port):
    low, high = BOXES.get(port["unit"], (-1, 1))
    least, most = port.get("low", -1e300), port.get("high", 1e300)
    low, high = max(low, least), min(high, most)
    if low <= high:
        return low, high
    return (least, min(most, least + abs(least))) if least > -1e300 else (most - abs(most), most)


def plain_signal(name, unit):
    if unit.startswith("="):
        factor = re.search(r"[ /]", unit)
        unit = "Hz" if factor else ""
    return name if unit in ("", "any") else f"({name} / 1 {unit})"


def required_setting(node, setting):
    key = node["name"] + "." + setting["name"]
    if key in SETTINGS:
        return SETTINGS[key]
    if not setting["required"]:
        return None
    given = re.search(" " + setting["name"] + r' = ("[^"]*"|\[.*\]|[^,} ]+)', node["example"])
    return given[1] if given else None


def settings_of(node, bits):
    """What must be given, and one choice or flag at random."""
    given = {s["name"]: required_setting(node, s) for s in node["settings"]}
    words = [(s["name"], word) for s in node["settings"]
             for word in ([f'"{c}"' for c in s.get("choices", [])] if s["kind"] == "choice" else
                          ["true", "false"] if s["kind"] == "flag" else [])]
    if words and bits.pick(3) > 0:
        name, word = bits.choose(words)
        given[name] = word
    return "".join(f", {name} = {value}" for name, value in given.items() if value is not None)


class RandomGraph:
    """A graph text for a seed."""

    def __init__(self, seed, first_type=None, as_part=False, one_lane=False):
        self.bits, self.first_type, self.part, self.one_lane = Bits(seed), first_type, as_part, one_lane
        self.lanes = 2 + self.bits.pick(9)
        self.signals, self.lines, self.network = [], [], ""

    def text(self):
        bits = self.bits
        controls = [] if self.part else [f"c{i}" for i in range(bits.pick(4))]
        self.signals = ["x0", "x1"] + controls
        smooth = lambda: f'{{ value = 0.25, range = [-1, 1], smooth = "{bits.pick(3)} ms" }}'
        head = ["format = 1", "[inputs]", "x0 = {}", "x1 = {}", "[controls]"]
        head += [f"{name} = {smooth()}" for name in controls]
        for i in range(1 + bits.pick(4 if self.part else 10)):
            self.add_node(f"n{i}", self.first_type if i == 0 else None)
        if not self.part and bits.pick(3) == 0:
            self.add_part()
        if not self.part and bits.pick(3) == 0:
            self.add_network()
        self.lines += [f'later{i} = "{limited(self.signal())}"' for i in range(2)]
        # The last node and an input always lead to an output: so little is left out, and none is silent.
        sums = [f"{self.signals[-1]} + 0.1 * x0"] + [self.signal() for _ in range(0 if self.part else bits.pick(4))]
        if self.one_lane:
            self.lines += [f'sum{i} = {{ type = "mix", in = "{signal}" }}' for i, signal in enumerate(sums)]
            sums = [f"sum{i}" for i in range(len(sums))]
        outputs = [f'y{i} = {{ from = "{signal}"{self.kind() if i > 0 else ""} }}' for i, signal in enumerate(sums)]
        return "\n".join(head + ["[nodes]"] + self.lines) + "\n" + self.network + "\n".join(["[outputs]"] + outputs) + "\n"

    def kind(self):
        return ', kind = "audio"' if self.bits.pick(3) == 0 else ""

    def signal(self):
        one = lambda: self.bits.choose(self.signals)
        kind = self.bits.pick(9)
        if kind == 0:
            return f"0.5 * ({one()} - {one()})"
        if kind == 1:
            return f"min({one()}, {one()} + 0.1)"
        if kind == 2:
            return f"{one()} / (1 + abs({one()}))"
        if kind == 3:
            return f"0.9 * max(-0.5, {limited(one())} * {limited(one())})"
        return one()

    def back(self):
        return f"later{self.bits.pick(2)}"

    def value(self, port):
        bits, free, (low, high) = self.bits, is_free(port), typical_range(port)
        unit = " Hz" if port["unit"] == "=in/s" else "" if free or not port["unit"] else " " + port["unit"]
        if port["constant"] or not free and bits.pick(2) == 0:
            return f'"{number(bits.between(low, high))}{unit}"'
        middle, half = 0.5 * (low + high), 0.499 * (high - low)
        in_range = lambda signal: f'"{number(middle)}{unit} + {number(half)}{unit} * {limited(signal)}"'
        if port["name"] == "low":
            return f'"-0.6 + 0.4 * {limited(self.signal())}"'
        if port["name"] == "high":
            return f'"0.6 + 0.4 * {limited(self.signal())}"'
        if port["closes_loops"] and bits.pick(2) == 0:
            return in_range("0.5 * " + self.back())
        if not free or port.get("low", -2) > -1:
            return in_range(self.signal())
        if not self.part and bits.pick(6) == 0:
            return "[" + ", ".join(f'"{number(bits.between(-1, 1))} * x0"' for _ in range(self.lanes)) + "]"
        return f'"{self.signal()}"'

    def add_node(self, name, node=None):
        bits = self.bits
        node = node or bits.choose(TYPES)
        fields = f'{{ type = "{node["name"]}"'
        for port in node["inputs"]:
            if port["required"] or bits.pick(2) == 0:
                fields += f", {port['name']} = {self.value(port)}"
        fields += settings_of(node, bits)
        if node["name"] != "mix" and bits.pick(8) == 0:
            fields += f", voices = {self.lanes}"
        self.lines.append(f"{name} = {fields} }}")
        self.signals += [plain_signal(f"{name}.{output['name']}", output["unit"]) for output in node["outputs"]]

    def add_part(self):
        bits = self.bits
        fields = f'{{ use = "part.toml", x0 = "{self.signal()}", x1 = "{self.signal()}"'
        if bits.pick(2) == 0:
            fields += (f', rate = "1/{2 + bits.pick(90)}", take = "{bits.choose(["last", "mean"])}"'
                       f', between = "{bits.choose(["hold", "line"])}"')
        if bits.pick(3) == 0:
            fields += f", voices = {self.lanes}"
        self.lines.append(f"part = {fields} }}")
        self.signals.append("part")

    def in_unit(self, unit, most):
        signal = self.back() if self.bits.pick(2) == 0 else self.signal()
        return f"{number(most)} {unit} * {limited(signal)}"

    def add_network(self):
        """A chain of masses from the floor up, with one of each kind of element that takes a signal."""
        bits, lines = self.bits, []
        below = bits.choose(["floor", "table"])
        lines += [f'solver = "{bits.choose(["passive", "explicit"])}"', 'floor = { type = "ground" }',
                  f'table = {{ type = "motion", position = "{self.in_unit("mm", 5)}" }}']
        for i in range(1 + bits.pick(5)):
            between = f'between = ["{below}", "m{i}"]'
            lines.append(f'm{i} = {{ type = "mass", mass = "{number(bits.between(1, 100))} g", at = "{i + 1} mm" }}')
            lines.append(
                f'l{i} = {{ type = "contact", {between}, stiffness = "{number(bits.between(1e3, 1e6))} N/m^1.5", '
                f'loss = "1 s/m" }}' if bits.pick(3) == 0 else
                f'l{i} = {{ type = "spring", {between}, stiffness = "{number(bits.between(10, 1e4))} N/m", '
                f'damping = "{number(bits.between(0.1, 5))} N s/m" }}')
            self.signals += [f"(net.m{i}.position / 1 mm)", f"(net.l{i}.force / 1 N)"]
            below = f"m{i}"
        lines.append(f'push = {{ type = "force", on = "m0", force = "{self.in_unit("N", 2)}" }}')
        if bits.pick(2) == 0:
            lines.append('hand = { type = "hand", on = "m0", stiffness = "10 N/m", damping = "1 N s/m", '
                         f'position = "{self.in_unit("mm", 10)}" }}')
        if bits.pick(2) == 0:
            lines.append(f'coil = {{ type = "coil", on = "m0", voltage = "{self.in_unit("V", 5)}", '
                         'force_factor = "6 T m", resistance = "6 ohm" }')
        if bits.pick(3) == 0:
            lines.append(f'rub = {{ type = "friction", between = ["floor", "m0"], normal = "{self.in_unit("N", 1)}" }}')
        if bits.pick(3) == 0:
            lines.append('end = { type = "port", on = "m0", impedance = "0.5 N s/m", '
                         f'wave = "{self.in_unit("N", 1)}" }}')
            self.signals.append("(net.end.wave / 1 N)")
        self.network = "[networks.net]\n" + "\n".join(lines) + "\n"


def graph(seed, one_lane=False):
    """Each type is the first node of some graph."""
    return RandomGraph(1000 + seed, TYPES[seed % len(TYPES)], one_lane=one_lane).text()


def part():
    return RandomGraph(7, as_part=True).text()


def edited(text, bits):
    """The next version of a running graph: other numbers, an expression more, or a node less."""
    kind = bits.pick(3)
    if kind == 0:
        return re.sub(r"0\.9 \*|0\.1 \*|0\.5 \*", lambda _: f"{number(bits.between(0.05, 0.95))} *", text)
    if kind == 1:
        return text.replace("[nodes]\n", f'[nodes]\nextra{bits.pick(1000)} = "0.5 * x0"\n').replace(
            'y0 = { from = "', f'y0 = {{ from = "{number(bits.between(0.1, 0.9))} * x1 + ')
    return re.sub(r'y0 = \{ from = "[^"]*"', f'y0 = {{ from = "{number(bits.between(0.1, 0.9))} * x0"', text)


def broken(text, bits):
    """A text with one error in it, wherever it falls."""
    lines = text.splitlines(keepends=True)
    kind, at = bits.pick(6), 1 + bits.pick(len(lines) - 1)
    if kind == 0:
        del lines[at]
    elif kind == 1:
        lines.insert(at, lines[at])
    else:
        line = lines[at]
        words = list(re.finditer({2: r"[a-z_0-9]+", 3: r"[0-9.]+", 4: r'["{}\[\],=]', 5: r"[a-z]+ ="}[kind], line))
        if words:
            word = bits.choose(words)
            other = {2: word[0] + "q", 3: "-1e9 N", 4: "", 5: "unknown ="}[kind]
            lines[at] = line[:word.start()] + other + line[word.end():]
    return "".join(lines)
