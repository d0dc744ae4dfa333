#include "engine/runtime/replacement.h"

namespace tactus {
namespace {

void add_faults(const Running& running, std::map<std::string, std::int64_t>& counts) {
  for (std::size_t v = 0; v < running.faults.size(); ++v)
    if (const auto count = running.faults[v].load(std::memory_order_relaxed); count > 0)
      counts[running.plan->vertices[v].path] += count;
}

}  // namespace

Replacement::Replacement(std::unique_ptr<Plan> plan)
    : newest_(std::make_unique<Running>(std::move(plan), 1)) {}

Running& Replacement::restart() {
  incoming_ = nullptr;
  retired_ = false;
  before_.reset();
  past_faults_.clear();
  return *newest_;
}

Status Replacement::offer(std::unique_ptr<Plan> plan, std::int64_t frame, int max_frames) {
  collect();
  if (before_ != nullptr)
    return fail(Errc::BadArgument, "", "the previous edit is not in effect yet", "try again after a block");
  auto next = std::make_unique<Running>(std::move(plan), max_frames);
  if (auto status = plan_handover(*newest_, *next); !status) return status;
  next->frame = frame;
  before_ = std::move(newest_);
  newest_ = std::move(next);
  incoming_.store(newest_.get(), std::memory_order_release);
  return {};
}

/// Frees the version that was replaced, on the thread that made it.
void Replacement::collect() {
  if (!retired_.exchange(false, std::memory_order_acquire)) return;
  add_faults(*before_, past_faults_);
  before_.reset();
}

std::vector<FaultCount> Replacement::faults() const {
  auto counts = past_faults_;
  add_faults(*newest_, counts);
  if (before_ != nullptr) add_faults(*before_, counts);
  std::vector<FaultCount> found;
  for (const auto& [path, count] : counts) found.push_back({path, count});
  return found;
}

}  // namespace tactus
