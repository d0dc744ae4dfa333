#include "tests/realtime/world_subject.h"

#include <stdexcept>
#include <vector>

#include "engine/graph/body_source.h"
#include "engine/graph/file/load.h"
#include "engine/graph/plan/compile.h"
#include "engine/nodes/table.h"

namespace tactus::realtime {
#if defined(TACTUS_HAS_ODE)
namespace {

constexpr auto kPoolRate = 48_kHz;
constexpr int kPoolBodies = 13, kPoolLinks = 4, kPoolBalls = 8;

template <class Wanted>
auto must_have(Checked<Wanted> result) {
  if (!result) throw std::runtime_error(to_string(result.error().front()));
  return std::move(*result);
}

class WorldSubject final : public Subject {
 public:
  WorldSubject(std::unique_ptr<Plan> plan, int frames)
      : player_(std::move(plan)), out_(static_cast<std::size_t>(frames)), frames_(frames) {
    name = "pool of bodies";
    if (!player_.prepare({kPoolRate, 0, 1, frames})) throw std::runtime_error("the pool cannot be prepared");
    for (const auto& node : player_.plan().nodes)
      if (auto* source = dynamic_cast<BodySource*>(node.get())) source_ = source;
    if (source_ == nullptr) throw std::runtime_error("the pool has no world");
    source_->watch_poses(true);
    source_->watch_impacts(true);
  }
  void callback() noexcept override {
    double* out[] = {out_.data()};
    player_.process({nullptr, out, frames_});
  }
  void disturb(std::mt19937& random) override {
    const auto below = [&](int end) { return static_cast<int>(random() % static_cast<unsigned>(end)); };
    const auto ball = "pool_ball_" + std::to_string(1 + below(kPoolBalls));
    set(ball + "_present", below(4) > 0);
    set(ball + "_z", 0.05 + 0.01 * below(20));
    set(ball + "_place", below(2));
    const auto link = "pool_link_" + std::to_string(1 + below(kPoolLinks));
    set(link + "_kind", below(kJointNames.size() + 1));
    set(link + "_first", 1 + below(kPoolBodies));
    set(link + "_second", below(kPoolBodies + 1));
    set(link + "_stiffness", below(3));
    set(link + "_damping", 0.1 * below(3));
    set(link + "_effort", 0.1 * below(3));
    set(link + "_attach", below(2));
    (void)source_->take_poses(poses_);
    for (BodyImpact impact; source_->take_impact(impact);) continue;
  }

 private:
  void set(const std::string& control, double value) {
    (void)player_.post(
        {JournalEntry::kNow, JournalEntry::Kind::ControlChange, player_.control_index(control), value});
  }

  Player player_;
  BodySource* source_ = nullptr;
  BodyPoses poses_;
  std::vector<double> out_;
  int frames_;
};

}  // namespace

std::unique_ptr<Subject> world_subject(const std::filesystem::path& instruments, int frames) {
  auto graph = must_have(load_graph(instruments / "world" / "pool.toml"));
  return std::make_unique<WorldSubject>(must_have(compile(*graph, standard_nodes(), {})), frames);
}

#else

std::unique_ptr<Subject> world_subject(const std::filesystem::path&, int) { return nullptr; }

#endif
}  // namespace tactus::realtime
