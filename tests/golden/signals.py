"""Deterministic numbers and WAV files. Nothing here may ever change: every reference depends on it."""

import array
import struct


class Bits:
    """SplitMix64 (Steele, Lea, Flood, OOPSLA 2014); Python's own generators may differ between versions."""

    def __init__(self, seed):
        self.state = seed * 0x9E3779B97F4A7C15 & (1 << 64) - 1

    def __call__(self):
        self.state = self.state + 0x9E3779B97F4A7C15 & (1 << 64) - 1
        z = self.state
        z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9 & (1 << 64) - 1
        z = (z ^ z >> 27) * 0x94D049BB133111EB & (1 << 64) - 1
        return z ^ z >> 31

    def pick(self, count):
        return self() % count

    def choose(self, items):
        return items[self.pick(len(items))]

    def between(self, low, high):
        return low + (high - low) * (self() >> 11) / (1 << 53)


def sensor(bits, frames, rate=48000):
    """Noise, silence, strikes that fade and slow ramps in turn: what sensors of many kinds may give."""
    samples, kind, level, value = [], 0, 0.0, 0.0
    for n in range(frames):
        if n % (rate // 20) == 0:
            kind, level, value = bits.pick(4), bits.between(0.05, 0.9), bits.between(-0.5, 0.5)
        if kind == 0:
            samples.append(level * bits.between(-1, 1))
        elif kind == 1:
            samples.append(0.0)
        elif kind == 2:
            level *= 0.998
            samples.append(level * bits.between(-1, 1))
        else:
            value += (0.3 - value) / 2000
            samples.append(value)
    return samples


def interleaved(channels):
    return [sample for frame in zip(*channels) for sample in frame]


def write_wav(path, channels, rate, bits=32):
    """float32 with 32 bits, PCM with 16 or 24."""
    samples = interleaved(channels)
    if bits == 32:
        data = array.array("f", samples).tobytes()
    else:
        top = (1 << bits - 1) - 1
        whole = (max(-top - 1, min(top, round(sample * (top + 1)))) for sample in samples)
        data = b"".join(value.to_bytes(bits // 8, "little", signed=True) for value in whole)
    frame = len(channels) * bits // 8
    form = struct.pack("<HHIIHH", 3 if bits == 32 else 1, len(channels), rate, rate * frame, frame, bits)
    path.write_bytes(b"RIFF" + struct.pack("<I", 36 + len(data)) + b"WAVEfmt " + struct.pack("<I", 16) + form +
                     b"data" + struct.pack("<I", len(data)) + data)


def wav_chunks(path):
    """The chunks of a RIFF or RF64 file by name; other chunks may hold times."""
    content, chunks, at = path.read_bytes(), {}, 12
    while at + 8 <= len(content):
        name, size = content[at:at + 4], struct.unpack_from("<I", content, at + 4)[0]
        chunks[name.decode("latin-1")] = content[at + 8:at + 8 + size]
        at += 8 + size + size % 2
    return chunks


def read_wav(path):
    """(channels, rate) of a float32 or PCM file."""
    chunks = wav_chunks(path)
    _, count, rate, _, _, bits = struct.unpack_from("<HHIIHH", chunks["fmt "])
    data = chunks["data"]
    if bits == 32:
        samples = array.array("f", data[:len(data) // 4 * 4]).tolist()
    else:
        step, scale = bits // 8, 1 << bits - 1
        samples = [int.from_bytes(data[i:i + step], "little", signed=True) / scale
                   for i in range(0, len(data) - step + 1, step)]
    return [samples[c::count] for c in range(count)], rate
