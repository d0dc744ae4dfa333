"""Instruments: graphs that run on arrays."""

import collections.abc
import dataclasses
import difflib
import os
import warnings

import numpy

from . import _place, _tactus, instruments
from .arrays import frames_by_channels, numbers, one_channel
from .errors import Error, FileWarning, RunWarning


@dataclasses.dataclass(frozen=True)
class Control:
    """A control of an instrument: name; value [SI], as loaded; unit ("dB" for a gain written in decibels, whose value
    is a factor); range (low, high) [SI]; ramp [s], in which a change takes effect; fixed: it is read when the graph is
    compiled, and cannot move while it runs."""

    name: str
    value: float
    unit: str
    range: tuple
    ramp: float
    fixed: bool


class Instrument:
    """An instrument that is ready to run: see load.

    name, about    as in the file
    sample_rate    [Hz]
    inputs         names of the inputs, in the order of the channels of `render`
    outputs        names of the outputs, likewise
    sounds         those of the outputs that are for ears, and drive no actuator
    controls       {name: Control}
    steps          what runs, in its order: [(path of the node, what it does)]
    warnings       what is allowed in the file and probably not meant: [Error], not raised

    It does not change: several threads may render with it at the same time.
    """

    def __init__(self, compiled):
        self._compiled = compiled
        self.name, self.about, self.sample_rate = compiled.name, compiled.about, compiled.sample_rate
        self.inputs, self.outputs, self.sounds = compiled.inputs, compiled.outputs, compiled.sounds
        self.controls = {control[0]: Control(*control) for control in compiled.controls}
        self.warnings = [Error(*warning) for warning in compiled.warnings]

    def __repr__(self):
        return f"<tactus.Instrument {self.name!r}: {', '.join(self.inputs)} -> {', '.join(self.outputs)} at {self.sample_rate:g} Hz>"

    @property
    def steps(self):
        return self._compiled.steps

    def render(self, inputs=None, *, controls=None, frames=None, block=256, profile=None, volts_per_full_scale=None,
               raise_limits=None):
        """Runs the instrument from its start on an input, and gives its outputs.

            outputs[n, k] = output k at frame n, behind the drive guard

        inputs        array of the shape (frames, inputs), or (frames,) for a single input; or {name: array (frames,)},
                      where inputs that are left out are silent; or None: all are silent. Any type of real numbers;
                      float32 and float64 are exact. Full scale is 1; non-finite samples count as 0.
        controls      {name: value}. One number [SI] or string with a unit: from the start on. An array (frames,): the
                      value at each frame, without the control's ramp. A list of (time [s], value): at each of these
                      times the control moves to the value with its ramp, as when a user moves it.
        frames        without inputs: how many to run
        block         frames of one block, 1 to 8192. It does not change the result.
        profile       actuator profile for all drives, such as "woofer", or a file: its limits replace the cautious ones of
                      an unknown actuator; with volts_per_full_scale, 1 mV to 1 kV: the voltage at the actuator for a
                      sample value of 1
        raise_limits  {limit: value}, limits of the drive guard to raise, as --raise-limit does: "ceiling", "slew", …;
                      or "OUTPUT.LIMIT" for one output

        Gives an array of float64 of the shape (frames, outputs), the same bit for bit as the file that `tactus render`
        writes (there as float32). A RunWarning reports what the guard did, faults, and non-finite inputs.

        Raises ValueError and TypeError for arrays of another shape or type; Error for unknown controls (UnknownName),
        values outside their range (OutOfRange), a control that is fixed (BadArgument), and limits.
        """
        samples = self._samples(inputs, frames)
        if not (isinstance(block, (int, numpy.integer)) and 1 <= block <= 8192):
            raise ValueError(f"block must be a whole number from 1 to 8192, not {block!r}")
        start, moves = self._controls(controls or {}, len(samples))
        drives = _drives(profile, volts_per_full_scale, raise_limits or {})
        outputs, guard, faults, nonfinite = self._compiled.render(samples, start, moves, int(block), drives)
        for line in guard:
            warnings.warn(f"drive guard: {line}", RunWarning, stacklevel=2)
        for path, count in faults:
            warnings.warn(f"{path} produced non-finite values {count} times", RunWarning, stacklevel=2)
        if nonfinite:
            warnings.warn(f"{nonfinite} non-finite input samples replaced by zero", RunWarning, stacklevel=2)
        return outputs

    def _samples(self, inputs, frames):
        if inputs is None or isinstance(inputs, collections.abc.Mapping) and not inputs:
            if not (isinstance(frames, (int, numpy.integer)) and frames >= 0):
                raise ValueError("without inputs, give the number of frames, such as frames=48000")
            return numpy.zeros((int(frames), len(self.inputs)))
        if isinstance(inputs, collections.abc.Mapping):
            samples = self._named(inputs)
        else:
            samples = frames_by_channels(inputs, "inputs")
            if samples.shape[1] != len(self.inputs):
                raise ValueError(f"inputs have the shape {numpy.shape(inputs)}: '{self.name}' has {len(self.inputs)} inputs "
                                 f"({', '.join(self.inputs)}), so the shape must be (frames, {len(self.inputs)})")
        if frames is not None and frames != len(samples):
            raise ValueError(f"inputs have {len(samples)} frames, not {frames}")
        return samples

    def _named(self, inputs):
        channels = {}
        for name, values in inputs.items():
            if name not in self.inputs:
                raise ValueError(f"'{self.name}' has no input {name!r}{_nearest(name, self.inputs)}")
            channels[name] = one_channel(values, f"input '{name}'")
        lengths = {name: len(channel) for name, channel in channels.items()}
        if len(set(lengths.values())) > 1:
            raise ValueError("inputs have different lengths: " + ", ".join(f"{name} {length}" for name, length in lengths.items()))
        samples = numpy.zeros((next(iter(lengths.values())), len(self.inputs)))
        for name, channel in channels.items():
            samples[:, self.inputs.index(name)] = channel
        return samples

    def _controls(self, controls, frames):
        start, moves = {}, []
        for name, value in controls.items():
            if isinstance(value, str) or numpy.ndim(value) == 0:
                start[name] = value
            elif isinstance(value, (list, tuple)) and all(isinstance(point, (list, tuple)) and len(point) == 2 for point in value):
                moves.append(self._breakpoints(name, value))
            else:
                values = one_channel(value, f"control '{name}'")
                if len(values) != frames:
                    raise ValueError(f"control '{name}' has {len(values)} values for {frames} frames; "
                                     "for breakpoints give a list of (time, value)")
                if not len(values):
                    continue
                changed = numpy.concatenate(([0], numpy.flatnonzero(values[1:] != values[:-1]) + 1))
                moves.append(_tactus.ControlMove(name, changed.tolist(), values[changed].tolist(), True))
        return start, moves

    def _breakpoints(self, name, points):
        times = numbers([time for time, _ in points], f"the times of control '{name}'")
        values = numbers([value for _, value in points], f"the values of control '{name}'")
        if not (numpy.all(times >= 0) and numpy.all(numpy.diff(times) > 0)):
            raise ValueError(f"the times of control '{name}' must rise, from 0 s on")
        frames = numpy.rint(times * self.sample_rate).astype(numpy.int64)
        return _tactus.ControlMove(name, frames.tolist(), values.tolist(), False)


def _drives(profile, volts, raises):
    if (profile is None) != (volts is None):
        raise ValueError("profile and volts_per_full_scale must be given together, such as profile='woofer', volts_per_full_scale=8")
    if volts is not None and not 1e-3 <= volts <= 1000:
        raise ValueError(f"volts_per_full_scale must be from 0.001 to 1000, not {volts}")
    raises = [(name, str(value)) for name, value in raises.items()]
    return _tactus.DriveOptions(os.fspath(profile or ""), float(volts or 0), raises, str(instruments))


def _nearest(name, names):
    near = difflib.get_close_matches(str(name), names, 1)
    return f"; did you mean {near[0]!r}?" if near else f"; there are {', '.join(names)}"


def load(source, *, sample_rate=48000, parameters=None, delay=0):
    """Reads and compiles an instrument, plant or part.

    source       a path; a folder, for its instrument.toml; the name of a shipped instrument, such as "haptic_drum"; or
                 the text of a graph file, which is a string with at least one line end
    sample_rate  1 kHz to 768 kHz; [Hz] or a string with a unit
    parameters   {control: value}: values in place of those of the file, as --set gives them to the program; also
                 controls that are fixed when the graph is compiled
    delay        system delay, 0 to 10 s, for instruments that use it; [s] or a string with a unit

    Gives an Instrument. Raises Error with all errors of the file. Warnings of the file are issued as FileWarning.
    """
    compiled = _tactus.Instrument(_place(source), sample_rate, dict(parameters or {}), delay)
    instrument = Instrument(compiled)
    for warning in instrument.warnings:
        warnings.warn(str(warning), FileWarning, stacklevel=2)
    return instrument
