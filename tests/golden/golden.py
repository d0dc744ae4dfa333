"""Runs the cases and compares their hashes with reference.txt: see docs/golden.md and scripts/golden --help."""

import argparse
import concurrent.futures
import os
import pathlib
import resource
import re
import shutil
import subprocess
import sys
import tempfile
import time

import canonical
import cases

ROOT = cases.ROOT
REFERENCE = cases.HERE / "reference.txt"
SKIP = 77


def machine(compiler):
    """What decides about the last bits: processor and compiler."""
    info = pathlib.Path("/proc/cpuinfo")
    cpu = re.search(r"model name\s*: (.*)", info.read_text() if info.exists() else "")
    version = subprocess.run([compiler, "--version"], capture_output=True, text=True).stdout.splitlines()
    compiler = [version[0].replace(pathlib.Path(compiler).name, "c++", 1)] if version else []
    return f"# {cpu[1] if cpu else 'unknown processor'}; {compiler[0] if compiler else 'unknown compiler'}"


def arguments():
    parser = argparse.ArgumentParser(prog="scripts/golden", description="Regression reference: one hash a case.")
    parser.add_argument("--quick", action="store_true", help="the subset that runs with every commit")
    parser.add_argument("--program", default=ROOT / "build/release/tactus", type=pathlib.Path, help="[build/release/tactus]")
    parser.add_argument("--compiler", default="c++", help="that compiled the program [c++]")
    parser.add_argument("--not-native", action="store_true", help="it was compiled without -march=native")
    parser.add_argument("--samples", action="store_true",
                        help="only cases that every level of optimisation answers alike: samples, events and errors")
    parser.add_argument("--one-in", type=int, default=1, metavar="N", help="every Nth case [1]")
    parser.add_argument("--only", default="", metavar="REGEX", help="cases whose name matches")
    parser.add_argument("--keep", type=pathlib.Path, metavar="DIR", help="keep what was hashed, to compare two programs")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="cases at a time; [one a core]")
    parser.add_argument("--any-machine", action="store_true", help="compare although processor or compiler differ")
    parser.add_argument("--times", action="store_true", help="print the seconds of the slowest cases")
    action = parser.add_mutually_exclusive_group()
    action.add_argument("--check", action="store_true", help="compare with the reference; the default")
    action.add_argument("--record", action="store_true", help="write the reference (with --only: those lines of it)")
    action.add_argument("--print", action="store_true", help="only print the hashes")
    action.add_argument("--repeat", action="store_true",
                        help="run each case again, with other block sizes, and compare the two instead of the reference")
    action.add_argument("--compare", nargs=2, type=pathlib.Path, metavar="DIR",
                        help="the size of the differences between two folders of --keep")
    return parser.parse_args()


def run_case(case, options, work, again=False):
    name, _, function = case
    folder = (options.keep or work) / re.sub(r"[^\w.-]+", "_", name)
    folder.mkdir(parents=True, exist_ok=True)
    begin = time.monotonic()
    try:
        text = function(cases.Runner(options.program.resolve(), folder, work / "shared", again))
    except subprocess.TimeoutExpired:
        text = "no end"
    text = text.replace(" ", "\n")  # a number a line, for --compare
    if options.keep:
        (folder / "answer.txt").write_text(text)
    else:
        shutil.rmtree(folder)
    return canonical.digest(text), name, time.monotonic() - begin


def run_all(options):
    chosen = [case for case in cases.all_cases() if re.search(options.only, case[0]) and (case[1] or not options.quick)
              and (cases.SAMPLES.match(case[0]) or not options.samples)][::options.one_in]
    with tempfile.TemporaryDirectory(prefix="tactus_golden_") as name:
        work = pathlib.Path(name)
        (work / "shared").mkdir()
        cases.prepare(options.program.resolve(), work / "shared", cases.shipped()[0])
        with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
            results = list(pool.map(lambda case: run_case(case, options, work), chosen))
            second = list(pool.map(lambda case: run_case(case, options, work, True), chosen if options.repeat else []))
    if options.times:
        for _, name, seconds in sorted(results, key=lambda result: -result[2])[:25]:
            print(f"{seconds:7.1f} s  {name}", file=sys.stderr)
    used = resource.getrusage(resource.RUSAGE_CHILDREN), resource.getrusage(resource.RUSAGE_SELF)
    seconds = sum(usage.ru_utime + usage.ru_stime for usage in used)
    print(f"{len(results)} cases, {seconds:.0f} s of processor time", file=sys.stderr)
    return ({name: digest for digest, name, _ in results}, {name: digest for digest, name, _ in second})


def read_reference():
    lines = REFERENCE.read_text().splitlines() if REFERENCE.exists() else [""]
    return lines[0], {name: digest for digest, name in (line.split("  ", 1) for line in lines[1:])}


def record(found, partly, here):
    known = read_reference()[1] if partly else {}
    known.update(found)
    order = [case[0] for case in cases.all_cases() if case[0] in known]
    REFERENCE.write_text("\n".join([here] + [f"{known[name]}  {name}" for name in order]) + "\n")
    print(f"{REFERENCE.relative_to(ROOT)}: {len(found)} cases recorded", file=sys.stderr)
    return 0


def check(found, known):
    wrong = [name for name, digest in found.items() if known.get(name) != digest]
    for name in wrong:
        print(f"{'differs' if name in known else 'not in the reference'}: {name}")
    print(f"{len(found) - len(wrong)} of {len(found)} as in the reference")
    return 1 if wrong else 0


def check_repeated(first, second):
    wrong = [name for name, digest in first.items() if second[name] != digest]
    for name in wrong:
        print(f"differs when it is run again with other block sizes: {name}")
    print(f"{len(first) - len(wrong)} of {len(first)} the same again")
    return 1 if wrong else 0


def wav_difference(one, other):
    (a, rate), (b, _) = cases.read_wav(one), cases.read_wav(other)
    worst = max((abs(x - y) for p, q in zip(a, b) for x, y in zip(p, q)), default=0.0)
    shape = "" if [len(c) for c in a] == [len(c) for c in b] else ", another length or number of channels"
    first = min((n for p, q in zip(a, b) for n, (x, y) in enumerate(zip(p, q)) if x != y), default=0)
    return f"largest difference {worst:.3g}, from frame {first} at {rate} Hz{shape}"


def compare(before, after):
    """Prints what differs, and by how much."""
    differences = 0
    for answer in sorted(before.glob("*/answer.txt")):
        other = after / answer.parent.name
        if not other.exists() or answer.read_text() == (other / "answer.txt").read_text():
            continue
        differences += 1
        print(answer.parent.name)
        for wav in sorted(answer.parent.glob("*.wav")):
            if (other / wav.name).exists() and cases.canonical.of_wav(wav) != cases.canonical.of_wav(other / wav.name):
                print(f"  {wav.name}: {wav_difference(wav, other / wav.name)}")
        lines = subprocess.run(["diff", answer, other / "answer.txt"], capture_output=True, text=True).stdout.splitlines()
        print("".join(f"  {line}\n" for line in lines[:12]), end="")
    return 1 if differences else 0


def main():
    options = arguments()
    if options.compare:
        return compare(*options.compare)
    if not options.program.exists():
        print(f"there is no program {options.program}; run scripts/build, or give --program", file=sys.stderr)
        return 2
    recorded_on, known = read_reference()
    here = machine(options.compiler)
    comparing = not (options.record or options.print or options.repeat)
    if comparing and not options.any_machine and (recorded_on != here or options.not_native):
        why = "" if recorded_on != here else ", compiled without -march=native"
        print(f"SKIPPED: the reference was recorded on {recorded_on[2:]}, this is {here[2:]}{why}")
        return SKIP
    found, again = run_all(options)
    if options.repeat:
        return check_repeated(found, again)
    if options.record:
        return record(found, options.quick or options.only or options.samples or options.one_in > 1, here)
    if options.print:
        print("\n".join(f"{digest}  {name}" for name, digest in found.items()))
        return 0
    return check(found, known)


if __name__ == "__main__":
    sys.exit(main())
