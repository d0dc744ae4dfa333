#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

/// The works of docs/performance.md as somebody would write them down in C++ for one rate, frame by frame.
/// `Number` is double or float.
namespace tactus::bench {

inline constexpr double kRate = 48000;

template <class Number>
struct HandWritten {
  virtual ~HandWritten() = default;
  virtual void process(const Number* const* in, Number* const* out, int frames) = 0;
};

/// R. Bristow-Johnson's low-pass, direct form I.
template <class Number>
struct HandLowPass {
  explicit HandLowPass(double cutoff_hz) {
    const double w = 2 * std::numbers::pi * cutoff_hz / kRate, alpha = std::sin(w) * std::sqrt(0.5);
    b0 = static_cast<Number>((1 - std::cos(w)) / 2 / (1 + alpha));
    a1 = static_cast<Number>(2 * std::cos(w) / (1 + alpha));
    a2 = static_cast<Number>((alpha - 1) / (1 + alpha));
  }
  Number step(Number x) {
    const Number y = b0 * (x + 2 * x1 + x2) + a1 * y1 + a2 * y2;
    x2 = x1, x1 = x, y2 = y1, y1 = y;
    return y;
  }
  Number b0, a1, a2, x1 = 0, x2 = 0, y1 = 0, y2 = 0;
};

/// s[n] = u[n] + 0.99 l[n], l = 0.7 d + 0.3 l1, d = `Taps` taps of s, the newest `newest` frames back.
template <class Number, std::size_t Taps>
struct HandLoop {
  static constexpr unsigned kSize = 4096;

  HandLoop(int newest_tap, std::array<double, Taps> weights) : newest(newest_tap) {
    for (std::size_t k = 0; k < Taps; ++k) weight[k] = static_cast<Number>(weights[k]);
  }
  Number step(Number u) {
    Number d = 0;
    for (unsigned k = 0; k < Taps; ++k)
      d += weight[k] * line[(now - static_cast<unsigned>(newest) - k) % kSize];
    last = Number(0.7) * d + Number(0.3) * last;
    const Number s = u + Number(0.99) * last;
    line[now++ % kSize] = s;
    return s;
  }
  int newest;
  std::array<Number, Taps> weight;
  Number last = 0;
  unsigned now = 0;
  std::vector<Number> line = std::vector<Number>(kSize);
};

inline std::array<double, 4> hand_lagrange3(double t) {
  return {(t - 1) * (t - 2) * (t - 3) / -6, t * (t - 2) * (t - 3) / 2, t * (t - 1) * (t - 3) / -2,
          t * (t - 1) * (t - 2) / 6};
}

template <class Number>
struct HandBowedString {
  HandBowedString(double cutoff_hz, double pitch_hz) : HandBowedString(cutoff_hz, kRate / pitch_hz, 0) {}
  Number step(Number x) { return std::clamp(loop.step(low_pass.step(x)), Number(-0.5), Number(0.5)); }
  HandLowPass<Number> low_pass;
  HandLoop<Number, 4> loop;

 private:
  HandBowedString(double cutoff_hz, double delay, int)
      : low_pass(cutoff_hz),
        loop(static_cast<int>(delay) - 1, hand_lagrange3(delay - std::floor(delay) + 1)) {}
};

template <class Number>
struct HandW1 : HandWritten<Number> {
  void process(const Number* const* in, Number* const* out, int frames) override {
    for (int n = 0; n < frames; ++n) out[0][n] = string.step(in[0][n]);
  }
  HandBowedString<Number> string{3000, 220};
};

/// Taps of the loop are worked out by whoever makes it: a tuned string is not written down in a line.
template <class Number>
struct HandW1String : HandWritten<Number> {
  HandW1String(int newest, std::array<double, 6> taps) : loop(newest, taps) {}
  void process(const Number* const* in, Number* const* out, int frames) override {
    for (int n = 0; n < frames; ++n)
      out[0][n] = std::clamp(loop.step(low_pass.step(in[0][n])), Number(-0.5), Number(0.5));
  }
  HandLowPass<Number> low_pass{3000};
  HandLoop<Number, 6> loop;
};

template <class Number>
struct HandW2 : HandWritten<Number> {
  void process(const Number* const* in, Number* const* out, int frames) override {
    for (int n = 0; n < frames; ++n) {
      const Number r = std::abs(in[0][n]);
      e += (r > e ? ka : kr) * (r - e);
      if (e < Number(0.05)) armed = true;
      if (hold > 0) --hold;
      p *= kp;
      if (armed && e > Number(0.15) && hold == 0) {
        armed = false;
        hold = 2400;
        p = 1;
      }
      out[0][n] = Number(0.8) * p;
    }
  }
  const Number ka = static_cast<Number>(1 - std::exp(-1 / (kRate * 0.0005)));
  const Number kr = static_cast<Number>(1 - std::exp(-1 / (kRate * 0.02)));
  const Number kp = static_cast<Number>(std::exp(-1 / (kRate * 0.010)));
  Number e = 0, p = 0;
  bool armed = true;
  int hold = 0;
};

/// A chain of masses between two fixed ends. The force at a third of it is the mean over the frame, as an
/// input that is held from frame to frame has it.
template <class Number>
struct HandW3 : HandWritten<Number> {
  explicit HandW3(int count) : masses(count), driven(count / 3), read(2 * count / 3) {
    for (auto* list : {&x, &moved, &force}) list->assign(static_cast<std::size_t>(masses) + 2, Number(0));
  }
  void process(const Number* const* in, Number* const* out, int frames) override {
    for (int n = 0; n < frames; ++n) {
      out[0][n] = x[index(read)];
      for (std::size_t i = 1; i <= static_cast<std::size_t>(masses); ++i)
        force[i] = Number(0.25) * (x[i - 1] - 2 * x[i] + x[i + 1]) +
                   Number(0.01) * (moved[i - 1] - 2 * moved[i] + moved[i + 1]) - Number(0.0005) * moved[i];
      force[index(driven)] += Number(0.5) * (before + in[0][n]);
      before = in[0][n];
      for (std::size_t i = 1; i <= static_cast<std::size_t>(masses); ++i) {
        moved[i] += force[i];
        x[i] += moved[i];
      }
    }
  }
  static std::size_t index(int mass) { return static_cast<std::size_t>(mass) + 1; }
  int masses, driven, read;
  std::vector<Number> x, moved, force;
  Number before = 0;
};

/// Two-pole resonators, each as loud as its bandwidth, in even steps of pitch.
template <class Number>
struct HandW4 : HandWritten<Number> {
  explicit HandW4(int count) {
    for (int k = 0; k < count; ++k) {
      const double w = 2 * std::numbers::pi * mode_hz(k, count) / kRate, r = mode_radius(k, count);
      modes.push_back({static_cast<Number>(mode_level(k, count)), static_cast<Number>(2 * r * std::cos(w)),
                       static_cast<Number>(-r * r)});
    }
  }
  void process(const Number* const* in, Number* const* out, int frames) override {
    for (int n = 0; n < frames; ++n) {
      Number sum = 0;
      for (auto& m : modes) {
        const Number y = m.b * before + m.a1 * m.y1 + m.a2 * m.y2;
        m.y2 = m.y1, m.y1 = y;
        sum += y;
      }
      before = in[0][n];
      out[0][n] = sum;
    }
  }
  static double mode_hz(int k, int count) { return 60 * std::pow(200.0, k / (count - 1.0)); }
  static double mode_radius(int k, int count) {
    return std::pow(0.001, 1 / (1.5 * std::sqrt(60 / mode_hz(k, count)) * kRate));
  }
  static double mode_level(int k, int count) {
    return (1 - mode_radius(k, count)) / std::sqrt(count) * (k % 2 == 0 ? 1 : -1);
  }
  struct Mode {
    Number b, a1, a2, y1 = 0, y2 = 0;
  };
  std::vector<Mode> modes;
  Number before = 0;
};

template <class Number>
struct HandW5 : HandWritten<Number> {
  HandW5() {
    for (int v = 0; v < 64; ++v) voices.emplace_back(1500 + 50 * v, 82.4 * std::exp2(3 * v / 64.0));
  }
  void process(const Number* const* in, Number* const* out, int frames) override {
    for (int n = 0; n < frames; ++n) {
      Number sum = 0;
      for (auto& voice : voices) sum += voice.step(in[0][n]);
      out[0][n] = sum / 8;
    }
  }
  std::vector<HandBowedString<Number>> voices;
};

template <class Number>
struct HandW6 : HandWritten<Number> {
  void process(const Number* const* in, Number* const* out, int frames) override {
    for (int n = 0; n < frames; ++n)
      for (int c = 0; c < 8; ++c) {
        const Number now = in[c][n];
        v[c] = gain * (now - x1[c]) * Number(kRate) + (1 - gain) * v[c];
        x1[c] = now;
        const Number force = now > 0 ? std::max(Number(0), 800 * now + 2 * v[c]) : Number(0);
        out[c][n] = -std::min(force, Number(10));
      }
  }
  static Number pole_gain() {
    const double c = 1 - std::cos(2 * std::numbers::pi * 200 / kRate);
    return static_cast<Number>(std::sqrt(c * (c + 2)) - c);
  }
  const Number gain = pole_gain();
  Number x1[8] = {}, v[8] = {};
};

}  // namespace tactus::bench
