#include "apps/play/live/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <sstream>

#include "apps/cli/commands.h"
#include "apps/cli/console.h"
#include "apps/play/live/learn_sensor.h"
#include "apps/play/save_rig.h"
#include "engine/rig/check_rig.h"
#include "latency/measured.h"

namespace tactus::app {
namespace {

std::vector<int> from_zero(std::vector<int> channels) {
  for (auto& channel : channels) --channel;
  return channels;
}

/// A quantity of the command line, else of the rig, else nothing.
Result<std::optional<double>> chosen(const std::string& text, const char* unit, const char* option,
                                     std::optional<double> of_rig) {
  if (text.empty()) return of_rig;
  const auto value = parse_option(text, unit, option);
  if (!value) return tl::unexpected(value.error());
  return *value;
}

/// The control values of the rig, overridden by the command line.
Result<std::map<std::string, ControlValue>> settings_of(const LiveOptions& options, const Rig* rig) {
  auto settings = parse_settings(options.set);
  if (!settings || rig == nullptr) return settings;
  for (const auto& control : rig->controls)
    settings->try_emplace(control.name, control.value.bare
                                            ? ControlValue{control.value.si}
                                            : ControlValue{control.value.si, control.value.unit.dimension});
  return settings;
}

/// Makes a plan, step by step; each step leaves what it found in `plan_`.
class Planner {
 public:
  explicit Planner(const LiveOptions& options)
      : options_(options),
        file_(resolve_target(options.target, options.listen ? "scene.toml" : "instrument.toml")),
        root_(root_of(file_)) {}

  tl::expected<Plan, Refusal> run() {
    for (const auto step :
         {&Planner::read_rig, &Planner::choose_devices, &Planner::make_request, &Planner::ask_for_rig,
          &Planner::learn, &Planner::find_delay, &Planner::make_performer})
      if (auto refusal = (this->*step)()) return tl::unexpected(std::move(*refusal));
    return std::move(plan_);
  }

 private:
  using Refused = std::optional<Refusal>;
  static Refusal refuse(Error error, int exit = kUsage) { return {{std::move(error)}, exit}; }
  static Refusal refuse(std::vector<Error> errors, int exit) { return {std::move(errors), exit}; }

  const Rig* rig() const { return plan_.rig ? &*plan_.rig : nullptr; }
  std::string rig_file() const { return options_.rig.empty() ? options_.save_rig : options_.rig; }

  Refused read_rig() {
    if (options_.listen && !rig_file().empty())
      return refuse(
          {Errc::BadArgument, "--listen", "a simulated world needs no rig", "leave one of them out"});
    if (options_.listen && !options_.record.empty())
      return refuse({Errc::BadArgument, "--record", "does not go with --listen",
                     "tactus play without --listen writes what a scene does"});
    if (!options_.rig.empty() && !options_.save_rig.empty())
      return refuse(
          {Errc::BadArgument, "--save-rig", "there is a rig already", "leave --rig out, or change its file"});
    plan_.rig_file = rig_file();
    if (options_.rig.empty()) return {};
    auto read = load_rig(options_.rig, root_);
    if (!read) return refuse(std::move(read.error()), kBadFile);
    plan_.rig = std::move(*read);
    // What hangs on which channel of which card is the rig's to say: nothing may go around it.
    const auto& device = plan_.rig->device;
    for (const auto& [given, option] :
         {std::pair{!options_.in.empty(), "--inputs"},
          {!options_.out.empty(), "--outputs"},
          {!options_.device.empty() && options_.device != device.output, "--device"},
          {!options_.input_device.empty() && options_.input_device != device.input, "--input-device"}})
      if (given)
        return refuse({Errc::BadArgument, option, "cannot be combined with --rig, which assigns the channels",
                       "change the rig file, or make another with --save-rig"});
    return {};
  }

  Refused choose_devices() {
    const auto or_rig = [&](const std::string& text, std::string Rig::Device::*of) {
      return text.empty() && rig() != nullptr ? rig()->device.*of : text;
    };
    auto devices = app::choose_devices(options_.backend, or_rig(options_.device, &Rig::Device::output),
                                       or_rig(options_.input_device, &Rig::Device::input));
    if (!devices) return refuse(devices.error(), devices.error().where == "--backend" ? kUsage : kDevice);
    plan_.devices = std::move(*devices);
    return {};
  }

  Refused make_request() {
    auto& request = plan_.request;
    const auto& device = plan_.devices.output;
    request.device = device.id;
    if (plan_.devices.input.id != device.id) request.input_device = plan_.devices.input.id;
    const auto of_rig = rig() ? rig()->device.rate : std::nullopt;
    const auto rate =
        chosen(options_.rate, "Hz", "rate", of_rig ? std::optional{of_rig->value} : std::nullopt);
    if (!rate) return refuse(rate.error());
    request.sample_rate = Hertz{rate->value_or(device.default_rate.value)};
    request.block_frames = options_.block || rig() == nullptr ? options_.block : rig()->device.block;
    request.periods = options_.periods || rig() == nullptr ? options_.periods : rig()->device.periods;
    return {};
  }

  Refused ask_for_rig() {
    if (options_.save_rig.empty()) return {};
    const auto graph = load_graph(file_, root_);
    if (!graph) return refuse(graph.error(), kBadFile);
    Rig::Device device;
    device.output = plan_.request.device;
    device.input = plan_.request.input_device;
    device.rate = plan_.request.sample_rate;
    device.block = plan_.request.block_frames;
    device.periods = plan_.request.periods;
    RigInterview interview{**graph, device, plan_.devices.input.in_channels,
                           plan_.devices.output.out_channels, root_};
    auto rig = hold_interview(interview, std::cin, std::cerr, options_.yes);
    if (!rig) return refuse(rig.error());
    plan_.rig = std::move(*rig);
    return save(options_.force);
  }

  Refused save(bool force) {
    std::istringstream empty;
    std::istream& asked = options_.yes ? empty : std::cin;
    const auto saved = save_rig(*plan_.rig, plan_.rig_file, asked, std::cerr, force);
    if (!saved) return refuse(saved.error(), kBadFile);
    fmt::print(stderr, "{} is written\n", plan_.rig_file);
    return {};
  }

  Refused learn() {
    if (options_.learn.empty()) return {};
    if (rig() == nullptr)
      return refuse({Errc::Missing, "--learn", "there is no rig to keep the sensitivity in",
                     "give --rig, or --save-rig to make one"});
    const auto graph = load_graph(file_, root_);
    if (!graph) return refuse(graph.error(), kBadFile);
    auto learnt =
        learn_sensitivity(*plan_.rig, **graph, options_.learn, *plan_.devices.backend, plan_.request);
    if (!learnt) return refuse(learnt.error(), kNo);
    return save(true);
  }

  Refused find_delay() {
    const auto of_rig = rig() ? rig()->measured_delay : std::nullopt;
    auto measured =
        chosen(options_.delay, "s", "delay", of_rig ? std::optional{of_rig->value} : std::nullopt);
    if (!measured) return refuse(measured.error());
    plan_.delay_s = *measured;
    if (options_.delay.empty() && of_rig) {
      plan_.delay_block = rig()->device.block;
      plan_.delay_periods = rig()->device.periods;
    }
    if (!plan_.delay_s && !options_.listen) take_kept_delay();
    const auto to = rig() ? rig()->pad_delay : std::nullopt;
    const auto pad =
        chosen(options_.pad_delay, "s", "pad-delay", to ? std::optional{to->value} : std::nullopt);
    if (!pad) return refuse(pad.error());
    if (!*pad) return {};
    const auto frames = padding_frames(plan_.delay_s ? std::optional{Seconds{*plan_.delay_s}} : std::nullopt,
                                       Seconds{**pad}, *plan_.request.sample_rate,
                                       options_.pad_delay.empty() ? plan_.rig_file : "--pad-delay");
    if (!frames) return refuse(frames.error());
    plan_.padding_frames = *frames;
    return {};
  }

  /// The newest that was measured on this machine with what is asked for. What is left to the card is known
  /// when the stream is open: `check_delay`.
  void take_kept_delay() {
    const auto& request = plan_.request;
    const auto block = request.block_frames ? request.block_frames : plan_.devices.output.block_frames;
    const auto kept = MeasuredDelays::load();
    const MeasuredDelay* newest = nullptr;
    for (const auto& delay : kept.all()) {
      const auto& key = delay.key;
      if (key.input != plan_.devices.input.id || key.output != plan_.devices.output.id ||
          !(key.sample_rate == *request.sample_rate) ||
          key.block_frames != block.value_or(key.block_frames) ||
          (key.periods > 0 && key.periods != request.periods.value_or(key.periods)))
        continue;
      if (newest == nullptr || delay.when >= newest->when) newest = &delay;
    }
    if (newest == nullptr) return;
    plan_.delay_s = newest->delay.value;
    plan_.delay_block = newest->key.block_frames;
    if (newest->key.periods > 0) plan_.delay_periods = newest->key.periods;
  }

  Refused make_performer() {
    auto settings = settings_of(options_, rig());
    if (!settings) return refuse(settings.error());
    const auto rate = *plan_.request.sample_rate;
    const auto delay = plan_.delay_s ? std::optional{Seconds{*plan_.delay_s}} : std::nullopt;
    const Seconds whole{plan_.delay_s.value_or(0.0) + plan_.padding_frames / rate.value};
    auto performer = options_.listen
                         ? make_world({file_, root_, rate, delay, std::move(*settings), options_.guard,
                                       std::min(2, plan_.devices.output.out_channels)})
                         : make_instrument({file_, root_, rate, whole, plan_.padding_frames,
                                            std::move(*settings), plan_.rig, options_.guard});
    if (!performer) return refuse(performer.error(), kBadFile);
    plan_.performer = std::move(*performer);
    auto& request = plan_.request;
    request.in_channels = static_cast<int>(plan_.performer->inputs().size());
    request.out_channels = static_cast<int>(plan_.performer->outputs().size());
    request.in_map = options_.in.empty() ? plan_.performer->in_map() : from_zero(options_.in);
    request.out_map = options_.out.empty() ? plan_.performer->out_map() : from_zero(options_.out);
    return {};
  }

  const LiveOptions& options_;
  std::filesystem::path file_, root_;
  Plan plan_;
};

}  // namespace

tl::expected<Plan, Refusal> make_plan(const LiveOptions& options) { return Planner{options}.run(); }

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
    text += fmt::format(" ({} periods were asked for)", *asked.periods);
  if (granted.input_latency_frames && granted.output_latency_frames)
    text += fmt::format("\ndriver    reports {:.2f} ms in and {:.2f} ms out (not measured)",
                        *granted.input_latency_frames * ms, *granted.output_latency_frames * ms);
  return text;
}

Status check_delay(Plan& plan, const StreamGranted& granted) {
  const int block = plan.delay_block.value_or(granted.block_frames);
  const int periods = granted.periods > 0 ? plan.delay_periods.value_or(granted.periods) : 0;
  if (!plan.delay_s || (block == granted.block_frames && periods == granted.periods)) return {};
  const auto what =
      block != granted.block_frames
          ? fmt::format("the delay was measured with {} frames a block, and there are {}", block,
                        granted.block_frames)
          : fmt::format("the delay was measured with {} periods, and there are {}", periods, granted.periods);
  if (plan.padding_frames > 0)
    return fail(Errc::BadArgument, plan.rig_file, what + ": the padding is unknown",
                "set the device to that block size, or measure again");
  plan.delay_s.reset();
  fmt::print(stderr, "warning: {}; it counts as unknown\n", what);
  return {};
}

std::string delay_in_words(const Plan& plan) {
  if (!plan.delay_s) return "delay     not measured: the instrument assumes 0; run tactus latency measure";
  const double padded = plan.padding_frames / plan.request.sample_rate->value;
  return fmt::format("delay     {:.2f} ms measured{}", 1e3 * *plan.delay_s,
                     plan.padding_frames > 0
                         ? fmt::format(", held at {:.2f} ms by {} frames more",
                                       1e3 * (*plan.delay_s + padded), plan.padding_frames)
                         : "");
}

}  // namespace tactus::app
