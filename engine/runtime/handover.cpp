#include "engine/runtime/handover.h"

#include <algorithm>
#include <optional>
#include <unordered_map>

#include "engine/graph/node.h"
#include "engine/runtime/anatomy.h"

namespace tactus {
namespace {

using Part = Anatomy::Part;
using Operand = Anatomy::Operand;

Status same_border(const Schedule& before, const Schedule& after) {
  const auto same_channel = [](const ScheduledChannel& a, const ScheduledChannel& b) {
    return a.name == b.name && a.use == b.use;
  };
  const char* what = nullptr;
  if (before.sample_rate != after.sample_rate)
    what = "the sample rate";
  else if (before.input_names != after.input_names)
    what = "the inputs";
  else if (!std::equal(before.channels.begin(), before.channels.end(), after.channels.begin(),
                       after.channels.end(), same_channel))
    what = "the outputs";
  if (what == nullptr) return {};
  return fail(Errc::BadArgument, "", std::string(what) + " of a graph cannot change while it plays",
              "stop it and play it again");
}

class Planner {
 public:
  Planner(const Running& before, Running& after)
      : old_(before), new_(after), was_(anatomy(*before.schedule)), is_(anatomy(*after.schedule)) {
    for (std::size_t r = 0; r < old_.ramps.size(); ++r)
      for (const int slot : old_.ramps[r].mover.readers.slots) ramp_at_.emplace(slot, static_cast<int>(r));
  }

  void run() {
    pair_controls();
    changed_.assign(is_.parts.size(), false);
    for (std::size_t p = 0; p < is_.parts.size(); ++p) compare(p);
    pair_silences();
    spread_changes();
    for (std::size_t c = 0; c < new_.outputs.size(); ++c) {
      const auto channel = static_cast<std::size_t>(new_.outputs[c]);
      const auto& now = is_.channels[channel];
      new_.handover.jumps.push_back(now.source != was_.channels[channel].source ||
                                    now.constant != was_.channels[channel].constant || is_changed(now));
    }
  }

 private:
  /// Which entry of `silent_until` holds for each node: that of its step, or of the loop that it is in.
  static std::vector<int> silence_of_nodes(const Schedule& schedule) {
    std::vector<int> found(schedule.nodes.size(), 0);
    for (const auto& section : schedule.sections)
      for (int s = section.first_step; s < section.end_step; ++s)
        if (const int node = schedule.steps[static_cast<std::size_t>(s)].node; node >= 0)
          found[static_cast<std::size_t>(node)] = section.loop ? section.first_step : s;
    return found;
  }

  /// A fault's silence goes on.
  void pair_silences() {
    const auto was = silence_of_nodes(*old_.schedule), is = silence_of_nodes(*new_.schedule);
    for (const auto [from, to] : new_.handover.nodes)
      new_.handover.silences.push_back(
          {was[static_cast<std::size_t>(from)], is[static_cast<std::size_t>(to)]});
  }

  void pair_controls() {
    std::unordered_map<std::string, int> index;
    for (std::size_t c = 0; c < new_.controls.size(); ++c)
      index.emplace(new_.schedule->controls[c].control.name, static_cast<int>(c));
    std::vector<bool> known(new_.controls.size(), false);
    new_.control_of.assign(old_.control_of.size(), -1);
    new_.control_names = old_.control_names;
    for (std::size_t number = 0; number < old_.control_names.size(); ++number) {
      const auto found = index.find(old_.control_names[number]);
      if (found == index.end()) continue;
      new_.control_of[number] = found->second;
      known[static_cast<std::size_t>(found->second)] = true;
      if (old_.control_of[number] >= 0) pair_control(old_.control_of[number], found->second);
    }
    for (std::size_t c = 0; c < known.size(); ++c) {
      if (known[c]) continue;
      new_.control_of.push_back(static_cast<int>(c));
      new_.control_names.push_back(new_.schedule->controls[c].control.name);
    }
  }

  void pair_control(int from, int to) {
    const auto& before = old_.schedule->controls[static_cast<std::size_t>(from)];
    const auto& after = new_.schedule->controls[static_cast<std::size_t>(to)];
    if (after.frozen) return;  // a node was made with the value of the file
    new_.handover.controls.push_back({from, to});
    new_.handover.new_value.push_back(before.control.value != after.control.value);
  }

  void compare(std::size_t p) {
    const Part& now = is_.parts[p];
    const auto found = was_.index.find(now.name);
    changed_[p] = true;
    if (found == was_.index.end()) return;
    const Part& then = was_.parts[found->second];
    if (then.made_from != now.made_from || then.operands.size() != now.operands.size()) {
      if (then.node >= 0 && now.node >= 0) new_.handover.remade.push_back({then.node, now.node});
      return;
    }
    if (now.node >= 0) new_.handover.nodes.push_back({then.node, now.node});
    changed_[p] = false;
    for (std::size_t i = 0; i < now.operands.size(); ++i)
      if (!same(then.operands[i], now.operands[i], now.pace)) changed_[p] = true;
  }

  /// Constants are the same in this sense even if their values differ: then one moves to the other.
  bool same(const Operand& then, const Operand& now, int pace) {
    const auto ramp = ramp_at_.find(then.slot);
    const bool moves = ramp != ramp_at_.end();
    const auto before =
        moves ? old_.ramps[static_cast<std::size_t>(ramp->second)].mover.value.to : then.constant;
    if (before.has_value() != now.constant.has_value()) return false;
    if (!before) return then.source == now.source;
    if (moves || *before != *now.constant) add_ramp(now, pace, *before, moves ? ramp->second : -1);
    return true;
  }

  void add_ramp(const Operand& now, int pace, double before, int ramp_before) {
    auto& ramp = new_.ramps.emplace_back();
    ramp.before = ramp_before;
    ramp.pace = pace;
    ramp.samples.assign(kMaxPiece, 0.0);
    ramp.mover.readers.slots = {now.slot};
    ramp.mover.value = {before, *now.constant, 0, 0};
    ramp.mover.buffer = ramp.samples.data();
    new_.schedule->inputs[static_cast<std::size_t>(now.slot)].data = ramp.samples.data();
  }

  /// The part that an operand comes from, if it is one's.
  std::optional<std::size_t> part_of(const Operand& operand) const {
    const auto part = is_.index.find(operand.source.substr(0, operand.source.find_last_of(':')));
    return part == is_.index.end() ? std::nullopt : std::optional{part->second};
  }

  bool is_changed(const Operand& operand) const {
    const auto part = part_of(operand);
    return part && changed_[*part];
  }

  /// Whoever reads what changed has changed.
  void spread_changes() {
    std::vector<std::vector<std::size_t>> readers(is_.parts.size());
    std::vector<std::size_t> work;
    for (std::size_t p = 0; p < is_.parts.size(); ++p) {
      if (changed_[p]) work.push_back(p);
      for (const auto& operand : is_.parts[p].operands)
        if (const auto source = part_of(operand)) readers[*source].push_back(p);
    }
    while (!work.empty()) {
      const auto p = work.back();
      work.pop_back();
      for (const auto reader : readers[p]) {
        if (changed_[reader]) continue;
        changed_[reader] = true;
        work.push_back(reader);
      }
    }
  }

  const Running& old_;
  Running& new_;
  Anatomy was_, is_;
  std::unordered_map<int, int> ramp_at_;  ///< [slot of the schedule before] its ramp
  std::vector<bool> changed_;             ///< [part]
};

}  // namespace

Status plan_handover(const Running& before, Running& after) {
  if (auto status = same_border(*before.schedule, *after.schedule); !status) return status;
  Planner{before, after}.run();
  return {};
}

}  // namespace tactus
