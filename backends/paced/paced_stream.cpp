#include "backends/paced/paced_stream.h"

#include <fmt/format.h>

#include <utility>

#include "backends/realtime_thread.h"

namespace tactus {
namespace {

void run(PacedLine& line) {
  (void)become_realtime(line.settings.priority);
  if (line.settings.core) (void)stay_on_core(*line.settings.core);
  use_stack();
  SystemTimer timer{line.settings.wait};
  std::vector<const float*> in(index(line.device->in_channels()));
  std::vector<float*> out(index(line.device->out_channels()));
  line.device->expect_frames(true);
  line.loop.run(timer, line.stops, [&](const float* inputs, float* outputs, const PacedFrame& frame) {
    for (std::size_t c = 0; c < in.size(); ++c) in[c] = inputs + c;
    for (std::size_t c = 0; c < out.size(); ++c) out[c] = outputs + c;
    if (frame.skipped > 0) {
      line.card->gap(Gap::Output, CardCallback::GapLength::Counted);
      line.card->lost(frame.skipped);
    }
    if (frame.from_zero) line.card->restart_from_zero();
    line.card->block(in.data(), out.data(), static_cast<int>(out.size()), 1);
  });
  line.device->expect_frames(false);
}

std::string us(LatenessHistogram::Time time) {
  return fmt::format("{:.0f} us", 1e-3 * static_cast<double>(time.count()));
}

}  // namespace

std::vector<Hertz> paced_rates() {
  std::vector<Hertz> rates;
  for (const double khz : {1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20}) rates.push_back(Hertz{1000 * khz});
  return rates;
}

Result<std::unique_ptr<Stream>> PacedStream::open(std::unique_ptr<FrameDevice> device, StreamGranted granted,
                                                  const PacedSettings& settings, GuardedBlocks& processor) {
  if (settings.core)
    if (auto status = check_core(*settings.core); !status) return tl::unexpected(status.error());
  granted.block_frames = granted.format.max_frames = 1;
  if (auto status = processor.prepare(granted.format); !status) return tl::unexpected(status.error());
  const int rate = static_cast<int>(granted.format.sample_rate.value);
  auto line = std::make_shared<PacedLine>(std::move(device), rate, settings);
  StreamRequest request;  // the device has the channels in their order
  return std::unique_ptr<Stream>{new PacedStream{std::move(line), std::move(granted), request, processor}};
}

std::string PacedStream::take_note() {
  const auto& loop = line_->loop;
  if (loop.frames() < 2 * loop.rate_hz()) return {};
  const auto most_us = loop.lateness().longest().count() / 1000;
  if (noted_us_ > 0 && most_us < 2 * noted_us_ && loop.skipped() < 2 * noted_skipped_ + 1) return {};
  noted_us_ = std::max<std::int64_t>(most_us, 1);
  noted_skipped_ = loop.skipped();
  const auto priority = health().realtime_priority;
  return fmt::format(
      "{} frames of {:.0f} us{}: late by {} (half of them), {} (99.9 %), {} (most); outputs written after {} "
      "(half), {} (most); {} skipped",
      loop.frames(), 1e6 / loop.rate_hz(), priority > 0 ? "" : ", without real-time priority",
      us(loop.lateness().quantile(0.5)), us(loop.lateness().quantile(0.999)), us(loop.lateness().longest()),
      us(loop.answer().quantile(0.5)), us(loop.answer().longest()), loop.skipped());
}

Status PacedStream::start_library() {
  line_->stops = false;
  thread_ = std::thread{[line = line_] { run(*line); }};
  return {};
}

Status PacedStream::stop_library(bool) {
  line_->stops = true;
  if (thread_.joinable()) thread_.join();
  return {};
}

}  // namespace tactus
