#include "engine/runtime/replacement.h"

#include <algorithm>
#include <bit>
#include <set>
#include <tuple>
#include <unordered_map>

#include "engine/graph/node.h"

namespace tactus {
namespace {

Status same_border(const Plan& before, const Plan& after) {
  const auto same_channel = [](const OutputChannel& a, const OutputChannel& b) {
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
  return fail(Errc::BadArgument, "", std::string(what) + " of a graph cannot change during playback",
              "stop and restart it");
}

/// What a vertex continues from one plan to the next: kind, name, and which of several with that name it is.
using Key = std::tuple<Vertex::Kind, std::string_view, int>;

Key key_of(const Plan& plan, const Vertex& vertex) {
  using Kind = Vertex::Kind;
  if (vertex.runs >= 0) return {Kind::Node, vertex.path, vertex.nth};
  if (vertex.kind == Kind::Input) return {vertex.kind, {}, vertex.index};
  if (vertex.kind == Kind::Control) return {vertex.kind, plan.controls[index(vertex.index)].control.name, 0};
  return {vertex.kind, vertex.kind == Kind::Operation ? vertex.path : std::string_view{}, vertex.nth};
}

/// Fills in what `after` takes over from `before`, which may be running meanwhile:
///  - A node of the same path and made from the same things continues with its state.
///  - A control keeps its value and its number; one whose value in the file is another moves there.
///  - A constant that differs at a place that is otherwise the same moves from the old number to the new.
///  - An output jumps if a step that feeds it, directly or through others, is new, was made anew, or reads
///    something else. What differs in constants alone does not jump.
class Planner {
 public:
  Planner(const Running& before, Running& after)
      : old_(before), new_(after), was_(*before.plan), is_(*after.plan) {
    std::map<Key, int> known;
    for (int v = 0; v < static_cast<int>(was_.vertices.size()); ++v) {
      const auto& vertex = was_.vertices[index(v)];
      known.emplace(key_of(was_, vertex), v);
      for (const auto& path : vertex.also) known.emplace(Key{Vertex::Kind::Node, path, 0}, v);
    }
    for (const auto& vertex : is_.vertices) {
      const auto found = known.find(key_of(is_, vertex));
      twin_.push_back(found == known.end() ? -1 : found->second);
    }
    for (std::size_t r = 0; r < old_.ramps.size(); ++r)
      for (const int slot : old_.ramps[r].control.readers.slots) ramp_at_.emplace(slot, static_cast<int>(r));
  }

  void run() {
    pair_controls();
    changed_.assign(is_.vertices.size(), false);
    for (std::size_t v = 0; v < is_.vertices.size(); ++v)
      if (is_step(is_.vertices[v])) compare(v);
    pair_silences();
    spread_changes();
    for (const int output : new_.outputs) new_.handover.jumps.push_back(jumps(index(output)));
  }

 private:
  static bool is_step(const Vertex& vertex) {
    return vertex.runs >= 0 || vertex.kind == Vertex::Kind::Operation;
  }

  /// Which entry of `silent_until` applies to each node: that of its step, or of the loop that it is in.
  static std::vector<int> silence_of_nodes(const Plan& plan) {
    std::vector<int> found(plan.nodes.size(), 0);
    for (const auto& section : plan.sections)
      for (int s = section.first_step; s < section.end_step; ++s)
        if (const int node = plan.steps[index(s)].node; node >= 0)
          found[index(node)] = section.loop ? section.first_step : s;
    return found;
  }

  /// The silence of a fault continues.
  void pair_silences() {
    const auto was = silence_of_nodes(was_), is = silence_of_nodes(is_);
    for (const auto [from, to] : new_.handover.nodes)
      new_.handover.silences.push_back({was[index(from)], is[index(to)]});
  }

  void pair_controls() {
    std::unordered_map<std::string_view, std::size_t> numbers;
    for (const auto& name : old_.control_names) numbers.emplace(name, numbers.size());
    new_.control_of.assign(numbers.size(), -1);
    new_.control_names = old_.control_names;
    for (int c = 0; c < static_cast<int>(is_.controls.size()); ++c) {
      const auto& name = is_.controls[index(c)].control.name;
      const auto [known, is_new] = numbers.emplace(name, numbers.size());
      if (is_new) new_.control_names.push_back(name);
      new_.control_of.resize(new_.control_names.size());
      new_.control_of[known->second] = c;
      if (!is_new && old_.control_of[known->second] >= 0) pair_control(old_.control_of[known->second], c);
    }
  }

  void pair_control(int from, int to) {
    const auto& before = was_.controls[index(from)];
    const auto& after = is_.controls[index(to)];
    if (after.frozen) return;  // a node was made with the value of the file
    new_.handover.controls.push_back({from, to});
    new_.handover.new_value.push_back(before.control.value != after.control.value);
  }

  void compare(std::size_t v) {
    const auto& now = is_.vertices[v];
    changed_[v] = true;
    if (twin_[v] < 0) return;
    const auto& then = was_.vertices[index(twin_[v])];
    const bool same_making = now.runs >= 0 ? then.fingerprint == now.fingerprint : then.op == now.op;
    if (!same_making || then.in.size() != now.in.size()) {
      if (now.runs >= 0) new_.handover.remade.push_back({then.runs, now.runs});
      return;
    }
    // The first takes the node itself; an edit may have separated others that were equal to it.
    if (now.runs >= 0)
      (taken_.insert(then.runs).second ? new_.handover.nodes : new_.handover.copies)
          .push_back({then.runs, now.runs});
    changed_[v] = false;
    for (int i = 0; i < static_cast<int>(now.in.size()); ++i)
      if (!same_operand(then, now, i)) changed_[v] = true;
  }

  /// Constants are the same in this sense even if their values differ: then one moves to the other.
  bool same_operand(const Vertex& then, const Vertex& now, int i) {
    const auto& was = then.in[index(i)];
    const auto& is = now.in[index(i)];
    const auto before = was_.constant(was), after = is_.constant(is);
    if (before.has_value() != after.has_value()) return false;
    if (!before) return same_source(was, is);
    const auto ramp = ramp_at_.find(then.first_in + i);
    const bool moves = ramp != ramp_at_.end();
    if (moves || *before != *after) add_ramp(now, i, *before, *after, moves ? ramp->second : -1);
    return true;
  }

  bool same_source(const Wire& then, const Wire& now) const {
    const auto &was = was_.vertex_of(then), &is = is_.vertex_of(now);
    if (is.kind == Vertex::Kind::Constant)
      return was.kind == Vertex::Kind::Constant &&
             std::equal(was.values.begin(), was.values.end(), is.values.begin(), is.values.end(), same_bits);
    return twin_[index(now.vertex)] == then.vertex && then.port == now.port &&
           std::max(0, then.lane) == std::max(0, now.lane);
  }

  static bool same_bits(double a, double b) {
    return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
  }

  void add_ramp(const Vertex& now, int input, double before, double after, int ramp_before) {
    auto& ramp = new_.ramps.emplace_back();
    ramp.before = ramp_before;
    const auto& divisors = is_.divisors;
    const int divisor = now.kind == Vertex::Kind::RateConverter ? now.conversion.from : now.divisor;
    ramp.divider = static_cast<int>(std::find(divisors.begin(), divisors.end(), divisor) - divisors.begin());
    ramp.samples.assign(kMaxSubBlock, 0.0);
    const int slot = now.first_in + input;
    ramp.control.readers.slots = {slot};
    ramp.control.value = {before, after, 0, 0};
    ramp.control.buffer = ramp.samples.data();
    new_.plan->inputs[index(slot)].data = ramp.samples.data();
  }

  bool jumps(std::size_t channel) const {
    const auto &then = was_.channels[channel].from, &now = is_.channels[channel].from;
    const auto before = was_.constant(then), after = is_.constant(now);
    if (before || after) return before != after;
    return !same_source(then, now) || changed_[index(now.vertex)];
  }

  /// Whoever reads what changed has changed.
  void spread_changes() {
    std::vector<std::vector<std::size_t>> readers(is_.vertices.size());
    std::vector<std::size_t> work;
    for (std::size_t v = 0; v < is_.vertices.size(); ++v) {
      if (changed_[v]) work.push_back(v);
      if (!is_step(is_.vertices[v])) continue;
      for (const auto& wire : is_.vertices[v].in) readers[index(wire.vertex)].push_back(v);
    }
    while (!work.empty()) {
      const auto v = work.back();
      work.pop_back();
      for (const auto reader : readers[v]) {
        if (changed_[reader]) continue;
        changed_[reader] = true;
        work.push_back(reader);
      }
    }
  }

  const Running& old_;
  Running& new_;
  const Plan &was_, &is_;
  std::vector<int> twin_;                 ///< [vertex] the one before that it continues, or -1
  std::unordered_map<int, int> ramp_at_;  ///< [slot of the plan before] its ramp
  std::vector<bool> changed_;             ///< [vertex]
  std::set<int> taken_;                   ///< nodes before that one of now continues as
};

void add_faults(const Running& running, std::map<std::string, std::int64_t>& counts) {
  for (std::size_t v = 0; v < running.faults.size(); ++v)
    if (const auto count = running.faults[v].load(std::memory_order_relaxed); count > 0)
      counts[running.plan->vertices[v].path] += count;
}

}  // namespace

Replacement::Replacement(std::unique_ptr<Plan> plan)
    : newest_(std::make_unique<Running>(std::move(plan), 1)) {}

Running& Replacement::restart() {
  incoming_ = nullptr;
  retired_ = false;
  before_.reset();
  past_faults_.clear();
  return *newest_;
}

Status Replacement::offer(std::unique_ptr<Plan> plan, std::int64_t frame, int max_frames) {
  collect();
  if (before_ != nullptr)
    return fail(Errc::BadArgument, "", "the previous edit is not in effect yet", "try again after a block");
  if (auto status = same_border(*newest_->plan, *plan); !status) return status;
  auto next = std::make_unique<Running>(std::move(plan), max_frames);
  Planner{*newest_, *next}.run();
  next->frame = frame;
  before_ = std::move(newest_);
  newest_ = std::move(next);
  incoming_.store(newest_.get(), std::memory_order_release);
  return {};
}

/// Frees the version that was replaced, on the thread that made it.
void Replacement::collect() {
  if (!retired_.exchange(false, std::memory_order_acquire)) return;
  add_faults(*before_, past_faults_);
  before_.reset();
}

std::vector<FaultCount> Replacement::faults() const {
  auto counts = past_faults_;
  add_faults(*newest_, counts);
  if (before_ != nullptr) add_faults(*before_, counts);
  std::vector<FaultCount> found;
  for (const auto& [path, count] : counts) found.push_back({path, count});
  return found;
}

}  // namespace tactus
