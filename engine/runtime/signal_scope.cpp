#include "engine/runtime/signal_scope.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

namespace tactus {
namespace {

/// "string" of "string[8]".
std::string without_lane(const std::string& path) { return path.substr(0, path.rfind('[')); }

/// Names the signals of a plan and finds where they lie.
class Lister {
  using Kind = Vertex::Kind;

 public:
  explicit Lister(const Plan& plan) : plan_(plan), expressions_(named_expressions(plan)) {}

  std::vector<ScopeSignal> run() {
    add_inputs();
    for (const auto& step : plan_.steps) add_nodes(step);
    for (const auto& operation : plan_.operations) add_operation(operation);
    for (const auto& channel : plan_.channels) add_output(channel);
    return std::move(signals_);
  }

 private:
  const Vertex& at(int v) const { return plan_.vertices[index(v)]; }

  void add_inputs() {
    for (int v = 0; v < std::ssize(plan_.vertices); ++v) {
      const auto& vertex = at(v);
      if (vertex.kind == Kind::Input) {
        const auto& buffer = plan_.input_buffers[index(vertex.index)];
        add(vertex.path, v, {}, {.data = buffer.data, .stride = buffer.stride});
      }
      if (vertex.kind != Kind::Control) continue;
      const auto& control = plan_.controls[index(vertex.index)];
      add(control.control.name, v, control.control.unit.dimension,
          {.data = control.buffer, .control = vertex.index});
    }
  }

  void add_nodes(const Step& step) {
    // The first half of a node that closes a loop gives its outputs.
    if (step.node < 0 || step.kind == Step::Kind::Absorb || step.kind == Step::Kind::Operations) return;
    const auto& vertex = at(step.vertex);
    if (vertex.kind != Kind::Node || vertex.type == nullptr) return;
    for (int port = 0; port < step.outputs; ++port) {
      const double* data = plan_.outputs[index(step.first_out + port)];
      if (data == nullptr) continue;
      const auto& declared = vertex.type->outputs[index(port)];
      for (int lane = 0; lane < vertex.width; ++lane) {
        add(signal_name(vertex, port, lane), step.vertex, dimension_of(declared.unit),
            {.data = data + lane, .stride = vertex.width, .divider = step.divider_out});
        auto& added = signals_.back();
        added.port = &declared;
        added.lane = lane;
        added.in_part = vertex.path.find('.') != std::string::npos;
      }
    }
  }

  void add_operation(const MicroOperation& operation) {
    const auto& vertex = at(operation.vertex);
    const auto named = expressions_.find(vertex.path);
    if (named == expressions_.end() || named->second != operation.vertex) return;
    add(vertex.path, operation.vertex, {}, place_of(operation));
  }

  SignalPlace place_of(const MicroOperation& operation) const {
    const auto divider =
        std::ranges::find(plan_.divisors, at(operation.vertex).divisor) - plan_.divisors.begin();
    return {.data = operation.out, .divider = static_cast<int>(divider), .can_rest = operation.can_rest};
  }

  void add_output(const OutputChannel& channel) {
    if (channel.use == OutputUse::Tap || plan_.constant(channel.from)) return;
    add("out/" + channel.name, channel.from.vertex, channel.dimension, place_of(channel.signal));
  }

  /// The stride of what can rest changes while it runs, on another thread.
  SignalPlace place_of(const Signal& signal) const {
    const auto same =
        std::ranges::find(signals_, signal.data, [](const auto& other) { return other.place.data; });
    if (same != signals_.end()) return same->place;
    const auto operation = std::ranges::find(plan_.operations, signal.data,
                                             [](const auto& one) -> const double* { return one.out; });
    if (operation != plan_.operations.end() && operation->can_rest >= 0) return place_of(*operation);
    return {.data = signal.data, .stride = signal.stride};
  }

  void add(std::string name, int vertex, Dimension dimension, const SignalPlace& place) {
    if (place.data != nullptr) signals_.push_back({std::move(name), vertex, dimension, place});
  }

  static Dimension dimension_of(const std::string& unit) {
    const auto known = parse_unit(unit);
    return known ? known->dimension : Dimension{};
  }

  const Plan& plan_;
  std::map<std::string, int> expressions_;
  std::vector<ScopeSignal> signals_;
};

}  // namespace

std::string signal_name(const Vertex& vertex, int port, int lane) {
  const auto& ports = vertex.type->outputs;
  const auto name = without_lane(vertex.path) + (ports.size() == 1 ? "" : "." + ports[index(port)].name);
  if (!vertex.path.ends_with(']')) return name;
  const int first = std::stoi(vertex.path.substr(vertex.path.rfind('[') + 1));  // of a vectorised vertex
  return name + "[" + std::to_string(first + lane) + "]";
}

/// Of the operations of an expression the last one is its value.
std::map<std::string, int> named_expressions(const Plan& plan) {
  using Kind = Vertex::Kind;
  std::map<std::string, int> named;
  std::set<std::string> nodes;
  std::set<int> read;
  for (int v = 0; v < std::ssize(plan.vertices); ++v) {
    const auto& vertex = plan.vertices[index(v)];
    if (vertex.kind == Kind::Operation) named[vertex.path] = v;
    if (vertex.kind == Kind::Node) nodes.insert(without_lane(vertex.path));
    if (vertex.kind != Kind::Output)
      for (const auto& wire : vertex.in) read.insert(wire.vertex);
  }
  for (const auto& channel : plan.channels)
    if (const auto own = named.find(channel.name); own != named.end() && !read.contains(own->second))
      named.erase(own);
  std::erase_if(named, [&](const auto& entry) { return nodes.contains(entry.first); });
  return named;
}

ScopeChoice ScopeChoice::of(std::uint64_t version, std::uint32_t id, int bin,
                            std::span<const SignalPlace> places) {
  ScopeChoice choice{.running = version, .id = id, .bin = bin, .places = {}};
  for (const auto& place : places.first(std::min(places.size(), choice.places.size())))
    choice.places[index(choice.traces++)] = place;
  return choice;
}

std::vector<ScopeSignal> scope_signals(const Plan& plan) { return Lister{plan}.run(); }

void SignalScope::observe(const Running& running, std::int64_t now, int frames) noexcept {
  if (!take_choices(running)) return;
  if (now != next_) in_chunk_ = false;
  std::array<SignalReader, ScopeChunk::kMostTraces> readers;
  for (int t = 0; t < choice_.traces; ++t) readers[index(t)] = {running, choice_.places[index(t)]};
  for (int n = 0; n < frames; ++n) {
    for (int t = 0; t < choice_.traces; ++t) held_[index(t)] = readers[index(t)].at(n, held_[index(t)]);
    add(now + n, held_.data());
  }
  next_ = now + frames;
}

/// The last one counts. False: there is nothing to show of this version.
bool SignalScope::take_choices(const Running& running) noexcept {
  for (ScopeChoice choice; choices_.pop(choice);) {
    choice_ = choice;
    held_.fill(0.0);
    in_chunk_ = false;
  }
  return choice_.traces > 0 && choice_.running == running.number;
}

void SignalScope::add(std::int64_t frame, const double* values) noexcept {
  if (frame % (std::int64_t{choice_.bin} * ScopeChunk::bins_of(choice_.bin)) == 0) {
    in_chunk_ = true;
    chunk_.id = choice_.id;
    chunk_.bin = choice_.bin;
    chunk_.traces = choice_.traces;
    chunk_.bins = 0;
    chunk_.frame = frame;
  }
  if (!in_chunk_) return;  // the first one is whole
  const bool begins = frame % choice_.bin == 0;
  for (int t = 0; t < choice_.traces; ++t) {
    auto& extremes = extremes_[index(t)];
    const double value = values[t];
    extremes = begins ? Extremes{value, value}
                      : Extremes{std::min(extremes.low, value), std::max(extremes.high, value)};
  }
  if ((frame + 1) % choice_.bin == 0) finish_bin();
}

void SignalScope::finish_bin() noexcept {
  const int per_bin = chunk_.per_bin();
  for (int t = 0; t < choice_.traces; ++t) {
    const auto& extremes = extremes_[index(t)];
    float* const to = chunk_.values.data() + (t * ScopeChunk::kMostBins + chunk_.bins) * per_bin;
    to[0] = static_cast<float>(extremes.low);
    if (per_bin == 2) to[1] = static_cast<float>(extremes.high);
  }
  if (++chunk_.bins < ScopeChunk::bins_of(chunk_.bin)) return;
  if (!chunks_.push(chunk_)) lost_.fetch_add(1, std::memory_order_relaxed);
}

}  // namespace tactus
