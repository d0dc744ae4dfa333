#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "apps/cli/console.h"
#include "apps/render/render.h"
#include "apps/render/render_events.h"
#include "engine/dsp/delays/resample.h"
#include "engine/nodes/table.h"
#include "engine/scene/measures/events.h"

namespace tactus::app {

Samples resample(const Samples& samples, Hertz to) {
  if (to == samples.sample_rate) return samples;
  const auto frames = std::llround(static_cast<double>(samples.frames()) / (samples.sample_rate / to));
  Samples result{to, {}};
  for (const auto& channel : samples.channels)
    result.channels.push_back(tactus::resample(channel, samples.sample_rate, to, 0, frames));
  return result;
}

RenderFiles::RenderFiles(const RenderOptions& options, const std::vector<std::string>& outputs,
                         const std::vector<std::string>& sounds, Hertz sample_rate)
    : events_(options.events) {
  if (!options.sound.empty() && sounds.empty())
    exit_with({Errc::BadArgument, "--sound", "this instrument has no monitor output",
               "omit --sound, or give an output the kind \"audio\""});
  for (const auto& sound : sounds)
    sounds_.push_back(static_cast<std::size_t>(std::ranges::find(outputs, sound) - outputs.begin()));
  const auto create = [&](const std::string& file, const auto& channels) -> std::optional<WavWriter> {
    if (file.empty()) return std::nullopt;
    const int count = static_cast<int>(channels.size());
    return or_exit(WavWriter::create(file, sample_rate, count, options.encoding()));
  };
  out_ = create(options.out, outputs);
  sound_ = create(options.sound, sounds);
}

Status RenderFiles::write(const double* const* outputs, int frames) {
  if (out_)
    if (auto status = out_->write(outputs, frames); !status) return status;
  if (!sound_) return {};
  std::vector<const double*> sounds;
  for (const auto output : sounds_) sounds.push_back(outputs[output]);
  return sound_->write(sounds.data(), frames);
}

void RenderFiles::close(const Json& events) {
  for (auto* writer : {&out_, &sound_})
    if (*writer) or_exit((*writer)->close());
  if (!events_.empty()) or_exit(write_json(events_, events));
}

namespace {

/// What reads the input file at the rate asked for, followed by silence; without a file only silence. Only a
/// file at another rate is read as a whole.
OfflineInput open_input(const RenderOptions& options) {
  if (options.in.empty()) {
    const auto read = [](double* const* to, int count) { std::fill_n(to[0], count, 0.0); };
    return {options.rate.empty() ? 48_kHz : parse_rate(options.rate), 1, 0, read};
  }
  const auto file = std::make_shared<WavReader>(or_exit(WavReader::open(options.in)));
  const auto rate = options.rate.empty() ? file->sample_rate() : parse_rate(options.rate);
  if (rate == file->sample_rate())
    return {rate, file->channels(), file->frames(),
            [file](double* const* to, int count) { (void)file->read(to, count); }};
  const auto samples = std::make_shared<Samples>(resample(or_exit(read_wav(options.in)), rate));
  const auto read = [samples, at = std::int64_t{0}](double* const* to, int count) mutable {
    const auto there = std::clamp<std::int64_t>(samples->frames() - at, 0, count);
    for (std::size_t c = 0; c < samples->channels.size(); ++c) {
      std::copy_n(samples->channels[c].data() + at, there, to[c]);
      std::fill(to[c] + there, to[c] + count, 0.0);
    }
    at += there;
  };
  return {rate, file->channels(), samples->frames(), read};
}

/// With as many frames as are asked for.
OfflineInput input_of(const RenderOptions& options) {
  auto input = open_input(options);
  const double rate = input.sample_rate.value;
  if (!(rate >= 1e3 && rate <= 768e3))
    exit_with(
        {Errc::OutOfRange, options.in, fmt::format("cannot run at {} Hz", rate), "choose 1 kHz to 768 kHz"});
  if (options.duration.empty() && !options.in.empty()) return input;
  const auto duration =
      options.duration.empty() ? 10_s : parse_duration(options.duration, Seconds{kLongestTime_s});
  input.frames = static_cast<std::int64_t>(frames_in(duration, input.sample_rate));
  return input;
}

struct Rendered {
  std::vector<std::string> outputs, sounds;  ///< names; of the monitor output
  Json events;
  GuardReport guard;
  std::vector<NetworkReport> networks;
};

/// Nothing of the signals is kept: the memory needed does not grow with the duration.
Rendered run(Player& engine, const OfflineInput& input, const std::vector<std::string>& taps,
             const LimitBook& limits, const RenderOptions& options) {
  const auto& plan = engine.plan();
  Guarded guarded{engine, guarded_channels(plan, limits)};
  Rendered rendered{output_names(plan), sound_names(plan), {}, {}, {}};
  RenderFiles files{options, rendered.outputs, rendered.sounds, input.sample_rate};
  EventCollector events{taps, input.sample_rate};
  std::vector<const double*> tapped(taps.size());
  Progress progress{"rendering"};
  StepTimes times{engine, timed_every(static_cast<double>(input.frames))};
  const auto take = [&, done = 0.0](const double* const* channels, int count) mutable {
    times.add(count);
    for (std::size_t t = 0; t < tapped.size(); ++t) tapped[t] = engine.tap(static_cast<int>(t));
    events.add(tapped, count);
    progress((done += count) / static_cast<double>(input.frames));
    return files.write(channels, count);
  };
  const int outputs = static_cast<int>(rendered.outputs.size());
  or_exit(run_offline(guarded, input, outputs, {options.block.value_or(256)}, take));
  rendered.events = events.json();
  files.close(rendered.events);
  rendered.guard = report_of(guarded, plan, limits);
  rendered.networks = report_networks(plan, times.ns_per_frame());
  return rendered;
}

void print(const RenderOptions& options, const std::string& name, const OfflineInput& input,
           const Player& engine, const Rendered& rendered) {
  const auto rate = input.sample_rate;
  const int inputs = engine.in_channels();
  fmt::print("{}: {:.3f} s at {:g} Hz, {} events\n", name, static_cast<double>(input.frames) / rate.value,
             rate.value, count_of(rendered.events));
  if (input.channels != inputs && !options.in.empty())
    fmt::print(
        "the file has {} channels, the instrument {} inputs: {}\n", input.channels, inputs,
        input.channels > inputs ? "only the first channels were used" : "the other inputs were silent");
  if (!options.out.empty()) fmt::print("{}: {}\n", options.out, fmt::join(rendered.outputs, ", "));
  if (!options.sound.empty()) fmt::print("{}: {}\n", options.sound, fmt::join(rendered.sounds, ", "));
  if (!options.events.empty()) fmt::print("{}: the events\n", options.events);
  if (engine.bad_input_samples() > 0)
    fmt::print("{} non-finite input samples replaced by zero\n", engine.bad_input_samples());
  for (const auto& fault : engine.faults())
    fmt::print("fault: {} produced non-finite values {} times\n", fault.path, fault.count);
  if (!rendered.guard.idle() || rendered.guard.any_raised()) print_guard(rendered.guard, rate);
  print_networks(rendered.networks);
}

}  // namespace

int render_instrument(const RenderOptions& options, const Target& target) {
  const auto loaded = load_graph_leniently(target.file, target.root());
  if (loaded.spec == nullptr) throw CommandError{loaded.errors};
  const auto input = input_of(options);
  CompileOptions compiling;
  compiling.sample_rate = input.sample_rate;
  compiling.controls = parse_settings(options.set);
  if (!options.delay.empty()) compiling.system_delay = parse_delay(options.delay);
  compiling.taps = event_taps(*loaded.spec, standard_nodes());
  const auto limits = apply(options.guard, {});
  Player engine{or_exit(compile(loaded, standard_nodes(), compiling))};
  announce_raises(limits, engine.plan());
  const auto& name = loaded.spec->name;
  if (!options.delay.empty()) announce_delay(*loaded.spec, compiling.system_delay.value);
  const auto rendered = run(engine, input, compiling.taps, limits, options);
  const int exit_code = rendered.guard.faded() ? kNo : kDone;
  if (!options.json) return print(options, name, input, engine, rendered), exit_code;
  print_json({{"instrument", name},
              {"sample_rate_hz", input.sample_rate.value},
              {"frames", input.frames},
              {"outputs", rendered.outputs},
              {"events", count_of(rendered.events)},
              {"bad_input_samples", engine.bad_input_samples()},
              {"faults", faults_json(engine.faults())},
              {"guard", guard_json(rendered.guard, input.sample_rate)},
              {"network_solvers", networks_json(rendered.networks)}});
  return exit_code;
}

}  // namespace tactus::app
