#include "apps/play/live/remote/live_scope.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/core/index.h"

namespace tactus::app {
namespace {

constexpr int kLevelBin = 480;  // frames over which a level is taken

double highest(const ScopeChunk& chunk, int trace) {
  float level = 0;
  const auto* values = chunk.values.data() + trace * ScopeChunk::kMostBins * chunk.per_bin();
  for (int v = 0; v < chunk.bins * chunk.per_bin(); ++v) level = std::max(level, std::abs(values[v]));
  return static_cast<double>(level);
}

}  // namespace

LiveScope::LiveScope(Player& instrument, Player* plant) {
  for (auto* player : {&instrument, plant}) {
    if (player == nullptr) continue;
    halves_.push_back(std::make_unique<Half>());
    auto& half = *halves_.back();
    half.player = player;
    player->add_observer(half.scope);
    player->add_observer(half.levels);
  }
  (void)follow_edits();
}

LiveScope::~LiveScope() {
  for (const auto& half : halves_) {
    half->player->remove_observer(half->scope);
    half->player->remove_observer(half->levels);
  }
}

// The control thread's side.

bool LiveScope::tick() {
  const bool edited = follow_edits();
  std::optional<Order> order;
  {
    const std::lock_guard lock{mutex_};
    order = std::exchange(new_order_, std::nullopt);
  }
  if (order) order_ = std::move(*order);
  if (order || edited) choose();
  for (std::size_t h = 0; h < halves_.size(); ++h) measure_levels(h);
  return edited;
}

bool LiveScope::follow_edits() {
  const bool edited =
      std::ranges::any_of(halves_, [](const auto& half) { return half->player->version() != half->version; });
  if (!edited) return false;
  signals_.clear();
  for (std::size_t h = 0; h < halves_.size(); ++h) {
    auto& half = *halves_[h];
    half.version = half.player->version();
    half.measuring = false;
    half.next_level = 0;
    for (auto& signal : scope_signals(half.player->plan())) {
      const auto name = (h == 0 ? "" : "plant/") + signal.name;
      signals_.push_back({static_cast<int>(h), name, std::move(signal)});
    }
  }
  levels_.clear();
  return true;
}

void LiveScope::choose() {
  auto shown = std::make_shared<RemoteScope>();
  auto layout = std::make_shared<Layout>();
  shown->id = layout->id = order_.id;
  std::array<std::vector<SignalPlace>, 2> places;
  for (const auto& name : order_.names) {
    const auto signal = std::ranges::find(signals_, name, &Signal::name);
    if (signal == signals_.end()) {
      shown->refused.emplace_back(name, "the graph has no such signal, or it never changes");
      continue;
    }
    places[index(signal->player)].push_back(signal->of.place);
    layout->places[index(signal->player)].push_back(static_cast<int>(shown->signals.size()));
    shown->signals.push_back(name);
  }
  // Full while no blocks come; the next edit or order tries again.
  for (std::size_t h = 0; h < halves_.size(); ++h)
    (void)halves_[h]->scope.choose(ScopeChoice::of(halves_[h]->version, order_.id, order_.bin, places[h]));
  const std::lock_guard lock{mutex_};
  shown_ = std::move(shown);
  layout_ = std::move(layout);
}

/// Of up to eight signals of a player at a time, one group after the other.
void LiveScope::measure_levels(std::size_t h) {
  auto& half = *halves_[h];
  if (!levels_wanted_) {
    if (half.measuring) (void)half.levels.choose({});
    half.measuring = false;
    levels_.clear();
    return;
  }
  levels_.resize(signals_.size(), 0.0);
  if (!half.measuring) return choose_levels(h);
  for (ScopeChunk chunk; half.levels.take(chunk);) {
    if (chunk.id != half.level_id) continue;
    for (int t = 0; t < chunk.traces; ++t)
      levels_[half.measured[static_cast<std::size_t>(t)]] = highest(chunk, t);
    return choose_levels(h);
  }
}

void LiveScope::choose_levels(std::size_t h) {
  auto& half = *halves_[h];
  std::vector<std::size_t> own;
  for (std::size_t s = 0; s < signals_.size(); ++s)
    if (signals_[s].player == static_cast<int>(h)) own.push_back(s);
  if (own.empty()) return;
  half.measured.clear();
  std::vector<SignalPlace> places;
  for (std::size_t n = 0; n < std::min<std::size_t>(own.size(), ScopeChunk::kMostTraces); ++n) {
    half.measured.push_back(own[half.next_level++ % own.size()]);
    places.push_back(signals_[half.measured.back()].of.place);
  }
  half.measuring = half.levels.choose(ScopeChoice::of(half.version, ++half.level_id, kLevelBin, places));
}

// The network thread's side.

void LiveScope::order(std::uint32_t id, int bin, std::vector<std::string> names) {
  const std::lock_guard lock{mutex_};
  new_order_ = {id, bin, std::move(names)};
}

void LiveScope::order_levels(bool on) { levels_wanted_ = on; }

std::shared_ptr<const RemoteScope> LiveScope::shown() const {
  const std::lock_guard lock{mutex_};
  return shown_;
}

bool LiveScope::take(ScopeChunk& chunk) {
  std::shared_ptr<const Layout> layout;
  {
    const std::lock_guard lock{mutex_};
    layout = layout_;
  }
  if (layout == nullptr) return false;
  const bool first = !layout->places[0].empty(), second = !layout->places[1].empty();
  if (!first && !second) return false;
  while (true) {
    if (first && !take_half(0, layout->id)) return false;
    if (second && !take_half(1, layout->id)) return false;
    if (!first || !second || waiting_[0]->frame == waiting_[1]->frame) break;
    waiting_[waiting_[0]->frame < waiting_[1]->frame ? 0 : 1].reset();
  }
  chunk = joined(*layout);
  return true;
}

/// Fills what waits of a player if it is empty or of an earlier choice.
bool LiveScope::take_half(std::size_t half, std::uint32_t id) {
  auto& waiting = waiting_[half];
  if (waiting && waiting->id == id) return true;
  waiting.reset();
  for (ScopeChunk next; halves_[half]->scope.take(next);) {
    if (next.id != id) continue;
    waiting = next;
    return true;
  }
  return false;
}

/// Traces of both players in the same frames, in the order in which they were asked for.
ScopeChunk LiveScope::joined(const Layout& layout) {
  ScopeChunk all;
  int traces = 0;
  for (std::size_t h = 0; h < waiting_.size(); ++h) {
    const auto& places = layout.places[h];
    if (places.empty()) continue;
    const auto half = std::exchange(waiting_[h], std::nullopt);
    all.id = half->id;
    all.bin = half->bin;
    all.bins = half->bins;
    all.frame = half->frame;
    traces += half->traces;
    const auto length = ScopeChunk::kMostBins * half->per_bin();
    for (int t = 0; t < std::min(half->traces, static_cast<int>(std::ssize(places))); ++t)
      std::copy_n(half->values.begin() + t * length, length, all.values.begin() + places[index(t)] * length);
  }
  all.traces = traces;
  return all;
}

}  // namespace tactus::app
