#pragma once

#include <memory>
#include <vector>

#include "engine/nodes/world/world_handle.h"
#include "engine/nodes/world/world_watch.h"

namespace tactus {

/// Everything of a running world but the bodies.
struct WorldState {
  std::vector<double> from, to;  ///< outputs at the last step and at the next one
  std::vector<HandleState> handles;
  std::vector<char> put, launch;  ///< bodies that are placed or launched with the next step
  std::vector<char> attach;       ///< links that are made anew with it
  bool started = false;
};

/// A running world: see `world_type`.
class WorldNode final : public Node, public BodySource {
 public:
  /// [control]
  WorldNode(WorldRecipe recipe, const NodeSetup& setup, std::unique_ptr<RigidBodies> bodies);

  void process(const NodeBlock& block) noexcept override;
  void emit(const NodeBlock& block) noexcept override;
  void absorb(const NodeBlock& block) noexcept override { advance(block, 0); }
  void reset() noexcept override;
  void copy(const Node& other) noexcept override;
  void adopt(const Node& before) noexcept override;
  DelayRange delay(int input, int output) const override;
  std::string about() const override;
  std::vector<LeftOut> left_out() const override { return recipe_.left_out; }

  const BodyLooks& looks() const override { return watch_.looks(); }
  void watch_poses(bool on) noexcept override { watch_.watch_poses(on); }
  void watch_impacts(bool on) noexcept override { watch_.watch_impacts(on); }
  bool take_poses(BodyPoses& poses) override { return watch_.take_poses(poses); }
  bool take_impact(BodyImpact& impact) override { return watch_.take_impact(impact); }

 private:
  HandleCoupling coupling(std::size_t handle) const noexcept {
    return {recipe_.handles[handle], recipe_.frames, frame_s_, recipe_.model.step_s};
  }
  int since_step(std::int64_t frame) const noexcept;
  void write(const NodeBlock& block, int frame, std::size_t count) noexcept;
  void advance(const NodeBlock& block, int frame) noexcept;
  void step(const NodeBlock& block, int frame) noexcept;
  void fail() noexcept;
  void update_body(std::size_t i, const NodeBlock& block, int frame) noexcept;
  void update_link(std::size_t i, const NodeBlock& block, int frame) noexcept;
  int held_body(const WorldHandle& handle, const NodeBlock& block, int frame) const noexcept;
  int body_number(double number) const noexcept;
  void show() noexcept;
  void show_watch(std::int64_t frame) noexcept;
  double of_world(int quantity) const noexcept;
  double of_body(int body, int quantity) const noexcept;
  void show_impact(const WorldOutput& output, double& shown) const noexcept;

  WorldRecipe recipe_;
  std::unique_ptr<RigidBodies> bodies_;
  std::uint64_t fingerprint_;
  double frame_s_;
  std::vector<std::size_t> read_, shown_;
  std::vector<bool> late_;
  WorldState state_;
  WorldWatch watch_;
};

}  // namespace tactus
