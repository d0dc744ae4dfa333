"""The delay in recordings."""

import dataclasses
import typing

import numpy

from . import _tactus
from .arrays import frames_by_channels, one_channel


@dataclasses.dataclass(frozen=True)
class LatencyResult:
    """What a recording says about the path from what was played to what was captured.

        H(f) = g A(f) exp(-2 pi i f D / sample_rate),  D = delay_frames

    verdict                "ok", or the reason why no delay is reported: "NO_SIGNAL", "CLIPPING", "LOST_FRAMES", "LOW_SNR", …
    what, remedy           the same in words
    delay_frames, delay_ms, standard_error_frames
                           None unless the verdict is "ok"
    polarity               1 or -1; gain_db, snr_db, drift_ppm, low_hz, high_hz (within 3 dB), high_pass_hz, misfit: None
                           where they are not known
    noise_floor_dbfs, dc   of what was captured
    harmonics_db           levels of H2 to H5 relative to the fundamental; None: not measured
    group_delay            record array: hz, frames, error
    probes                 record array, one row for each probe: played_at [s], frames, gain_db, level
    steps                  record array: at [s], frames; where the delay changed
    spectrum               record array: hz, gain_db, noise_db
    impulse_response       array; its first sample has the delay impulse_response_at [frames]
    """

    verdict: str
    what: str
    remedy: str
    sample_rate: float
    delay_frames: typing.Optional[float]
    delay_ms: typing.Optional[float]
    standard_error_frames: typing.Optional[float]
    polarity: typing.Optional[int]
    gain_db: typing.Optional[float]
    snr_db: typing.Optional[float]
    drift_ppm: typing.Optional[float]
    noise_floor_dbfs: typing.Optional[float]
    dc: typing.Optional[float]
    low_hz: typing.Optional[float]
    high_hz: typing.Optional[float]
    high_pass_hz: typing.Optional[float]
    misfit: typing.Optional[float]
    harmonics_db: list
    group_delay: numpy.recarray
    probes: numpy.recarray
    steps: numpy.recarray
    spectrum: numpy.recarray
    impulse_response: numpy.ndarray
    impulse_response_at: int

    def __bool__(self):
        return self.verdict == "ok"


def _records(rows, *names):
    return numpy.array(rows, dtype=[(name, numpy.float64) for name in names]).view(numpy.recarray)


def analyze_latency(recording, sample_rate, *, played=None, channel=None):
    """Finds the delay in a recording: `tactus latency analyze`.

    recording    array (frames, channels). Without `played` the first channel is what was played, as in the files of
                 `tactus latency measure --wav`.
    sample_rate  1 kHz to 1 MHz; [Hz] or a string with a unit
    played       array (frames,): what was played, from the first frame of the recording on, such as latency_probe gives
    channel      column of the recording with the captured signal, from 0; None: the first one that was captured

    Gives a LatencyResult. Raises ValueError for shapes, channels and non-finite samples; Error (BadArgument) if what was
    played has no repeated bursts between pauses.
    """
    captured = frames_by_channels(recording, "recording")
    first = 0
    if played is None:
        if captured.shape[1] < 2:
            raise ValueError("the recording has one channel: give what was played as `played`, or as the first of two channels")
        sent, captured, first = captured[:, 0], captured[:, 1:], 1
    else:
        sent = one_channel(played, "played")
    if not len(captured) or not len(sent):
        raise ValueError("the recording contains no samples")
    if not (numpy.isfinite(captured).all() and numpy.isfinite(sent).all()):
        raise ValueError("some samples of the recording are non-finite")
    column = first if channel is None else channel
    if not first <= column < first + captured.shape[1]:
        raise ValueError(f"the captured channels are {first} to {first + captured.shape[1] - 1}, not {channel}")
    found = _tactus.analyze_latency(captured, sent[:, numpy.newaxis], int(column) - first, sample_rate)
    found["group_delay"] = _records(found["group_delay"], "hz", "frames", "error")
    found["probes"] = _records(found["probes"], "played_at", "frames", "gain_db", "level")
    found["steps"] = _records(found["steps"], "at", "frames")
    found["spectrum"] = _records(found["spectrum"], "hz", "gain_db", "noise_db")
    return LatencyResult(**found)


def latency_probe(sample_rate=48000, *, level_dbfs=-12):
    """The test signal of `tactus latency probe`: an array (frames,) of float64, full scale 1.

    sample_rate  1 kHz to 1 MHz; [Hz] or a string with a unit
    level_dbfs   its highest peak, -120 to 0
    """
    if not -120 <= level_dbfs <= 0:
        raise ValueError(f"level_dbfs must be from -120 to 0, not {level_dbfs}")
    return _tactus.latency_probe(sample_rate, float(level_dbfs))
