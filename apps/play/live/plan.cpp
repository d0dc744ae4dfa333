#include "apps/play/live/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <iostream>
#include <thread>

#include "apps/cli/console.h"
#include "apps/cli/rig_files.h"
#include "apps/cli/target.h"
#include "apps/play/save_rig.h"
#include "engine/core/decibels.h"
#include "engine/core/named.h"
#include "engine/core/spsc_queue.h"
#include "engine/rig/check_rig.h"
#include "engine/rig/learn_sensor.h"
#include "latency/measured.h"

namespace tactus::app {
namespace {

/// The channels of the command line, from 0 on; without any those of the rig.
std::vector<int> channels_or(std::vector<int> given, const std::vector<int>& of_rig) {
  for (auto& channel : given) --channel;
  return given.empty() ? of_rig : given;
}

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
const RigInput& find_input(const Rig& rig, const std::string& name) {
  std::vector<std::string> names;
  for (const auto& input : rig.inputs) {
    if (input.channels.empty() || input.on_second_device()) continue;
    if (name == "*" || name == input.name) return input;
    names.push_back(input.name);
  }
  exit_with({Errc::UnknownName, "--learn",
             fmt::format("no input {}of the rig has a channel of the sound card",
                         name == "*" ? "" : "'" + name + "' "),
             names.empty() ? "" : fmt::format("there is {}", fmt::join(names, ", "))},
            kNo);
}

/// Asks the user to hit softly five times, and reads the sensor at `input` with nothing driven.
LearntSensor learn_sensitivity(const RigInput& input, Backend& backend, StreamRequest request) {
  using namespace std::chrono_literals;
  request.in_channels = 1;
  request.in_map = {input.channels.front() - 1};
  request.out_channels = 0;
  request.out_map.clear();
  InputReader reader;
  Guarded guarded{reader, {}};
  guarded.disable_sensor_watch();
  const auto stream = or_exit(backend.open(request, guarded), kNo);
  or_exit(stream->start(), kNo);
  fmt::print(stderr, "hit softly five times (Ctrl-C ends): {}\n", input.name);
  SensorLearner learner{stream->granted().format.sample_rate};
  const auto deadline = std::chrono::steady_clock::now() + 60s;
  for (int reported = 0; !learner.done() && std::chrono::steady_clock::now() < deadline;) {
    std::this_thread::sleep_for(20ms);
    learner.process(reader.take());
    if (stream->state() == StreamState::Lost)
      exit_with({Errc::Device, "", "the device was disconnected", "try again"}, kNo);
    for (; reported < learner.hits(); ++reported) fmt::print(stderr, "{} ", reported + 1);
    std::fflush(stderr);
  }
  fmt::print(stderr, "\n");
  (void)stream->stop();
  const auto learnt = or_exit(learner.result(), kNo);
  fmt::print(stderr,
             "a soft hit peaks at {:.1f} dBFS, {:.0f} dB above the noise; it now corresponds to -20 dB\n",
             amplitude_to_db(learnt.soft), amplitude_to_db(learnt.soft / std::max(learnt.noise, 1e-9)));
  return learnt;
}

/// Makes a plan, step by step; each step leaves what it found in `plan_`.
class Planner {
 public:
  explicit Planner(const LiveOptions& options) : options_(options) {
    const bool simulated = options.listen && options.in.empty();
    plan_.target = resolve_target(options.target, simulated ? FolderMeans::Scene : FolderMeans::Instrument);
    plan_.in = options.in;
    if (!options.listen) check_instrument();
  }

  LivePlan run() {
    read_rig();
    plan_.devices = choose_devices(options_, device_);
    error_if(options_.midi == "jack" && plan_.devices.backend->name() != "jack", "--midi",
             "MIDI over JACK needs a sound card over JACK",
             "choose --device jack:system, or MIDI by another backend, such as --midi alsa");
    plan_.request = request_for(plan_.devices, device_, options_.rate, options_.block, options_.periods);
    if (!options_.save_rig.empty()) make_rig();
    if (!options_.learn.empty()) learn();
    find_delay();
    make_performer();
    return std::move(plan_);
  }

 private:
  /// On a card the player and the hardware are the plant.
  void check_instrument() const {
    error_if(!options_.in.empty(), "--in", "the inputs of a sound card are the inputs of the instrument",
             "omit --in, or omit the sound card to simulate");
    if (!plan_.target.scene) return;
    const auto loaded = load_scene_leniently(plan_.target);
    const auto* part = loaded.scene ? loaded.scene->part("instrument") : nullptr;
    const bool known = part != nullptr && part->graph != nullptr;
    exit_with({Errc::BadArgument, plan_.target.file.generic_string(),
               "this is a scene, whose plant is simulated; on a sound card the hardware is the plant",
               known ? "play its instrument, " + *part->graph->file.file +
                           ", or add --listen to hear the simulation"
                     : "name the file of an instrument"},
              kUsage);
  }

  static void error_if(bool given, const char* option, const char* what, const char* remedy) {
    if (given) exit_with({Errc::BadArgument, option, what, remedy});
  }

  void read_rig() {
    plan_.rig_file = options_.rig.empty() ? options_.save_rig : options_.rig;
    error_if(options_.listen && !plan_.rig_file.empty(), "--listen", "a simulated scene does not use a rig",
             "omit one of them");
    error_if(options_.listen && !options_.record.empty(), "--record", "cannot be combined with --listen",
             "omit --listen to write the signals of a scene to files");
    error_if(!options_.rig.empty() && !options_.save_rig.empty(), "--save-rig", "a rig file is already given",
             "omit --rig, or change the rig file");
    for (const auto& [given, option] : {std::pair{!options_.guard.profile.empty(), "--profile"},
                                        {!options_.guard.volts.empty(), "--volts-per-full-scale"}})
      error_if(given && !plan_.rig_file.empty(), option,
               "cannot be combined with a rig, which names the actuator of each channel",
               "change the rig file; to raise a limit, use --raise-limit");
    // The rig says which actuator is on which channel of which card: no option may override it.
    for (const auto& [given, option] : {std::pair{!options_.in_channels.empty(), "--inputs"},
                                        {!options_.out_channels.empty(), "--outputs"}})
      error_if(given && !plan_.rig_file.empty(), option,
               options_.rig.empty()
                   ? "cannot be combined with --save-rig, which asks for the channels"
                   : "cannot be combined with --rig, which names the device and the channels",
               options_.rig.empty() ? "give the channels as answers"
                                    : "change the rig file, or create another with --save-rig");
    if (options_.rig.empty()) return;
    plan_.rig = open_rig(options_.rig);
    device_ = plan_.rig->device;
    for (const auto& [given, option] :
         {std::pair{!options_.backend.empty(), "--backend"},
          {!options_.device.empty() && options_.device != device_.output, "--device"},
          {!options_.input_device.empty() && options_.input_device != device_.input, "--input-device"}})
      error_if(given, option, "cannot be combined with --rig, which names the device and the channels",
               "change the rig file, or create another with --save-rig");
  }

  void make_rig() {
    const auto graph = or_exit(load_graph(plan_.target.file, plan_.target.root()), kBadFile);
    const auto& [request, devices] = std::tie(plan_.request, plan_.devices);
    plan_.rig = ask_for_rig(*graph,
                            {{},
                             request.device,
                             request.input_device,
                             {},
                             request.sample_rate,
                             request.block_frames,
                             request.periods},
                            devices.input.in_channels, devices.output.out_channels,
                            profile_places(plan_.rig_file), dialog_);
    or_exit(save_rig(*plan_.rig, plan_.rig_file, dialog_, options_.force), kBadFile);
    take_saved();
  }

  void take_saved() {
    fmt::print(stderr, "{} is written\n", plan_.rig_file);
    plan_.rig = open_rig(plan_.rig_file);  // with the limits of its profiles
  }

  void learn() {
    if (!plan_.rig)
      exit_with({Errc::Missing, "--learn", "there is no rig file to store the sensitivity in",
                 "give --rig, or --save-rig to create one"});
    const auto graph = or_exit(load_graph(plan_.target.file, plan_.target.root()), kBadFile);
    const auto input = find_input(*plan_.rig, options_.learn);
    const auto learnt = learn_sensitivity(input, *plan_.devices.backend, plan_.request);
    const auto* port = find_named(graph->inputs, input.name);
    const auto unit = port != nullptr ? port->dimension : Dimension{};
    or_exit(use_learnt(*plan_.rig, input.name, learnt, unit), kNo);
    const auto use = [&](Rig& rig) { (void)use_learnt(rig, input.name, learnt, unit); };
    if (auto errors = change_rig(plan_.rig_file, plan_.rig->device, use); !errors.empty())
      exit_with(std::move(errors), kBadFile);
    take_saved();
  }

  void find_delay() {
    const auto of_rig = plan_.rig ? plan_.rig->measured_delay : std::nullopt;
    if (!options_.delay.empty()) {
      plan_.delay = parse_delay(options_.delay);
      plan_.delay_assumed = true;
    } else if (of_rig) {
      plan_.delay = of_rig;
      plan_.delay_settings.block = plan_.rig->device.block;
      plan_.delay_settings.periods = plan_.rig->device.periods;
    } else if (!options_.listen) {
      take_stored_delay();
    }
    auto pad = plan_.rig ? plan_.rig->pad_delay : std::nullopt;
    if (!options_.pad_delay.empty()) pad = Seconds{parse_option(options_.pad_delay, "s", "pad-delay", 0, 10)};
    if (pad)
      plan_.padding_frames =
          or_exit(padding_frames(plan_.delay, *pad, *plan_.request.sample_rate,
                                 options_.pad_delay.empty() ? plan_.rig_file : "--pad-delay"),
                  kUsage);
  }

  /// The newest that was measured on this machine with what is asked for. What is left to the card is known
  /// when the stream is open: `check_delay`.
  void take_stored_delay() {
    const auto& request = plan_.request;
    const auto block = request.block_frames ? request.block_frames : plan_.devices.output.block_frames;
    const auto stored = MeasuredDelays::load();
    const auto* newest = stored.newest([&](const DelayKey& key) {
      return key.input == plan_.devices.input.id && key.output == plan_.devices.output.id &&
             key.sample_rate == *request.sample_rate &&
             key.block_frames == block.value_or(key.block_frames) &&
             (key.periods <= 0 || key.periods == request.periods.value_or(key.periods));
    });
    if (newest == nullptr) return;
    plan_.delay = newest->delay;
    plan_.delay_settings.block = newest->key.block_frames;
    if (newest->key.periods > 0) plan_.delay_settings.periods = newest->key.periods;
  }

  void make_performer() {
    auto& request = plan_.request;
    plan_.rate = *request.sample_rate;
    plan_.guard = options_.guard;
    plan_.speakers = std::min(2, plan_.devices.output.out_channels);
    plan_.controls = parse_settings(options_.set);
    if (plan_.rig)  // its values for the others
      for (const auto& [name, at, value] : plan_.rig->controls) plan_.controls.try_emplace(name, value);
    plan_.performer = options_.listen ? make_world(plan_) : make_instrument(plan_);
    const auto& performer = *plan_.performer;
    request.in_channels = static_cast<int>(performer.inputs.size());
    request.out_channels = static_cast<int>(performer.outputs.size());
    check_channels("input", performer.inputs, options_.in_channels, plan_.devices.input);
    check_channels("output", performer.outputs, options_.out_channels, plan_.devices.output);
    request.in_map = channels_or(options_.in_channels, performer.in_map);
    request.out_map = channels_or(options_.out_channels, performer.out_map);
  }

  /// Without a rig every port has a channel.
  void check_channels(const char* what, const std::vector<std::string>& ports, const std::vector<int>& given,
                      const Device& device) const {
    if (plan_.rig) return;
    const bool input = what[0] == 'i';
    const int channels =
        given.empty() ? (input ? device.in_channels : device.out_channels) : static_cast<int>(given.size());
    const auto count = static_cast<int>(ports.size());
    if (given.empty() ? count <= channels : count == channels) return;
    const auto there = given.empty() ? fmt::format("'{}' has {}", device.id, channels)
                                     : fmt::format("--{}s names {}", what, channels);
    exit_with(
        {Errc::BadArgument, given.empty() ? "--device" : fmt::format("--{}s", what),
         fmt::format("the instrument has {} {}s ({}), but {} channels", count, what, fmt::join(ports, ", "),
                     there),
         fmt::format("write a rig with --save-rig desk.toml, in which {} = {{ channel = \"none\" }} leaves "
                     "one out",
                     ports.empty() ? "NAME" : ports.back())},
        kUsage);
  }

  const LiveOptions& options_;
  Dialog dialog_{std::cin, std::cerr, options_.yes};
  Rig::Device device_;  ///< of the rig
  LivePlan plan_;
};

}  // namespace

LivePlan make_plan(const LiveOptions& options) { return Planner{options}.run(); }

std::string granted_text(const LivePlan& plan, const StreamGranted& granted) {
  const auto& asked = plan.request;
  const double rate = granted.format.sample_rate.value, ms = 1e3 / rate;
  const auto unless_asked = [](double wanted, double is, const char* unit) {
    return wanted != is ? fmt::format(" ({:g}{} requested)", wanted, unit) : "";
  };
  auto text = "device    " + granted.device;
  if (!granted.input_device.empty()) text += ", inputs from " + granted.input_device;
  text += fmt::format("\nrate      {:g} Hz{}\nblock     ", rate,
                      unless_asked(asked.sample_rate.value_or(Hertz{rate}).value, rate, ""));
  text += granted.block_frames > 0
              ? fmt::format("{} frames, {:.2f} ms", granted.block_frames, granted.block_frames * ms)
              : "changes from block to block";
  text += unless_asked(asked.block_frames.value_or(granted.block_frames), granted.block_frames, "");
  if (granted.periods > 0) text += fmt::format(", {} periods", granted.periods);
  text += unless_asked(asked.periods.value_or(granted.periods), granted.periods, " periods");
  if (const auto& second = granted.second)
    text += fmt::format(
        "\nsecond    {}: its inputs are {:g} ms later, its outputs play {:g} ms after they are computed",
        second->device, 1e3 * second->input_delay.value, 1e3 * second->output_delay.value);
  if (granted.input_latency_frames && granted.output_latency_frames)
    text += fmt::format("\ndriver    reports {:.2f} ms in and {:.2f} ms out (not measured)",
                        *granted.input_latency_frames * ms, *granted.output_latency_frames * ms);
  return text;
}

void check_delay(LivePlan& plan, const StreamGranted& granted) {
  if (!plan.delay) return;
  auto& settings = plan.delay_settings;
  const auto why = settings.why_invalid(granted);
  if (why.empty()) {
    settings.block = granted.block_frames;
    if (granted.periods > 0) settings.periods = granted.periods;
    settings.padded = plan.padding_frames > 0;
    return;
  }
  if (plan.padding_frames > 0)
    exit_with({Errc::BadArgument, plan.rig_file, why + ": the padding is unknown",
               "set the device to that block size, or measure again"},
              kUsage);
  plan.delay.reset();
  fmt::print(stderr, "warning: {}; the delay is treated as unknown\n", why);
}

std::string delay_text(const LivePlan& plan) {
  if (!plan.delay)
    return "delay     not measured: assumed to be 0; " + delay_remedy(plan.devices.output.id, plan.rig_file);
  auto text = fmt::format("delay     {:.2f} ms {}", 1e3 * plan.delay->value,
                          plan.delay_assumed ? "assumed (--delay)" : "measured");
  const double padding_s = plan.padding_frames / plan.request.sample_rate->value;
  if (plan.padding_frames > 0)
    text += fmt::format(", extended to {:.2f} ms by {} frames", 1e3 * (plan.delay->value + padding_s),
                        plan.padding_frames);
  return text;
}

}  // namespace tactus::app
