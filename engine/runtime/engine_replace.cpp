// How one version of a graph takes over from another while it plays.
#include <algorithm>
#include <cmath>

#include "engine/runtime/engine.h"
#include "engine/runtime/handover.h"

namespace tactus {

namespace {

constexpr double kFadeSeconds = 0.010;

void add_faults(const Running& running, std::map<std::string, std::int64_t>& counts) {
  for (std::size_t i = 0; i < running.faults.size(); ++i)
    if (const auto count = running.faults[i].load(std::memory_order_relaxed); count > 0)
      counts[running.plan->vertices[i].path] += count;
}

}  // namespace

// ---- control side
// -----------------------------------------------------------------------------------------------

Status Engine::replace(std::unique_ptr<Plan> plan, std::int64_t frame) {
  collect();
  if (before_ != nullptr)
    return fail(Errc::BadArgument, "", "the last edit has not taken over yet", "try again after a block");
  auto next = std::make_unique<Running>(std::move(plan), format_.max_frames);
  if (auto status = plan_handover(*newest_, *next); !status) return status;
  next->frame = frame;
  before_ = std::move(newest_);
  newest_ = std::move(next);
  incoming_.store(newest_.get(), std::memory_order_release);
  return {};
}

/// Frees the version that was replaced, on the thread that made it.
void Engine::collect() {
  if (!retired_.exchange(false, std::memory_order_acquire)) return;
  add_faults(*before_, past_faults_);
  before_.reset();
}

int Engine::control_index(std::string_view control) const {
  const auto& names = newest_->control_names;
  const auto found = std::find(names.begin(), names.end(), control);
  if (found == names.end()) return -1;
  const auto number = found - names.begin();
  return newest_->control_of[static_cast<std::size_t>(number)] < 0 ? -1 : static_cast<int>(number);
}

std::vector<FaultCount> Engine::faults() const {
  auto counts = past_faults_;
  add_faults(*newest_, counts);
  if (before_ != nullptr) add_faults(*before_, counts);
  std::vector<FaultCount> found;
  for (const auto& [path, count] : counts) found.push_back({path, count});
  return found;
}

// ---- audio side
// -------------------------------------------------------------------------------------------------

/// What went out in the frame before this one.
double Engine::last_output(std::size_t output) const noexcept {
  if (last_frames_ == 0) return 0.0;
  const auto channel = static_cast<std::size_t>(running_->outputs[output]);
  return plan_->channels[channel].signal[last_frames_ - 1] + fades_[output].at(now_ - 1);
}

void Engine::take_over(Running& next) noexcept {
  Plan& plan = *next.plan;
  for (const auto [from, to] : next.handover.remade)
    plan.nodes[static_cast<std::size_t>(to)]->adopt(*plan_->nodes[static_cast<std::size_t>(from)]);
  for (const auto [from, to] : next.handover.nodes)
    std::swap(plan.nodes[static_cast<std::size_t>(to)], plan_->nodes[static_cast<std::size_t>(from)]);
  if (plan.system_delay != nullptr && plan_->system_delay != nullptr)
    std::copy_n(plan_->system_delay, kWide, plan.system_delay);
  const auto fade = static_cast<std::int64_t>(std::lround(kFadeSeconds * plan.sample_rate.value));
  next.take_values(*running_, now_, fade);
  for (std::size_t c = 0; c < fades_.size(); ++c)
    if (next.handover.jumps[c]) fades_[c].begin(now_, fade, last_output(c));
  fading_until_ = now_ + fade;
  running_ = &next;
  plan_ = &plan;
  tell({now_, JournalEntry::Kind::Replacement, ++replacements_, 0.0});
  incoming_.store(nullptr, std::memory_order_relaxed);
  retired_.store(true, std::memory_order_release);
}

}  // namespace tactus
