"""What the reference covers. A case is a name, whether it is quick, and a function of a `Runner` that returns
the text whose hash counts."""

import functools
import pathlib
import re
import subprocess
import tomllib

import canonical
import captures
import random_graphs
import takes
from signals import Bits, read_wav, sensor, write_wav

HERE = pathlib.Path(__file__).parent
ROOT = HERE.parent.parent
BLOCKS = [256, 1, 37, 64, 1024]
# Scenes whose loops take from 6 to 60 s to judge; some of them are checked, without the runs.
SLOW_TO_CHECK = re.compile(r"monochord/|cellomobo/|active_string/|bar/plant")
CHECKED_SLOWLY = re.compile(r"cellomobo/(flat|scene|instrument|plant)|active_string/scene|monochord/plant|bar/plant")
DELAYS = ["0 ms", "5 ms", "20 ms"]
# Of these the compiler's level of optimisation changes no bit; of numbers that Eigen computes it does.
SAMPLES = re.compile("(scene|play|instrument|guard|graph|take|edits|wrong|broken)/")


class Runner:
    """Runs the program in a folder of the case's own. `again`: with other block sizes."""

    def __init__(self, program, folder, shared, again=False):
        self.program, self.folder, self.shared, self.again = program, folder, shared, again

    def blocks(self, usual, other):
        """`usual` None: that of the program."""
        block = other if self.again else usual
        return [] if block is None else ["--block", block]

    def __call__(self, *arguments, seconds=3600):
        return subprocess.run([self.program, *map(str, arguments)], cwd=ROOT, capture_output=True, text=True,
                              errors="replace", stdin=subprocess.DEVNULL, timeout=seconds)

    def answer(self, *arguments, sort=False):
        """Exit code, numbers of the JSON, places of errors."""
        done = self(*arguments)
        body = canonical.of_json(done.stdout, sort) if done.stdout.lstrip().startswith(("{", "[")) else ""
        return "\n".join([f"exit {done.returncode}", body, canonical.of_errors(done.stderr)])

    def rendered(self, *arguments, events=True):
        """The same, the samples and the events of `render`."""
        out, times = self.folder / "out.wav", self.folder / "events.json"
        for file in (out, times):
            file.unlink(missing_ok=True)
        text = self.answer("render", *arguments, "--out", out, *(["--events", times] if events else []), "--json")
        if times.exists():
            text += "\n" + canonical.of_json(times.read_text())
        return text + "\n" + canonical.of_wav(out)


def shipped():
    """Paths of graphs and scenes, relative to the checkout."""
    graphs, scenes = [], []
    for file in sorted((ROOT / "instruments").rglob("*.toml")):
        if "templates" in file.parts:  # to be changed freely; tests play them
            continue
        content = tomllib.loads(file.read_text())
        kind = scenes if "parts" in content else graphs if "outputs" in content else None
        if kind is not None and "world" not in file.parts:  # an optional library computes those, in its own version
            kind.append(str(file.relative_to(ROOT)))
    return graphs, scenes


def inputs_of(graphs):
    found = {}
    for graph in graphs:
        found.update(dict.fromkeys(tomllib.loads((ROOT / graph).read_text()).get("inputs", {})))
    return sorted(found)


def prepare(program, shared, graphs):
    """Files that many cases read."""
    write_wav(shared / "noise.wav", [sensor(Bits(c), 12000) for c in range(2)], 48000)
    write_wav(shared / "sensors.wav", [sensor(Bits(20 + c), 36000) for c in range(4)], 48000)
    (shared / "sensors").mkdir()
    takes.make_sensors(shared / "sensors", inputs_of(graphs))
    subprocess.run([program, "latency", "probe", "--out", shared / "probe.wav"], check=True, capture_output=True)


def write_graph(folder, text):
    write_wav(folder / "sound.wav", [sensor(Bits(3), 3000, 32000)], 32000, 16)
    (folder / "part.toml").write_text(random_graphs.part())
    (folder / "graph.toml").write_text(text)
    return folder / "graph.toml"


# ---- each kind of case

def scene(run, file, delay, blocks):
    """Of all block sizes one text, if they agree, otherwise several in the order of `blocks`. Without an instrument
    there are no outputs to render."""
    parts = tomllib.loads((ROOT / file).read_text())["parts"]
    how = run.rendered if "instrument" in parts else functools.partial(play, run)
    blocks = blocks[::-1] if run.again else blocks
    texts = [how(file, "--delay", delay, "--block", block, "--duration", "0.5 s") for block in blocks]
    return "\n".join(dict.fromkeys(texts))


def play(run, file, *options):
    text = run.answer("play", file, "--folder", run.folder, "--json", *options)
    waves = [f"{wav.name.rsplit('_', 1)[1]} {canonical.of_wav(wav)}" for wav in sorted(run.folder.glob("*.wav"))]
    return "\n".join([text] + waves)


def instrument(run, file):
    live = run.rendered(file, "--in", run.shared / "sensors.wav", "--delay", "3 ms", *run.blocks(None, 100))
    take = run.rendered("--replay", run.shared / "sensors" / "take.wav", file, *run.blocks(None, 100), events=False)
    return live + "\n" + take


def guarded(run, profile):
    return run.rendered("instruments/haptic_drum/instrument.toml", "--in", run.shared / "sensors.wav", "--profile", profile,
                        "--volts-per-full-scale", "20 V", *run.blocks(None, 100))


def graph(run, seed):
    file = write_graph(run.folder, random_graphs.graph(seed))
    return run.rendered(file, "--in", run.shared / "noise.wav", *run.blocks([64, 256, 100, 17][seed % 4], 41))


def explained(run, seed):
    return run.answer("explain", write_graph(run.folder, random_graphs.graph(seed)), "--json")


def broken(run, seed):
    bits = Bits(9000 + seed)
    file = write_graph(run.folder, random_graphs.broken(random_graphs.graph(seed), bits))
    return run.answer("render", file, "--duration", "1 ms")


def wrong(run, file):
    """As scripts/check_schema reads these files: profile, rig, or anything else."""
    text = (ROOT / file).read_text()
    drum = "instruments/haptic_drum"
    if "[drive]" in text:
        return run.answer("play", drum, "--folder", run.folder, "--profile", file, "--volts-per-full-scale", "1 V")
    if "[device]" in text:
        return run.answer("play", drum, "--rig", file)
    return run.answer("explain", file)


def take(run, wav):
    return run.rendered("--replay", wav, *run.blocks(None, 73), events=False)


def edits(run, seed):
    takes.make(run.folder, seed)
    return run.rendered("--replay", run.folder / "take.wav", *run.blocks([64, 256, 111][seed % 3], 29), events=False)


@functools.cache
def probe_of(shared):
    return read_wav(shared / "probe.wav")


def capture(run, name):
    (probe,), rate = probe_of(run.shared)
    file = run.folder / "capture.wav"
    channels = captures.captures(probe)[name]()
    write_wav(file, channels, rate, 24)
    return run.answer("latency", "analyze", file, "--played", run.shared / "probe.wav", "--json", "--channel", len(channels))


def probe(run, *options):
    file = run.folder / "probe.wav"
    return run.answer("latency", "probe", "--out", file, "--json", *options) + canonical.of_wav(file)


def nodes(run):
    return run.answer("nodes", "--json")


STUDIES = {
    "stability/wall": ["stability", "instruments/wall", "--points", "2"],
    "stability/bare": ["stability", "--device-mass", "20 g", "--device-damping", "0.3 N s/m", "--rate", "8 kHz", "--points", "2"],
    "bifurcation/ball": ["bifurcation", "instruments/bouncing_ball", "--over", "gamma=1.1:1.7:5",
                         "--settle", "1", "--read", "1"],
    "playability/drum": ["playability", "instruments/haptic_drum", "--delays", "0:20:20 ms", "--over", "strength=0.5:1:2",
                         "--duration", "4 s"],
    "playability/drum_gain": ["playability", "instruments/haptic_drum", "--delays", "20 ms", "--gain", "6 dB", "--draws", "3",
                              "--duration", "4 s"],
    "playability/string": ["playability", "instruments/cellomobo/open_string.toml", "--delays", "0:20:20 ms"],
    "playability/weight": ["playability", "instruments/cellomobo/open_string.toml", "--delays", "20 ms", "--over",
                           "weight=0.5:2:2:log"],
}


def study(run, *arguments):
    # The runs of work-precision are listed by the time that they took.
    return run.answer("study", *arguments, "--json", sort=arguments[0] == "work-precision")


def all_cases():
    graphs, scenes = shipped()
    cases = []

    def add(name, quick, function, *arguments):
        cases.append((name, quick, lambda run: function(run, *arguments)))

    plain = lambda file: file.removeprefix("instruments/").removesuffix(".toml")
    for file in scenes:
        for number, delay in enumerate(DELAYS):
            add(f"scene/{plain(file)} {delay}", number == 2, scene, file, delay, BLOCKS)
    for file in scenes:
        add(f"play/{plain(file)}", False, play, file)
    for file in graphs:
        add(f"instrument/{plain(file)}", True, instrument, file)
    for profile in sorted((ROOT / "instruments/profiles").glob("*.toml")):
        add(f"guard/{profile.stem}", True, guarded, profile.stem)
    for seed in range(200):
        add(f"graph/{seed:03}", seed % 2 == 0, graph, seed)
    for wav in sorted((HERE / "takes").glob("*.wav")):
        add(f"take/{wav.stem}", True, take, wav)
    for seed in range(60):
        add(f"edits/{seed:03}", seed % 2 == 0, edits, seed)
    for file in graphs + scenes:
        slow = SLOW_TO_CHECK.search(file)
        if not slow or CHECKED_SLOWLY.search(file):
            add(f"check/{plain(file)} quick", not slow, lambda run, file: run.answer("check", file, "--quick", "--json"), file)
        add(f"explain/{plain(file)}", False, lambda run, file: run.answer("explain", file, "--json"), file)
        if file in scenes and not slow:
            add(f"check/{plain(file)}", False, lambda run, file: run.answer("check", file, "--json"), file)
    for seed in range(0, 200, 10):
        add(f"explain/graph_{seed:03}", seed % 50 == 0, explained, seed)
    for file in scenes:
        if "accuracy" in tomllib.loads((ROOT / file).read_text()):
            add(f"study/work-precision/{plain(file)}", False, study, "work-precision", file, "--solvers",
                "explicit,exact,implicit,passive", "--rates", "24kHz,48kHz", "--oversample", "1,4", "--repeat", "1")
            add(f"error/{plain(file)}", False, lambda run, file: run.answer("render", file, "--error", "--json"), file)
    for name, arguments in STUDIES.items():
        add(f"study/{name}", False, study, *arguments)
    for options in [(), ("--rate", "44.1 kHz"), ("--rate", "96 kHz", "--level", "-30 dBFS")]:
        add(f"latency/probe {' '.join(options)}".strip(), True, probe, *options)
    for name in captures.captures([]):
        add(f"latency/{name}", name in ("plain", "clipped", "drift_50ppm", "lost_frames"), capture, name)
    for file in sorted((ROOT / "tests/schema/wrong").glob("*.toml")):
        add(f"wrong/{file.stem}", True, wrong, str(file.relative_to(ROOT)))
    for seed in range(80):
        add(f"broken/{seed:03}", seed % 2 == 0, broken, seed)
    add("nodes", True, nodes)
    return cases
