#include "engine/nodes/world/world_watch.h"

#include "engine/core/index.h"

namespace tactus {

WorldWatch::WorldWatch(const WorldRecipe& recipe) : looks_(recipe.looks), before_(recipe.bodies.size()) {
  for (auto& copy : copies_) {
    copy.bodies.resize(recipe.bodies.size());
    copy.handles.resize(recipe.handles.size());
  }
}

bool WorldWatch::take_poses(BodyPoses& poses) {
  if ((newest_.load(std::memory_order_relaxed) & kFresh) == 0) return false;
  read_ = newest_.exchange(read_, std::memory_order_acq_rel) & ~kFresh;
  poses = copies_[read_];
  return true;
}

void WorldWatch::publish() noexcept {
  filled_ = newest_.exchange(filled_ | kFresh, std::memory_order_acq_rel) & ~kFresh;
}

void WorldWatch::add_bodies(const RigidBodies& bodies, double step_s, BodyPoses& poses) noexcept {
  for (std::size_t i = 0; i < poses.bodies.size(); ++i) {
    auto& pose = poses.bodies[i];
    const int body = static_cast<int>(i);
    pose.present = bodies.present(body);
    pose.position = bodies.position(body);
    pose.velocity = bodies.velocity(body);
    for (std::size_t axis = 0; axis < 3; ++axis)
      pose.acceleration[axis] = (pose.velocity[axis] - before_[i][axis]) / step_s;
    before_[i] = pose.velocity;
    pose.turn = bodies.turn(body);
    pose.size = bodies.state(body).size;
  }
}

void WorldWatch::add_impacts(const RigidBodies& bodies, std::int64_t frame) noexcept {
  if (!impacts_wanted_.load(std::memory_order_relaxed)) return;
  for (const auto& contact : bodies.contacts())
    if (contact.began && contact.impulse > 0 && contact.speed >= kLeastImpact_m_per_s)
      (void)impacts_.push({contact.one, contact.other, contact.speed, contact.impulse, frame});
}

}  // namespace tactus
