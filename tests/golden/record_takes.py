"""Records the takes of tests/golden/takes: somebody plays a graph on a simulated card, presses keys and edits
the file. They are recordings: each run of this gives others. Only for a new set of takes.
    python3 tests/golden/record_takes.py PROGRAM"""

import os
import pathlib
import pty
import select
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).parent
TAKES = HERE / "takes"

PART = '''format = 1
[inputs]
in = {}
[controls]
depth = { value = 0.5, range = [0, 1] }
[nodes]
late = { type = "delay", in = "in + depth * 0.5 * late", time = "7 ms" }
[outputs]
out = { from = "late" }
'''

GRAPHS = {
    "drum": '''format = 1
[inputs]
sensor = {}
[controls]
strength = { value = 0.5, range = [0, 1] }
sensitivity = { value = "-20 dB", range = ["-40 dB", "0 dB"] }
[nodes]
hit = { type = "onset", in = "sensor", threshold = "sensitivity", hold = "15 ms" }
pulse = { type = "decay", trigger = "hit", time = "12 ms" }
[outputs]
woofer = { from = "strength * pulse" }
''',
    "echo": '''format = 1
[inputs]
left = {}
right = {}
[controls]
level = { value = 0.4, range = [0, 1], smooth = "20 ms" }
depth = { value = 0.3, range = [0, 1] }
[nodes]
room = { use = "part.toml", in = "left", depth = "depth" }
wobble = { type = "sine", frequency = "3 Hz" }
[outputs]
drive = { from = "level * room" }
sound = { from = "0.5 * right + 0.1 * wobble", kind = "audio" }
''',
    "voices": '''format = 1
[inputs]
sensor = {}
[controls]
level = { value = 0.6, range = [0, 1] }
tone = { value = "300 Hz", range = ["50 Hz", "2 kHz"], smooth = "5 ms" }
[nodes]
bank = { type = "band_pass", in = "sensor", frequency = { from = "100 Hz", to = "2 kHz" }, voices = 12 }
sum = { type = "mix", in = "bank" }
all = { type = "band_pass", in = "sum", frequency = "tone" }
[outputs]
drive = { from = "level * all" }
''',
    "mass": '''format = 1
[inputs]
sensor = {}
[controls]
push = { value = 0.5, range = [0, 2] }
lift = { value = "2 mm", range = ["0 mm", "10 mm"], smooth = "30 ms" }
[nodes]
slow = { use = "part.toml", in = "net.stick.position / 10 mm", rate = "1/8", take = "mean", between = "line" }
[networks.net]
solver = "passive"
floor = { type = "ground" }
stick = { type = "mass", mass = "12 g", at = "5 mm" }
pad = { type = "contact", between = ["floor", "stick"], stiffness = "1e5 N/m^1.5", loss = "0.5 s/m" }
hand = { type = "hand", on = "stick", stiffness = "20 N/m", damping = "0.3 N s/m", position = "lift" }
force = { type = "force", on = "stick", force = "2 N * push * sensor" }
[outputs]
drive = { from = "0.5 * slow + 0.2 * sensor" }
''',
}

UP, DOWN, RIGHT, LEFT = b"\x1b[A", b"\x1b[B", b"\x1b[C", b"\x1b[D"


def replaced(*pairs):
    def edit(folder):
        text = (folder / "graph.toml").read_text()
        for old, new in pairs:
            assert old in text, old
            text = text.replace(old, new)
        (folder / "graph.toml").write_text(text)
    return edit


def part_replaced(old, new):
    def edit(folder):
        text = (folder / "part.toml").read_text()
        (folder / "part.toml").write_text(text.replace(old, new))
    return edit


def broken(folder):
    (folder / "graph.toml").write_text((folder / "graph.toml").read_text() + "[weather\n")


def repaired(folder):
    (folder / "graph.toml").write_text((folder / "graph.toml").read_text().replace("[weather\n", "# again\n"))


CONSTANT = {"drum": replaced(('"12 ms"', '"30 ms"')), "echo": replaced(('"3 Hz"', '"11 Hz"')),
            "voices": replaced(('to = "2 kHz"', 'to = "3 kHz"')), "mass": replaced(('"12 g"', '"25 g"'))}
HALF = replaced(("0.5", "0.75"))
AGAIN = {"drum": HALF, "echo": HALF, "voices": replaced(('"100 Hz"', '"150 Hz"')), "mass": HALF}
MORE = {"drum": replaced(("[outputs]", 'ring = { type = "band_pass", in = "sensor", frequency = "200 Hz" }\n[outputs]'),
                         ('pulse" }', 'pulse + 0.3 * ring" }')),
        "echo": replaced(("0.5 * right", "0.25 * left + 0.25 * room")),
        "voices": replaced(("voices = 12", "voices = 5"), ('* all" }', '* all + 0.1 * sensor" }')),
        "mass": replaced(("[outputs]", 'top = { type = "mass", mass = "4 g", at = "9 mm" }\nrod = { type = "spring", between = '
                                       '["stick", "top"], stiffness = "800 N/m", damping = "0.2 N s/m", rest = "4 mm" }\n[outputs]'))}
CONTROL = {"drum": replaced(("[nodes]", 'extra = { value = 0.2, range = [0, 1] }\n[nodes]'), ("strength *", "(strength + extra) *")),
           "echo": replaced(("[nodes]", 'extra = { value = 0.2, range = [0, 1] }\n[nodes]'), ("0.1 * wobble", "extra * wobble")),
           "voices": replaced(("[nodes]", 'extra = { value = 0.2, range = [0, 1] }\n[nodes]'), ("level * all", "extra * all")),
           "mass": replaced(("[nodes]", 'extra = { value = 0.2, range = [0, 1] }\n[nodes]'), ("0.5 * slow", "extra * slow"))}

# Seconds after the drives were armed, and what is done then.
SCRIPTS = {
    "controls": lambda g: [(0.15, RIGHT * 3), (0.25, DOWN), (0.3, RIGHT * 4), (0.4, LEFT * 7), (0.5, b"m"),
                           (0.55, b"m"), (0.6, UP + LEFT * 2)],
    "constants": lambda g: [(0.2, CONSTANT[g]), (0.3, RIGHT), (0.45, AGAIN[g])],
    "structure": lambda g: [(0.15, MORE[g]), (0.3, DOWN + RIGHT * 2), (0.4, CONSTANT[g]), (0.5, b"a")],
    "broken": lambda g: [(0.15, broken), (0.25, RIGHT * 2), (0.35, repaired), (0.5, CONSTANT[g])],
    "new_control": lambda g: [(0.1, CONTROL[g]), (0.3, DOWN * 2 + RIGHT * 5), (0.45, MORE[g]), (0.55, LEFT * 3),
                              (0.6, part_replaced("0.5 * late", "0.8 * late"))],
}


def record(program, graph, script, seconds=0.7):
    with tempfile.TemporaryDirectory(dir="/tmp") as name:
        folder = pathlib.Path(name) / "instrument"
        folder.mkdir()
        (folder / "graph.toml").write_text(GRAPHS[graph])
        (folder / "part.toml").write_text(PART)
        wav = TAKES / f"{graph}_{script}.wav"
        for file in (wav, wav.with_suffix(".jsonl")):
            file.unlink(missing_ok=True)
        command = [program, "play", folder / "graph.toml", "--backend", "loop", "--device",
                   "loop:delay=240,gain=-12dB,noise=-14dB,bits=12", "--rate", "16 kHz", "--block", "64", "--duration", "5 s",
                   "--record", wav]
        child, main = pty.fork()  # keys count only from the terminal that controls the program
        if child == 0:
            os.execv(program, [str(word) for word in command])
        said, asked, begin = b"", None, None
        actions = SCRIPTS[script](graph) + [(seconds, b"q")]
        while True:
            if select.select([main], [], [], 0.005)[0]:
                try:
                    said += os.read(main, 65536)
                except OSError:  # the program has closed its end
                    break
            if asked is None and b"keys:" in said:
                os.write(main, b"a")
                asked = time.monotonic()
            if begin is None and asked and time.monotonic() - asked > 0.3:
                os.write(main, b"\r")  # arms
                begin = time.monotonic()
            while begin and actions and time.monotonic() - begin >= actions[0][0]:
                action = actions.pop(0)[1]
                os.write(main, action) if isinstance(action, bytes) else action(folder)
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        os.close(main)
        kinds = [line.split('"kind":"')[1].split('"')[0] for line in wav.with_suffix(".jsonl").read_text().splitlines()[1:]]
        print(wav.stem, status, {kind: kinds.count(kind) for kind in kinds}, wav.stat().st_size)
        if status != 0:
            print(said.decode(errors="replace"))


if __name__ == "__main__":
    TAKES.mkdir(exist_ok=True)
    for graph in GRAPHS:
        for script in SCRIPTS:
            record(sys.argv[1], graph, script)
