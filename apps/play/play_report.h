#pragma once
// Thread: [control]

#include <CLI/CLI.hpp>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "apps/cli/json.h"
#include "apps/cli/target.h"
#include "backends/health.h"
#include "backends/wav_file.h"
#include "engine/core/error.h"
#include "engine/plot/plot.h"
#include "engine/scene/guard_report.h"
#include "engine/scene/network_report.h"
#include "engine/scene/play_scene.h"

namespace tactus::app {

/// Options of the drive guard.
struct GuardOptions {
  std::string profile;             ///< "woofer", or a file; lowers the limits of every drive
  std::string volts;               ///< volts per full scale
  std::vector<std::string> raise;  ///< LIMIT=VALUE, OUTPUT.LIMIT=VALUE
};

/// `limits` with those of the command line. Throws a CommandError.
LimitBook apply(const GuardOptions& options, LimitBook limits);
/// Warns on stderr of every limit that was raised. Throws a CommandError for a raise without effect.
void announce_raises(const LimitBook& limits, const Plan& plan);

/// The limits of all outputs with their sources, for machines.
Json limits_json(const GuardReport& report);
/// What the guards did, and which limits were raised, for machines.
Json guard_json(const GuardReport& report, Hertz sample_rate);
/// And for people.
void print_guard(const GuardReport& report, Hertz sample_rate);
/// Nodes that produced non-finite values, and sensors that gave them.
void print_faults(const SceneRecording& recording);

/// Options of every run of an instrument or a scene.
struct PlayerOptions {
  std::string target;
  std::string in;                     ///< a sound file, or what else the inputs receive; empty: the default
  std::string rate, delay, duration;  ///< empty: as the file says
  std::optional<int> block;
  std::vector<std::string> set;  ///< NAME=VALUE
  GuardOptions guard;
  bool json = false;
};
/// All but FILE.
void add_player_options(CLI::App& command, PlayerOptions& options);

struct PlayedScene {
  SceneSpec scene;
  SceneRecording recording;
  std::vector<NetworkReport> networks;  ///< of all parts, then of the instrument
  std::string inputs{};                 ///< as World::inputs
};

/// Loads, builds and plays a scene, or an instrument without its plant. `compared`: control values [SI] on
/// top of the options, for a second run, which does not repeat the warnings of the first. Throws a
/// CommandError with all errors of its files.
PlayedScene play_file(const Target& target, const PlayerOptions& options,
                      const std::map<std::string, double>* compared = nullptr);

Json faults_json(const std::vector<FaultCount>& faults);
/// Numbers of gaps by their causes.
Json gaps_json(const Health& health);

/// The energy that passed the ports of a scene, for machines and for people.
Json ports_json(const std::vector<PortEnergy>& ports);
void print_ports(const std::vector<PortEnergy>& ports);

/// A line for each network, for machines and for people.
Json networks_json(const std::vector<NetworkReport>& networks);
void print_networks(const std::vector<NetworkReport>& networks);

/// A section of the report of a played scene: what the signal with one role did, for machines and for people.
struct ReportSection {
  Json json = Json::object();  ///< part of the report
  std::string text{};
};

/// The sections of the roles that [roles] gives, in its order; without it, of those that ports play by name.
/// `contact`: a roll; `ball`: its orbit; `monitor`: notes (see melody_of). `compared`: the other run of a
/// scene with [compare], or nullptr.
std::vector<ReportSection> sections_of(const PlayedScene& played, const PlayedScene* compared);

/// What the names of all files of a run begin with.
std::string base_of(const std::string& folder, const PlayedScene& played);

/// What the plot of a run shows.
struct ShownPart {
  double from_s = 0, to_s = 0;
  bool all = false;  ///< every signal, else at most five subplots
};

/// Pitch, motion (a subplot for the signals of one unit whose ranges differ by less than a factor of 20),
/// sensors with a mark at each trigger, and drives, each with its unit. Constant signals are named, not
/// drawn. `compared`: the other run of a scene with [compare], drawn dashed beside it, or nullptr. Where the
/// guard acted it shows the ceiling and its events.
Plot scene_plot(const PlayedScene& played, const PlayedScene* compared, const ShownPart& shown);

/// The times that the plot shows: those of --show, else of [show], else all. Throws a CommandError:
/// OutOfRange.
ShownPart shown_part(const std::vector<std::string>& times, const PlayedScene& played);

/// The monitor output as a sound file of 24 bits, with the gain of the scene; the drives and the sensors as
/// one each, unscaled and unclipped; what moved as another, in metres and newtons; the plot. No empty files.
/// A line each: the path and its contents. Throws a CommandError: BadFile.
std::vector<std::string> write_files(const std::string& folder, const PlayedScene& played,
                                     const PlayedScene* compared, const ShownPart& shown);

}  // namespace tactus::app
