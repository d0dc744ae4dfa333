"""Recordings of the latency probe, each with something that may happen to one. Pure arithmetic, so that they
are the same bytes everywhere."""

from signals import Bits


def at(samples, place):
    """Between samples, by a straight line."""
    n = int(place // 1)
    if n < 0 or n + 1 >= len(samples):
        return 0.0
    return samples[n] + (place - n) * (samples[n + 1] - samples[n])


def delayed(probe, delay, ppm=0.0, frames=None):
    speed = 1 + ppm * 1e-6
    return [at(probe, n * speed - delay) for n in range(frames or len(probe))]


def noisy(samples, rms, seed):
    """Uniform noise."""
    bits, most = Bits(seed), rms * 3 ** 0.5
    return [sample + bits.between(-most, most) for sample in samples]


def gain(samples, factor, low=-1.0, high=1.0, dc=0.0):
    return [max(low, min(high, factor * sample + dc)) for sample in samples]


def low_passed(samples, share):
    out, state = [], 0.0
    for sample in samples:
        state += share * (sample - state)
        out.append(state)
    return out


def high_passed(samples, share):
    return [sample - low for sample, low in zip(samples, low_passed(samples, share))]


def added(one, other, factor=1.0):
    return [a + factor * b for a, b in zip(one, other)]


def without(samples, begin, end):
    return samples[:begin] + samples[end:]


def captures(probe):
    """{name: function that makes the channels}."""
    loop = lambda delay, **more: delayed(probe, delay, **more)
    half = len(probe) // 2
    return {
        "plain": lambda: [noisy(loop(960), 3e-5, 1)],
        "fraction": lambda: [noisy(loop(188.25), 3e-5, 2)],
        "long": lambda: [noisy(loop(4801.5), 3e-5, 3)],
        "short": lambda: [noisy(loop(3), 3e-5, 4)],
        "exact": lambda: [loop(512)],
        "inverted": lambda: [noisy(gain(loop(700), -0.5), 3e-5, 5)],
        "quiet": lambda: [noisy(gain(loop(700), 0.003), 3e-5, 6)],
        "noise": lambda: [noisy(gain(loop(700), 0.01), 0.016, 7)],
        "clipped": lambda: [noisy(gain(loop(700), 20.0), 3e-5, 8)],
        "clipped_low": lambda: [gain(noisy(loop(700.5), 3e-5, 9), 6.0, -0.4, 0.4)],
        "dc": lambda: [gain(noisy(loop(333), 3e-5, 10), 0.5, dc=0.3)],
        "no_cable": lambda: [noisy([0.0] * len(probe), 3e-5, 11)],
        "silence": lambda: [[0.0] * len(probe)],
        "drift_50ppm": lambda: [noisy(loop(960, ppm=50), 3e-5, 12)],
        "drift_800ppm": lambda: [noisy(loop(960, ppm=-800), 3e-5, 13)],
        "echo": lambda: [noisy(added(loop(500), loop(2300), 0.4), 3e-5, 14)],
        "lost_frames": lambda: [noisy(without(loop(960), half, half + 64), 3e-5, 15)],
        "low_passed": lambda: [noisy(low_passed(loop(200), 0.2), 3e-5, 16)],
        "high_passed": lambda: [noisy(high_passed(loop(200), 0.02), 3e-5, 17)],
        "cut_off": lambda: [noisy(loop(960), 3e-5, 18)[:half]],
        "second_channel": lambda: [noisy([0.0] * len(probe), 1e-4, 19), noisy(loop(960), 3e-5, 20)],
    }
