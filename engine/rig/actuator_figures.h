#pragma once
// Thread: [control]

#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/error.h"
#include "engine/graph/file/field.h"

namespace tactus {

/// What is known of one property of an actuator, and where it comes from.
struct ActuatorFigure {
  enum class Kind {
    Sheet,      ///< was read in the source
    Derived,    ///< follows from other figures by the law of the plant
    Judgement,  ///< has no source
    Unknown,
  };
  std::string value;  ///< for people: "25 N at 40 Hz and 5 V"
  Kind kind = Kind::Unknown;
  std::string source;
  std::optional<double> low, high;  ///< SI, US $ of a price; nothing: not known, or no limit
};
/// [any] As a file has it: "sheet", "derived", "judgement", "unknown".
const std::vector<std::string>& actuator_figure_kinds();

/// A file of instruments/actuators/figures: what an actuator can do and costs.
struct ActuatorFigures {
  std::string name;
  Source name_at, profile_at;
  std::string row;            ///< in table 1 of the paper; or empty
  std::string section;        ///< of the paper
  std::string plant;          ///< file of its simulated plant, relative to this one; or empty
  std::string profile;        ///< of the drive guard; or empty
  ActuatorFigure price;       ///< low to high
  ActuatorFigure force;       ///< high: the largest [N]
  ActuatorFigure band;        ///< low to high [Hz]
  ActuatorFigure excursion;   ///< high: to either side [m]; infinite: it turns without end
  ActuatorFigure resolution;  ///< low: the step of its sensor [m]
  /// [Hz] Changes of the drive that it follows, where the drive has other frequencies than the movement: the
  /// DC of a vibration motor.
  std::optional<double> drive_to;
  std::optional<double> arm;  ///< [m] The length of the arm at whose tip a motor has this force.
  bool no_sensor = false;     ///< it has none of its own
  bool sensor = false;        ///< it is one, and moves nothing

  bool turns_without_end() const { return excursion.high && std::isinf(*excursion.high); }
  /// About an axis; else it moves along a line.
  bool rotates() const { return turns_without_end() || arm; }

  /// [N m]
  std::optional<double> torque() const {
    return arm && force.high ? std::optional{*arm * *force.high} : std::nullopt;
  }
};

/// [any] All keys of such a file.
const SectionType& actuator_figure_fields();

/// [control] All errors of a file at once.
Checked<ActuatorFigures> load_actuator_figures(const std::filesystem::path& file);
Checked<ActuatorFigures> parse_actuator_figures(std::string_view text, const std::string& file_name);

}  // namespace tactus
