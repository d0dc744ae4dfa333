"""Instruments on arrays: the same as `tactus render`, and what is refused."""

import concurrent.futures
import pathlib
import signal
import subprocess
import sys
import threading
import time
import warnings

import numpy

import tactus
from support import INSTRUMENTS, TestCase, quiet, read_wav, run, strikes, write_wav

GAIN = """format = 1
name = "gain"
[inputs]
x = { unit = "full scale" }
[controls]
g = { value = 0.25, range = [0, 1] }
[outputs]
y = { from = "g * x", kind = "audio" }
"""
PAIR = """format = 1
[inputs]
left = { unit = "full scale" }
right = { unit = "full scale" }
[outputs]
both = { from = "0.5 * left + 0.25 * right", kind = "audio" }
"""
# A control that is read when the graph is compiled, and a file with a bare number where a unit is expected.
FIXED = """format = 1
[controls]
m = { value = "10 g", range = ["1 g", "1 kg"] }
[inputs]
f = { unit = "N" }
[networks.n]
body = { type = "mass", mass = "m" }
push = { type = "force", on = "body", force = "f" }
[outputs]
y = { from = "n.body.position / 1 m", kind = "audio" }
"""


class SameAsTheProgram(TestCase):
    def compare(self, instrument, sets=(), seconds=1.5, rate=48000, controls=None):
        with quiet():
            loaded = tactus.load(instrument, sample_rate=rate)
        samples = strikes(int(seconds * rate), len(loaded.inputs), rate)
        write_wav(self.folder / "in.wav", samples, rate)
        options = [option for text in sets for option in ("--set", text)]
        run("render", instrument, "--in", self.folder / "in.wav", "--out", self.folder / "out.wav", *options)
        expected = read_wav(self.folder / "out.wav")
        self.assertGreater(numpy.abs(expected).max(), 0, "the output is silent")
        for block in (1, 64, 256, 1000):
            with quiet():
                rendered = loaded.render(samples, controls=controls, block=block)
            self.assertEqual(rendered.dtype, numpy.float64)
            self.assert_same_bits(rendered.astype(numpy.float32), expected, f"{instrument}, blocks of {block}")

    def test_the_drum(self):
        self.compare(INSTRUMENTS / "haptic_drum/instrument.toml")

    def test_controls(self):
        self.compare(INSTRUMENTS / "haptic_drum/every_strike.toml", ["strength=0.4", "sensitivity=-30 dB", "length=9 ms"],
                     controls={"strength": 0.4, "sensitivity": "-30 dB", "length": "9 ms"})

    def test_parts_at_a_rate_of_their_own(self):
        self.compare(INSTRUMENTS / "multirate/instrument.toml", ["ribs=3 N"], controls={"ribs": 3.0})

    def test_a_plant_with_a_network(self):
        self.compare(INSTRUMENTS / "haptic_drum/plant.toml", seconds=0.4)

    def test_an_instrument_without_inputs(self):
        path = INSTRUMENTS / "templates/metronome/instrument.toml"
        run("render", path, "--duration", "1 s", "--out", self.folder / "out.wav")
        with quiet():
            rendered = tactus.load(path).render(frames=48000)
        self.assert_same_bits(rendered.astype(numpy.float32), read_wav(self.folder / "out.wav"))
        self.assertGreater(numpy.abs(rendered).max(), 0)

    def test_another_sample_rate(self):
        self.compare(INSTRUMENTS / "haptic_drum/every_strike.toml", rate=44100)

    def compare_guarded(self, options, **arguments):
        loud = self.write("loud.toml", PAIR.replace(', kind = "audio"', "").replace("0.5 * left", "4 * left"))
        samples = strikes(24000, 2)
        write_wav(self.folder / "in.wav", samples, 48000)
        run("render", loud, "--in", self.folder / "in.wav", "--out", self.folder / "out.wav", *options)
        with quiet():
            rendered = tactus.load(loud).render(samples, **arguments)
            cautious = tactus.load(loud).render(samples)
        self.assert_same_bits(rendered.astype(numpy.float32), read_wav(self.folder / "out.wav"))
        self.assertFalse(numpy.array_equal(rendered, cautious))

    def test_raised_limits(self):
        self.compare_guarded(["--raise-limit", "ceiling=0.8"], raise_limits={"ceiling": 0.8})
        self.compare_guarded(["--raise-limit", "both.ceiling=0.7"], raise_limits={"both.ceiling": 0.7})

    def test_limits_of_a_profile(self):
        self.compare_guarded(["--profile", "woofer", "--volts-per-full-scale", "10 V"], profile="woofer", volts_per_full_scale=10)


class Arrays(TestCase):
    def test_any_layout_and_number_type_is_exact(self):
        instrument = tactus.load(PAIR)
        samples = strikes(3000, 2).astype(numpy.float64)
        expected = instrument.render(samples)
        self.assert_same_bits(instrument.render(numpy.asfortranarray(samples)), expected)
        self.assert_same_bits(instrument.render(samples.astype(numpy.float32)), expected)
        self.assert_same_bits(instrument.render(numpy.repeat(samples, 2, axis=0)[::2]), expected)
        self.assert_same_bits(instrument.render(samples.astype(">f8")), expected)
        self.assert_same_bits(instrument.render(samples[::-1][::-1]), expected)
        self.assert_same_bits(instrument.render(samples.tolist()), expected)

    def test_inputs_by_name(self):
        instrument = tactus.load(PAIR)
        samples = strikes(3000, 2)
        expected = instrument.render(samples)
        self.assert_same_bits(instrument.render({"right": samples[:, 1], "left": samples[:, 0]}), expected)
        silent = instrument.render({"left": samples[:, 0]})
        self.assert_same_bits(silent, instrument.render(samples * numpy.array([1, 0], numpy.float32)))

    def test_one_input_needs_no_second_axis(self):
        instrument = tactus.load(GAIN)
        samples = numpy.linspace(-1, 1, 100)
        rendered = instrument.render(samples)
        self.assertEqual(rendered.shape, (100, 1))
        numpy.testing.assert_array_equal(rendered[:, 0], 0.25 * samples)

    def test_silence_and_no_frames(self):
        instrument = tactus.load(GAIN)
        self.assertEqual(instrument.render(frames=100).shape, (100, 1))
        self.assertEqual(instrument.render(numpy.zeros((0, 1))).shape, (0, 1))

    def test_wrong_shapes_are_refused(self):
        instrument = tactus.load(PAIR)
        for inputs, message in ((numpy.zeros((10, 3)), r"2 inputs \(left, right\).*\(frames, 2\)"), (numpy.zeros(10), "2 inputs"),
                                (numpy.zeros((2, 2, 2)), r"\(frames, channels\)"), ({"left": numpy.zeros((5, 2))}, "input 'left'"),
                                ({"left": numpy.zeros(5), "right": numpy.zeros(6)}, "left 5, right 6"),
                                ({"lift": numpy.zeros(5)}, "did you mean 'left'"), (None, "number of frames")):
            with self.subTest(message), self.assertRaisesRegex(ValueError, message):
                instrument.render(inputs)
        for inputs in (numpy.zeros((10, 2), complex), [["a", "b"]]):
            with self.assertRaisesRegex(TypeError, "real numbers"):
                instrument.render(inputs)
        for block in (0, 8193, 2.5):
            with self.assertRaisesRegex(ValueError, "block"):
                instrument.render(frames=10, block=block)

    def test_nonfinite_inputs_count_as_zero(self):
        samples = numpy.full(100, 0.5)
        samples[[3, 50]] = numpy.nan, numpy.inf
        with self.assertWarnsRegex(tactus.RunWarning, "2 non-finite input samples"):
            rendered = tactus.load(GAIN).render(samples)
        self.assertEqual(rendered[3, 0], 0)
        self.assertEqual(rendered[4, 0], 0.125)

    def test_the_guard_is_reported(self):
        drive = tactus.load(GAIN.replace(', kind = "audio"', ""))
        with self.assertWarnsRegex(tactus.RunWarning, "drive guard: y: .*ceiling"):
            rendered = drive.render(numpy.ones(4800), controls={"g": 1})
        self.assertEqual(rendered.max(), 0.5)


class Controls(TestCase):
    def test_a_number_holds_from_the_start(self):
        rendered = tactus.load(GAIN).render(numpy.ones(10), controls={"g": 0.75})
        numpy.testing.assert_array_equal(rendered[:, 0], 0.75)

    def test_parameters_hold_for_every_run(self):
        instrument = tactus.load(GAIN, parameters={"g": "-20 dB"})
        numpy.testing.assert_array_equal(instrument.render(numpy.ones(10))[:, 0], instrument.controls["g"].value)
        self.assertAlmostEqual(instrument.controls["g"].value, 0.1, places=15)

    def test_an_array_gives_the_value_at_each_frame(self):
        values = numpy.repeat(numpy.random.default_rng(2).uniform(0, 1, 50), 37)
        instrument = tactus.load(GAIN)
        for block in (1, 64, 1000):
            rendered = instrument.render(numpy.ones(len(values)), controls={"g": values}, block=block)
            numpy.testing.assert_array_equal(rendered[:, 0], values)
        every_frame = numpy.linspace(0, 1, 1000)
        rendered = instrument.render(numpy.ones(1000), controls={"g": every_frame.astype(numpy.float32)})
        numpy.testing.assert_array_equal(rendered[:, 0], every_frame.astype(numpy.float32))

    def test_breakpoints_take_the_ramp_of_the_control(self):
        # The ramp lasts 10 ms unless the file says otherwise.
        instrument = tactus.load(GAIN)
        rendered = instrument.render(numpy.ones(4800), controls={"g": [(0.05, 1.0)]})[:, 0]
        numpy.testing.assert_array_equal(rendered[:2400], 0.25)
        numpy.testing.assert_array_equal(rendered[2400 + 480 + 8:], 1.0)
        self.assertAlmostEqual(rendered[2400 + 240], 0.625, delta=0.02)
        self.assertEqual(instrument.controls["g"].ramp, 0.01)

    def test_breakpoints_are_the_gestures_of_a_scene(self):
        self.write("i.toml", GAIN)
        scene = self.write("s.toml", """format = 1
duration = "0.4 s"
[converters]
off = true
[parts]
instrument = { use = "i.toml", x = "way", g = "knob" }
[gestures]
way  = { points = [["0 s", 0.1], ["0.4 s", 0.9]] }
knob = { curve = "step", points = [["0 s", 0.25], ["0.1 s", 0.75], ["0.25 s", 0.5]] }
""")
        played = tactus.run_scene(scene)
        rendered = tactus.load(GAIN).render(played.signals["instrument.x"], controls={"g": [(0, 0.25), (0.1, 0.75), (0.25, 0.5)]})
        self.assert_same_bits(rendered[:, 0], numpy.array(played.signals["instrument.y"]))

    def test_what_is_refused(self):
        instrument = tactus.load(GAIN)
        for controls, code in (({"h": 0.5}, "UnknownName"), ({"h": [(0, 0.5)]}, "UnknownName"), ({"g": 2}, "OutOfRange"),
                               ({"g": [(0, 2)]}, "OutOfRange"), ({"g": "3 m"}, "UnitMismatch"), ({"g": "many"}, "Syntax")):
            with self.subTest(controls), self.assertRaises(tactus.Error) as caught:
                instrument.render(frames=10, controls=controls)
            self.assertEqual(caught.exception.code, code)
        for values in (numpy.zeros(9), [(0.2, 0), (0.1, 1)], [(-1, 0)]):
            with self.assertRaises(ValueError):
                instrument.render(frames=10, controls={"g": values})

    def test_a_fixed_control_cannot_move(self):
        instrument = tactus.load(FIXED)
        self.assertTrue(instrument.controls["m"].fixed)
        with self.assertRaises(tactus.Error) as caught:
            instrument.render(frames=10, controls={"m": [(0, 0.1)]})
        self.assertEqual(caught.exception.code, "BadArgument")
        light = instrument.render(numpy.full(480, 1e-3), controls={"m": "1 g"})
        heavy = instrument.render(numpy.full(480, 1e-3), controls={"m": 0.1})
        self.assertGreater(light[-1, 0], 50 * heavy[-1, 0])


class Runs(TestCase):
    def test_threads_do_not_disturb_each_other(self):
        with quiet():
            drum = tactus.load(INSTRUMENTS / "haptic_drum/instrument.toml")
            inputs = [strikes(48000, 1, seed=seed) for seed in range(4)]
            one_by_one = [drum.render(samples) for samples in inputs]
            with concurrent.futures.ThreadPoolExecutor(2) as pool:
                together = list(pool.map(drum.render, inputs))
        for alone, beside in zip(one_by_one, together):
            self.assert_same_bits(alone, beside)

    def test_other_threads_run_meanwhile(self):
        # With the lock held, the counter would stand still from the start of the run to its end.
        instrument = tactus.load(GAIN)
        counter, end = [0], threading.Event()

        def count():
            while not end.is_set():
                counter[0] += 1
                time.sleep(0)
        helper = threading.Thread(target=count)
        helper.start()
        try:
            samples = numpy.zeros((4_000_000, 1))
            before = counter[0]
            instrument.render(samples)
            self.assertGreater(counter[0] - before, 10)
        finally:
            end.set()
            helper.join()

    def test_a_thousand_runs_do_not_grow(self):
        instrument = tactus.load(GAIN)
        samples = numpy.ones(480)

        def resident():
            for line in pathlib.Path("/proc/self/status").read_text().splitlines():
                if line.startswith("VmRSS:"):
                    return int(line.split()[1])
            self.skipTest("the system does not say how much memory is in use")
        for _ in range(200):
            instrument.render(samples, controls={"g": [(0, 0.5)]})
        before = resident()
        for _ in range(1000):
            instrument.render(samples, controls={"g": [(0, 0.5)]})
        self.assertLess(resident() - before, 1000)  # KiB: less than 1 KiB for each run

    def test_ctrl_c_ends_a_run(self):
        code = ("import sys; sys.path.insert(0, sys.argv[1]); import numpy, tactus\n"
                f"i = tactus.load({GAIN!r})\nz = numpy.zeros((10_000_000, 1))\n\n"
                "try:\n    print('ready', flush=True)\n    i.render(z, block=1)\n    print('done')\nexcept KeyboardInterrupt:\n    print('interrupted')\n")
        package = str(pathlib.Path(tactus.__file__).parents[1])
        child = subprocess.Popen([sys.executable, "-c", code, package], stdout=subprocess.PIPE, text=True)
        self.assertEqual(child.stdout.readline(), "ready\n")
        child.send_signal(signal.SIGINT)
        output, _ = child.communicate(timeout=60)
        self.assertEqual((output, child.returncode), ("interrupted\n", 0))


class Loading(TestCase):
    def test_what_an_instrument_says_of_itself(self):
        drum = tactus.load(INSTRUMENTS / "haptic_drum/every_strike.toml")
        self.assertEqual(drum.inputs, ["microphone"])
        self.assertEqual(drum.outputs, ["woofer", "sound"])
        self.assertEqual(drum.sounds, ["sound"])
        self.assertEqual(drum.sample_rate, 48000)
        self.assertEqual(drum.controls["sensitivity"].unit, "dB")
        self.assertEqual(drum.controls["strength"].range, (0, 1))
        self.assertIn("hit", [path for path, _ in drum.steps])
        self.assertIn("haptic drum", repr(drum))

    def test_folders_and_names(self):
        folder = tactus.load(INSTRUMENTS / "haptic_drum")
        self.assertEqual(folder.name, "haptic drum")
        self.assertEqual(tactus.load("haptic_drum").name, "haptic drum")
        self.assertTrue((tactus.instruments / "haptic_drum/instrument.toml").exists())

    def test_warnings_of_a_file(self):
        bare = GAIN.replace("g * x", "g * d").replace("[outputs]", '[nodes]\nd = { type = "delay", in = "x", time = 3 }\n[outputs]')
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            instrument = tactus.load(bare)
        self.assertEqual([warning.category for warning in caught], [tactus.FileWarning])
        self.assertEqual((instrument.warnings[0].file, instrument.warnings[0].line), ("<text>", 8))
