#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

// The layers are read from the table of docs/design.md.

namespace {

namespace fs = std::filesystem;

/// folder -> folders that it may include, besides itself.
using Layers = std::map<std::string, std::vector<std::string>>;

/// The names between backticks in `text`.
std::vector<std::string> quoted_names(const std::string& text) {
  std::vector<std::string> names;
  for (auto at = text.find('`'); at != std::string::npos;) {
    const auto end = text.find('`', at + 1);
    if (end == std::string::npos) break;
    names.push_back(text.substr(at + 1, end - at - 1));
    at = text.find('`', end + 1);
  }
  return names;
}

/// The rows of the table under the heading "Layers": | `folder` | `folder`, `folder` | …
Layers read_layers(std::istream& text) {
  Layers layers;
  bool here = false;
  for (std::string line; std::getline(text, line);) {
    if (line.starts_with("## ")) here = line == "## Layers";
    if (!here || !line.starts_with("| `")) continue;
    const auto second = line.find('|', 1);
    const auto third = line.find('|', second + 1);
    const auto may_include = quoted_names(line.substr(second, third - second));
    for (const auto& folder : quoted_names(line.substr(0, second))) layers[folder] = may_include;
  }
  return layers;
}

const Layers& layers() {
  static const Layers read = [] {
    std::ifstream text{fs::path{TACTUS_SOURCE_DIR} / "docs/design.md"};
    return read_layers(text);
  }();
  return read;
}

/// Where the headers that begin like this may be included, as beginnings of paths.
struct ThirdParty {
  std::string header;
  std::vector<std::string> allowed;
};
const std::vector<ThirdParty> kThirdParty = {
    {"tl/expected.hpp", {"engine/core/"}},
    {"math.h", {"engine/dsp/kernel.h"}},
    {"sanitizer/", {"engine/core/not_realtime.h"}},
    {"Eigen/", {"engine/physics/", "engine/study/", "latency/"}},
    {"unsupported/Eigen/", {"engine/physics/", "engine/study/", "latency/"}},
    {"toml++/", {"engine/graph/file/", "engine/rig/"}},
    {"sndfile.h", {"engine/nodes/", "backends/wav_file.cpp"}},
    {"ode/", {"engine/nodes/world/"}},
    {"fmt/",
     {"engine/graph/", "engine/nodes/", "engine/runtime/", "engine/rig/", "engine/scene/", "engine/plot/",
      "engine/study/", "export/", "backends/", "latency/", "remote/", "apps/", "python/"}},
    {"nlohmann/",
     {"engine/study/", "backends/json_fields.h", "backends/take/", "latency/", "remote/", "apps/"}},
    {"oscpack/", {"remote/osc/"}},
    {"SDL.h", {"remote/hid/", "backends/sdl/"}},
    {"boost/asio.hpp", {"remote/osc/", "remote/panel/", "remote/serial/"}},
    {"boost/beast/", {"remote/panel/"}},
    {"CLI/", {"apps/"}},
    {"pybind11/", {"python/"}},
};

/// Vector intrinsics exist wherever the compiler's macros say so; the system's own headers only at the rim.
const std::set<std::string> kIntrinsics = {"xmmintrin.h", "immintrin.h", "arm_neon.h"};
const std::set<std::string> kSystem = {
    "unistd.h",   "io.h",           "pthread.h",       "sched.h",       "dlfcn.h",      "windows.h",
    "sys/mman.h", "sys/resource.h", "sys/time.h",      "sys/utsname.h", "sys/sysctl.h", "sys/ioctl.h",
    "fcntl.h",    "poll.h",         "termios.h",       "conio.h",       "cpuid.h",      "sys/socket.h",
    "sys/stat.h", "sys/wait.h",     "sys/sysmacros.h", "spawn.h",       "shellapi.h"};

struct Include {
  std::string path;
  bool quoted;
};

bool begins(const std::string& text, const std::string& beginning) { return text.starts_with(beginning); }

/// "engine/graph/file/load.h" -> "engine/graph"; "backends/jack/stream.cpp" -> "backends"; "" if it is no
/// layer.
std::string layer_of(const std::string& path) {
  std::string longest;  // "backends/loop" and not "backends"
  for (const auto& [layer, may_include] : layers())
    if (begins(path, layer + "/") && layer.size() > longest.size()) longest = layer;
  return longest;
}

/// "backends/jack" for what lies below a backend's own folder, otherwise "".
std::string backend_of(const std::string& path) {
  if (!begins(path, "backends/")) return "";
  const auto slash = path.find('/', 9);
  return slash == std::string::npos ? "" : path.substr(0, slash);
}

bool reaches(const std::string& from, const std::string& to) {
  if (from == to) return true;
  const auto& next = layers().at(from);
  return std::any_of(next.begin(), next.end(), [&](const auto& layer) { return reaches(layer, to); });
}

std::string judge_own(const std::string& file, const std::string& include) {
  const auto from = layer_of(file);
  const auto to = layer_of(include);
  if (to.empty()) return "not a path from the repository's root";
  if (!reaches(from, to)) return from + " must not include " + to;
  // Apps choose a backend by name; below them, each backend stands alone, but for folders that its row names.
  const auto backend = backend_of(include);
  const auto& named = layers().at(from);
  if (begins(from, "backends") && !backend.empty() && backend != backend_of(file) &&
      std::count(named.begin(), named.end(), backend) == 0)
    return "a backend must not include another";
  return "";
}

/// The library of a backend: in its folder's .cpp files, so that no user of a backend needs its headers; and
/// in one file about what is common to all clients of the process, and one that asks JACK's server what other
/// libraries would find there.
std::string judge_in_backend(const std::string& file, const std::string& include) {
  if (include.find_first_of("./") == std::string::npos) return "";
  if (!file.ends_with(".cpp")) return "only a .cpp may include it";
  if (file == "backends/library_calls.cpp" || file == "backends/jack_names.cpp") return "";
  if (backend_of(file).empty()) return "only the folder of its backend may include it";
  std::string name = include;
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
  for (const auto& entry : fs::directory_iterator(fs::path{TACTUS_SOURCE_DIR} / "backends"))
    if (const auto folder = entry.path().filename().string();
        entry.is_directory() && begins(name, folder) && "backends/" + folder != backend_of(file))
      return "only the folder of its backend may include it";
  return "";
}

std::string judge_foreign(const std::string& file, const std::string& include) {
  const auto matches = [&](const auto& beginning) { return begins(include, beginning); };
  for (const auto& library : kThirdParty) {
    if (!matches(library.header)) continue;
    if (!file.ends_with(".cpp") && library.header == "sndfile.h") return "only a .cpp may include it";
    const bool allowed = std::any_of(library.allowed.begin(), library.allowed.end(),
                                     [&](const auto& place) { return begins(file, place); });
    return allowed ? "" : "not allowed in " + layer_of(file);
  }
  if (kIntrinsics.contains(include)) return "";
  if (kSystem.contains(include))
    return begins(file, "engine/") ? "the engine must not know the operating system" : "";
  if (begins(file, "backends/")) return judge_in_backend(file, include);
  const bool standard = include.find_first_of("./") == std::string::npos || include == "experimental/simd";
  return standard ? "" : "an unknown library: name it in tests/layers_test.cpp and say where it may be used";
}

/// What is wrong with `file` including `include`; empty: nothing.
std::string judge(const std::string& file, const Include& include) {
  return include.quoted ? judge_own(file, include.path) : judge_foreign(file, include.path);
}

std::vector<Include> includes_in(std::istream& text) {
  std::vector<Include> found;
  for (std::string line; std::getline(text, line);) {
    std::string squeezed;
    for (const char c : line)
      if (c != ' ' && c != '\t') squeezed += c;
    if (!begins(squeezed, "#include") || squeezed.size() < 11) continue;
    const bool quoted = squeezed[8] == '"';
    const auto end = squeezed.find(quoted ? '"' : '>', 9);
    if (end == std::string::npos) continue;
    found.push_back({squeezed.substr(9, end - 9), quoted});
  }
  return found;
}

std::vector<std::string> source_files() {
  const fs::path root = TACTUS_SOURCE_DIR;
  std::vector<std::string> files;
  for (const auto* folder : {"engine", "backends", "latency", "remote", "apps", "python"}) {
    if (!fs::exists(root / folder)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
      const auto extension = entry.path().extension();
      if (extension == ".h" || extension == ".cpp")
        files.push_back(fs::relative(entry.path(), root).generic_string());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<Include> includes_of(const std::string& file) {
  std::ifstream text{fs::path{TACTUS_SOURCE_DIR} / file};
  return includes_in(text);
}

}  // namespace

TEST_CASE("layers: no file includes against the table", "[layers]") {
  const auto files = source_files();
  REQUIRE(files.size() > 10);
  std::size_t includes = 0;
  std::string wrong;
  for (const auto& file : files) {
    for (const auto& include : includes_of(file)) {
      ++includes;
      const auto reason = judge(file, include);
      if (!reason.empty()) wrong += file + ": " + include.path + ": " + reason + "\n";
    }
  }
  REQUIRE(includes > files.size());
  INFO(wrong);
  CHECK(wrong.empty());
}

TEST_CASE("layers: one file of the graph reads TOML", "[layers]") {
  std::vector<std::string> readers;
  for (const auto& file : source_files()) {
    const auto includes = includes_of(file);
    const bool reads = std::any_of(includes.begin(), includes.end(),
                                   [](const auto& include) { return begins(include.path, "toml++/"); });
    if (reads && begins(file, "engine/graph/")) readers.push_back(file);
  }
  CAPTURE(readers);
  CHECK(readers.size() <= 1);
}

TEST_CASE("layers: headers say #pragma once first", "[layers]") {
  std::string wrong;
  for (const auto& file : source_files()) {
    if (!file.ends_with(".h")) continue;
    std::ifstream text{fs::path{TACTUS_SOURCE_DIR} / file};
    std::string line;
    std::getline(text, line);
    if (line != "#pragma once") wrong += file + "\n";
  }
  INFO(wrong);
  CHECK(wrong.empty());
}

TEST_CASE("layers: an include against the table is refused, with the reason", "[layers]") {
  CHECK(judge("engine/core/a.h", {"engine/graph/node.h", true}) ==
        "engine/core must not include engine/graph");
  CHECK(judge("engine/dsp/a.h", {"engine/physics/b.h", true}) ==
        "engine/dsp must not include engine/physics");
  CHECK(judge("engine/graph/a.h", {"engine/physics/b.h", true}) ==
        "engine/graph must not include engine/physics");
  CHECK(judge("engine/runtime/a.h", {"engine/scene/b.h", true}) ==
        "engine/runtime must not include engine/scene");
  CHECK(judge("engine/nodes/a.h", {"backends/backend.h", true}) == "engine/nodes must not include backends");
  CHECK(judge("backends/jack/a.cpp", {"engine/runtime/player.h", true}) ==
        "backends must not include engine/runtime");
  CHECK(judge("remote/a.cpp", {"apps/play/live/a.h", true}) == "remote must not include apps");
  CHECK(judge("latency/a.cpp", {"engine/study/a.h", true}) == "latency must not include engine/study");
  CHECK(judge("backends/jack/a.cpp", {"backends/rtaudio/b.h", true}) == "a backend must not include another");
  CHECK(judge("backends/loop/a.cpp", {"engine/plot/plot.h", true}) ==
        "backends/loop must not include engine/plot");
  CHECK(judge("latency/a.cpp", {"backends/loop/b.h", true}) == "latency must not include backends/loop");
  CHECK(judge("engine/core/a.cpp", {"error.h", true}) == "not a path from the repository's root");
  CHECK(judge("engine/core/a.cpp", {"tests/helper.h", true}) == "not a path from the repository's root");
}

TEST_CASE("layers: a library outside its place is refused, with the reason", "[layers]") {
  CHECK(judge("engine/core/a.h", {"fmt/format.h", false}) == "not allowed in engine/core");
  CHECK(judge("engine/nodes/a.cpp", {"Eigen/Dense", false}) == "not allowed in engine/nodes");
  CHECK(judge("engine/runtime/a.cpp", {"toml++/toml.h", false}) == "not allowed in engine/runtime");
  CHECK(judge("backends/wav_file.h", {"sndfile.h", false}) == "only a .cpp may include it");
  CHECK(judge("backends/portaudio/a.cpp", {"jack/jack.h", false}) ==
        "only the folder of its backend may include it");
  CHECK(judge("backends/health.cpp", {"jack/jack.h", false}) ==
        "only the folder of its backend may include it");
  CHECK(judge("backends/jack/a.h", {"jack/jack.h", false}) == "only a .cpp may include it");
  CHECK(judge("apps/a.cpp", {"oscpack/osc/OscTypes.h", false}) == "not allowed in apps");
  CHECK(judge("remote/a.h", {"boost/asio.hpp", false}) == "not allowed in remote");
  CHECK(judge("engine/core/a.cpp", {"unistd.h", false}) == "the engine must not know the operating system");
  CHECK(judge("engine/core/a.cpp", {"boost/any.hpp", false}) ==
        "an unknown library: name it in tests/layers_test.cpp and say where it may be used");
}

TEST_CASE("layers: an include along the table is allowed", "[layers]") {
  CHECK(judge("engine/nodes/a.cpp", {"engine/dsp/b.h", true}).empty());
  CHECK(judge("apps/main.cpp", {"engine/physics/b.h", true}).empty());
  CHECK(judge("apps/main.cpp", {"backends/backend.h", true}).empty());
  CHECK(judge("backends/jack/a.cpp", {"backends/jack/a.h", true}).empty());
  CHECK(judge("backends/loop/a.cpp", {"engine/dsp/a.h", true}).empty());
  CHECK(judge("backends/loop/a.cpp", {"backends/backend.h", true}).empty());
  CHECK(judge("apps/play/play.cpp", {"backends/loop/a.h", true}).empty());
  CHECK(judge("backends/jack/a.cpp", {"backends/backend.h", true}).empty());
  CHECK(judge("backends/jack/a.cpp", {"jack/jack.h", false}).empty());
  CHECK(judge("engine/physics/a.h", {"Eigen/Dense", false}).empty());
  CHECK(judge("engine/core/a.h", {"vector", false}).empty());
}

TEST_CASE("layers: includes are found however they are spaced", "[layers]") {
  std::istringstream text{
      "#pragma once\n  #  include <vector>\n#include \"engine/core/error.h\"  // why\n// #include <x>\n"};
  const auto found = includes_in(text);
  REQUIRE(found.size() == 2);
  CHECK(found[0].path == "vector");
  CHECK_FALSE(found[0].quoted);
  CHECK(found[1].path == "engine/core/error.h");
  CHECK(found[1].quoted);
}
