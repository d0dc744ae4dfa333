#include "backends/loop/loop_card.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <string_view>

#include "engine/core/decibels.h"
#include "engine/core/parse_double.h"

namespace tactus {
namespace {

constexpr auto kUsual = "20ms,noise=3e-5,bits=24";  // -90 dB: a quiet line input

std::optional<double> number(std::string_view text, std::string_view unit = {}) {
  if (!text.ends_with(unit)) return std::nullopt;
  text.remove_suffix(unit.size());
  double value = 0.0;
  const auto [end, error] = parse_double(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// A key of a description: its range, and what it sets.
struct Setting {
  const char* name;
  double low, high;
  void (*set)(LoopCard&, double);
};

const Setting kSettings[] = {
    {"delay", 0, 1e6,
     [](LoopCard& card, double frames) {
       card.delay = Seconds{0.0};
       card.delay_frames = frames;
     }},
    {"blocks", 0, 100, [](LoopCard& card, double value) { card.delay_blocks = static_cast<int>(value); }},
    {"cable", 0, 2,
     [](LoopCard& card, double value) { card.cable = LoopCard::Cable{static_cast<int>(value)}; }},
    {"gain", -1e6, 1e6, [](LoopCard& card, double value) { card.gain = value; }},
    {"high_pass", 0, 1e4, [](LoopCard& card, double value) { card.high_pass = Hertz{value}; }},
    {"noise", -1e6, 1e6, [](LoopCard& card, double value) { card.noise = value; }},
    {"dc", -1e6, 1e6, [](LoopCard& card, double value) { card.dc = value; }},
    {"clip", 0, 1, [](LoopCard& card, double value) { card.clip = value; }},
    {"bits", 0, 32, [](LoopCard& card, double value) { card.bits = static_cast<int>(value); }},
    {"agc", 0, 1, [](LoopCard& card, double value) { card.agc = value != 0; }},
    {"echo_cancel", 0, 1, [](LoopCard& card, double value) { card.echo_cancel = value != 0; }},
    {"monitor", -1e6, 1e6, [](LoopCard& card, double value) { card.monitor_gain = value; }},
    {"in_software", 0, 1, [](LoopCard& card, double value) { card.monitor_in_software = value != 0; }},
    {"drops", -1e4, 1e4,
     [](LoopCard& card, double frames) {
       card.drops = {{Seconds{1.0}, Seconds{1.0}, static_cast<int>(frames)}};
     }},
    {"ppm", -1e4, 1e4, [](LoopCard& card, double value) { card.input_ppm = value; }},
    {"unstable", 0, 1e5,
     [](LoopCard& card, double value) { card.unstable_frames = static_cast<int>(value); }},
    {"rate_factor", 0.1, 10, [](LoopCard& card, double value) { card.rate_factor = value; }},
    {"block_factor", 0.01, 1, [](LoopCard& card, double value) { card.block_factor = value; }},
    {"real_time", 0, 1, [](LoopCard& card, double value) { card.real_time = value != 0; }},
    {"per_sample", 0, 1, [](LoopCard& card, double value) { card.per_sample = value != 0; }},
    {"busy", 0, 1,
     [](LoopCard& card, double value) {
       card.pace.wait = value != 0 ? SystemTimer::Wait::Busy : SystemTimer::Wait::Timer;
     }},
    {"core", 0, 1023, [](LoopCard& card, double value) { card.pace.core = static_cast<int>(value); }},
};

/// Sets `key` to "-20dB" or "0.1"; false: there is no such key, or no such value.
bool change(LoopCard& card, std::string_view key, std::string_view text) {
  const auto setting = std::find_if(std::begin(kSettings), std::end(kSettings),
                                    [&](const Setting& each) { return key == each.name; });
  auto value = number(text);
  if (const auto db = number(text, "dB")) value = amplitude_from_db(*db);
  if (setting == std::end(kSettings) || !value || !(*value >= setting->low && *value <= setting->high))
    return false;
  setting->set(card, *value);
  return true;
}

/// Applies "20ms,gain=-20dB"; false: a part of it means nothing.
bool change(LoopCard& card, std::string_view text) {
  while (!text.empty()) {
    const auto part = text.substr(0, text.find(','));
    text.remove_prefix(std::min(text.size(), part.size() + 1));
    const auto equals = part.find('=');
    if (const auto ms = number(part, "ms"); ms && *ms >= 0 && *ms <= 1e4)
      card.delay = Seconds{*ms / 1e3};
    else if (equals == std::string_view::npos ||
             !change(card, part.substr(0, equals), part.substr(equals + 1)))
      return false;
  }
  return true;
}

}  // namespace

Result<LoopCard> loop_card(const std::string& text) {
  const auto comma = std::min(text.find(','), text.size());
  const auto named = std::find_if(loop_cards().begin(), loop_cards().end(), [&](const NamedLoopCard& each) {
    return text.substr(0, comma) == each.name;
  });
  LoopCard card;
  std::string_view rest = text;
  bool known = change(card, kUsual) && !text.empty();
  if (named != loop_cards().end()) {
    known = change(card, named->settings);
    rest.remove_prefix(std::min(comma + 1, text.size()));
  }
  known = known && change(card, rest);
  if (known) return card;
  return fail(Errc::UnknownName, "", "there is no simulated card '" + text + "'",
              "choose one that 'tactus devices --backend loop' lists, or give settings such as "
              "loop:delay=960.25,gain=-20dB,noise=-80dB,ppm=50");
}

const std::vector<NamedLoopCard>& loop_cards() {
  static const std::vector<NamedLoopCard> all = {
      {"cable", "a cable, converters of 60.25 frames and two blocks of buffer", "delay=60.25,blocks=2"},
      {"20ms", "a cable, 20 ms; any other time can be given", ""},
      {"inverted", "a cable with inverted polarity", "gain=-1"},
      {"ac_coupled", "coupling capacitors of 20 Hz", "high_pass=20"},
      {"no_cable", "no signal returns", "cable=2"},
      {"wrong_channel", "the cable is connected to the next input", "cable=1"},
      {"howl", "the card plays back what it captures, with gain", "monitor=1.1"},
      {"clipping", "an input with far too much gain", "gain=50dB"},
      {"drops", "the driver loses 32 frames every second", "drops=32"},
      {"wrong_rate", "runs at 44.1 kHz but reports 48 kHz", "rate_factor=0.9187500000000001"},
      {"wrong_block", "its blocks are half the reported size", "block_factor=0.5"},
      {"drift", "the input's clock is 50 ppm faster", "ppm=50"},
      {"echo_cancel", "the echo canceller of a call program", "echo_cancel=1"},
      {"agc", "the automatic gain control of a call program", "agc=1"},
      {"monitor", "direct monitoring", "delay=200,blocks=2,monitor=0.25"},
      {"software_monitor", "a connection from its input to its output in software",
       "delay=200,blocks=2,monitor=0.25,in_software=1"},
      {"noise", "more noise than signal", "gain=-50dB,noise=-36dB"},
      {"unstable", "a different delay each time it is opened", "unstable=200"},
      {"per_sample", "blocks of one frame at 1 to 20 kHz, as of a data acquisition card of 16 bits",
       "per_sample=1,delay=1,noise=0,bits=16"},
  };
  return all;
}

}  // namespace tactus
