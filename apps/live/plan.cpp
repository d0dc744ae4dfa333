#include "apps/live/plan.h"

#include <fmt/format.h>

#include <algorithm>

#include "apps/commands.h"
#include "apps/console.h"
#include "engine/scene/check_rig.h"

namespace tactus::app {
namespace {

std::vector<int> from_zero(std::vector<int> channels) {
  for (auto& channel : channels) --channel;
  return channels;
}

/// What a number with a unit on the command line says, or the rig, or nobody.
Result<std::optional<double>> chosen(const std::string& text, const char* unit, const char* option,
                                     std::optional<double> of_rig) {
  if (text.empty()) return of_rig;
  const auto value = parse_option(text, unit, option);
  if (!value) return tl::unexpected(value.error());
  return *value;
}

Checked<std::optional<Rig>> read_rig(const LiveOptions& options, const std::filesystem::path& root) {
  if (options.rig.empty()) return std::optional<Rig>{};
  auto rig = load_rig(options.rig, root);
  if (!rig) return tl::unexpected(rig.error());
  return std::optional{std::move(*rig)};
}

/// The knobs as the rig left them, unless the command line says otherwise.
Result<std::map<std::string, ControlValue>> settings_of(const LiveOptions& options, const Rig* rig) {
  auto settings = parse_settings(options.set);
  if (!settings || rig == nullptr) return settings;
  for (const auto& control : rig->controls)
    settings->try_emplace(control.name, control.value.bare
                                            ? ControlValue{control.value.si}
                                            : ControlValue{control.value.si, control.value.unit.dimension});
  return settings;
}

}  // namespace

tl::expected<Plan, Refusal> make_plan(const LiveOptions& options) {
  const auto refuse = [](auto errors, int exit) {
    if constexpr (std::is_same_v<decltype(errors), Error>)
      return tl::unexpected(Refusal{{std::move(errors)}, exit});
    else
      return tl::unexpected(Refusal{std::move(errors), exit});
  };
  const auto file = resolve_target(options.target, options.listen ? "scene.toml" : "instrument.toml");
  const auto root = root_of(file);
  const auto rig = read_rig(options, root);
  if (!rig) return refuse(rig.error(), kBadFile);
  const Rig* known = *rig ? &**rig : nullptr;
  const auto or_rig = [&](const std::string& text, std::string Rig::Device::*of) {
    return text.empty() && known != nullptr ? known->device.*of : text;
  };
  auto devices = choose_devices(options.backend, or_rig(options.device, &Rig::Device::output),
                                or_rig(options.input_device, &Rig::Device::input));
  if (!devices) return refuse(devices.error(), kDevice);

  StreamRequest request;
  request.device = devices->output.id;
  if (devices->input.id != devices->output.id) request.input_device = devices->input.id;
  const auto rate =
      chosen(options.rate, "Hz", "rate",
             known && known->device.rate ? std::optional{known->device.rate->value} : std::nullopt);
  if (!rate) return refuse(rate.error(), kUsage);
  request.sample_rate = Hertz{rate->value_or(devices->output.default_rate.value)};
  request.block_frames = options.block || known == nullptr ? options.block : known->device.block;
  request.periods = options.periods || known == nullptr ? options.periods : known->device.periods;
  const auto measured =
      chosen(options.delay, "s", "delay",
             known && known->measured_delay ? std::optional{known->measured_delay->value} : std::nullopt);
  if (!measured) return refuse(measured.error(), kUsage);
  const auto pad = chosen(options.pad_delay, "s", "pad-delay",
                          known && known->pad_delay ? std::optional{known->pad_delay->value} : std::nullopt);
  if (!pad) return refuse(pad.error(), kUsage);
  auto settings = settings_of(options, known);
  if (!settings) return refuse(settings.error(), kUsage);

  int padding = 0;
  if (*pad) {
    const auto frames =
        padding_frames(*measured ? std::optional{Seconds{**measured}} : std::nullopt, Seconds{**pad},
                       *request.sample_rate, options.pad_delay.empty() ? options.rig : "--pad-delay");
    if (!frames) return refuse(frames.error(), kUsage);
    padding = *frames;
  }
  const auto as_seconds = [](std::optional<double> value) {
    return value ? std::optional{Seconds{*value}} : std::nullopt;
  };
  auto performer =
      options.listen
          ? make_world({file, root, *request.sample_rate, as_seconds(*measured), std::move(*settings),
                        options.guard, std::min(2, devices->output.out_channels)})
          : make_instrument({file, root, *request.sample_rate,
                             Seconds{pad->value_or(measured->value_or(0.0))}, padding, std::move(*settings),
                             *rig, options.guard});
  if (!performer) return refuse(performer.error(), kBadFile);
  request.in_channels = static_cast<int>((*performer)->inputs().size());
  request.out_channels = static_cast<int>((*performer)->outputs().size());
  request.in_map = options.in.empty() ? (*performer)->in_map() : from_zero(options.in);
  request.out_map = options.out.empty() ? (*performer)->out_map() : from_zero(options.out);
  return Plan{std::move(*devices), std::move(request), std::move(*performer), *measured, padding};
}

std::string granted_in_words(const Plan& plan, const StreamGranted& granted) {
  const auto& asked = plan.request;
  const auto& format = granted.format;
  const double ms = 1e3 / format.sample_rate.value;
  std::string text = fmt::format("device    {}", granted.device);
  if (!granted.input_device.empty()) text += fmt::format(", inputs from {}", granted.input_device);
  text += fmt::format("\nrate      {:g} Hz{}", format.sample_rate.value,
                      asked.sample_rate && !(*asked.sample_rate == format.sample_rate)
                          ? fmt::format(" ({:g} were asked for)", asked.sample_rate->value)
                          : "");
  text += granted.block_frames > 0 ? fmt::format("\nblock     {} frames, {:.2f} ms", granted.block_frames,
                                                 granted.block_frames * ms)
                                   : "\nblock     changes from block to block";
  if (asked.block_frames && *asked.block_frames != granted.block_frames)
    text += fmt::format(" ({} were asked for)", *asked.block_frames);
  if (granted.periods > 0) text += fmt::format(", {} periods", granted.periods);
  if (asked.periods && *asked.periods != granted.periods)
    text += fmt::format(" ({} were asked for)", *asked.periods);
  if (granted.input_latency_frames && granted.output_latency_frames)
    text += fmt::format("\ndriver    says {:.2f} ms in and {:.2f} ms out; tactus latency measures it",
                        *granted.input_latency_frames * ms, *granted.output_latency_frames * ms);
  return text;
}

std::string delay_in_words(const Plan& plan) {
  if (!plan.delay_s) return "delay     not measured: the instrument reckons with none";
  const double padded = plan.padding_frames / plan.request.sample_rate->value;
  return fmt::format("delay     {:.2f} ms measured{}", 1e3 * *plan.delay_s,
                     plan.padding_frames > 0
                         ? fmt::format(", held at {:.2f} ms by {} frames more",
                                       1e3 * (*plan.delay_s + padded), plan.padding_frames)
                         : "");
}

}  // namespace tactus::app
