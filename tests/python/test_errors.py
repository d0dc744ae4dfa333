"""Errors as exceptions: file, line, column, code."""

import pickle

import numpy

import tactus
from support import INSTRUMENTS, TestCase, run_json

WRONG = """format = 1
[inputs]
x = { unit = "full scale" }
[nodes]
low = { type = "low_pas", in = "x" }
d   = { type = "delay", in = "x", time = "5 mm" }
[outputs]
y = { from = "low + lo" }
"""


class Errors(TestCase):
    def test_all_errors_of_a_file_with_their_places(self):
        path = self.write("wrong.toml", WRONG)
        with self.assertRaises(tactus.Error) as caught:
            tactus.load(path)
        error = caught.exception
        self.assertEqual((error.file, error.line, error.column, error.code), (str(path), 5, 16, "UnknownName"))
        self.assertIn("low_pass", error.remedy)
        self.assertEqual([(one.line, one.code) for one in error.errors],
                         [(5, "UnknownName"), (6, "UnitMismatch"), (8, "UnknownName")])
        reported = run_json("explain", path, codes=(3,))["errors"]
        self.assertEqual([(one["where"], one["what"], one["remedy"]) for one in reported],
                         [(one.where, one.what, one.remedy) for one in error.errors])
        self.assertEqual(str(error).split("\n")[0], f"{path}:5:16: {error.what}; {error.remedy}")

    def test_a_text_has_no_file_of_its_own(self):
        with self.assertRaises(tactus.Error) as caught:
            tactus.load("format = 1\n[nodes\n")
        self.assertEqual((caught.exception.file, caught.exception.line, caught.exception.code), ("<text>", 2, "Syntax"))

    def test_files_that_are_missing(self):
        for call in (tactus.load, tactus.run_scene, tactus.check):
            with self.assertRaises(tactus.Error) as caught:
                call("haptic_drumm")
            self.assertEqual((caught.exception.file, caught.exception.line, caught.exception.code), ("haptic_drumm", None, "BadFile"))
            self.assertIn("haptic_drum", caught.exception.remedy)

    def test_a_scene_is_no_instrument(self):
        with self.assertRaisesRegex(tactus.Error, "run_scene"):
            tactus.load(INSTRUMENTS / "haptic_drum/scene.toml")
        with self.assertRaisesRegex(tactus.Error, "tactus.load"):
            tactus.run_scene(INSTRUMENTS / "haptic_drum/instrument.toml")

    def test_arguments(self):
        drum = INSTRUMENTS / "haptic_drum/scene.toml"
        for call, code in ((lambda: tactus.load("haptic_drum", sample_rate=10), "OutOfRange"),
                           (lambda: tactus.load("haptic_drum", sample_rate="1 m"), "UnitMismatch"),
                           (lambda: tactus.load("haptic_drum", delay=[]), "WrongType"),
                           (lambda: tactus.load("haptic_drum", parameters={"strenght": 1}), "UnknownName"),
                           (lambda: tactus.run_scene(drum, delay=-1), "OutOfRange"),
                           (lambda: tactus.run_scene(drum, duration="soon"), "Syntax"),
                           (lambda: tactus.sweep(drum, {"strenght": [1]}, "rate"), "UnknownName"),
                           (lambda: tactus.sweep(drum, {"strength": [1]}, "speed"), "UnknownName"),
                           (lambda: tactus.sweep(drum, {"strength": [1]}, "rate", parameters={"strength": 1}), "BadArgument"),
                           (lambda: tactus.sweep(drum, {"solver": ["fast"]}, "rate"), "UnknownName"),
                           (lambda: tactus.load("haptic_drum").render(frames=9, raise_limits={"ceilin": 1}), "UnknownName"),
                           (lambda: tactus.load("haptic_drum").render(frames=9, profile="wofer", volts_per_full_scale=8), "UnknownName")):
            with self.subTest(code), self.assertRaises(tactus.Error) as caught:
                call()
            self.assertEqual(caught.exception.code, code, str(caught.exception))
            self.assertIsNone(caught.exception.line)
        with self.assertRaises(TypeError):
            tactus.load(3)
        with self.assertRaisesRegex(ValueError, "together"):
            tactus.load("haptic_drum").render(frames=9, profile="woofer")

    def test_an_error_survives_another_process(self):
        with self.assertRaises(tactus.Error) as caught:
            tactus.load(self.write("wrong.toml", WRONG))
        again = pickle.loads(pickle.dumps(caught.exception))
        self.assertEqual(str(again), str(caught.exception))
        self.assertEqual(len(again.errors), 3)

    def test_a_probe_that_was_not_played(self):
        with self.assertRaises(tactus.Error) as caught:
            tactus.analyze_latency(numpy.zeros((4800, 2)), 48000)
        self.assertEqual(caught.exception.code, "BadArgument")
