#include "engine/nodes/world/world_node.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/core/index.h"
#include "engine/nodes/process.h"

namespace tactus {
namespace {

/// The library ends the program when a square or a quotient of numbers overflows.
double value(const WorldInput& input, const NodeBlock& block, int frame) noexcept {
  return std::clamp(input.port < 0 ? input.value : block.in[input.port][frame], -kLargestField,
                    kLargestField);
}
Vector3 value(const std::array<WorldInput, 3>& inputs, const NodeBlock& block, int frame) noexcept {
  return {value(inputs[0], block, frame), value(inputs[1], block, frame), value(inputs[2], block, frame)};
}

}  // namespace

WorldNode::WorldNode(WorldRecipe recipe, const NodeSetup& setup, std::unique_ptr<RigidBodies> bodies)
    : recipe_(std::move(recipe)),
      bodies_(std::move(bodies)),
      fingerprint_(setup.type->fingerprint),
      frame_s_(1 / setup.sample_rate.value),
      read_(recipe_.outputs.size()),
      watch_(recipe_) {
  for (const auto& input : setup.type->inputs) late_.push_back(input.late);
  for (std::size_t i = 0; i < recipe_.outputs.size(); ++i)
    if (recipe_.outputs[i].part >= 0 && (setup.read.empty() || setup.read[i])) shown_.push_back(i);
  state_.from.resize(recipe_.outputs.size());
  state_.put.resize(recipe_.bodies.size());
  state_.launch.resize(recipe_.bodies.size());
  state_.attach.resize(recipe_.links.size());
  state_.handles.resize(recipe_.handles.size());
  for (auto& handle : state_.handles) handle.before.resize(index(recipe_.frames));
  state_.to = state_.from;
  reset();
}

void WorldNode::process(const NodeBlock& block) noexcept {
  const std::size_t count = find_read(block, read_);
  for (int frame = 0; frame < block.frames; ++frame) {
    write(block, frame, count);
    advance(block, frame);
  }
}

void WorldNode::emit(const NodeBlock& block) noexcept { write(block, 0, find_read(block, read_)); }

void WorldNode::reset() noexcept {
  bodies_->reset();
  state_.started = false;
  for (auto* triggered : {&state_.put, &state_.launch, &state_.attach})
    std::fill(triggered->begin(), triggered->end(), char{0});
  for (std::size_t h = 0; h < state_.handles.size(); ++h) coupling(h).reset(state_.handles[h]);
  std::fill(state_.to.begin(), state_.to.end(), 0.0);
  show();
  state_.from = state_.to;
}

void WorldNode::copy(const Node& other) noexcept {
  const auto* same = dynamic_cast<const WorldNode*>(&other);
  if (same == nullptr || same->recipe_.frames != recipe_.frames ||
      same->state_.to.size() != state_.to.size() || same->state_.put.size() != state_.put.size() ||
      same->state_.attach.size() != state_.attach.size() ||
      same->state_.handles.size() != state_.handles.size())
    return;
  bodies_->copy(*same->bodies_);
  state_ = same->state_;  // of the same sizes: nothing is allocated
}

void WorldNode::adopt(const Node& before) noexcept {
  const auto* other = dynamic_cast<const WorldNode*>(&before);
  if (other != nullptr && other->fingerprint_ == fingerprint_ && other->recipe_.variant == recipe_.variant)
    copy(before);
}

std::string WorldNode::about() const {
  const auto links = recipe_.links.empty() ? "" : fmt::format(", {} links", recipe_.links.size());
  return fmt::format("{} bodies{}, a step every {} frames, {} solver, {:.2f} MB", recipe_.bodies.size(),
                     links, recipe_.frames, recipe_.model.direct ? "direct" : "iterative",
                     1e-6 * static_cast<double>(recipe_.model.bytes()));
}

DelayRange WorldNode::delay(int input, int) const {
  return late_[index(input)] ? DelayRange{1, recipe_.frames} : DelayRange{};
}

/// Frames since the last step, 1 to `frames`; 0 at the very first frame.
int WorldNode::since_step(std::int64_t frame) const noexcept {
  return frame == 0 ? 0 : static_cast<int>((frame - 1) % recipe_.frames) + 1;
}

void WorldNode::write(const NodeBlock& block, int frame, std::size_t count) noexcept {
  const auto now = block.first_frame + frame;
  const int k = since_step(now);
  const double part = static_cast<double>(k) / recipe_.frames;
  for (std::size_t h = 0; h < state_.handles.size(); ++h)
    coupling(h).move(state_.handles[h], value(recipe_.handles[h].position, block, frame), *bodies_, now, part,
                     state_.started);
  for (std::size_t i = 0; i < count; ++i) {
    const auto& output = recipe_.outputs[read_[i]];
    const double from = state_.from[read_[i]], to = state_.to[read_[i]];
    double shown = to;
    if (output.reading == WorldReading::Line) shown = k == recipe_.frames ? to : from + part * (to - from);
    if (output.reading == WorldReading::Trigger) shown = k == 1 ? to : 0.0;
    if (output.reading == WorldReading::Frame)
      shown = output.part < 0 ? 0.0 : -state_.handles[index(output.part)].force[index(output.quantity)];
    block.out[read_[i]][frame] = shown;
  }
}

void WorldNode::advance(const NodeBlock& block, int frame) noexcept {
  for (std::size_t h = 0; h < state_.handles.size(); ++h) coupling(h).collect(state_.handles[h]);
  for (std::size_t i = 0; i < recipe_.bodies.size(); ++i) {
    if (value(recipe_.bodies[i].put, block, frame) >= 0.5) state_.put[i] = 1;
    if (value(recipe_.bodies[i].launch, block, frame) >= 0.5) state_.launch[i] = 1;
  }
  for (std::size_t i = 0; i < recipe_.links.size(); ++i)
    if (value(recipe_.links[i].attach, block, frame) >= 0.5) state_.attach[i] = 1;
  if ((block.first_frame + frame) % recipe_.frames == 0) step(block, frame);
}

void WorldNode::step(const NodeBlock& block, int frame) noexcept {
  bodies_->set_gravity(value(recipe_.gravity, block, frame));
  for (std::size_t i = 0; i < recipe_.bodies.size(); ++i) update_body(i, block, frame);
  for (std::size_t i = 0; i < recipe_.links.size(); ++i) update_link(i, block, frame);
  if (!state_.started) show();
  state_.started = true;
  for (const auto& drive : recipe_.drives) bodies_->drive(drive.joint, value(drive.effort, block, frame), 0);
  for (std::size_t h = 0; h < state_.handles.size(); ++h)
    coupling(h).before_step(state_.handles[h], *bodies_);
  bodies_->step();
  if (!bodies_->within_range()) return fail();
  for (std::size_t h = 0; h < state_.handles.size(); ++h) {
    coupling(h).after_step(state_.handles[h], *bodies_);
    coupling(h).hold(state_.handles[h], held_body(recipe_.handles[h], block, frame));
  }
  state_.from.swap(state_.to);
  // What is not computed anew stays.
  state_.to = state_.from;
  show();
  show_watch(block.first_frame + frame);
}

/// What is not finite is counted as a fault of this node, which then begins anew. So does a world that
/// nothing reads.
void WorldNode::fail() noexcept {
  reset();
  std::fill(state_.to.begin(), state_.to.end(), std::numeric_limits<double>::quiet_NaN());
  state_.from = state_.to;
}

void WorldNode::update_body(std::size_t i, const NodeBlock& block, int frame) noexcept {
  const auto& inputs = recipe_.bodies[i];
  if (inputs.shape == WorldShape::Plane) return;
  const int body = static_cast<int>(i);
  const bool present = value(inputs.present, block, frame) >= 0.5;
  const bool appears = !state_.started || (present && !bodies_->present(body));
  const bool put = std::exchange(state_.put[i], char{0}) != 0,
             launch = std::exchange(state_.launch[i], char{0}) != 0;
  BodyState at;
  at.size = value(inputs.size, block, frame);
  at.mass = inputs.by_density ? value(inputs.density, block, frame) * inputs.volume(at.size)
                              : value(inputs.mass, block, frame);
  bodies_->resize(body, at);
  if (put || appears) bodies_->place(body, value(inputs.place, block, frame));
  if (launch || appears) bodies_->launch(body, value(inputs.velocity, block, frame));
  bodies_->set_present(body, present);
  bodies_->push(body, value(inputs.force, block, frame));
}

void WorldNode::update_link(std::size_t i, const NodeBlock& block, int frame) noexcept {
  const auto& inputs = recipe_.links[i];
  const auto kind = std::lround(value(inputs.kind, block, frame));
  const bool attach = std::exchange(state_.attach[i], char{0}) != 0 || !state_.started;
  if (attach) {
    JointModel model{.on = -1};
    if (kind >= 1 && kind <= kJointKinds) {
      model.kind = static_cast<WorldJoint>(kind - 1);
      model.on = body_number(value(inputs.first, block, frame));
      model.against = body_number(value(inputs.second, block, frame));
      model.anchor = value(inputs.anchor, block, frame);
      model.axis = value(inputs.axis, block, frame);
      model.second_axis = value(inputs.second_axis, block, frame);
    }
    bodies_->link(inputs.joint, model);
  }
  bodies_->set_spring(inputs.joint, value(inputs.stiffness, block, frame),
                      value(inputs.damping, block, frame));
  bodies_->drive(inputs.joint, value(inputs.effort, block, frame), value(inputs.second_effort, block, frame));
}

int WorldNode::held_body(const WorldHandle& handle, const NodeBlock& block, int frame) const noexcept {
  const double number = value(handle.holds, block, frame);
  return number < 0 ? handle.body : body_number(number);
}

/// By its number in the file; -1: none, or one that is left out.
int WorldNode::body_number(double number) const noexcept {
  const auto at = std::lround(std::clamp(number, 0.0, double{kMostBodies}));
  return at >= 1 && at <= std::ssize(recipe_.by_number) ? recipe_.by_number[index(at - 1)] : -1;
}

/// What the outputs that are read show of the bodies as they are.
void WorldNode::show() noexcept {
  for (const auto i : shown_) {
    const auto& output = recipe_.outputs[i];
    if (output.type == nullptr)
      state_.to[i] = of_world(output.quantity);
    else if (output.type->part == WorldPart::Body)
      state_.to[i] = of_body(output.part, output.quantity);
    else if (output.type->part == WorldPart::Joint)
      state_.to[i] =
          output.quantity == 0 ? bodies_->joint_position(output.part) : bodies_->joint_rate(output.part);
    else if (output.type->part == WorldPart::Handle)
      state_.to[i] = state_.handles[index(output.part)].generated;
    else if (output.type->part == WorldPart::Collision)
      show_impact(output, state_.to[i]);
  }
}

double WorldNode::of_world(int quantity) const noexcept {
  if (quantity == 0) return bodies_->energy();
  if (quantity == 2) return bodies_->refused();
  double depth = 0;
  for (const auto& contact : bodies_->contacts()) depth = std::max(depth, contact.depth);
  return depth;
}
double WorldNode::of_body(int body, int quantity) const noexcept {
  const auto axis = index(quantity % 3);
  return quantity < 3   ? bodies_->position(body)[axis]
         : quantity < 6 ? bodies_->velocity(body)[axis]
                        : bodies_->turning(body)[axis];
}

/// Of the hardest impact of the last step; all but the trigger stay until the next one.
void WorldNode::show_impact(const WorldOutput& output, double& shown) const noexcept {
  const auto& wanted = recipe_.impacts[index(output.part)];
  const RigidContact* hardest = nullptr;
  for (const auto& contact : bodies_->contacts()) {
    const bool one = contact.one == wanted.on, other = contact.other == wanted.on;
    if (!one && !other) continue;
    if (wanted.against >= 0 && (one ? contact.other : contact.one) != wanted.against) continue;
    if (!contact.began || contact.impulse <= 0 || contact.speed < wanted.least_speed) continue;
    if (hardest == nullptr || contact.impulse > hardest->impulse) hardest = &contact;
  }
  if (output.quantity == 0)
    shown = hardest != nullptr ? 1.0 : 0.0;
  else if (hardest != nullptr)
    shown = output.quantity == 1   ? hardest->impulse
            : output.quantity == 2 ? hardest->speed
                                   : hardest->place[index(output.quantity - 3)];
}

/// For screens and messages, where they ask for it.
void WorldNode::show_watch(std::int64_t frame) noexcept {
  watch_.add_impacts(*bodies_, frame);
  auto* poses = watch_.begin();
  if (poses == nullptr) return;
  poses->frame = frame;
  watch_.add_bodies(*bodies_, recipe_.model.step_s, *poses);
  for (std::size_t h = 0; h < poses->handles.size(); ++h) {
    const auto& handle = state_.handles[h];
    poses->handles[h] = {
        handle.body, handle.position, {-handle.force[0], -handle.force[1], -handle.force[2]}};
  }
  watch_.publish();
}

}  // namespace tactus
