"""Scenes and sweeps: the same as `tactus play`, `tactus sweep` and `tactus check`."""

import json

import numpy

import tactus
from support import INSTRUMENTS, TestCase, read_wav, run, run_json

DRUM = INSTRUMENTS / "haptic_drum/scene.toml"
KNOB = INSTRUMENTS / "templates/knob/scene.toml"


class Scenes(TestCase):
    def compare(self, scene, options=(), codes=(0, 1), **arguments):
        report = run_json("play", scene, "--folder", self.folder, *options, codes=codes)
        played = tactus.run_scene(scene, **arguments)
        self.assertEqual(played.name, report["scene"])
        self.assertEqual((played.sample_rate, played.duration), (report["sample_rate_hz"], report["duration_s"]))
        self.assertAlmostEqual(1e3 * played.delay, report["delay_ms"], places=9)
        self.assertEqual([(one.name, one.unit, one.wanted, one.met) for one in played.measures.values()],
                         [(one["name"], one["unit"], one["wanted"], one["holds"]) for one in report["expected"]])
        for one in report["expected"]:
            if one["value"] is not None:
                self.assertEqual(played.measures[one["name"]].value, one["value"])
        self.assertEqual(played.guard, report["guard"]["in_words"])
        return played, report

    def test_measures_of_the_drum(self):
        played, _ = self.compare(DRUM, ["--duration", "3 s"], duration=3)
        self.assertEqual(played.measures["faults"].met, True)

    def test_measures_of_the_knob_with_settings(self):
        played, _ = self.compare(KNOB, ["--set", "strength=6 mN m", "--delay", "3 ms"], delay="3 ms",
                                 parameters={"strength": "6 mN m"})
        self.assertFalse(played.verdict)

    def test_a_shortened_run_leaves_measures_open(self):
        played, _ = self.compare(INSTRUMENTS / "multirate/scene.toml", ["--duration", "0.3 s"], duration="0.3 s")
        self.assertIsNone(played.measures["depth"].met)
        self.assertTrue(numpy.isnan(played.measures["depth"].value))

    def test_signals_are_those_of_the_files(self):
        played = tactus.run_scene(DRUM, duration="1 s")
        run("render", DRUM, "--duration", "1 s", "--out", self.folder / "out.wav")
        outputs = numpy.stack([played.signals[f"instrument.{name}"] for name in played.outputs], axis=1)
        self.assert_same_bits(outputs.astype(numpy.float32), read_wav(self.folder / "out.wav"))
        self.assertEqual(len(played.time), 48000)
        self.assertEqual(played.units["plant.stick"], "m")
        self.assertFalse(played.signals["plant.stick"].flags.writeable)

    def test_signals_outlive_their_result(self):
        stick = tactus.run_scene(KNOB, duration="0.1 s").signals["plant.angle"]
        again = tactus.run_scene(KNOB, duration="0.1 s").signals["plant.angle"]
        numpy.testing.assert_array_equal(stick, again)

    def test_events_are_those_of_the_program(self):
        run("render", DRUM, "--duration", "1 s", "--events", self.folder / "events.json")
        events = json.loads((self.folder / "events.json").read_text())["events"]
        played = tactus.run_scene(DRUM, duration="1 s")
        hits = [event["time_s"] for event in events if event["node"] == "hit"]
        self.assertGreater(len(hits), 3)
        numpy.testing.assert_array_equal(played.events["hit"], hits)

    def test_the_block_size_does_not_matter(self):
        played = [tactus.run_scene(KNOB, duration="0.3 s", block=block).signals for block in (1, 64, 1000)]
        for name, signal in played[0].items():
            for other in played[1:]:
                self.assert_same_bits(numpy.array(signal), numpy.array(other[name]), name)

    def test_any_measure_of_a_run(self):
        played = tactus.run_scene(KNOB, duration="1 s")
        value, unit = played.measure("peak:plant.torque")
        self.assertEqual(value, numpy.abs(played.signals["plant.torque"]).max())
        self.assertEqual(unit, "N m")
        value, _ = played.measure("rms:plant.torque", 0.25, 0.5)
        self.assertAlmostEqual(value, numpy.sqrt(numpy.mean(played.signals["plant.torque"][12000:24000] ** 2)), places=12)
        with self.assertRaises(tactus.Error):
            played.measure("peak:plant.torqe")


class Sweeps(TestCase):
    def compare(self, scene, options, over, measures, **arguments):
        report = run_json("sweep", scene, *options)
        records = tactus.sweep(scene, over, measures, **arguments)
        self.assertEqual(len(records), len(report["runs"]))
        for row, expected in zip(records, report["runs"]):
            for name, value in expected["at"].items():
                self.assertEqual(row[name], value)
            for name, value in expected["measures"].items():
                self.assertEqual(row[name], numpy.nan if value is None else value, f"{name} at {expected['at']}")
        units = {measure["name"]: measure["unit"] for measure in report["measures"]}
        self.assertEqual(records.dtype.metadata["units"], units)
        return records

    def test_two_parameters(self):
        records = self.compare(
            KNOB, ["--over", "strength=4:20:3 mN m", "--over", "delay=0:4:2 ms", "--measure", "pull", "--measure",
                   "rms:plant.torque", "--duration", "1 s"],
            {"strength": (numpy.linspace(4, 20, 3), "mN m"), "delay": [0, 0.004]}, ["pull", "rms:plant.torque"], duration=1)
        self.assertEqual(records.dtype.names, ("strength", "delay", "pull", "rms:plant.torque"))
        self.assertEqual(records.pull.shape, (6,))

    def test_solvers_and_draws(self):
        records = self.compare(
            INSTRUMENTS / "haptic_drum/every_strike_scene.toml",
            ["--over", "solver=explicit,passive", "--draws", "2", "--within", "10 %", "--seed", "5", "--duration", "0.5 s",
             "--measure", "peak:plant.stick"],
            {"solver": ["explicit", "passive"]}, {"peak:plant.stick": "peak:plant.stick"}, draws=2, within=0.1, seed=5, duration="0.5 s")
        self.assertEqual(list(records.variant[:3]), ["as written", "draw 1", "draw 2"])
        self.assertEqual(list(records.solver[::3]), ["explicit", "passive"])

    def test_threads_do_not_matter(self):
        over, measures = {"strength": [0.004, 0.008, 0.012]}, "pull"
        one, two = (tactus.sweep(KNOB, over, measures, duration=0.5, threads=threads) for threads in (1, 2))
        numpy.testing.assert_array_equal(one, two)

    def test_results_are_kept(self):
        over = {"strength": [0.004, 0.008]}
        first = tactus.sweep(KNOB, over, "pull", duration=0.5, keep=self.folder / "runs")
        second = tactus.sweep(KNOB, over, "pull", duration=0.5, keep=self.folder / "runs")
        numpy.testing.assert_array_equal(first, second)
        self.assertEqual(len(list((self.folder / "runs").glob("*.jsonl"))), 1)

    def test_names_must_differ(self):
        with self.assertRaisesRegex(ValueError, "another name"):
            tactus.sweep(DRUM, {"rate": [48000]}, ["rate"])
        records = tactus.sweep(KNOB, {"delay": [0]}, {"pulled": "pull"}, duration=0.5)
        self.assertEqual(records.dtype.names, ("delay", "pulled"))


class Checks(TestCase):
    def test_the_verdict_is_that_of_the_program(self):
        for target in (INSTRUMENTS / "wall/scene.toml", INSTRUMENTS / "exploding/scene.toml",
                       INSTRUMENTS / "haptic_drum/every_strike.toml"):
            report = run_json("check", target, "--quick", codes=(0, 1))
            result = tactus.check(target, quick=True)
            self.assertEqual((result.verdict, result.words), (report["verdict"], report["words"]))
            self.assertEqual(bool(result), report["holds"])
