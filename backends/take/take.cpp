#include "backends/take/take.h"

#include <fmt/format.h>

#include <fstream>
#include <system_error>

#include "backends/take/take_lines.h"

namespace tactus {
namespace {

namespace fs = std::filesystem;

tl::unexpected<Error> at(const fs::path& path, Error error) {
  error.where = path.string();
  return tl::unexpected(std::move(error));
}

}  // namespace

fs::path journal_path(const fs::path& wav) { return fs::path{wav}.replace_extension(".jsonl"); }

Result<Take> read_take(const fs::path& wav) {
  const auto path = journal_path(wav);
  std::error_code ignored;
  if (!fs::exists(wav, ignored))
    return fail(Errc::BadFile, wav.string(), "there is no such file", "check the path");
  if (!fs::exists(path, ignored))
    return fail(Errc::BadFile, wav.string(),
                fmt::format("there is no '{}' beside it, so the graph that was played is unknown",
                            path.filename().string()),
                "a WAV file of sensors alone is played with --in");
  std::ifstream file{path, std::ios::binary};
  std::string line;
  if (!std::getline(file, line))
    return fail(Errc::BadFile, path.string(), "it is empty", "the take was cut off before it began");
  auto header = parse_header(line);
  if (!header) return at(path, header.error());
  Take take;
  take.header = std::move(*header);
  for (int number = 2; std::getline(file, line); ++number) {
    const bool whole = !file.eof();
    if (parse_line(line, take)) continue;
    if (!whole || file.peek() == std::ifstream::traits_type::eof()) break;  // cut off here
    return fail(Errc::BadFile, fmt::format("{}:{}", path.string(), number), "this is no line of a take",
                "restore the file from a copy");
  }
  return take;
}

std::string why_not_exact(const Take& take) {
  if (take.lost_entries > 0)
    return fmt::format("{} changes of controls or of the guard could not be kept", take.lost_entries);
  if (!take.gaps.empty()) {
    const auto first_s = static_cast<double>(take.gaps.front().frame) / take.header.sample_rate.value;
    if (take.gaps.size() == 1) return fmt::format("frames are missing at {:.3f} s", first_s);
    return fmt::format("frames are missing in {} places, first at {:.3f} s", take.gaps.size(), first_s);
  }
  if (take.rounded_sensors > 0)
    return fmt::format("{} samples of its sensors have more digits than a WAV file of floats keeps",
                       take.rounded_sensors);
  return {};
}

}  // namespace tactus
