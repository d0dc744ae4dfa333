#pragma once

#include <string>

namespace tactus::test {

/// Loops, lanes, a network, expressions, ramps and events; [outputs] are to follow.
inline const std::string kBusyGraph = R"(format = 1
name = "test"
[inputs]
x = {}
go = {}
[controls]
gain  = { value = 0.4, range = [-0.5, 0.5] }
pitch = { value = "300 Hz", range = ["100 Hz", "1 kHz"] }
[networks.drum]
frame = { type = "ground" }
cone  = { type = "mass", mass = "35 g" }
stick = { type = "mass", mass = "12 g", at = "1 mm" }
hold  = { type = "spring", between = ["frame", "cone"], stiffness = "1000 N/m", damping = "1.2 kg/s" }
lens  = { type = "contact", between = ["cone", "stick"], stiffness = "5e6 N/m^1.5", loss = "0.15 s/m" }
coil  = { type = "coil", on = "cone", voltage = "10 V * back", force_factor = "6 T m", resistance = "6 ohm" }
fall  = { type = "force", on = "stick", force = "-1 N" }
[nodes]
filtered  = { type = "band_pass", in = "drum.lens.force / 1 N", frequency = "3 kHz", q = 0.7 }
hit    = { type = "onset", in = "filtered", threshold = "-34 dB", hold = "15 ms" }
back   = { type = "decay", trigger = "hit + go", time = "12 ms" }
combs  = { type = "delay", voices = 8, in = "x + gain * loss", time = { from = "1 ms", to = "9 ms" } }
loss   = { type = "low_pass", in = "combs", cutoff = "pitch * 4", q = 0.7 }
tuned  = { type = "delay", in = "filtered + 0.9 * damped", time = "1 / pitch", compensate = ["damped"] }
damped = { type = "one_pole", in = "tuned", cutoff = "4 kHz" }
all    = { type = "mix", in = "loss" }
)";

}  // namespace tactus::test
