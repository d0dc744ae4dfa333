#include "backends/loop/loop_card.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <optional>
#include <string_view>
#include <type_traits>
#include <variant>

#include "engine/core/decibels.h"

namespace tactus {
namespace {

constexpr Seconds kUsualDelay{0.02};
constexpr double kUsualNoise = 3e-5;  // -90 dB: a quiet line input

LoopCard usual() {
  LoopCard card;
  card.delay = kUsualDelay;
  card.noise = kUsualNoise;
  card.bits = 24;
  return card;
}

std::optional<double> number(std::string_view text, std::string_view unit = {}) {
  if (!text.ends_with(unit)) return std::nullopt;
  text.remove_suffix(unit.size());
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// A key of a description: its range, and what it sets.
struct Setting {
  const char* name;
  double low, high;
  std::variant<double LoopCard::*, int LoopCard::*, bool LoopCard::*, void (*)(LoopCard&, double)> sets;
};

const Setting kSettings[] = {
    {"delay", 0, 1e6,
     [](LoopCard& card, double frames) {
       card.delay = Seconds{0.0};
       card.delay_frames = frames;
     }},
    {"blocks", 0, 100, &LoopCard::delay_blocks},
    {"cable", 0, 2,
     [](LoopCard& card, double kind) { card.cable = static_cast<LoopCard::Cable>(static_cast<int>(kind)); }},
    {"gain", -1e6, 1e6, &LoopCard::gain},
    {"high_pass", 0, 1e4, [](LoopCard& card, double hertz) { card.high_pass = Hertz{hertz}; }},
    {"noise", -1e6, 1e6, &LoopCard::noise},
    {"dc", -1e6, 1e6, &LoopCard::dc},
    {"clip", 0, 1, &LoopCard::clip},
    {"bits", 0, 32, &LoopCard::bits},
    {"agc", 0, 1, &LoopCard::agc},
    {"echo_cancel", 0, 1, &LoopCard::echo_cancel},
    {"monitor", -1e6, 1e6, [](LoopCard& card, double gain) { card.monitor.gain = gain; }},
    {"in_software", 0, 1, [](LoopCard& card, double on) { card.monitor.in_software = on != 0; }},
    {"drops", -1e4, 1e4,
     [](LoopCard& card, double frames) {
       card.drops = {{Seconds{1.0}, Seconds{1.0}, static_cast<int>(frames)}};
     }},
    {"ppm", -1e4, 1e4, &LoopCard::input_ppm},
    {"unstable", 0, 1e5, &LoopCard::unstable_frames},
    {"rate_factor", 0.1, 10, &LoopCard::rate_factor},
    {"block_factor", 0.01, 1, &LoopCard::block_factor},
};

/// Sets `key` to "-20dB" or "0.1"; false: there is no such key, or no such value.
bool change(LoopCard& card, std::string_view key, std::string_view text) {
  const auto setting = std::find_if(std::begin(kSettings), std::end(kSettings),
                                    [&](const Setting& each) { return key == each.name; });
  auto value = number(text);
  if (const auto db = number(text, "dB")) value = amplitude_from_db(*db);
  if (setting == std::end(kSettings) || !value || !(*value >= setting->low && *value <= setting->high))
    return false;
  const auto assign = [&](auto sets) {
    if constexpr (std::is_member_pointer_v<decltype(sets)>)
      card.*sets = static_cast<std::remove_reference_t<decltype(card.*sets)>>(*value);
    else
      sets(card, *value);
  };
  std::visit(assign, setting->sets);
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
  auto card = usual();
  std::string_view rest = text;
  bool known = !text.empty();
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
  };
  return all;
}

}  // namespace tactus
