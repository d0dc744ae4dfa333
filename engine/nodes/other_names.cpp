#include "engine/nodes/other_names.h"

#include <algorithm>
#include <cctype>
#include <iterator>

namespace tactus {
namespace {

// Sorted by what is meant. A remedy is a line of a graph file.
constexpr OtherName kOtherNames[] = {
    {"lfo", "sine triangle square random_walk", "{ type = \"sine\", frequency = \"2 Hz\" }"},
    {"osc", "sine", {}},
    {"oscillator", "sine saw square triangle wavetable", {}},
    {"cycle", "sine", {}},
    {"sinosc", "sine", {}},
    {"sin", "sine", {}},
    {"cosine", "sine", "{ type = \"sine\", frequency = \"2 Hz\", phase = \"90 deg\" }"},
    {"sawtooth", "saw", {}},
    {"lfsaw", "saw phasor", {}},
    {"ramp", "phasor slew curve", {}},
    {"line", "slew curve", {}},
    {"pulse_wave", "square", {}},
    {"pulse", "square decay", {}},
    {"rect", "square", {}},
    {"pwm", "square", "{ type = \"square\", frequency = \"60 Hz\", width = 0.25 }"},
    {"tri", "triangle", {}},
    {"table", "wavetable map", {}},
    {"tabread", "wavetable map", {}},
    {"lookup", "map", {}},
    {"scale", "map", {}},
    {"groove", "sample", {}},
    {"sfplay", "sample", {}},
    {"playbuf", "sample", {}},
    {"random", "noise random_walk", {}},
    {"rand", "noise random_walk", {}},
    {"white_noise", "noise", {}},
    {"whitenoise", "noise", {}},
    {"brown_noise", "random_walk", {}},
    {"drunk", "random_walk", {}},
    {"brownian", "random_walk", {}},
    {"pink_noise", "noise one_pole", "noise behind a one_pole filter"},
    {"metro", "clock", "{ type = \"clock\", tempo = \"120 bpm\" }"},
    {"metronome", "clock", "{ type = \"clock\", tempo = \"120 bpm\" }"},
    {"tempo", "clock", {}},
    {"impulse", "clock", {}},
    {"timer", "clock", {}},
    {"seq", "sequence", {}},
    {"sequencer", "sequence", {}},
    {"step", "sequence", {}},
    {"steps", "sequence", {}},
    {"pattern", "sequence", {}},
    {"lpf", "low_pass", {}},
    {"lowpass", "low_pass", {}},
    {"lop", "one_pole", {}},
    {"smooth", "one_pole slew", {}},
    {"lag", "one_pole", {}},
    {"onepole", "one_pole", {}},
    {"hpf", "high_pass", {}},
    {"highpass", "high_pass", {}},
    {"hip", "high_pass", {}},
    {"bpf", "band_pass", {}},
    {"bandpass", "band_pass", {}},
    {"resonator", "band_pass modal", {}},
    {"reson", "band_pass", {}},
    {"biquad", "low_pass high_pass band_pass", {}},
    {"svf", "low_pass high_pass band_pass", {}},
    {"filter", "one_pole low_pass high_pass band_pass", {}},
    {"moog", "low_pass", {}},
    {"vcf", "low_pass", {}},
    {"convolution", "fir", {}},
    {"convolve", "fir", {}},
    {"leakdc", "dc_blocker", {}},
    {"dcblock", "dc_blocker", {}},
    {"env", "envelope adsr decay", {}},
    {"eg", "adsr", {}},
    {"envgen", "adsr decay curve", {}},
    {"slide", "slew one_pole", {}},
    {"ad", "decay adsr", {}},
    {"ar", "adsr", {}},
    {"asr", "adsr", {}},
    {"perc", "decay", {}},
    {"follower", "envelope", {}},
    {"amplitude", "envelope", {}},
    {"rms", "envelope", {}},
    {"bonk", "onset stroke", {}},
    {"fiddle", "pitch", {}},
    {"sigmund", "pitch", {}},
    {"tartini", "pitch", {}},
    {"pitch_detector", "pitch", {}},
    {"attack", "onset stroke", {}},
    {"transient", "onset stroke", {}},
    {"karplus", "string", "{ type = \"string\", in = \"pluck\", pitch = \"110 Hz\" }"},
    {"karplus_strong", "string", "{ type = \"string\", in = \"pluck\", pitch = \"110 Hz\" }"},
    {"pluck", "string", "a string; the network element pluck goes under [networks.NAME]"},
    {"comb", "string delay", {}},
    {"echo", "delay", {}},
    {"delayn", "delay", {}},
    {"vd", "delay", {}},
    {"delread", "delay", {}},
    {"tapin", "delay", {}},
    {"schmitt", "threshold", {}},
    {"comparator", "threshold",
     "a comparison in an expression (\"x > 0.5\"), or threshold, which has hysteresis"},
    {"gate", "threshold latch", {}},
    {"edge", "threshold", {}},
    {"samphold", "sample_hold", {}},
    {"sah", "sample_hold", {}},
    {"snapshot", "sample_hold", {}},
    {"sample_and_hold", "sample_hold", {}},
    {"flipflop", "latch toggle", {}},
    {"flip_flop", "latch toggle", {}},
    {"switch", "toggle", "select(condition, a, b) in an expression, or toggle"},
    {"count", "counter", {}},
    {"tanh", "shaper", {}},
    {"distortion", "shaper", {}},
    {"overdrive", "shaper", {}},
    {"saturate", "shaper", {}},
    {"saturation", "shaper", {}},
    {"waveshaper", "shaper map", {}},
    {"fold", "shaper", "{ type = \"shaper\", in = \"x\", shape = \"fold\" }"},
    {"clamp", "clip", {}},
    {"limit", "clip slew", {}},
    {"limiter", "clip", {}},
    {"quantize", "quantiser", {}},
    {"quantizer", "quantiser", {}},
    {"bitcrush", "quantiser", {}},
    {"xfade", "crossfade", {}},
    {"sum", "mix", "a + b in an expression; mix adds the lanes of a signal"},
    {"mixer", "mix", "a + b in an expression; mix adds the lanes of a signal"},
    {"add", "", "write a + b, as in total = \"a + b\""},
    {"gain", "", "write a product, as in loud = \"0.5 * x\""},
    {"mul", "", "write a product, as in loud = \"0.5 * x\""},
    {"abs", "", "write a function, as in level = \"abs(x)\""},
    {"select", "", "write a function, as in y = \"select(x > 0, a, b)\""},
    {"if", "", "write a function, as in y = \"select(x > 0, a, b)\""},
    {"bang", "",
     "a trigger is a value of at least 0.5 for one frame, as in \"x > 0.5\" behind threshold, or clock"},
    {"reverb", "modal delay",
     "modal for a body that rings, or a delay that feeds itself: { type = \"delay\", in = \"in + 0.6 * "
     "echo\", time = \"80 ms\" }"},
    {"multiply", "", "write a product, as in loud = \"0.5 * x\""},
    {"expr", "", "write the expression itself, as in y = \"2 * x + 1\""},
    {"constant", "", "write the number where it is used, or a control"},
    {"slider", "", "declare it under [controls], as in strength = { value = 0.5, range = [0, 1] }"},
    {"knob", "", "declare it under [controls], as in strength = { value = 0.5, range = [0, 1] }"},
    {"adc", "", "declare it under [inputs]"},
    {"dac", "", "declare it under [outputs]"},
    {"in", "", "declare it under [inputs]"},
    {"out", "", "declare it under [outputs]"},
    {"midi", "poly", "controls with midi = \"note\", and a poly node for chords"},
    {"keyboard", "poly", "controls with midi = \"note\", and a poly node for chords"},
    {"notein", "poly", "controls with midi = \"note\", and a poly node for chords"},
    {"bow", "string", "a string, and a friction element under [networks.NAME]"},
    {"bar", "modal modal_body", {}},
    {"ribbon", "", "declare it under [inputs]"},
    {"piezo", "", "declare it under [inputs]"},
    {"microphone", "", "declare it under [inputs]"},
    {"vca", "", "write a product, as in loud = \"level * x\""},
    {"allpass", "delay", {}},
    {"dust", "noise threshold", "noise behind a threshold"},
    {"swing", "clock", "{ type = \"clock\", tempo = \"120 bpm\", swing = 0.6 }"},
    {"midiin", "", "declare a control, and let a MIDI controller turn it (tactus play --learn)"},
    {"mtof", "", "write 440 Hz * pow(2, (note - 69) / 12)"},
    {"clone", "poly", {}},
    {"voices", "poly", {}},
    {"detent", "terrain", {}},
    {"notch", "terrain band_pass", "terrain for a detent; x - band_pass for a filter"},
    {"texture", "terrain", {}},
    {"differentiate", "velocity difference", {}},
    {"derivative", "velocity difference", {}},
    {"integrator", "one_pole", "a one_pole filter of low cutoff, or a mass in a network"},
    {"mass", "", "write it under [networks.NAME]: mass, spring, damper, contact, friction are elements"},
    {"contact", "", "write it under [networks.NAME]: mass, spring, damper, contact, friction are elements"},
    {"friction", "", "write it under [networks.NAME]: mass, spring, damper, contact, friction are elements"},
};

/// "lfo" of "LFO~", "lfo.ar".
std::string plain_name(std::string_view name) {
  std::string plain{name.substr(0, name.find_first_of("~."))};
  std::ranges::transform(plain, plain.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return plain;
}

/// "sine, triangle or square"
std::string choice_of(std::string_view types) {
  std::string text;
  while (true) {
    const auto space = types.find(' ');
    const auto rest = space == std::string_view::npos ? std::string_view{} : types.substr(space + 1);
    text += types.substr(0, space);
    if (rest.empty()) return text;
    text += rest.find(' ') == std::string_view::npos ? " or " : ", ";
    types = rest;
  }
}

}  // namespace

std::span<const OtherName> other_names() { return kOtherNames; }

std::string other_name(std::string_view name) {
  const auto* const found = std::ranges::find(kOtherNames, plain_name(name), &OtherName::name);
  if (found == std::end(kOtherNames)) return {};
  if (found->types.empty()) return std::string{found->remedy};
  std::string text = "use " + choice_of(found->types);
  if (!found->remedy.empty()) text += ": " + std::string{found->remedy};
  return text;
}

}  // namespace tactus
