"""Runs every command and every graph of the documentation, and checks every link. See docs/howto/write_a_page.md.

Exit code 0: all examples work; 1: each one that does not is listed with its page and line.
"""

import argparse
import concurrent.futures
import os
import pathlib
import re
import shlex
import shutil
import struct
import subprocess
import sys
import tempfile
import time

import pages

try:
    import tomllib
except ImportError:
    print("SKIPPED: python3 is older than 3.11")
    sys.exit(77)

ROOT = pages.ROOT
FILES = pathlib.Path(__file__).parent / "files"
COMMAND = re.compile(r"^(?:\$ )?(?:build/\w+/)?(?:tactus|scripts/\w+)\b")
GALLERY = pages.DOCS / "gallery/index.md"
NODES = pages.DOCS / "nodes.md"
SECONDS = 120  # for one command
UNITS = ["full scale", "m", "N", "m/s", "Hz", "m/s^2", "s"]  # of the signals that examples of the reference name


def silent_wav():
    """A tenth of a second of silence."""
    samples = bytes(9600)
    return (b"RIFF" + struct.pack("<I", 36 + len(samples)) + b"WAVEfmt " + struct.pack("<IHHIIHH", 16, 1, 1, 48000, 96000, 2, 16)
            + b"data" + struct.pack("<I", len(samples)) + samples)


def logical_lines(text, prompt):
    """(offset of the line, command), continued lines joined; with a prompt only the lines that have one."""
    joined, start = "", 0
    for offset, line in enumerate(text.split("\n")):
        if not joined:
            start = offset
            if prompt and not line.startswith("$ "):
                continue
            line = line.removeprefix("$ ") if prompt else line
        joined += line
        if joined.endswith("\\"):
            joined = joined[:-1]
            continue
        if joined.strip() and not joined.lstrip().startswith("#"):
            yield start, joined.strip()
        joined = ""


WORLD_ELEMENTS = ("sphere", "box", "capsule", "plane", "hinge", "slider", "ball", "fixed", "handle", "gravity", "collision", "link")


class NotBuilt(Exception):
    """The program lacks an optional component."""


class Examples:
    def __init__(self, program, work):
        self.program = program.resolve()
        self.work = work
        self.errors, self.not_run, self.slow = [], [], []
        self.run, self.compared, self.graphs, self.links = 0, 0, 0, 0
        self.helps = {}
        self.in_gallery = {line.removesuffix(" --folder media") for line in GALLERY.read_text().split("\n")}
        self.folders = {}
        self.instruments = shutil.copytree(ROOT / "instruments", work / ".instruments")

    def error(self, place, message):
        self.errors.append(f"{place}: {message}")

    # Commands

    def folder(self, page):
        """The scratch folder of a page: the shipped instruments, what tests/docs/files has for it, nothing else."""
        if page not in self.folders:
            name = str(page.relative_to(ROOT).with_suffix(""))
            folder = self.work / name.replace("/", "_")
            shutil.copytree(self.instruments, folder / "instruments", copy_function=os.link)
            for place in ("build/release", "build/dev"):
                (folder / place).mkdir(parents=True)
                (folder / place / "tactus").symlink_to(self.program)
            (folder / "scripts").mkdir()
            # It builds the program and starts it.
            (folder / "scripts/play").write_text('#!/bin/sh\n[ $# -gt 0 ] || set -- instruments/haptic_drum\nexec tactus play "$@"\n')
            (folder / "scripts/play").chmod(0o755)
            (folder / "home").mkdir()
            own = FILES / pathlib.Path(name).name
            if own.is_dir():
                shutil.copytree(own, folder, dirs_exist_ok=True)
            self.folders[page] = folder
        return self.folders[page]

    def execute(self, command, folder):
        environment = {name: value for name, value in os.environ.items() if not name.startswith("XDG_")}
        environment |= {"PATH": f"{folder}/build/dev:{environment['PATH']}", "HOME": str(folder / "home"), "LC_ALL": "C.UTF-8",
                        "COLUMNS": "120"}
        began = time.monotonic()
        try:
            plain = not re.search(r"[|&;<>$*~()`]", command)  # most need no shell
            words = shlex.split(command, comments=True) if plain else ["bash", "-o", "pipefail", "-c", command]
            done = subprocess.run(words, cwd=folder, env=environment, text=True, timeout=SECONDS,
                                  stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
            code, output = done.returncode, done.stdout
        except FileNotFoundError as error:
            code, output = 127, str(error)
        except subprocess.TimeoutExpired:
            code, output = "none", f"not finished after {SECONDS} s"
        self.slow.append((time.monotonic() - began, command))
        if missing := re.search(r"run (scripts/setup \S+) and build again", output):
            raise NotBuilt(missing[1])
        return code, output

    def help_of(self, words):
        """The options of `tactus a b …`, as its --help prints them, and how many words name the command."""
        used = []
        for word in words:
            if word.startswith("-") or not re.fullmatch(r"[a-z-]+", word):
                break
            listed = self.help_text(tuple(used)).partition("Subcommands:")[2]
            if not re.search(rf"^  {re.escape(word)}\s", listed, re.M):
                break
            used.append(word)
        return self.help_text(tuple(used)), used

    def help_text(self, words):
        if words not in self.helps:
            done = subprocess.run([self.program, *words, "--help"], text=True, capture_output=True)
            self.helps[words] = done.stdout
        return self.helps[words]

    def compare_with_help(self, command, place):
        """A command that is not run: it must exist, and so must its options."""
        self.compared += 1
        try:
            words = shlex.split(re.sub(r"(^|\s)\$ ", r"\1", command), comments=True)
        except ValueError as error:
            return self.error(place, f"'{command}' cannot be read by a shell: {error}")
        if words and words[0].startswith("scripts/"):
            if not (ROOT / words[0]).exists():
                self.error(place, f"'{words[0]}' does not exist")
            return
        names = [index for index, word in enumerate(words) if pathlib.PurePath(word).name == "tactus"]
        if not names:
            return
        words = [word for word in words[names[0] + 1:]]
        end = next((index for index, word in enumerate(words) if word in ("|", "&&", ">", ";", "&") or word.startswith(">")), len(words))
        words = words[:end]
        text, used = self.help_of(words)
        if words and not used and not words[0].startswith("-") and words[0] not in ("help", "…", "..."):
            self.error(place, f"'{command}': there is no command '{words[0]}'")
        for word in words:
            option = word.split("=")[0]
            if re.fullmatch(r"--[a-z][a-z-]*", option) and not re.search(rf"(?<![\w-]){option}(?![\w-])", text):
                self.error(place, f"'{command}': 'tactus {' '.join(used)}' has no option '{option}'")

    def commands(self, fence):
        codes = [int(code) for code in fence.options.get("exit", "0").split(",")]
        reason = fence.options.get("no-run")
        outputs = []
        for offset, command in logical_lines(fence.text, fence.language == "console"):
            place = f"{fence.page.relative_to(ROOT)}:{fence.line + 1 + offset}"
            if reason is not None:
                self.not_run.append((reason, place, command))
                self.compare_with_help(command, place)
                continue
            self.run += 1
            code, output = self.execute(command, self.folder(fence.page))
            outputs.append(output)
            if code not in codes:
                self.error(place, f"'{command}' ended with exit code {code}, not {fence.options.get('exit', '0')}:\n"
                           + "\n".join(f"    {line}" for line in output.strip().split("\n")[-8:]))
        return "\n".join(outputs)

    def compare_output(self, fence, printed):
        """Each line that a page shows must be printed; numbers may be others, and … stands for anything."""
        loose = lambda text: re.sub(r"\d+(?:\.\d+)?(?:e[+-]?\d+)?", "0", " ".join(text.split()))
        lines = [loose(line) for line in printed.split("\n")]
        for offset, line in enumerate(fence.text.split("\n")):
            pattern = re.escape(loose(line)).replace("…", ".*")
            if line.strip() and not any(re.fullmatch(pattern, other) for other in lines):
                self.error(f"{fence.page.relative_to(ROOT)}:{fence.line + 1 + offset}", f"is not printed by the command above: {line.strip()}")

    # Graphs

    def graph(self, fence):
        options = fence.options
        folder = self.folder(fence.page)
        if "no-check" in options:
            self.not_run.append((options["no-check"], fence.place, "a file"))
            return
        self.graphs += 1
        text = fence.text
        if "scene" in options:  # a section of a scene
            inputs = tomllib.loads((ROOT / options["scene"]).read_text()).get("inputs", {})
            wires = "".join(f", {name} = 0" for name in inputs)
            text = f'format = 1\nduration = "10 ms"\n[parts]\ninstrument = {{ use = "{options["scene"]}"{wires} }}\n{text}'
        elif not re.search(r"^format *=", text, re.M):  # a section or some nodes of a graph
            first = next(line for line in text.split("\n") if line.strip() and not line.lstrip().startswith("#"))
            if not first.startswith("["):
                text = f"[nodes]\n{text}"
            inputs = [word.partition(":") for word in options.get("inputs", "").split()]
            declared = "".join(f'{name} = {{ unit = "{unit.replace("_", " ") or "full scale"}" }}\n' for name, _, unit in inputs)
            text = "format = 1\n" + (f"[inputs]\n{declared}" if declared else "") + text
        file = folder / options.get("file", f"block_{fence.line}.toml")
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text + "\n")
        try:
            document = tomllib.loads(text)
        except tomllib.TOMLDecodeError as error:
            return self.error(fence.place, f"is not TOML: {error}")
        name = shlex.quote(str(file.relative_to(folder)))
        if "device" in document or "rig" in options:
            instrument = options.get("rig", "instruments/haptic_drum")
            command, codes = f"tactus check {instrument} --rig {name} --quick --delay '5 ms'", (0, 1)
        elif "drive" in document:
            command, codes = f"tactus render instruments/templates/metronome/instrument.toml --duration 1ms --profile {name} --volts-per-full-scale 10", (0,)
        else:
            command, codes = f"tactus explain {name}", (0,)
        code, output = self.execute(command, folder)
        if code not in codes:
            self.error(fence.place, f"is refused by '{command}':\n" + "\n".join(f"    {line}" for line in output.strip().split("\n")[:6]))

    def declaration(self, fence):
        """An example of the reference, which names signals and bodies that it does not have: they are declared for it."""
        self.graphs += 1
        text = fence.text if re.match(r"\s*\w+ *=", fence.text) else f"example = {fence.text}"
        folder = self.folder(fence.page)
        file = folder / f"example_{fence.line}.toml"
        (folder / "thud.wav").write_bytes(silent_wav())
        element = re.search(r"between = |\bon = |type = \"(?:mass|oscillator|ground|motion|chain|ring|grid|particle|anchor|trajectory|thread|sheet)\"", text)
        bodies = {name.partition(".")[0] for names in re.findall(r"(?:between = \[|on = )([^\],}]*(?:, *\"[^\"]*\")?)", text)
                  for name in re.findall(r"\"([\w.]+)\"", names)} if element else set()
        world = re.search(rf"type = \"(?:{'|'.join(WORLD_ELEMENTS)})\"", text)
        if world:
            named = set(re.findall(r"(?:on|against) = \"(\w+)\"", text)) or ({"body"} if re.search("gravity|link", text) else set())
            text = "[worlds.example]\n" + "".join(f'{body} = {{ type = "sphere", radius = "1 cm", mass = "10 g" }}\n' for body in sorted(named)) + text
        network = "[networks.example]\n" + "".join(
            f'{body} = {{ type = "chain", masses = 80, mass = "1 g", stiffness = "1 kN/m" }}\n' if f'"{body}.' in text else
            f'{body} = {{ type = "particle", mass = "10 g", z = "{place} m" }}\n' if "line_spring" in text else
            f'{body} = {{ type = "mass", mass = "10 g" }}\n' for place, body in enumerate(sorted(bodies)))
        # A wave comes from a port of a network of the example's impedance.
        waves = re.findall(r"wave = \"(\w+)\.(\w+)\.wave\", impedance = \"([^\"]*)\"", text)
        waves += [(*wave, "1 N s/m") for wave in re.findall(r"wave = \"(\w+)\.(\w+)\.wave\", (?!impedance)", text)]
        ports = "".join(f'[networks.{name}]\nspot = {{ type = "mass", mass = "10 g" }}\n'
                        f'{port} = {{ type = "port", on = "spot", impedance = "{impedance}", wave = "example" }}\n' for name, port, impedance in waves)
        text = f"{ports}{network if element else '[nodes]'}\n{text}" if not text.startswith("[") else text
        names, output, attempt = [], "", 0
        while attempt < len(UNITS) ** len(names):
            units = [UNITS[attempt // len(UNITS) ** index % len(UNITS)] for index in range(len(names))]
            declared = "".join(f'{name} = {{ unit = "{unit}" }}\n' for name, unit in zip(names, units))
            file.write_text(f"format = 1\n[inputs]\n{declared}{text}\n")
            code, output = self.execute(f"tactus explain {file.name}", folder)
            if code == 0:
                return
            new = [name for name in dict.fromkeys(re.findall(r"there is no '(\w+)'", output)) if name not in names]
            names += new
            attempt = 0 if new else attempt + 1
        self.error(fence.place, f"is refused by 'tactus explain':\n    {output.strip()[:300]}")

    # Pages

    def page(self, page):
        printed = ""
        for fence in pages.fences(page):
            if page.is_relative_to(ROOT / "instruments") and not fence.language and COMMAND.match(fence.text):
                fence.language = "sh"  # the pages of instruments have only commands that run
            try:
                if fence.language in ("sh", "console"):
                    printed = self.commands(fence)
                elif fence.language == "toml":
                    self.declaration(fence) if page == NODES else self.graph(fence)
                elif fence.language == "python":
                    continue  # tests/python/test_page.py runs them
                elif "output" in fence.options:
                    self.compare_output(fence, printed)
                elif any(COMMAND.match(line) for line in fence.text.split("\n")):
                    self.error(fence.place, "has commands: write ```sh above them, or ```sh no-run=\"reason\" (docs/howto/write_a_page.md)")
            except NotBuilt as missing:
                self.not_run.append((f"the program is built without what '{missing}' installs", fence.place, "a file or command"))
            except Exception as error:
                self.error(fence.place, f"{type(error).__name__}: {error}")
        for line, command in pages.indented_commands(page):
            place = f"{page.relative_to(ROOT)}:{line}"
            if page.is_relative_to(ROOT / "instruments"):
                options = {"exit": "0,1"}  # a verdict may be no
                if command in self.in_gallery:
                    options = {"no-run": "runs on the page of the gallery"}
                elif command.startswith("tactus study"):
                    options = {"no-run": "a study, seconds"}
                self.commands(pages.Fence(page, line - 1, "sh", options, command))
            else:
                self.error(place, "is a command in indented code: put it into a fence, as docs/howto/write_a_page.md says")
        for line, command in pages.code_spans(page.read_text()):
            if "`" not in command and not re.search(r"…|\.\.\.", command.split("#")[0]):
                self.compare_with_help(command, f"{page.relative_to(ROOT)}:{line}")

    def check_links(self, page):
        for line, target in pages.links(page):
            if re.match(r"[a-z]+:", target):
                continue
            self.links += 1
            place = f"{page.relative_to(ROOT)}:{line}"
            path, _, anchor = target.partition("#")
            file = (page.parent / path).resolve() if path else page
            if not file.is_relative_to(ROOT):
                self.error(place, f"'{target}' leads out of the repository")
                continue
            name = str(file.relative_to(ROOT))
            if not file.exists():
                made = self.folders.get(page, pathlib.Path("/nonexistent")) / path  # by a command of the page
                if name not in pages.GENERATED and not made.exists() and not made.with_suffix(".wav").exists():
                    self.error(place, f"'{target}' does not exist")
            elif anchor and file.suffix == ".md" and anchor not in pages.anchors(file.read_text()):
                self.error(place, f"'{path or page.name}' has no heading for '#{anchor}'")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--program", type=pathlib.Path, default=ROOT / "build/dev/tactus", help="[build/dev/tactus]")
    parser.add_argument("--only", default="", metavar="REGEX", help="pages whose path matches")
    parser.add_argument("--jobs", type=int, default=3, help="pages at a time [3]")
    parser.add_argument("--keep", type=pathlib.Path, metavar="FOLDER", help="keep the scratch folders here")
    parser.add_argument("--verbose", action="store_true", help="list what is not run, and the slowest commands")
    options = parser.parse_args()
    began = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="tactus_docs_") as work:
        examples = Examples(options.program, options.keep or pathlib.Path(work))
        chosen = [page for page in pages.pages() if re.search(options.only, str(page.relative_to(ROOT)))]

        def check(page):
            examples.page(page)
            examples.check_links(page)

        with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:  # playing in real time is mostly waiting
            list(pool.map(check, chosen))
    if options.verbose:
        for reason, place, command in examples.not_run:
            print(f"not run ({reason}): {place}: {command}")
        for seconds, command in sorted(examples.slow, reverse=True)[:12]:
            print(f"{seconds:6.2f} s  {command}")
    for error in sorted(examples.errors):
        print(error)
    print(f"{len(chosen)} pages: {examples.run} commands run, {examples.compared} compared with --help only "
          f"({len(examples.not_run)} marked as not run), {examples.graphs} files and graphs checked, {examples.links} links followed, "
          f"{len(examples.errors)} errors, {time.monotonic() - began:.0f} s")
    return 1 if examples.errors else 0


if __name__ == "__main__":
    sys.exit(main())
