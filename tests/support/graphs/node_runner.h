#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <random>
#include <span>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "engine/core/dimension.h"
#include "engine/nodes/table.h"
#include "tests/support/error_summary.h"

namespace tactus::test {

using Samples = std::vector<double>;
using Outputs = std::vector<Samples>;  ///< [output][frame]
using InputValue = std::variant<double, Samples>;

inline constexpr int kLongestSubBlock = 64;

inline const NodeType& node_type(std::string_view name) { return *standard_nodes().find(name); }

/// Uniform noise in [low, high], the same for the same seed on every machine.
inline Samples noise(int frames, unsigned seed, double low = -1, double high = 1) {
  std::mt19937 bits(seed);
  Samples samples(static_cast<std::size_t>(frames));
  for (auto& sample : samples) sample = low + (high - low) * static_cast<double>(bits()) / 4294967296.0;
  return samples;
}

inline Samples impulse(int frames, double height = 1) {
  Samples samples(static_cast<std::size_t>(frames));
  samples.at(0) = height;
  return samples;
}

/// `frames` in blocks of `length`, the last one shorter.
inline std::vector<int> even_cutting(int frames, int length) {
  std::vector<int> lengths;
  for (; frames > 0; frames -= length) lengths.push_back(std::min(frames, length));
  return lengths;
}

/// `frames` in blocks of random length up to `longest`.
inline std::vector<int> random_cutting(int frames, unsigned seed, int longest = kLongestSubBlock) {
  std::mt19937 bits(seed);
  std::vector<int> lengths;
  while (frames > 0) {
    const int length = std::min(frames, 1 + static_cast<int>(bits() % static_cast<unsigned>(longest)));
    lengths.push_back(length);
    frames -= length;
  }
  return lengths;
}

/// "" if equal bit for bit (so that -0 is not 0), else where they first differ.
inline std::string first_difference(const Outputs& a, const Outputs& b) {
  if (a.size() != b.size()) return "number of outputs";
  for (std::size_t o = 0; o < a.size(); ++o) {
    if (a[o].size() != b[o].size()) return "number of frames of output " + std::to_string(o);
    for (std::size_t n = 0; n < a[o].size(); ++n)
      if (std::bit_cast<std::uint64_t>(a[o][n]) != std::bit_cast<std::uint64_t>(b[o][n]))
        return "output " + std::to_string(o) + " frame " + std::to_string(n) + ": " +
               std::to_string(a[o][n]) + " and " + std::to_string(b[o][n]);
  }
  return {};
}

/// A setting from text as a file has it: `lagrange3`, `8`, `true`, `[1, "2 ms"]`, `[[0, 1], [2, 3]]`, `[a,
/// b]`.
inline SettingValue setting_value(const Setting& setting, const std::string& text) {
  SettingValue value;
  std::string words;
  for (const char c : text) words += c == '[' || c == ']' || c == '"' ? ' ' : c;
  std::vector<std::string> items;
  for (std::size_t at = 0; at <= words.size();) {
    const auto end = std::min(words.find(',', at), words.size());
    const auto first = words.find_first_not_of(' ', at);
    if (first < end) {
      const auto item = words.substr(first, end - first);
      items.push_back(item.substr(0, item.find_last_not_of(' ') + 1));
    }
    at = end + 1;
  }
  const auto si = [](const std::string& item) {
    const auto quantity = parse_quantity(item);
    if (!quantity) throw std::invalid_argument("not a quantity: " + item);
    return quantity->si;
  };
  switch (setting.kind) {
    case Setting::Kind::Integer:
      value.number = std::stod(text);
      break;
    case Setting::Kind::Quantity:
      value.number = si(text);
      break;
    case Setting::Kind::Flag:
      value.number = text == "true" ? 1 : 0;
      break;
    case Setting::Kind::Numbers:
      for (const auto& item : items) value.numbers.push_back(si(item));
      break;
    case Setting::Kind::Points:
      for (std::size_t i = 0; i + 1 < items.size(); i += 2)
        value.points.emplace_back(si(items[i]), si(items[i + 1]));
      break;
    case Setting::Kind::Names:
      value.names = items;
      break;
    default:
      value.text = text;
      break;
  }
  return value;
}

/// One node outside any graph: made from its declaration, run on given inputs in blocks of given lengths.
/// Inputs that are not named take their fallback. Misuse throws, so that a test stops there.
class NodeRunner {
 public:
  /// `ranges` replaces what the compiler would know of an input (for vectors: the smallest and largest
  /// sample).
  NodeRunner(const NodeType& type, std::map<std::string, InputValue> inputs,
             std::map<std::string, std::string> settings = {}, Hertz rate = Hertz{48000},
             std::map<std::string, Interval> ranges = {})
      : type_(type) {
    for (const auto& [name, value] : inputs)
      if (type.input_index(name) < 0) throw std::invalid_argument("no input " + name);
    NodeSetup setup{.sample_rate = rate, .type = &type, .inputs = {}, .settings = {}};
    for (const auto& port : type.inputs) {
      const auto found = inputs.find(port.name);
      if (found == inputs.end() && !port.fallback) throw std::invalid_argument("input needed: " + port.name);
      values_.push_back(found == inputs.end() ? InputValue{*port.fallback} : found->second);
      auto info = info_of(values_.back(), found != inputs.end());
      if (const auto range = ranges.find(port.name); range != ranges.end()) info.range = range->second;
      setup.inputs.push_back(info);
    }
    for (const auto& setting : type.settings) {
      const auto found = settings.find(setting.name);
      const bool given = found != settings.end();
      auto value = given || !setting.fallback.empty()
                       ? setting_value(setting, given ? found->second : setting.fallback)
                       : SettingValue{};
      value.given = given;
      setup.settings.push_back(value);
      settings.erase(setting.name);
    }
    if (!settings.empty()) throw std::invalid_argument("no setting " + settings.begin()->first);
    node_ = type.make(setup);
  }

  bool made() const { return node_.has_value(); }
  /// Code and names of what `make` reported; "" if it worked.
  std::string error() const { return summary(node_); }
  Node& node() {
    if (!made()) throw std::runtime_error(to_string(node_.error()));
    return **node_;
  }

  /// Blocks longer than 64 frames reach the node as sub-blocks, as in the engine. Every run starts from
  /// `reset`, except the first, which starts from `make`: so a second run also tests `reset`.
  Outputs run(std::span<const int> block_lengths, std::int64_t first_frame = 0) {
    return run_sub_blocks(block_lengths, first_frame,
                          [this](const NodeBlock& block) { node().process(block); });
  }

  /// The same through `emit` and `absorb`, as on a loop. The late inputs are NaN during `emit`.
  Outputs run_halves(std::span<const int> block_lengths, std::int64_t first_frame = 0) {
    return run_sub_blocks(block_lengths, first_frame, [this](const NodeBlock& block) {
      static const Samples unknown(kLongestSubBlock, std::numeric_limits<double>::quiet_NaN());
      std::vector<Signal> early(block.in, block.in + type_.inputs.size());
      for (std::size_t i = 0; i < early.size(); ++i)
        if (type_.inputs[i].late) early[i] = {unknown.data(), 1};
      auto half = block;
      half.in = early.data();
      node().emit(half);
      node().absorb(block);
    });
  }

  /// The same, from block `change` on by `other`, which continues as a copy.
  Outputs run_copied(std::span<const int> block_lengths, int change, Node& other) {
    int block_number = 0;
    return run_sub_blocks(block_lengths, 0, [&](const NodeBlock& block) {
      if (block_number == change) other.copy(node());
      (block_number++ < change ? node() : other).process(block);
    });
  }

  /// "" if random cuttings of `frames` frames, single frames and whole sub-blocks give the same bits.
  std::string cutting_matters(int frames, unsigned seeds = 4, std::int64_t first_frame = 0) {
    const auto whole = run(even_cutting(frames, kLongestSubBlock), first_frame);
    auto difference = first_difference(whole, run(even_cutting(frames, 1), first_frame));
    for (unsigned seed = 1; seed <= seeds && difference.empty(); ++seed)
      difference =
          first_difference(whole, run(random_cutting(frames, seed, seed % 2 ? 64 : 11), first_frame));
    return difference;
  }

 private:
  static InputInfo info_of(const InputValue& value, bool connected) {
    if (const auto* constant = std::get_if<double>(&value))
      return {.range = Interval::exactly(*constant), .constant = *constant, .connected = connected};
    const auto [low, high] =
        std::minmax_element(std::get<Samples>(value).begin(), std::get<Samples>(value).end());
    return {.range = {*low, *high}, .constant = std::nullopt, .connected = connected};
  }

  Signal signal(std::size_t input, int from, int length) const {
    if (const auto* constant = std::get_if<double>(&values_[input])) return {constant, 0};
    const auto& samples = std::get<Samples>(values_[input]);
    if (samples.size() < static_cast<std::size_t>(from + length)) throw std::out_of_range("input too short");
    return {samples.data() + from, 1};
  }

  template <class Step>
  Outputs run_sub_blocks(std::span<const int> block_lengths, std::int64_t first_frame, Step step) {
    if (ran_) node().reset();
    ran_ = true;
    int frames = 0;
    for (const int length : block_lengths) frames += length;
    Outputs outputs(type_.outputs.size(),
                    Samples(static_cast<std::size_t>(frames), std::numeric_limits<double>::quiet_NaN()));
    int from = 0;
    for (const int length : block_lengths)
      for (const int count : even_cutting(length, kLongestSubBlock)) {
        std::vector<Signal> in;
        std::vector<double*> out;
        for (std::size_t i = 0; i < values_.size(); ++i) in.push_back(signal(i, from, count));
        for (auto& output : outputs) out.push_back(output.data() + from);
        step(NodeBlock{in.data(), out.data(), count, first_frame + from});
        from += count;
      }
    return outputs;
  }

  const NodeType& type_;
  std::vector<InputValue> values_;
  Result<std::unique_ptr<Node>> node_ = nullptr;
  bool ran_ = false;
};

}  // namespace tactus::test
