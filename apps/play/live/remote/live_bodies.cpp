#include "apps/play/live/remote/live_bodies.h"

#include <algorithm>
#include <utility>

#include "engine/core/index.h"

namespace tactus::app {
namespace {

constexpr std::chrono::milliseconds kFetchInterval{10};

}  // namespace

LiveBodies::LiveBodies(Player& instrument, Player* plant) {
  for (auto* player : {&instrument, plant})
    if (player != nullptr) parts_.push_back({player, 0});
  (void)follow_edits();
}

bool LiveBodies::tick(Clock::time_point now) {
  const bool edited = follow_edits();
  RemoteWatch wanted;
  {
    const std::lock_guard lock{mutex_};
    wanted = wanted_;
    if (!wanted.poses || edited) bodies_.reset();
  }
  if (wanted != watched_ || edited)
    for (auto* source : sources_) {
      source->watch_poses(wanted.poses);
      source->watch_impacts(wanted.impacts);
    }
  watched_ = wanted;
  if (watched_.poses && now - fetched_ >= kFetchInterval) {
    fetched_ = now;
    fetch();
  }
  return edited;
}

/// While a version has not taken over yet, its nodes are about to be exchanged for those that continue.
bool LiveBodies::follow_edits() {
  const bool edited =
      std::ranges::any_of(parts_, [](const auto& part) { return part.player->version() != part.version; });
  if (!edited || std::ranges::any_of(parts_, [](const auto& part) { return part.player->replacing(); }))
    return false;
  nodes_.clear();
  sources_.clear();
  worlds_.clear();
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    parts_[p].version = parts_[p].player->version();
    const auto& plan = parts_[p].player->plan();
    for (const auto& vertex : plan.vertices) {
      if (vertex.runs < 0) continue;
      const auto& node = plan.nodes[index(vertex.runs)];
      auto* source = dynamic_cast<BodySource*>(node.get());
      if (source == nullptr) continue;
      nodes_.push_back(node);
      sources_.push_back(source);
      worlds_.push_back({(p == 0 ? "" : "plant/") + vertex.path, source->looks()});
    }
  }
  poses_.assign(sources_.size(), {});
  return true;
}

void LiveBodies::fetch() {
  bool any = false;
  for (std::size_t w = 0; w < sources_.size(); ++w) any |= sources_[w]->take_poses(poses_[w]);
  // Until there was a step of each, there is nothing to show.
  if (!any || std::ranges::any_of(poses_, [](const auto& poses) { return poses.bodies.empty(); })) return;
  auto next = std::make_shared<RemoteBodies>(RemoteBodies{poses_});
  const std::lock_guard lock{mutex_};
  bodies_ = std::move(next);
}

bool LiveBodies::take(Impact& impact) {
  for (std::size_t w = 0; w < sources_.size(); ++w)
    if (sources_[w]->take_impact(impact.impact)) {
      impact.world = static_cast<int>(w);
      return true;
    }
  return false;
}

void LiveBodies::watch(RemoteWatch watch) {
  const std::lock_guard lock{mutex_};
  wanted_ = watch;
}

std::shared_ptr<const RemoteBodies> LiveBodies::bodies() const {
  const std::lock_guard lock{mutex_};
  return bodies_;
}

}  // namespace tactus::app
