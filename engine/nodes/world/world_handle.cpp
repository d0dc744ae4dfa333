#include "engine/nodes/world/world_handle.h"

#include <algorithm>
#include <utility>

#include "engine/core/index.h"

namespace tactus {
namespace {

/// Half of the impulse times the velocity: before and after a step, the work that it does.
double work(const Vector3& impulse, const Vector3& velocity) noexcept {
  return 0.5 * (impulse[0] * velocity[0] + impulse[1] * velocity[1] + impulse[2] * velocity[2]);
}

}  // namespace

void HandleCoupling::reset(HandleState& state) const noexcept {
  auto before = std::move(state.before);
  state = {};
  state.before = std::move(before);
  state.body = model.body;
}

void HandleCoupling::hold(HandleState& state, int body) const noexcept {
  if (body == state.body) return;
  reset(state);
  state.body = body;
}

void HandleCoupling::move(HandleState& state, const Vector3& p, const RigidBodies& bodies, std::int64_t frame,
                          double part, bool started) const noexcept {
  if (state.body < 0 || !bodies.present(state.body)) {
    const int body = state.body;
    reset(state);
    state.body = body;
    state.position = p;
    return;
  }
  const auto position = bodies.position(state.body);
  const auto velocity = bodies.velocity(state.body);
  const bool fresh = std::exchange(state.fresh, false);
  if (fresh) std::fill(state.before.begin(), state.before.end(), p);
  auto& before = state.before[index(frame % frames)];
  double stored = 0, slip2 = 0, energy = -state.lost;
  Vector3 centre{}, slip{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!model.given[axis]) continue;
    // The body is on its way to the state that the last step computed.
    centre[axis] = started ? position[axis] - (1 - part) * step_s * velocity[axis] : position[axis];
    if (fresh)
      state.position[axis] = p[axis], state.centre[axis] = centre[axis];
    else
      slip[axis] = (p[axis] - before[axis]) / step_s - velocity[axis];
    const double stretch = p[axis] - centre[axis];
    stored += 0.5 * model.stiffness * stretch * stretch;
    energy += state.force[axis] * (p[axis] - state.position[axis] - centre[axis] + state.centre[axis]);
    slip2 += slip[axis] * slip[axis];
  }
  if (fresh) state.stored = stored;
  state.generated -= energy - (stored - state.stored);
  // A damper of that much would take in one frame what sampling has generated.
  const double wanted = slip2 > 0 ? state.generated / (slip2 * frame_s) : 0.0;
  const double damping = model.damping + std::clamp(wanted, 0.0, model.passivity);
  for (std::size_t axis = 0; axis < 3; ++axis)
    state.force[axis] =
        model.given[axis] ? model.stiffness * (p[axis] - centre[axis]) + damping * slip[axis] : 0.0;
  before = p;
  state.position = p;
  state.centre = centre;
  state.stored = stored;
  state.lost = model.damping * slip2 * frame_s;
}

void HandleCoupling::collect(HandleState& state) const noexcept {
  for (std::size_t axis = 0; axis < 3; ++axis) state.impulse[axis] += state.force[axis] * frame_s;
}

void HandleCoupling::before_step(HandleState& state, RigidBodies& bodies) const noexcept {
  if (state.body < 0) return;
  const auto& impulse = state.impulse;
  bodies.push(state.body, {impulse[0] / step_s, impulse[1] / step_s, impulse[2] / step_s});
  state.generated -= work(impulse, bodies.velocity(state.body));
}

void HandleCoupling::after_step(HandleState& state, const RigidBodies& bodies) const noexcept {
  if (state.body < 0) return;
  // What a step takes more than it gives is no credit for a later one.
  state.generated = std::max(0.0, state.generated + work(state.impulse, bodies.velocity(state.body)));
  state.impulse = {};
}

}  // namespace tactus
