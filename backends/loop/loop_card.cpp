#include "backends/loop/loop_card.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <string_view>

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

/// The usual one, changed.
template <class Change>
LoopCard with(Change change) {
  auto card = usual();
  change(card);
  return card;
}

LoopCard behind_buffers(double delay_frames) {
  return with([&](LoopCard& card) {
    card.delay = Seconds{0.0};
    card.delay_frames = delay_frames;
    card.delay_blocks = 2;
  });
}

struct Entry {
  NamedLoopCard named;
  LoopCard (*make)();
};

const std::vector<Entry>& entries() {
  static const std::vector<Entry> all = {
      {{"cable", "a cable, converters of 60.25 frames and two blocks of buffer"},
       [] { return behind_buffers(60.25); }},
      {{"20ms", "a cable, 20 ms; any other time is fine too"}, usual},
      {{"inverted", "a cable the wrong way around"}, [] { return with([](auto& c) { c.gain = -1.0; }); }},
      {{"ac_coupled", "coupling capacitors of 20 Hz"},
       [] { return with([](auto& c) { c.high_pass = 20_Hz; }); }},
      {{"no_cable", "nothing comes back"},
       [] { return with([](auto& c) { c.cable = LoopCard::Cable::None; }); }},
      {{"wrong_channel", "the cable ends in the next input"},
       [] { return with([](auto& c) { c.cable = LoopCard::Cable::Crossed; }); }},
      {{"howl", "the card plays what it hears, louder"},
       [] { return with([](auto& c) { c.monitor.gain = 1.1; }); }},
      {{"clipping", "an input that is far too sensitive"},
       [] { return with([](auto& c) { c.gain = amplitude_from_db(50.0); }); }},
      {{"drops", "the driver loses 32 frames every second"},
       [] { return with([](auto& c) {
              c.drops = {{Seconds{1.0}, Seconds{1.0}, 32}};
            }); }},
      {{"wrong_rate", "runs at 44.1 where it says 48"},
       [] { return with([](auto& c) { c.rate_factor = 44.1 / 48.0; }); }},
      {{"wrong_block", "its blocks are half as long as it says"},
       [] { return with([](auto& c) { c.block_factor = 0.5; }); }},
      {{"drift", "the input's clock is 50 ppm faster"},
       [] { return with([](auto& c) { c.input_ppm = 50.0; }); }},
      {{"echo_cancel", "an echo canceller for talking"},
       [] { return with([](auto& c) { c.echo_cancel = true; }); }},
      {{"agc", "an automatic gain for talking"}, [] { return with([](auto& c) { c.agc = true; }); }},
      {{"monitor", "direct monitoring"},
       [] {
         auto card = behind_buffers(200.0);
         card.monitor.gain = 0.25;
         return card;
       }},
      {{"software_monitor", "a connection from its input to its output in software"},
       [] {
         auto card = behind_buffers(200.0);
         card.monitor = {0.25, 0, true};
         return card;
       }},
      {{"noise", "more noise than signal"},
       [] {
         return with([](auto& c) {
           c.gain = amplitude_from_db(-50.0);
           c.noise = amplitude_from_db(-36.0);
         });
       }},
      {{"unstable", "another delay each time it is opened"},
       [] { return with([](auto& c) { c.unstable_frames = 200; }); }},
  };
  return all;
}

std::optional<double> number(std::string_view text, std::string_view unit = {}) {
  if (!text.ends_with(unit)) return std::nullopt;
  text.remove_suffix(unit.size());
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// Far outside of every range where no int can be so large.
int whole(double value) { return static_cast<int>(std::clamp(value, -1e6, 1e6)); }

using Setter = std::function<void(LoopCard&, double)>;

const std::map<std::string, Setter, std::less<>>& setters() {
  static const std::map<std::string, Setter, std::less<>> all = {
      {"delay",
       [](LoopCard& card, double frames) {
         card.delay = Seconds{0.0};
         card.delay_frames = frames;
       }},
      {"blocks", [](LoopCard& card, double blocks) { card.delay_blocks = whole(blocks); }},
      {"gain", [](LoopCard& card, double gain) { card.gain = gain; }},
      {"high_pass", [](LoopCard& card, double hertz) { card.high_pass = Hertz{hertz}; }},
      {"noise", [](LoopCard& card, double rms) { card.noise = rms; }},
      {"dc", [](LoopCard& card, double dc) { card.dc = dc; }},
      {"clip", [](LoopCard& card, double clip) { card.clip = clip; }},
      {"bits", [](LoopCard& card, double bits) { card.bits = whole(bits); }},
      {"monitor", [](LoopCard& card, double gain) { card.monitor.gain = gain; }},
      {"ppm", [](LoopCard& card, double ppm) { card.input_ppm = ppm; }},
      {"unstable", [](LoopCard& card, double frames) { card.unstable_frames = whole(frames); }},
  };
  return all;
}

bool in_range(const LoopCard& card) {
  const auto within = [](double x, double low, double high) { return x >= low && x <= high; };
  return within(card.delay.value, 0, 10) && within(card.delay_frames, 0, 1e6) &&
         within(card.delay_blocks, 0, 100) && within(card.bits, 0, 32) && within(card.clip, 0, 1) &&
         within(card.input_ppm, -1e4, 1e4) && within(card.unstable_frames, 0, 1e5) &&
         within(card.high_pass.value, 0, 1e4) && std::abs(card.gain) < 1e6 && std::abs(card.noise) < 1e6;
}

/// "20ms", "gain=-20dB"; false: it means nothing.
bool change(LoopCard& card, std::string_view text) {
  if (const auto ms = number(text, "ms")) {
    card.delay = Seconds{*ms / 1e3};
    return true;
  }
  const auto equals = text.find('=');
  if (equals == std::string_view::npos) return false;
  const auto setter = setters().find(text.substr(0, equals));
  if (setter == setters().end()) return false;
  const auto word = text.substr(equals + 1);
  if (const auto db = number(word, "dB"))
    setter->second(card, amplitude_from_db(*db));
  else if (const auto value = number(word))
    setter->second(card, *value);
  else
    return false;
  return true;
}

}  // namespace

Result<LoopCard> loop_card(const std::string& text) {
  auto card = usual();
  std::string_view rest = text;
  bool first = true, known = !rest.empty();
  while (known && !rest.empty()) {
    const auto piece = rest.substr(0, rest.find(','));
    rest.remove_prefix(std::min(rest.size(), piece.size() + 1));
    const auto entry = std::find_if(entries().begin(), entries().end(),
                                    [&](const Entry& each) { return piece == each.named.name; });
    if (first && entry != entries().end())
      card = entry->make();
    else
      known = change(card, piece);
    first = false;
  }
  if (known && in_range(card)) return card;
  return fail(Errc::UnknownName, "", "there is no simulated card '" + text + "'",
              "name one that 'tactus devices --backend loop' lists, or settings such as "
              "loop:delay=960.25,gain=-20dB,noise=-80dB,ppm=50");
}

const std::vector<NamedLoopCard>& loop_cards() {
  static const std::vector<NamedLoopCard> names = [] {
    std::vector<NamedLoopCard> all;
    for (const auto& entry : entries()) all.push_back(entry.named);
    return all;
  }();
  return names;
}

}  // namespace tactus
