"""Tactus, a low-latency haptics engine, for Python: instruments and scenes run offline, with numpy arrays.

    load             reads and compiles an instrument; Instrument.render runs it on arrays
    run_scene        runs a scene: an instrument, its plant and the gestures that play it
    sweep            runs a scene over ranges of parameters, on all cores
    check            whether a scene or an instrument is stable
    analyze_latency  finds the delay in a recording; latency_probe makes the signal to record

The engine is that of the program `tactus`, with the same objects: results are the same bit for bit. Quantities are
numbers in SI, or strings with a unit such as "10 ms" and "-40 dB". Errors are exceptions of the type Error.
"""

import os as _os
import pathlib as _pathlib

from . import _tactus
from .errors import Error, FileWarning, RunWarning

__version__ = _tactus.version

_beside = _pathlib.Path(__file__).parent / "instruments"
#: The folder with the shipped instruments, scenes and actuator profiles.
instruments = _beside if _beside.is_dir() else _pathlib.Path(_tactus.source_instruments)


def _place(source):
    """What a path, a name or the text of a file is for the engine."""
    if not isinstance(source, (str, _os.PathLike)):
        raise TypeError(f"an instrument or a scene is a path, a name or a text, not {type(source).__name__}")
    text = _os.fspath(source)
    if isinstance(text, bytes):
        text = _os.fsdecode(text)
    is_text = isinstance(source, str) and "\n" in text
    return _tactus.Place(text, is_text, str(instruments))


from .instrument import Control, Instrument, load  # noqa: E402
from .latency import LatencyResult, analyze_latency, latency_probe  # noqa: E402
from .scene import CheckResult, Measure, SceneResult, check, run_scene, sweep  # noqa: E402

__all__ = ["CheckResult", "Control", "Error", "FileWarning", "Instrument", "LatencyResult", "Measure", "RunWarning",
           "SceneResult", "analyze_latency", "check", "instruments", "latency_probe", "load", "run_scene", "sweep"]
