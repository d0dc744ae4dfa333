"""Scenes: an instrument with the world it plays in."""

import dataclasses
import typing

import numpy

from . import _place, _tactus
from .errors import Error


@dataclasses.dataclass(frozen=True)
class Measure:
    """An expectation of a scene: its name; the value that was measured, in `unit`; what was wanted, as text; met, or None
    if the run ended before the time window of the measure did."""

    name: str
    value: float
    unit: str
    wanted: str
    met: typing.Optional[bool]


class SceneResult:
    """What happened while a scene played: see run_scene.

    name          of the scene
    sample_rate   [Hz]
    delay         system delay [s]
    duration      [s]
    signals       {name: array (frames,), read-only}: "plant.stick", "instrument.microphone", "instrument.woofer", …
    units         {name: unit of the signal}, "" for a plain number or full scale
    inputs        names of the instrument's inputs; signals have them with "instrument." before
    outputs       names of its outputs, likewise
    measures      {name: Measure}: what [expect] of the scene asks for
    events        {trigger of the instrument: array of times [s]}
    verdict       True if every expectation was met, without a fault and without a fade of the drive guard: then the exit
                  code of `tactus play` is 0
    guard         what the drive guard did, one text for each action
    faults        [(node, how often it produced non-finite values)]
    warnings      of the files: [Error], not raised
    """

    def __init__(self, played):
        self._played = played
        self.name, self.sample_rate, self.duration = played.name, played.sample_rate, played.duration
        self.delay = played.delay_frames / played.sample_rate
        self.inputs, self.outputs = played.inputs, played.outputs
        self.signals, self.units, self.events = played.signals, played.units, played.events
        self.measures = {name: Measure(name, value if reached else numpy.nan, unit, wanted, met if reached else None)
                         for name, value, unit, wanted, met, reached in played.outcomes}
        self.verdict, self.guard, self.faults = played.passed, played.guard, played.faults
        self.warnings = [Error(*warning) for warning in played.warnings]

    def __repr__(self):
        met = sum(measure.met is True for measure in self.measures.values())
        return (f"<tactus.SceneResult {self.name!r}: {self.duration:g} s at {self.sample_rate:g} Hz, "
                f"{met} of {len(self.measures)} expectations met>")

    @property
    def time(self):
        """Time of each frame [s]."""
        frames = len(next(iter(self.signals.values()))) if self.signals else 0
        return numpy.arange(frames) / self.sample_rate

    def measure(self, measure, start=None, end=None):
        """A number computed from this run, as `tactus sweep --measure` takes it.

        measure     the name of an expectation of the scene, or MEASURE:SIGNAL such as "rms:instrument.woofer"
        start, end  the time window [s]; None: as the expectation has it, else the whole run

        Gives (value, unit). Raises Error (UnknownName with the nearest name).
        """
        return self._played.measure(measure, start, end)


def run_scene(source, *, parameters=None, delay=None, sample_rate=None, duration=None, block=64):
    """Runs a scene in simulation: the plant, the instrument and the gestures, with the system delay between them.

    source       a path; a folder, for its scene.toml; the name of a shipped instrument; or the text of a scene
    parameters   {name: value}: controls of the instrument ("strength"), of another part ("plant.grip"), as --set
    delay        system delay, 0 to 10 s; None: the scene's
    sample_rate  1 kHz to 768 kHz; None: the scene's
    duration     1 ms to 1 h; None: the scene's
    block        frames of one block, 1 to 8192. It does not change the result.

    Numbers are in SI; strings have a unit. Gives a SceneResult with the numbers of `tactus play`. Raises Error with all
    errors of the scene and of the files of its parts.
    """
    if not 1 <= block <= 8192:
        raise ValueError(f"block must be from 1 to 8192, not {block!r}")
    return SceneResult(_tactus.run_scene(_place(source), dict(parameters or {}), delay, sample_rate, duration, int(block)))


def sweep(source, over, measures, *, parameters=None, window=(None, None), duration=None, draws=0, within=0.2, seed=1,
          threads=0, keep=None):
    """Runs a scene at every combination of values, on all cores, and measures each run.

    source      a scene, as for run_scene
    over        {name: values}; the last name varies fastest. A name is what `tactus sweep --over` takes: a control, a
                gesture, a parameter of a node, "delay", "rate", "oversample" or "solver". Values are numbers [SI], strings
                with a unit, or (numbers, unit) for all of them, such as (numpy.linspace(0, 40, 9), "ms"); of "solver"
                they are names. A plain number scales a gesture, and a quantity holds it.
    measures    names of expectations, or MEASURE:SIGNAL such as "rms:instrument.sound"; or {field: measure}
    parameters  as for run_scene, in every run
    window      (start, end) of the measurement [s]; None: as the expectation has it
    duration    of each run
    draws       number of further runs at each point with random plants, whose quantities differ by at most `within`
                (a factor from 1e-6 to 0.999999) with the generator's `seed`
    threads     0: one for each core
    keep        a folder where finished runs are saved, and taken from the next time

    Gives a numpy record array with a row for each run and a field for each name (as given), for "variant" (where there
    are draws) and for each measure, in the order in which the program lists runs. The units of the measures are in
    records.dtype.metadata["units"], "" where it is that of the signal. Results depend neither on the number of threads nor on an interruption.

    Raises Error (UnknownName with the nearest name, UnitMismatch, OutOfRange, errors of the scene). Ctrl-C ends it after
    the runs in hand.
    """
    lists = {name: _values(values) for name, values in over.items()}
    if isinstance(measures, str):
        measures = [measures]
    fields = dict(measures) if isinstance(measures, dict) else {measure: measure for measure in measures}
    if not fields:
        raise ValueError("a sweep needs at least one measure")
    for name in fields:
        if name in lists or name == "variant":
            raise ValueError(f"{name!r} is swept and measured: give the measure another name, as in "
                             f"measures={{'measured': {fields[name]!r}}}")
    start, end = window
    if start is not None and end is not None and start >= end:
        raise ValueError("the window must end after it begins")
    at, variants, results, units = _tactus.sweep(
        _place(source), lists, dict(parameters or {}), list(fields.values()), start, end, duration, int(draws), float(within),
        int(seed), int(threads), "" if keep is None else str(keep))
    columns, kinds = [], []
    for axis, name in enumerate(lists):
        given = [point[axis] for point in at]
        if name == "solver":
            names = [lists[name][int(number)] for number in given]
            columns.append(names)
            kinds.append((name, f"U{max(map(len, lists[name]))}"))
        else:
            columns.append(given)
            kinds.append((name, numpy.float64))
    if draws:
        columns.append(variants)
        kinds.append(("variant", f"U{max(map(len, variants))}"))
    for column, name in enumerate(fields):
        columns.append([row[column] for row in results])
        kinds.append((name, numpy.float64))
    kind = numpy.dtype((numpy.record, numpy.dtype(kinds)), metadata={"units": dict(zip(fields, units))})
    records = numpy.empty(len(at), dtype=kind).view(numpy.recarray)
    for (name, _), column in zip(kinds, columns):
        records[name] = column
    return records


def _values(values):
    """As a list of numbers or strings."""
    if isinstance(values, tuple) and len(values) == 2 and isinstance(values[1], str) and not isinstance(values[0], str):
        return [f"{float(number)!r} {values[1]}" for number in numpy.ravel(values[0])]
    if isinstance(values, str) or numpy.ndim(values) == 0:
        return [values]
    return [value if isinstance(value, str) else float(value) for value in values]


@dataclasses.dataclass(frozen=True)
class CheckResult:
    """verdict: "stable", "unstable" or "undecided"; words: the verdict and what limits it, a sentence each. It counts as
    true if it is stable."""

    verdict: str
    words: list

    def __bool__(self):
        return self.verdict == "stable"


def check(source, *, parameters=None, delay=None, sample_rate=None, quick=False, threads=0):
    """Whether a scene, or an instrument by itself, is stable: `tactus check`.

    source      as for run_scene; of an instrument also its text
    parameters  as for run_scene
    delay       system delay; None: that of the scene, or the longest that the instrument was tested with
    quick       True: only the analysis, without simulation runs

    Gives a CheckResult. Raises Error with all errors of the files.
    """
    return CheckResult(*_tactus.check(_place(source), dict(parameters or {}), delay, sample_rate, bool(quick), int(threads)))
