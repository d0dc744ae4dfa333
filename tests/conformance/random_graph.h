#pragma once

#include <cstdio>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "engine/graph/semantics/operators.h"
#include "engine/nodes/table.h"
#include "tests/conformance/node_cases.h"
#include "tests/support/temporary_folder.h"

// Graphs that nobody would write, made from the declarations of all node types. What is wired back, in a
// loop, is limited to ±0.5 first: so every loop is bounded.

namespace tactus::test {

inline std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

/// One valid graph text a seed. Every signal is kept as a plain number (divided by its unit) and turned into
/// what a port wants: `middle + half * limited(signal)`, within the port's range.
class RandomGraph {
 public:
  RandomGraph(unsigned seed, int lanes) : bits_(seed), lanes_(lanes) {}

  std::string text(bool as_part) {
    part_ = as_part;
    const int inputs = 2, controls = as_part ? 1 : pick(4);
    text_ = "format = 1\n[inputs]\n";
    for (int i = 0; i < inputs; ++i) declare("x" + std::to_string(i), "{}");
    text_ += "[controls]\n";
    for (int i = 0; i < controls; ++i)
      declare("c" + std::to_string(i),
              "{ value = 0.25, range = [-1, 1], smooth = \"" + std::to_string(pick(3)) + " ms\" }");
    text_ += "[nodes]\n";
    const int nodes = 1 + pick(as_part ? 4 : 10);
    for (int i = 0; i < nodes; ++i) add_node("n" + std::to_string(i));
    if (!as_part && pick(3) == 0) add_part();
    if (!as_part && pick(4) == 0) add_network();
    for (int i = 0; i < 2; ++i) text_ += "later" + std::to_string(i) + " = \"" + limited(signal()) + "\"\n";
    text_ += networks_ + "[outputs]\n";
    for (int i = 0; i < (as_part ? 1 : 1 + pick(3)); ++i)
      text_ += "y" + std::to_string(i) + " = { from = \"" + signal() + "\" }\n";
    return text_;
  }

 private:
  static constexpr int kSlowestRate = 91;  ///< 1/91

  int pick(int count) { return static_cast<int>(bits_() % static_cast<unsigned>(count)); }
  double between(double low, double high) {
    return low + (high - low) * static_cast<double>(bits_()) / 4294967296.0;
  }

  void declare(const std::string& name, const std::string& fields) {
    text_ += name + " = " + fields + "\n";
    signals_.push_back(name);
  }

  /// Any signal that was named so far, or a little arithmetic on some.
  std::string signal() {
    const auto one = [this] {
      return signals_[static_cast<std::size_t>(pick(static_cast<int>(signals_.size())))];
    };
    switch (pick(12)) {
      case 0:
        return "0.5 * (" + one() + " - " + one() + ")";
      case 1:
        return "min(" + one() + ", " + one() + " + 0.1)";
      case 2:
        return one() + " / (1 + abs(" + one() + "))";
      case 3:
        return "0.9 * max(-0.5, " + limited(one()) + " * " + limited(one()) + ")";
      case 4:
        return "select(" + one() + " > 0.1, " + one() + ", 0.5 * " + one() + ")";
      case 5:
      case 6:
        return function_of(limited(one()), limited(one()));
      default:
        return one();
    }
  }
  /// Any function of numbers from -1 to 1, inside its domain. What it gives is never much larger.
  std::string function_of(const std::string& a, const std::string& b) {
    const auto& names = function_names();
    const auto& type = *find_function(names[static_cast<std::size_t>(pick(static_cast<int>(names.size())))]);
    const bool positive = type.can_fail && !type.domain.bounded();
    std::string text = std::string{type.name} + "(" + (positive ? "0.1 + abs(" + a + ")" : a);
    for (int i = 1; i < type.operands; ++i) text += ", " + (i == 1 && !type.can_fail ? b : "0.3");
    return text + ")";
  }

  static std::string limited(const std::string& signal) { return "max(-1, min(1, " + signal + "))"; }

  /// What a port takes: a number of its range, or a signal brought into it.
  std::string value(const InputPort& port) {
    const bool free = port.unit == "any" || (!port.unit.empty() && port.unit[0] == '=');
    const auto range = typical_range(port);
    const auto unit = port.unit == "=in/s"        ? std::string{" Hz"}
                      : free || port.unit.empty() ? ""
                                                  : " " + port.unit;
    // A part may run at 1/91 of the rate, where a shorter period than two frames is an error in the file.
    const double low = part_ && port.name == "period" ? 2 * kSlowestRate / 48e3 : range.low;
    if (port.fixed || (!free && pick(2) == 0)) return "\"" + number(between(low, range.high)) + unit + "\"";
    const double middle = 0.5 * (range.low + range.high), half = 0.499 * (range.high - range.low);
    const auto in_range = [&](const std::string& s) {
      return number(middle) + unit + " + " + number(half) + unit + " * " + limited(s);
    };
    // Upside down for certain is an error in the file.
    if (port.name == "low") return "\"-0.6 + 0.4 * " + limited(signal()) + "\"";
    if (port.name == "high") return "\"0.6 + 0.4 * " + limited(signal()) + "\"";
    if (port.late && pick(2) == 0) return "\"" + in_range("0.5 * " + back()) + "\"";
    if (free && port.low > -1) return "\"" + in_range(signal()) + "\"";
    // A part's input may have lanes of its own, of which a list takes none.
    if (free && !part_ && pick(6) == 0) return list_of_lanes();
    return free ? "\"" + signal() + "\"" : "\"" + in_range(signal()) + "\"";
  }
  std::string list_of_lanes() {
    std::string text;
    for (int lane = 0; lane < lanes_; ++lane)
      text += (lane > 0 ? ", \"" : "\"") + number(between(-1, 1)) + " * x0\"";
    return "[" + text + "]";
  }

  /// Any signal of the whole graph, limited, the one in hand among them.
  std::string back() { return "later" + std::to_string(pick(2)); }

  void add_node(const std::string& name) {
    const auto& types = standard_nodes().types;
    const auto& type = *types[static_cast<std::size_t>(pick(static_cast<int>(types.size())))];
    std::string fields = "{ type = \"" + type.name + "\"";
    for (const auto& port : type.inputs)
      if (!port.fallback || pick(2) == 0) fields += ", " + port.name + " = " + value(port);
    const auto variants = setting_variants(type);
    const auto variant = std::next(variants.begin(), pick(static_cast<int>(variants.size())));
    for (const auto& setting : type.settings)
      if (const auto given = variant->second.find(setting.name); given != variant->second.end())
        fields += ", " + setting.name + " = " + as_written(setting, given->second);
    if (type.name != "mix" && pick(8) == 0) fields += ", voices = " + std::to_string(lanes_);
    text_ += name + " = " + fields + " }\n";
    for (const auto& output : type.outputs)
      signals_.push_back(plain_signal(name + "." + output.name, output.unit));
  }

  void add_part() {
    text_ += "part = { use = \"part.toml\", x0 = \"" + signal() + "\", x1 = \"" + signal() + "\"";
    if (pick(2) == 0) text_ += ", c0 = \"" + limited(signal()) + "\"";
    if (pick(2) == 0) text_ += rate_of_its_own();
    text_ += pick(3) == 0 ? ", voices = " + std::to_string(lanes_) + " }\n" : " }\n";
    signals_.push_back("part");
  }

  std::string rate_of_its_own() {
    return ", rate = \"1/" + std::to_string(2 + pick(kSlowestRate - 1)) + "\", take = \"" +
           (pick(2) == 0 ? "last" : "mean") + "\", between = \"" + (pick(2) == 0 ? "hold" : "line") + "\"";
  }

  /// A chain of masses from the floor up, with one of each kind of element that takes a signal now and then.
  void add_network() {
    networks_ = "[networks.net]\nsolver = \"" + std::string{pick(2) == 0 ? "passive" : "explicit"} +
                "\"\nfloor = { type = \"ground\" }\ntable = { type = \"motion\", position = \"" +
                in_unit("mm", 5) + "\" }\n";
    std::string below = pick(2) == 0 ? "floor" : "table";
    const int masses = 1 + pick(5);
    for (int i = 0; i < masses; ++i) {
      const auto mass = "m" + std::to_string(i), link = "l" + std::to_string(i);
      const std::string between_them = "between = [\"" + below + "\", \"" + mass + "\"], ";
      networks_ += mass + " = { type = \"mass\", mass = \"" + number(between(1, 100)) + " g\", at = \"" +
                   std::to_string(i + 1) + " mm\" }\n" + link + " = { ";
      networks_ += pick(3) == 0
                       ? "type = \"contact\", " + between_them + "stiffness = \"" +
                             number(between(1e3, 1e6)) + " N/m^1.5\", loss = \"1 s/m\" }\n"
                       : "type = \"spring\", " + between_them + "stiffness = \"" + number(between(10, 1e4)) +
                             " N/m\", damping = \"" + number(between(0.1, 5)) + " N s/m\" }\n";
      signals_.push_back("(net." + mass + ".position / 1 mm)");
      signals_.push_back("(net." + link + ".force / 1 N)");
      below = mass;
    }
    networks_ += "push = { type = \"force\", on = \"m0\", force = \"" + in_unit("N", 2) + "\" }\n";
    if (pick(2) == 0)
      networks_ +=
          "hand = { type = \"hand\", on = \"m0\", stiffness = \"10 N/m\", damping = \"1 N s/m\", "
          "position = \"" +
          in_unit("mm", 10) + "\" }\n";
    if (pick(2) == 0)
      networks_ += "coil = { type = \"coil\", on = \"m0\", voltage = \"" + in_unit("V", 5) +
                   "\", force_factor = \"6 T m\", resistance = \"6 ohm\" }\n";
  }
  std::string in_unit(const std::string& unit, double most) {
    return number(most) + " " + unit + " * " + limited(pick(2) == 0 ? back() : signal());
  }

  std::mt19937 bits_;
  int lanes_;
  bool part_ = false;
  std::string text_, networks_;
  std::vector<std::string> signals_;
};

/// The files that settings name, beside the graphs.
inline void copy_files(const TemporaryFolder& folder) {
  for (const auto* type : standard_nodes().types)
    for (const auto& setting : type->settings)
      if (setting.kind == Setting::Kind::File) {
        const std::filesystem::path file = setting_variants(*type).at("").at(setting.name);
        std::filesystem::copy_file(file, folder.path() / file.filename());
      }
}

}  // namespace tactus::test
