#include "apps/cli/take_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <system_error>

#include "engine/graph/plan/fingerprint.h"
#include "engine/scene/guard_report.h"

namespace tactus::app {
namespace {

namespace fs = std::filesystem;

std::string from_root(const fs::path& file, const fs::path& root) {
  return fs::absolute(file)
      .lexically_normal()
      .lexically_relative(fs::absolute(root).lexically_normal())
      .generic_string();
}

constexpr std::uint64_t kMostSoundBytes = 1u << 30;

/// A device or a pipe might never end.
bool is_readable_sound(const fs::path& file) {
  std::error_code missing;
  return fs::is_regular_file(file, missing) && fs::file_size(file, missing) <= kMostSoundBytes;
}

/// Empty if the file cannot be read.
std::string print_of(const fs::path& file) {
  if (!is_readable_sound(file)) return {};
  std::ifstream stream{file, std::ios::binary};
  Fingerprint print;
  std::uint64_t bytes = 0;
  std::string part(1 << 16, '\0');
  while (stream.read(part.data(), std::ssize(part)), stream.gcount() > 0) {
    const auto read = static_cast<std::size_t>(stream.gcount());
    print.add_part({part.data(), read});
    bytes += read;
  }
  return fmt::format("{:016x}", print.add(bytes).value());
}

/// A graph names sound files in settings of the kind File.
void add_sounds(const GraphSpec& spec, const NodeTable& table, const fs::path& root, TakeFiles& files) {
  const auto folder = fs::path{*spec.file.file}.parent_path();
  for (const auto& node : spec.nodes) {
    const auto* type = table.find(node.type);
    if (type == nullptr) continue;
    for (const auto& setting : type->settings) {
      const auto* value = setting.kind == Setting::Kind::File ? find(node.fields, setting.name) : nullptr;
      const auto* text = value == nullptr ? nullptr : value->text();
      if (text != nullptr) files.sounds[from_root(folder / *text, root)] = print_of(folder / *text);
    }
  }
  for (const auto& [use, part] : spec.parts)
    if (part != nullptr) add_sounds(*part, table, root, files);
}

/// A take may come from anybody: nothing is written or read outside.
Result<fs::path> inside(const fs::path& folder, const std::string& name) {
  const auto path = fs::path{name}.lexically_normal();
  if (!path.has_root_path() && !path.empty() && *path.begin() != "..") return folder / path;
  return fail(Errc::BadFile, name, "the take refers to a file outside its folder", "do not trust this take");
}

}  // namespace

TakeFiles take_files(const LoadedGraph& graph, const NodeTable& table, const fs::path& root) {
  TakeFiles files;
  files.root = fs::absolute(root).lexically_normal().generic_string();
  files.main = from_root(*graph.spec->file.file, root);
  for (const auto& [name, text] : graph.texts) files.texts[from_root(name, root)] = text;
  add_sounds(*graph.spec, table, root, files);
  return files;
}

std::map<std::string, double> take_settings(const Plan& schedule) {
  std::map<std::string, double> settings;
  for (const auto& scheduled : schedule.controls) settings[scheduled.control.name] = scheduled.control.value;
  return settings;
}

void add_rig(const Rig& rig, const std::string& text, TakeHeader& header) {
  header.rig = text;
  const auto add = [&](const RigPort& port) {
    if (port.channels.empty()) header.left_out.push_back(port.name);
  };
  std::for_each(rig.inputs.begin(), rig.inputs.end(), add);
  std::for_each(rig.outputs.begin(), rig.outputs.end(), add);
}

TakeHeader take_header(const Player& engine, const Guarded& guarded) {
  const auto& schedule = engine.plan();
  TakeHeader header;
  header.sample_rate = schedule.sample_rate;
  header.inputs = schedule.input_names;
  header.outputs = output_names(schedule);
  header.controls = engine.control_names();
  header.settings = take_settings(schedule);
  header.system_delay = schedule.system_delay_at_start;
  header.guard = guarded.channels();
  header.armed = guarded.armed_at_start();
  header.state = guarded.state();
  return header;
}

Result<fs::path> unpack(const TakeFiles& files, const fs::path& folder) {
  std::error_code error;
  for (const auto& [name, text] : files.texts) {
    const auto path = inside(folder, name);
    if (!path) return path;
    fs::create_directories(path->parent_path(), error);
    if (!(std::ofstream{*path, std::ios::binary} << text))
      return fail(Errc::BadFile, path->string(), "cannot be written", "check the free disk space");
  }
  for (const auto& [name, print] : files.sounds) {
    const auto path = inside(folder, name), source = inside(files.root, name);
    if (!path) return path;
    if (fs::exists(*source, error) && !is_readable_sound(*source))
      return fail(Errc::BadFile, source->string(), "this sound is no regular file of at most 1 GiB",
                  "do not trust this take");
    if (print_of(*source) != print)
      return fail(Errc::BadFile, source->string(),
                  "this sound file is missing or has changed since the take was recorded",
                  "restore the original file");
    fs::create_directories(path->parent_path(), error);
    fs::copy_file(*source, *path, fs::copy_options::overwrite_existing, error);
    if (error) return fail(Errc::BadFile, path->string(), "cannot be written", "check the free disk space");
  }
  return inside(folder, files.main);
}

}  // namespace tactus::app
