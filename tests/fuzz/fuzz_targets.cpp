#include "tests/fuzz/fuzz_targets.h"

#include <cmath>
#include <limits>
#include <vector>

#include "engine/graph/plan/compile.h"
#include "engine/guard/guarded.h"
#include "engine/nodes/table.h"
#include "engine/runtime/player.h"
#include "engine/scene/build_scene.h"

namespace tactus::fuzz {
namespace {

// A folder with an instrument and a plant to use.
const std::string kFile = TACTUS_SOURCE_DIR "/instruments/haptic_drum/fuzzed.toml";

/// Small enough for many runs a second; what the limits themselves refuse has tests of its own.
CompileOptions small_graphs() {
  CompileOptions options;
  options.most_nodes = 20'000;
  options.most_bytes = 32u << 20;
  return options;
}

std::string badly_told(const std::vector<Error>& errors) {
  for (const auto& error : errors)
    if (error.what.empty() || error.remedy.empty()) return "without a remedy: " + to_string(error);
  return {};
}

constexpr int kMostFrames = 256;

/// One block of one channel; `turn` chooses what goes wrong with it.
void make_nasty(std::vector<double>& samples, int turn) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (int n = 0; n < kMostFrames; ++n) {
    const double square = n % 42 < 21 ? 1.0 : -1.0;
    const double values[] = {
        square,        1e-310 * square,
        square * 1e30, n == 33 ? kInfinity : n == 9 ? std::numeric_limits<double>::quiet_NaN() : 0.1,
        0.7,           n == 5 ? -kInfinity : square * 1e300};
    samples[static_cast<std::size_t>(n)] = values[turn % 6];
  }
}

/// Every control jumps to one end of its range, or far where it has none, every fourth one slowly.
void throw_controls(Player& engine, int turn) {
  const auto& controls = engine.plan().controls;
  for (std::size_t i = 0; i < controls.size() && i < 32; ++i) {
    const auto& range = controls[i].control.range;
    const double ends[] = {range.low, range.high, 0.0};
    const double end = ends[(static_cast<std::size_t>(turn) + i) % 3];
    (void)engine.post({.frame = engine.frame() + static_cast<std::int64_t>(7 * i % 64),
                       .kind = JournalEntry::Kind::ControlChange,
                       .index = static_cast<int>(i),
                       .value = std::isfinite(end) ? end : std::copysign(1e30, end)});
  }
}

std::string run_blocks(Player& engine) {
  Guarded guarded{engine, {}};
  const StreamFormat format{engine.plan().sample_rate, engine.in_channels(), engine.out_channels(),
                            kMostFrames};
  if (const auto ready = guarded.prepare(format); !ready) return to_string(ready.error());
  std::vector<std::vector<double>> in(static_cast<std::size_t>(engine.in_channels()),
                                      std::vector<double>(kMostFrames));
  std::vector<std::vector<double>> out(static_cast<std::size_t>(engine.out_channels()),
                                       std::vector<double>(kMostFrames));
  std::vector<const double*> from;
  std::vector<double*> to;
  for (const auto& channel : in) from.push_back(channel.data());
  for (auto& channel : out) to.push_back(channel.data());
  static constexpr int kBlocks[] = {64, 1, 256, 17, 128, 63};
  for (int turn = 0; turn < 12; ++turn) {
    for (std::size_t c = 0; c < in.size(); ++c) make_nasty(in[c], turn + static_cast<int>(c));
    throw_controls(engine, turn);
    const int frames = kBlocks[turn % 6];
    guarded.process({from.data(), to.data(), frames});
    for (const auto& channel : out)
      for (int n = 0; n < frames; ++n)
        if (!(std::abs(channel[static_cast<std::size_t>(n)]) <= DriveLimits{}.ceiling))
          return "above the ceiling";
  }
  for (int c = 0; c < engine.out_channels(); ++c)
    if (guarded.counts(c)[GuardStage::NonFinite].frames > 0)
      return "not finite at output " + std::to_string(c);
  return {};
}

}  // namespace

std::string load_anything(std::string_view text) {
  const auto graph = parse_graph_leniently(text, kFile);
  if (graph.spec == nullptr && graph.errors.empty()) return "neither read nor refused";
  auto wrong = badly_told(graph.errors);
  if (wrong.empty() && graph.spec) wrong = badly_told(check(*graph.spec, standard_nodes(), small_graphs()));
  const auto scene = parse_scene_leniently(text, kFile);
  if (wrong.empty() && scene.scene && !scene.scene->parts.empty()) {
    const auto built = build_scene(scene, standard_nodes());
    if (!built) wrong = badly_told(built.error());
  }
  return wrong;
}

std::string run_anything(std::string_view text) {
  const auto graph = parse_graph_leniently(text, kFile);
  if (!graph.errors.empty()) return {};
  auto compiled = compile(graph, standard_nodes(), small_graphs());
  if (!compiled) return badly_told(compiled.error());
  Player engine{std::move(*compiled)};
  return run_blocks(engine);
}

}  // namespace tactus::fuzz
