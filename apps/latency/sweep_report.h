#pragma once
// Thread: [control]

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "engine/plot/plot.h"
#include "latency/block_law.h"
#include "latency/estimation/analysis.h"

namespace tactus::app {

/// A requested setting and its result.
struct SweepRow {
  SettingDelay setting;          ///< as it was granted
  std::optional<Error> refused;  ///< by the device: nothing was measured
  int asked_block = 0;
  std::optional<int> asked_periods;
  bool again = false;  ///< granted was a setting that another row has
  std::int64_t xruns = 0, lost_frames = 0;
  double detected_lost_frames = 0.0;  ///< by what came back
  std::optional<double> reported_frames;
  Analysis analysis;
};

/// Those of one rate and one number of periods, and the line through them.
struct LawOfGroup {
  Hertz sample_rate;
  int periods = 0;
  BlockLaw law;
};

struct SweepReport {
  std::string source;
  std::vector<SweepRow> rows;
  std::vector<std::string> written;

  /// What was measured, each once.
  std::vector<SettingDelay> settings() const;
  /// The row to play with; without one, the last that was measured; nullptr: none was.
  const SweepRow* recommended() const;
  std::vector<LawOfGroup> laws() const;
};

nlohmann::ordered_json json_of(const SweepReport& report);
std::string text_of(const SweepReport& report);
/// Delay against block, with the lines.
Plot picture_of(const SweepReport& report);

}  // namespace tactus::app
