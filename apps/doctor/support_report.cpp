#include "apps/doctor/support_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>
#include <regex>
#include <set>
#include <sstream>

#include "apps/cli/console.h"

#if defined(__unix__) || defined(__APPLE__)
#include <unistd.h>
#endif

namespace tactus::app {
namespace {

bool in_word(char byte) { return std::isalnum(static_cast<unsigned char>(byte)) != 0 || byte == '_'; }

void replace_words(std::string& text, const std::string& word, const std::string& by) {
  if (word.empty()) return;
  for (auto at = text.find(word); at != std::string::npos; at = text.find(word, at)) {
    const auto end = at + word.size();
    const bool whole = (at == 0 || !in_word(text[at - 1])) && (end == text.size() || !in_word(text[end]));
    if (whole) text.replace(at, word.size(), by);
    at += whole ? by.size() : word.size();
  }
}

void replace_home(std::string& text, const std::string& home) {
  if (home.size() < 2) return;  // "/"
  for (auto at = text.find(home); at != std::string::npos; at = text.find(home, at + 1)) {
    const auto end = at + home.size();
    if (end == text.size() || text[end] == '/' || !in_word(text[end])) text.replace(at, home.size(), "~");
  }
}

/// The lines of a file that begin with one of `keys`.
std::string lines_with(const SystemFiles& system, const std::string& file,
                       const std::vector<std::string>& keys) {
  std::istringstream lines{system.text(file).value_or("")};
  std::string found;
  for (std::string line; std::getline(lines, line);) {
    const auto start = line.find_first_not_of(" \t");
    if (start == std::string::npos) continue;
    const auto begins = [&](const std::string& key) { return line.compare(start, key.size(), key) == 0; };
    if (std::ranges::any_of(keys, begins)) found += line + "\n";
  }
  return found;
}

std::string first_line(const std::string& lines) { return lines.substr(0, lines.find('\n')); }
std::string value_of(const std::string& line) {
  const auto at = line.find_first_of(":=");
  if (at == std::string::npos) return {};
  auto value = line.substr(line.find_first_not_of(" \t\"", at + 1));
  while (!value.empty() && (value.back() == '"' || value.back() == '\n')) value.pop_back();
  return value;
}

/// What the kernel says of the formats and rates of each card.
std::string cards_text(const SystemFiles& system) {
  auto text = system.text("proc/asound/cards").value_or("the kernel lists no sound cards\n");
  for (const auto& card : system.names("proc/asound")) {
    if (card.size() < 5 || !card.starts_with("card") ||
        std::isdigit(static_cast<unsigned char>(card[4])) == 0)
      continue;
    for (const auto& file : system.names("proc/asound/" + card)) {
      const auto path = "proc/asound/" + card + "/" + file;
      const auto found =
          file.starts_with("stream")
              ? lines_with(system, path,
                           {"Playback", "Capture", "Interface", "Format", "Channels", "Rates", "Bits"})
          : file.starts_with("codec") ? lines_with(system, path, {"Codec", "rates", "bits", "formats"})
                                      : std::string{};
      if (!found.empty()) text += card + "/" + file + "\n" + found;
    }
  }
  return text;
}

std::string findings_text(const std::vector<SystemFinding>& findings) {
  std::string text;
  for (const auto& finding : findings)
    text += fmt::format("{:8} {:18}  {}\n",
                        finding.state == SystemFinding::State::Ok     ? "ok"
                        : finding.state == SystemFinding::State::Warn ? "warn"
                                                                      : "unknown",
                        finding.name, finding.what);
  return text;
}

std::string section(const std::string& heading, const std::string& text) {
  return "\n== " + heading + "\n" + text + (text.empty() || text.back() != '\n' ? "\n" : "");
}

}  // namespace

PersonalNames PersonalNames::of_process() {
  PersonalNames names;
  if (const char* home = std::getenv("HOME")) names.home = home;
  names.user = names.home.substr(names.home.rfind('/') + 1);
  for (const auto* key : {"LOGNAME", "USER"})
    if (const char* user = std::getenv(key)) names.user = user;
#if defined(__unix__) || defined(__APPLE__)
  std::array<char, 256> host{};
  if (gethostname(host.data(), host.size() - 1) == 0) names.host = host.data();
#endif
  if (names.user == "root") names.user.clear();  // nobody's name
  if (names.host == "localhost") names.host.clear();
  return names;
}

std::string PersonalNames::removed_from(std::string text) const {
  replace_home(text, home);
  replace_words(text, host, "HOST");
  replace_words(text, user, "USER");
  static const std::regex serial{"serial [^ \\n\"',]+"};
  return std::regex_replace(text, serial, "serial (left out)");
}

std::vector<std::string> sound_servers(const SystemFiles& system) {
  static const std::set<std::string> kServers{"jackd",      "jackdbus",       "pipewire",
                                              "pulseaudio", "pipewire-pulse", "wireplumber"};
  std::vector<std::string> servers;
  for (const auto& id : system.names("proc")) {
    if (id.find_first_not_of("0123456789") != std::string::npos) continue;
    if (!kServers.contains(system.line("proc/" + id + "/comm"))) continue;
    auto command = system.text("proc/" + id + "/cmdline").value_or("");
    std::ranges::replace(command, '\0', ' ');
    servers.push_back(command);
  }
  return servers;
}

std::string support_report(const SystemState& system, const std::vector<SystemFinding>& findings,
                           const std::vector<std::pair<std::string, std::string>>& sections,
                           const PersonalNames& names) {
  const auto processors = lines_with(system, "proc/cpuinfo", {"model name"});
  auto text = section(
      "system", fmt::format("{}\n{}\nkernel {} {}\n{} x {}\n{}", version(),
                            value_of(first_line(lines_with(system, "etc/os-release", {"PRETTY_NAME"}))),
                            system.line("proc/sys/kernel/osrelease"), system.line("proc/sys/kernel/version"),
                            std::ranges::count(processors, '\n'), value_of(first_line(processors)),
                            first_line(lines_with(system, "proc/meminfo", {"MemTotal"}))));
  const auto servers = sound_servers(system);
  text += section("sound servers",
                  servers.empty() ? "none is running" : fmt::format("{}", fmt::join(servers, "\n")));
  if (!system.pipewire.empty()) text += section("PipeWire", system.pipewire);
  text += section("sound cards", cards_text(system));
  text += section("findings", findings_text(findings));
  for (const auto& [heading, more] : sections) text += section(heading, more);
  return "Report of tactus doctor, without names of users and computers and serial numbers\n" +
         names.removed_from(std::move(text));
}

}  // namespace tactus::app
