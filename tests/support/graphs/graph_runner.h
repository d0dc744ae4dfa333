#pragma once

#include <functional>
#include <string>
#include <vector>

#include "engine/graph/file/load.h"
#include "engine/graph/plan/compile.h"
#include "engine/nodes/table.h"
#include "engine/runtime/player.h"
#include "tests/support/error_summary.h"

namespace tactus::test {

using Channels = std::vector<std::vector<double>>;

/// Every error of a graph text as one string, one a line; "" if there is none.
inline std::string errors_of(const std::string& text, CompileOptions options = {}) {
  const auto schedule = compile(parse_graph_leniently(text, "test.toml"), standard_nodes(), options);
  return summary(schedule);
}

/// A graph text, compiled and ready to run. Throws what is wrong with the text.
/// The same with their remedies, as people read them.
inline std::string full_text(const std::vector<Error>& errors) {
  std::string lines;
  for (const auto& error : errors) lines += (lines.empty() ? "" : "\n") + to_string(error);
  return lines;
}
inline std::string full_errors_of(const std::string& text, CompileOptions options = {}) {
  const auto plan = compile(parse_graph_leniently(text, "test.toml"), standard_nodes(), options);
  return plan ? "" : full_text(plan.error());
}

inline std::unique_ptr<Player> engine_of(const std::string& text, CompileOptions options = {}) {
  const auto wrong = errors_of(text, options);
  if (!wrong.empty()) throw std::runtime_error(wrong);
  return std::make_unique<Player>(
      *compile(parse_graph_leniently(text, "test.toml"), standard_nodes(), options));
}

/// Runs from frame 0 in blocks of the given lengths, over and over, until the inputs (or `frames`) end.
/// Returns the outputs, then the taps.
inline Channels run(Player& engine, const Channels& inputs, int frames, const std::vector<int>& blocks) {
  StreamFormat format{engine.plan().sample_rate, static_cast<int>(inputs.size()), engine.out_channels(),
                      4096};
  if (const auto status = engine.prepare(format); !status)
    throw std::runtime_error(to_string(status.error()));
  Channels out(static_cast<std::size_t>(engine.out_channels() + engine.tap_count()),
               std::vector<double>(static_cast<std::size_t>(frames)));
  const NoDenormals no_denormals;
  std::size_t next = 0;
  for (int done = 0; done < frames;) {
    const int block = std::min(blocks[next++ % blocks.size()], frames - done);
    std::vector<const double*> in;
    std::vector<double*> to;
    for (const auto& channel : inputs) in.push_back(channel.data() + done);
    for (int c = 0; c < engine.out_channels(); ++c)
      to.push_back(out[static_cast<std::size_t>(c)].data() + done);
    engine.process({in.data(), to.data(), block});
    for (int t = 0; t < engine.tap_count(); ++t)
      std::copy_n(engine.tap(t), block,
                  out[static_cast<std::size_t>(engine.out_channels() + t)].data() + done);
    done += block;
  }
  return out;
}

}  // namespace tactus::test
