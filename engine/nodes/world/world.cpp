#include "engine/nodes/world/world.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "engine/core/index.h"
#include "engine/graph/plan/fingerprint.h"
#include "engine/nodes/process.h"
#include "engine/nodes/world/world_builder.h"

namespace tactus {
#if defined(TACTUS_HAS_ODE)

namespace {

void declare_inputs(NodeType& type, const NodeSpec& spec, WorldElement& element) {
  for (const auto& field : element.type->fields) {
    const bool absent = field.optional && find(spec.fields, field.name) == nullptr;
    element.ports.push_back(absent ? -1 : static_cast<int>(type.inputs.size()));
    if (absent) continue;
    auto& input = type.inputs.emplace_back(field);
    input.name = element.name + "." + field.name;
  }
}

OutputPort output_port(std::string name, const WorldQuantity& quantity) {
  const bool trigger = quantity.reading == WorldReading::Trigger;
  return {.name = std::move(name),
          .unit = quantity.unit,
          .doc = quantity.doc,
          .kind = trigger ? OutputKind::Trigger : OutputKind::Signal,
          .event_level = quantity.event_level,
          .range = trigger ? Interval{0, 1} : Interval{}};
}

void declare_outputs(NodeType& type, WorldElement& element) {
  element.first_output = static_cast<int>(type.outputs.size());
  const auto& quantities = element.type->quantities;
  for (const auto& quantity : quantities)
    type.outputs.push_back(output_port(element.name + "." + quantity.name, quantity));
  if (!quantities.empty()) type.outputs.push_back(output_port(element.name, quantities.front()));
}

std::uint64_t fingerprint_of(const WorldLayout& layout) {
  Fingerprint print;
  print.add(std::string_view{"world"}).add(std::uint64_t{layout.direct});
  for (const auto& element : layout.elements) {
    print.add(element.name).add(element.type->name);
    for (const int end : element.ends) print.add(static_cast<std::uint64_t>(end));
    for (const int port : element.ports) print.add(static_cast<std::uint64_t>(port));
    for (const auto& setting : element.settings) {
      print.add(setting.text);
      for (const double number : setting.numbers) print.add(number);
    }
  }
  return print.value();
}

/// What a handle needs from frame to frame.
struct HandleState {
  std::vector<Vector3> before;   ///< positions of the last step's frames, a ring
  Vector3 position{}, centre{};  ///< of the handle and its body, in the last frame
  Vector3 force{};               ///< on the body
  double stored = 0, lost = 0;   ///< in the spring; in the damper of the file, in the last frame [J]
  double generated = 0;          ///< J, at least 0
  Vector3 impulse{};             ///< on the body since the last step, N s
};

/// Everything but the bodies.
struct WorldState {
  std::vector<double> from, to;  ///< outputs at the last step and at the next one
  std::vector<HandleState> handles;
  std::vector<char> put, launch;  ///< bodies that are placed or launched with the next step
  bool started = false;
};

class WorldNode final : public Node {
 public:
  WorldNode(WorldRecipe recipe, const NodeSetup& setup, std::unique_ptr<RigidBodies> bodies)
      : recipe_(std::move(recipe)),
        bodies_(std::move(bodies)),
        fingerprint_(setup.type->fingerprint),
        frame_s_(1 / setup.sample_rate.value),
        read_(recipe_.outputs.size()) {
    for (const auto& input : setup.type->inputs) late_.push_back(input.late);
    for (std::size_t i = 0; i < recipe_.outputs.size(); ++i)
      if (recipe_.outputs[i].part >= 0 && (setup.read.empty() || setup.read[i])) shown_.push_back(i);
    state_.from.resize(recipe_.outputs.size());
    state_.put.resize(recipe_.bodies.size());
    state_.launch.resize(recipe_.bodies.size());
    state_.handles.resize(recipe_.handles.size());
    for (auto& handle : state_.handles) handle.before.resize(index(recipe_.frames));
    state_.to = state_.from;
    reset();
  }

  void process(const NodeBlock& block) noexcept override {
    const std::size_t count = find_read(block, read_);
    for (int frame = 0; frame < block.frames; ++frame) {
      write(block, frame, count);
      advance(block, frame);
    }
  }
  void emit(const NodeBlock& block) noexcept override { write(block, 0, find_read(block, read_)); }
  void absorb(const NodeBlock& block) noexcept override { advance(block, 0); }

  void reset() noexcept override {
    bodies_->reset();
    state_.started = false;
    std::fill(state_.put.begin(), state_.put.end(), char{0});
    std::fill(state_.launch.begin(), state_.launch.end(), char{0});
    for (auto& handle : state_.handles) {
      auto before = std::move(handle.before);
      handle = {};
      handle.before = std::move(before);
    }
    std::fill(state_.to.begin(), state_.to.end(), 0.0);
    show();
    state_.from = state_.to;
  }

  void copy(const Node& other) noexcept override {
    const auto* same = dynamic_cast<const WorldNode*>(&other);
    if (same == nullptr || same->recipe_.frames != recipe_.frames ||
        same->state_.to.size() != state_.to.size() || same->state_.put.size() != state_.put.size() ||
        same->state_.handles.size() != state_.handles.size())
      return;
    bodies_->copy(*same->bodies_);
    state_ = same->state_;  // of the same sizes: nothing is allocated
  }

  void adopt(const Node& before) noexcept override {
    const auto* other = dynamic_cast<const WorldNode*>(&before);
    if (other != nullptr && other->fingerprint_ == fingerprint_ && other->recipe_.variant == recipe_.variant)
      copy(before);
  }

  std::string about() const override {
    return fmt::format("{} bodies, a step every {} frames, {} solver, {:.2f} MB", recipe_.bodies.size(),
                       recipe_.frames, recipe_.model.direct ? "direct" : "iterative",
                       1e-6 * static_cast<double>(recipe_.model.bytes()));
  }
  std::vector<LeftOut> left_out() const override { return recipe_.left_out; }

  DelayRange delay(int input, int) const override {
    return late_[index(input)] ? DelayRange{1, recipe_.frames} : DelayRange{};
  }

 private:
  static double value(const WorldInput& input, const NodeBlock& block, int frame) noexcept {
    return input.port < 0 ? input.value : block.in[input.port][frame];
  }
  static Vector3 value(const std::array<WorldInput, 3>& inputs, const NodeBlock& block, int frame) noexcept {
    return {value(inputs[0], block, frame), value(inputs[1], block, frame), value(inputs[2], block, frame)};
  }

  /// Frames since the last step, 1 to `frames`; 0 at the very first frame.
  int since_step(std::int64_t frame) const noexcept {
    return frame == 0 ? 0 : static_cast<int>((frame - 1) % recipe_.frames) + 1;
  }

  void write(const NodeBlock& block, int frame, std::size_t count) noexcept {
    const int k = since_step(block.first_frame + frame);
    const double part = static_cast<double>(k) / recipe_.frames;
    for (std::size_t h = 0; h < state_.handles.size(); ++h) couple(h, block, frame, part);
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

  /// The forces of a handle in this frame, and the energy that they gave and took since the last one.
  void couple(std::size_t number, const NodeBlock& block, int frame, double part) noexcept {
    const auto& model = recipe_.handles[number];
    auto& handle = state_.handles[number];
    const auto p = value(model.position, block, frame);
    const auto position = bodies_->position(model.body);
    const auto velocity = bodies_->velocity(model.body);
    auto& before = handle.before[index((block.first_frame + frame) % recipe_.frames)];
    if (!state_.started) std::fill(handle.before.begin(), handle.before.end(), p);
    double stored = 0, slip2 = 0, energy = -handle.lost;
    Vector3 centre{}, slip{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!model.given[axis]) continue;
      // The body is on its way to the state that the last step computed.
      centre[axis] = state_.started ? position[axis] - (1 - part) * recipe_.model.step_s * velocity[axis]
                                    : position[axis];
      if (!state_.started) handle.position[axis] = p[axis], handle.centre[axis] = centre[axis];
      if (state_.started) slip[axis] = (p[axis] - before[axis]) / recipe_.model.step_s - velocity[axis];
      const double stretch = p[axis] - centre[axis];
      stored += 0.5 * model.stiffness * stretch * stretch;
      energy += handle.force[axis] * (p[axis] - handle.position[axis] - centre[axis] + handle.centre[axis]);
      slip2 += slip[axis] * slip[axis];
    }
    if (!state_.started) handle.stored = stored;
    handle.generated -= energy - (stored - handle.stored);
    // A damper of that much would take in one frame what sampling has generated.
    const double wanted = slip2 > 0 ? handle.generated / (slip2 * frame_s_) : 0.0;
    const double damping = model.damping + std::clamp(wanted, 0.0, model.passivity);
    for (std::size_t axis = 0; axis < 3; ++axis)
      handle.force[axis] =
          model.given[axis] ? model.stiffness * (p[axis] - centre[axis]) + damping * slip[axis] : 0.0;
    before = p;
    handle.position = p;
    handle.centre = centre;
    handle.stored = stored;
    handle.lost = model.damping * slip2 * frame_s_;
  }

  void advance(const NodeBlock& block, int frame) noexcept {
    for (auto& handle : state_.handles)
      for (std::size_t axis = 0; axis < 3; ++axis) handle.impulse[axis] += handle.force[axis] * frame_s_;
    for (std::size_t i = 0; i < recipe_.bodies.size(); ++i) {
      if (value(recipe_.bodies[i].put, block, frame) >= 0.5) state_.put[i] = 1;
      if (value(recipe_.bodies[i].launch, block, frame) >= 0.5) state_.launch[i] = 1;
    }
    if ((block.first_frame + frame) % recipe_.frames == 0) step(block, frame);
  }

  void step(const NodeBlock& block, int frame) noexcept {
    bodies_->set_gravity(value(recipe_.gravity, block, frame));
    for (std::size_t i = 0; i < recipe_.bodies.size(); ++i) update_body(i, block, frame);
    if (!state_.started) show();
    state_.started = true;
    for (const auto& drive : recipe_.drives) bodies_->drive(drive.joint, value(drive.effort, block, frame));
    const double h = recipe_.model.step_s;
    for (std::size_t i = 0; i < state_.handles.size(); ++i) {
      auto& handle = state_.handles[i];
      const int body = recipe_.handles[i].body;
      bodies_->push(body, {handle.impulse[0] / h, handle.impulse[1] / h, handle.impulse[2] / h});
      handle.generated -= work(handle.impulse, bodies_->velocity(body));
    }
    bodies_->step();
    for (std::size_t i = 0; i < state_.handles.size(); ++i) {
      auto& handle = state_.handles[i];
      // What a step takes more than it gives is no credit for a later one.
      handle.generated =
          std::max(0.0, handle.generated + work(handle.impulse, bodies_->velocity(recipe_.handles[i].body)));
      handle.impulse = {};
    }
    state_.from.swap(state_.to);
    // What is not computed anew stays.
    state_.to = state_.from;
    show();
  }

  /// Half of the impulse times the velocity: before and after a step, the work that it does.
  static double work(const Vector3& impulse, const Vector3& velocity) noexcept {
    return 0.5 * (impulse[0] * velocity[0] + impulse[1] * velocity[1] + impulse[2] * velocity[2]);
  }

  void update_body(std::size_t i, const NodeBlock& block, int frame) noexcept {
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

  /// What the outputs that are read show of the bodies as they are.
  void show() noexcept {
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

  double of_world(int quantity) const noexcept {
    if (quantity == 0) return bodies_->energy();
    if (quantity == 2) return bodies_->refused();
    double depth = 0;
    for (const auto& contact : bodies_->contacts()) depth = std::max(depth, contact.depth);
    return depth;
  }
  double of_body(int body, int quantity) const noexcept {
    const auto axis = index(quantity % 3);
    return quantity < 3   ? bodies_->position(body)[axis]
           : quantity < 6 ? bodies_->velocity(body)[axis]
                          : bodies_->turning(body)[axis];
  }

  /// Of the hardest impact of the last step; all but the trigger stay until the next one.
  void show_impact(const WorldOutput& output, double& shown) const noexcept {
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

  WorldRecipe recipe_;
  std::unique_ptr<RigidBodies> bodies_;
  std::uint64_t fingerprint_;
  double frame_s_;
  std::vector<std::size_t> read_, shown_;
  std::vector<bool> late_;
  WorldState state_;
};

Result<std::unique_ptr<Node>> make_world_node(const WorldLayout& layout, const NodeSetup& setup) {
  auto recipe = build_world(layout, setup);
  if (const auto fits = setup.take_memory(recipe.model.bytes() / sizeof(double)); !fits)
    return tl::unexpected(fits.error());
  setup.variant = recipe.variant;
  auto bodies = RigidBodies::make(recipe.model);
  if (!bodies) return tl::unexpected(bodies.error());
  return std::make_unique<WorldNode>(std::move(recipe), setup, std::move(*bodies));
}

}  // namespace

#endif

Checked<std::shared_ptr<const NodeType>> world_type(const NetworkSpec& spec) {
  auto layout = read_world_layout(spec);
  if (!layout) return tl::unexpected(layout.error());
#if defined(TACTUS_HAS_ODE)
  auto type = std::make_shared<NodeType>();
  type->name = "world";
  type->group = "worlds";
  type->summary = "Rigid bodies in space, with contacts, joints and haptic handles.";
  type->source = "Stewart & Trinkle, Int. J. Numer. Methods Eng. 39, 1996; Open Dynamics Engine 0.16";
  type->skips_unused_outputs = true;
  for (std::size_t i = 0; i < spec.elements.size(); ++i) {
    declare_inputs(*type, spec.elements[i], layout->elements[i]);
    declare_outputs(*type, layout->elements[i]);
  }
  for (const auto& quantity : world_quantities())
    type->outputs.push_back(output_port(quantity.name, quantity));
  type->fingerprint = fingerprint_of(*layout);
  const auto shared = std::make_shared<const WorldLayout>(std::move(*layout));
  type->make = [shared](const NodeSetup& setup) { return make_world_node(*shared, setup); };
  type->needed_inputs = [shared](const NodeSetup& setup) { return build_world(*shared, setup).needed; };
  return type;
#else
  return tl::unexpected(
      std::vector<Error>{{Errc::Missing, spec.at.text(),
                          "this build has no rigid bodies, so world '" + spec.name + "' cannot run",
                          "run scripts/setup libode-dev and build again"}});
#endif
}

}  // namespace tactus
