"""The program beside the module: its commands, and the WAV files that it reads and writes."""

import contextlib
import json
import os
import pathlib
import struct
import subprocess
import tempfile
import unittest
import warnings

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
INSTRUMENTS = ROOT / "instruments"
PROGRAM = os.environ["TACTUS_PROGRAM"]


def run(*arguments, codes=(0,), folder=None):
    """The standard output of a command of the program."""
    done = subprocess.run([PROGRAM, *map(str, arguments)], text=True, capture_output=True, cwd=folder)
    if done.returncode not in codes:
        raise AssertionError(f"tactus {' '.join(map(str, arguments))} ended with {done.returncode}: {done.stderr}")
    return done.stdout


def run_json(*arguments, codes=(0,), folder=None):
    return json.loads(run(*arguments, "--json", codes=codes, folder=folder))


def write_wav(path, samples, rate):
    """float32; samples of the shape (frames, channels)."""
    data = numpy.ascontiguousarray(samples, dtype="<f4")
    frames, channels = data.shape
    body = data.tobytes()
    header = struct.pack("<4sI4s4sIHHIIHH4sII4sI", b"RIFF", 48 + 2 + len(body), b"WAVE", b"fmt ", 16, 3, channels, rate,
                         4 * channels * rate, 4 * channels, 32, b"fact", 4, frames, b"data", len(body))
    pathlib.Path(path).write_bytes(header + body)


def read_wav(path):
    """(frames, channels) of a file of float32 or of 24 bits, the latter as float64."""
    data = pathlib.Path(path).read_bytes()
    at, kind, channels = 12, None, None
    while at + 8 <= len(data):
        name, size = data[at:at + 4], struct.unpack_from("<I", data, at + 4)[0]
        if name == b"fmt ":
            kind, channels, _, _, _, bits = struct.unpack_from("<HHIIHH", data, at + 8)
        elif name == b"data":
            body = data[at + 8:at + 8 + size]
            if bits == 32:
                return numpy.frombuffer(body, dtype="<f4").reshape(-1, channels)
            triples = numpy.frombuffer(body, dtype=numpy.uint8).reshape(-1, 3).astype(numpy.int32)
            whole = (triples[:, 0] << 8 | triples[:, 1] << 16 | triples[:, 2] << 24) >> 8
            return (whole / 2.0**23).reshape(-1, channels)
        at += 8 + size + size % 2
    raise AssertionError(f"{path} has no samples")


def strikes(frames, channels, rate=48000, seed=1):
    """Noise of float32 with a decaying burst ten times a second, which an onset detector finds."""
    generator = numpy.random.default_rng(seed)
    time = numpy.arange(frames) / rate
    burst = numpy.exp(-(time % 0.1) / 0.004)
    noise = generator.uniform(-1, 1, (frames, channels))
    return (noise * (0.4 * burst[:, None] + 1e-4)).astype(numpy.float32)


class TestCase(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)

    def write(self, name, text):
        path = self.folder / name
        path.write_text(text)
        return path

    def assert_same_bits(self, array, expected, message=""):
        self.assertEqual(array.shape, expected.shape, message)
        self.assertEqual(array.dtype, expected.dtype, message)
        different = numpy.flatnonzero((array.view(numpy.uint8) != expected.view(numpy.uint8)))
        self.assertEqual(len(different), 0, f"{message}: {len(different)} bytes differ")


@contextlib.contextmanager
def quiet():
    """Without the warnings of runs and files."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield
