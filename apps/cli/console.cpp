#include "apps/cli/console.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "apps/cli/commands.h"
#include "apps/play/live/controls/keyboard.h"
#include "engine/graph/file/quantity.h"
#include "engine/graph/file/read_graph.h"

namespace tactus::app {
int report(const std::vector<Error>& errors) {
  fmt::print(stderr, "{}\n", to_string(errors));
  const bool in_a_file = std::ranges::count(errors, Error::Place::File, &Error::place) > 0;
  return in_a_file ? kBadFile : kUsage;
}

int report(const Error& error) { return report(std::vector{error}); }

int exit_of(const Error& error) {
  return error.code == Errc::BadArgument || error.code == Errc::OutOfRange ? kUsage : kDevice;
}

Progress::Progress(std::string what) : what_(std::move(what)), terminal_(terminal_columns() > 0) {}

Progress::~Progress() {
  if (shown_) fmt::print(stderr, "\r{:70}\r", "");
}

void Progress::operator()(double share) {
  const int percent = static_cast<int>(share * 100);
  if (!terminal_ || percent == percent_) return;
  percent_ = percent;
  shown_ = true;
  const int full = percent * 30 / 100;
  fmt::print(stderr, "\r{} [{:=<{}}{: <{}}] {:3} %", what_, "", full, "", 30 - full, percent);
  std::fflush(stderr);
}

void Progress::operator()(double share, const std::string& what) {
  if (what != what_) {
    percent_ = -1;
    if (shown_) fmt::print(stderr, "\r{:70}", "");  // the previous text may be longer
  }
  what_ = what;
  (*this)(share);
}

void announce_delay(const GraphSpec& instrument, double delay_s) {
  const auto& tested = instrument.tested;
  if (!tested || tested->contains(delay_s)) return;
  const auto text = [](double si) { return short_quantity(si, Dimension{.second = 1}); };
  fmt::print(stderr,
             "warning: {} was tested with system delays from {} to {}; with {} it may not be playable\n",
             instrument.name, text(tested->low), text(tested->high), text(delay_s));
}

std::filesystem::path resolve_target(const std::string& target, const char* name) {
  const std::filesystem::path path{target};
  return std::filesystem::is_directory(path) ? path / name : path;
}

std::filesystem::path root_of(const std::filesystem::path& file) {
  const auto absolute = std::filesystem::absolute(file).lexically_normal();
  for (auto folder = absolute.parent_path(); folder.has_relative_path(); folder = folder.parent_path())
    if (folder.filename() == "instruments") return folder;
  return file.has_parent_path() ? file.parent_path() : std::filesystem::path{"."};
}

Result<std::map<std::string, ControlValue>> parse_settings(const std::vector<std::string>& texts) {
  std::map<std::string, ControlValue> settings;
  for (const auto& text : texts) {
    const auto equals = text.find('=');
    const auto value = equals == std::string::npos ? std::nullopt : parse_quantity(text.substr(equals + 1));
    if (!value || equals == 0)
      return fail(Errc::Syntax, "--set " + text, "is not NAME=VALUE",
                  "write for instance --set strength=0.5 or --set \"sensitivity=-40 dB\"");
    settings[text.substr(0, equals)] =
        value->bare ? ControlValue{value->si} : ControlValue{value->si, value->unit.dimension};
  }
  return settings;
}

Result<double> parse_option(const std::string& text, const char* unit, const char* option) {
  const auto value = read_quantity(Value{text, {}}, *parse_unit(unit), option);
  if (value) return *value;
  return tl::unexpected(value.error().at(std::string{"--"} + option));
}

Result<Hertz> parse_rate(const std::string& text) {
  const auto rate = parse_option(text, "Hz", "rate");
  if (!rate) return tl::unexpected(rate.error());
  if (*rate >= 1e3 && *rate <= 768e3) return Hertz{*rate};
  return fail(Errc::OutOfRange, "--rate", "must be between 1 kHz and 768 kHz", "");
}

Result<Seconds> parse_delay(const std::string& text) {
  const auto delay = parse_option(text, "s", "delay");
  if (!delay) return tl::unexpected(delay.error());
  if (*delay >= 0 && *delay <= 10) return Seconds{*delay};
  return fail(Errc::OutOfRange, "--delay", "must be between 0 s and 10 s", "");
}

Result<Seconds> parse_duration(const std::string& text, Seconds longest) {
  const auto duration = parse_option(text, "s", "duration");
  if (!duration) return tl::unexpected(duration.error());
  if (*duration > 0 && *duration <= longest.value) return Seconds{*duration};
  return fail(Errc::OutOfRange, "--duration",
              "must be above 0 s" +
                  (std::isfinite(longest.value) ? fmt::format(" and at most {:g} s", longest.value) : ""),
              "");
}

const char* version() { return "tactus " TACTUS_VERSION; }

}  // namespace tactus::app
