#include "apps/play/world.h"

#include <algorithm>

#include "apps/cli/console.h"
#include "backends/wav_file.h"
#include "engine/nodes/table.h"
#include "engine/scene/test_bench.h"

namespace tactus::app {
namespace {

constexpr Hertz kBenchRate = 48_kHz;
constexpr Seconds kBenchDuration = 4_s, kLongestBench = 3600_s;

struct Bench {
  BenchInputs inputs;
  Hertz rate = kBenchRate;
  Seconds duration = kBenchDuration;
};

Bench bench_of(const std::string& inputs, bool by_hand) {
  if (inputs.empty() || inputs == "test-signal") return {};
  if (inputs == "silence") return {{BenchInputs::Kind::Silence}};
  if (inputs == "keyboard") {
    if (!by_hand)
      exit_with({Errc::BadArgument, "--in", "keyboard strikes need a simulation in real time",
                 "add --listen, or choose test-signal, silence or a WAV file"});
    return {{BenchInputs::Kind::Keyboard}};
  }
  std::error_code none;
  if (!std::filesystem::exists(inputs, none))
    exit_with({Errc::BadArgument, "--in", "there is no file '" + inputs + "'",
               "name a WAV file, or test-signal, silence or keyboard"});
  const auto file = or_exit(WavReader::open(inputs));
  const double duration_s = static_cast<double>(file.frames()) / file.sample_rate().value;
  return {{BenchInputs::Kind::File, inputs, file.channels()},
          file.sample_rate(),
          Seconds{std::clamp(duration_s, 1e-3, kLongestBench.value)}};
}

}  // namespace

World load_world(const Target& target, const std::string& inputs, bool by_hand) {
  if (target.scene) {
    if (!inputs.empty())
      exit_with({Errc::BadArgument, "--in",
                 target.file.string() + " is a scene, whose plant provides the inputs",
                 "omit --in, or name the instrument"});
    return {load_scene_leniently(target)};
  }
  auto instrument = load_graph_leniently(target.file, target.root());
  if (instrument.spec == nullptr) throw CommandError{std::move(instrument.errors)};
  auto bench = bench_of(inputs, by_hand);
  bench.inputs.notes = bench.inputs.kind == BenchInputs::Kind::TestSignal && !by_hand;
  // Errors of the instrument are reported without those that they cause around it.
  CompileOptions options;
  options.sample_rate = bench.rate;
  (void)or_exit(compile(instrument, standard_nodes(), options));
  auto text = describe(bench.inputs, *instrument.spec, by_hand);
  if (!text.empty()) text += "\n(to change the inputs: --in FILE, test-signal, silence or keyboard)";
  return {scene_around(std::move(instrument), bench.inputs, bench.rate, bench.duration), std::move(text)};
}

}  // namespace tactus::app
