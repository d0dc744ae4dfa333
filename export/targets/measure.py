"""What scripts/export_avr and scripts/export_cortex_m have in common."""
import array, pathlib, re, shutil, subprocess, sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PAGE = ROOT / "docs/microcontrollers.md"
CANNOT_RUN = 77


def run(*command, **options):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, **options)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}\n{done.stdout}\n{done.stderr}")
    return done.stdout


def set_up(packages, program):
    """The tools, or the end; and the program that exports."""
    if subprocess.run([ROOT / "scripts/setup", *packages]).returncode != 0:
        print("cannot be had here: " + ", ".join(packages))
        sys.exit(CANNOT_RUN)
    if program is None:
        run(ROOT / "scripts/build", "release", "tactus")
    return (program or ROOT / "build/release/tactus").resolve()


def export(program, graph, target, number, rate, settings, folder):
    """Exports without a guard, which a comparison would see, with a delay of one frame; returns the name of the program."""
    shutil.rmtree(folder, ignore_errors=True)
    command = [program, "export", ROOT / graph, "--target", target, "--number", number, "--rate", f"{rate:g} Hz", "--delay",
               f"{1000 / rate:.9g} ms", "--recurrence", "plain", "--no-guard", "-o", folder]
    for setting in settings:
        command += ["--set", setting]
    run(*command)
    return next(file.stem for file in folder.glob("*.c") if file.stem not in ("main", "startup", "example", "simulate", "count_instructions"))


def on_this_machine(program, graph, number, rate, settings, frames, folder):
    """Outputs of the exported C program for frames of inputs, in doubles or floats; with doubles these are the engine's."""
    name = export(program, graph, "c", number, rate, settings, folder)
    run("cc", "-O2", "-ffp-contract=off", "-o", folder / "program", folder / "example.c", folder / f"{name}.c", "-lm")
    code = {"double": "d", "float": "f"}[number]
    flat = array.array(code, [value for frame in frames for value in frame])
    done = subprocess.run([folder / "program"], input=flat.tobytes(), capture_output=True, check=True)
    values = array.array(code, done.stdout)
    outputs = len(values) // len(frames)
    return [values[i * outputs:(i + 1) * outputs] for i in range(len(frames))]


def ports(folder, name):
    """Numbers of inputs and outputs."""
    text = (folder / f"{name}.h").read_text()
    return [int(count) for count in re.search(r"INPUTS = (\d+), \w+OUTPUTS = (\d+)", text).groups()]


def markdown(head, rows):
    return "\n".join("| " + " | ".join(row) + " |" for row in [head, ["---"] * len(head), *rows])


def renew(marker, script, table):
    """Puts a table between <!-- marker --> and <!-- end of marker --> of the page."""
    begin, end = f"<!-- {marker} -->", f"<!-- end of {marker} -->"
    before, rest = PAGE.read_text().split(begin)
    _, after = rest.split(end)
    PAGE.write_text(f"{before}{begin}\nMade by `{script}`; do not edit.\n\n{table}\n{end}{after}")
