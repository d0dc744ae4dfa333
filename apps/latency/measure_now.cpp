#include "apps/latency/measure_now.h"

#include <fmt/format.h>

#include "apps/cli/console.h"
#include "apps/cli/interrupts.h"

namespace tactus::app {
namespace {

struct Interrupted {};

}  // namespace

Result<std::optional<Measurement>> measure_now(Backend& backend, const MeasureSettings& settings) {
  Progress bar{"measuring"};
  try {
    auto measured = measure(backend, settings, [&](double share, const std::string& what) {
      if (interrupted()) throw Interrupted{};  // the stream ends with its owner, with a block of zeros
      bar(share, what);
    });
    if (!measured) return tl::unexpected(measured.error());
    return std::optional{std::move(*measured)};
  } catch (const Interrupted&) {
    return std::optional<Measurement>{};
  }
}

std::string source_in_words(const MeasureSettings& settings, const StreamGranted& granted) {
  const auto& wanted = settings.request;
  auto text = granted.device;
  if (!granted.input_device.empty()) text += " and " + granted.input_device;
  text += fmt::format(", {:g} kHz, ", granted.format.sample_rate.value / 1e3);
  text +=
      granted.block_frames > 0 ? fmt::format("{} frames a block", granted.block_frames) : "changing blocks";
  if (wanted.block_frames && *wanted.block_frames != granted.block_frames)
    text += fmt::format(" ({} were asked for)", *wanted.block_frames);
  if (granted.periods > 0) text += fmt::format(", {} periods", granted.periods);
  return text + fmt::format("; output {} to input {}", settings.output + 1, settings.input + 1);
}

}  // namespace tactus::app
