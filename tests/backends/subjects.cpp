#include "backends/loop/loop.h"
#include "backends/offline/offline.h"
#include "backends/simulated/simulated.h"
#include "tests/backends/every_backend.h"
#include "tests/support/graph_runner.h"

// The backends that need no hardware.

namespace tactus::test {
namespace {

StreamRequest two_in_one_out() {
  StreamRequest request;
  request.in_channels = 2;
  request.out_channels = 1;
  return request;
}

}  // namespace

Subject offline_subject() {
  Subject subject;
  subject.heard = std::make_shared<std::vector<double>>();
  OfflineJob job;
  job.frames = Subject::kFrames;
  job.sink.channels = 1;
  job.sink.write =
      job.sink.finish = [heard = subject.heard](const double* const* channels, int frames) -> Status {
    heard->insert(heard->end(), channels[0], channels[0] + frames);
    return {};
  };
  subject.backend = std::make_unique<OfflineBackend>(job);
  subject.request = two_in_one_out();
  return subject;
}

Subject simulated_subject() {
  std::shared_ptr<Player> plant = engine_of(R"(
format = 1
[inputs]
drive = { unit = "full scale" }
[nodes]
cone = { type = "one_pole", in = "drive", cutoff = "100 Hz" }
[outputs]
microphone = { from = "cone + 0.25" }
ribbon     = { from = "cone" }
)");
  Subject subject;
  subject.heard = std::make_shared<std::vector<double>>();
  const auto listener = [heard = subject.heard](const ClosedLoop::Block& piece) {
    heard->insert(heard->end(), piece.drives[0], piece.drives[0] + piece.frames);
  };
  subject.backend = std::make_unique<SimulatedBackend>(
      SimulatedWorld{.plant = *plant, .delay_frames = 100, .frames = Subject::kFrames, .listener = listener});
  subject.request = two_in_one_out();
  subject.stands_on.push_back(std::move(plant));
  return subject;
}

Subject loop_subject() {
  Subject subject;
  subject.backend = std::make_unique<LoopBackend>(LoopBackend::Pace::AsFastAsPossible);
  subject.request = two_in_one_out();
  subject.live = true;
  return subject;
}

}  // namespace tactus::test
