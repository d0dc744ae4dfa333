"""The delay in recordings: the same as `tactus latency analyze`."""

import numpy

import tactus
from support import TestCase, read_wav, run, run_json, write_wav

RATE = 48000


def captured(probe, delay, gain=-0.3, noise=1e-4):
    """What comes back after `delay` frames."""
    frames = len(probe) + 4800
    signal = numpy.zeros(frames)
    signal[delay:delay + len(probe)] = gain * probe
    return signal + noise * numpy.random.default_rng(3).standard_normal(frames)


class Latency(TestCase):
    def test_the_probe_is_that_of_the_program(self):
        run("latency", "probe", "--out", self.folder / "probe.wav")
        written = read_wav(self.folder / "probe.wav")[:, 0]
        probe = tactus.latency_probe(RATE)
        self.assertEqual(len(probe), len(written))
        self.assertLessEqual(numpy.abs(probe - written).max(), 2.0**-24)

    def test_a_recording_and_what_was_played(self):
        probe = tactus.latency_probe(RATE).astype(numpy.float32)
        recording = captured(probe, 960).astype(numpy.float32)
        write_wav(self.folder / "played.wav", probe[:, None], RATE)
        write_wav(self.folder / "captured.wav", recording[:, None], RATE)
        report = run_json("latency", "analyze", self.folder / "captured.wav", "--played", self.folder / "played.wav")
        self.compare(tactus.analyze_latency(recording, RATE, played=probe), report)

    def test_what_was_played_is_the_first_channel(self):
        probe = tactus.latency_probe(RATE)
        back = captured(probe, 333, gain=0.5)
        played = numpy.pad(probe, (0, len(back) - len(probe)))
        recording = numpy.stack([played, numpy.zeros(len(back)), back], axis=1).astype(numpy.float32)
        write_wav(self.folder / "raw.wav", recording, RATE)
        report = run_json("latency", "analyze", self.folder / "raw.wav", "--channel", "3")
        result = tactus.analyze_latency(recording, RATE, channel=2)
        self.compare(result, report)
        self.assertAlmostEqual(result.delay_frames, 333, delta=0.01)
        self.assertEqual(result.polarity, 1)
        self.assertTrue(result)
        # The default is the first captured channel, which is silent here.
        self.assertEqual(tactus.analyze_latency(recording, RATE).verdict, "WRONG_CHANNEL")

    def test_an_unreliable_delay_is_none(self):
        probe = tactus.latency_probe(RATE)
        result = tactus.analyze_latency(numpy.zeros(len(probe)), RATE, played=probe)
        self.assertEqual(result.verdict, "NO_SIGNAL")
        self.assertIsNone(result.delay_ms)
        self.assertFalse(result)

    def test_what_is_refused(self):
        probe = tactus.latency_probe(RATE)
        for recording, arguments in ((probe, {}), (numpy.zeros((10, 2, 2)), {}), (numpy.zeros((0, 2)), {}),
                                     (probe, {"played": numpy.zeros((10, 2))}), (probe, {"played": probe, "channel": 1}),
                                     (numpy.stack([probe, probe], axis=1), {"channel": 0}), (probe * numpy.nan, {"played": probe})):
            with self.assertRaises(ValueError):
                tactus.analyze_latency(recording, RATE, **arguments)
        with self.assertRaises(tactus.Error) as caught:
            tactus.analyze_latency(probe, 10, played=probe)
        self.assertEqual(caught.exception.code, "OutOfRange")

    def compare(self, result, report):
        for name in ("verdict", "what", "remedy", "delay_frames", "delay_ms", "standard_error_frames", "polarity", "gain_db",
                     "snr_db", "drift_ppm", "noise_floor_dbfs", "dc", "low_hz", "high_hz", "high_pass_hz", "misfit"):
            self.assertEqual(getattr(result, name), report[name], name)
        self.assertEqual(result.sample_rate, report["sample_rate_hz"])
        self.assertEqual(result.harmonics_db, [report["harmonics_db"][f"h{order}"] for order in range(2, 6)])
        self.assertEqual(result.group_delay.tolist(), [tuple(band.values()) for band in report["group_delay"]])
        self.assertEqual(result.probes.tolist(), [tuple(probe.values()) for probe in report["sweeps"]])
        self.assertEqual(result.steps.tolist(), [tuple(step.values()) for step in report["steps"]])
