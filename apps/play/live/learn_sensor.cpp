#include "engine/rig/learn_sensor.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include "apps/play/live/plan.h"
#include "engine/core/decibels.h"
#include "engine/core/named.h"
#include "engine/core/spsc_queue.h"
#include "engine/rig/check_rig.h"

namespace tactus::app {
namespace {

using namespace std::chrono_literals;

/// Hands the first input to the control thread; it has no outputs, so nothing moves.
class InputReader final : public BlockProcessor {
 public:
  Status prepare(const StreamFormat&) override { return {}; }
  void process(const BlockIo& io) noexcept override {
    for (int n = 0; n < io.frames; ++n) (void)samples_.push(io.in[0][n]);
  }
  std::vector<double> take() {
    std::vector<double> taken;
    for (double sample = 0; samples_.pop(sample);) taken.push_back(sample);
    return taken;
  }

 private:
  SpscQueue<double> samples_{1 << 17};
};

/// "*": the first one with a channel.
Result<const RigInput*> find_input(const Rig& rig, const std::string& name) {
  std::vector<std::string> names;
  for (const auto& input : rig.inputs) {
    if (input.channels.empty()) continue;
    if (name == "*" || name == input.name) return &input;
    names.push_back(input.name);
  }
  return fail(Errc::UnknownName, "--learn",
              fmt::format("the rig joins no input {}to a channel", name == "*" ? "" : "'" + name + "' "),
              names.empty() ? "" : fmt::format("there is {}", fmt::join(names, ", ")));
}

}  // namespace

Status learn_sensitivity(Rig& rig, const GraphSpec& instrument, const std::string& name, Backend& backend,
                         StreamRequest request) {
  const auto input = find_input(rig, name);
  if (!input) return tl::unexpected(input.error());
  request.in_channels = 1;
  request.in_map = {(*input)->channels.front() - 1};
  request.out_channels = 0;
  request.out_map.clear();
  InputReader reader;
  Guarded guarded{reader, {}};
  guarded.disable_sensor_watch();
  auto stream = backend.open(request, guarded);
  if (!stream) return tl::unexpected(stream.error());
  if (auto started = (*stream)->start(); !started) return started;
  fmt::print(stderr, "hit softly five times: {}\n", (*input)->name);
  SensorLearner learner{(*stream)->granted().format.sample_rate};
  const auto deadline = std::chrono::steady_clock::now() + 60s;
  for (int reported = 0; !learner.done() && std::chrono::steady_clock::now() < deadline;) {
    std::this_thread::sleep_for(20ms);
    learner.process(reader.take());
    if ((*stream)->state() == StreamState::Lost)
      return fail(Errc::Device, "", "the device was disconnected", "try again");
    for (; reported < learner.hits(); ++reported) fmt::print(stderr, "{} ", reported + 1);
    std::fflush(stderr);
  }
  fmt::print(stderr, "\n");
  (void)(*stream)->stop();
  const auto learnt = learner.result();
  if (!learnt) return tl::unexpected(learnt.error());
  fmt::print(stderr,
             "a soft hit reaches {:.1f} dB of the card, {:.0f} dB above the noise; it now "
             "counts as -20 dB\n",
             amplitude_to_db(learnt->soft), amplitude_to_db(learnt->soft / std::max(learnt->noise, 1e-9)));
  const auto* port = find_named(instrument.inputs, (*input)->name);
  return use_learnt(rig, (*input)->name, *learnt, port != nullptr ? dimension_of(*port) : Dimension{});
}

}  // namespace tactus::app
