#pragma once

#include <catch2/catch.hpp>
#include <csignal>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/sound_server.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/wait_until.h"

namespace tactus::test {

using namespace std::chrono_literals;

/// Gives out a constant, and hears what comes back.
inline std::string constant(const std::string& level) {
  return "format = 1\nname = \"constant\"\n[inputs]\nheard = {}\n[nodes]\nsame = \"0 * heard + " + level +
         "\"\n[outputs]\ntone = { from = \"same\" }\n";
}

/// `tactus play` with keys for stdin and one log for what it says.
class Playing {
 public:
  explicit Playing(const std::vector<std::string>& arguments,
                   const std::vector<std::string>& program = {TACTUS_PROGRAM, "play"})
      : process_(command(program, arguments), Logged) {}

  void press(const std::string& key) { REQUIRE(process_.type(key)); }
  /// Presses a, then Enter; again where a busy machine took too long between them, or another key or a disarm
  /// is not a second ago. Until `answer`. The times are part of what is pressed.
  void arm(const std::string& answer = "drives armed") {
    for (const auto before = count(answer); count(answer) == before;) {
      const auto asked = count("press Enter"), seen = answers(answer);
      press("a");
      REQUIRE(wait_until([&] { return count("press Enter") > asked || answers(answer) > seen; }));
      std::this_thread::sleep_for(count("press Enter") > asked ? 150ms : 1100ms);
      if (count("press Enter") == asked) continue;
      press("\n");
      REQUIRE(wait_until([&] { return answers(answer) > seen; }));
    }
  }
  /// How often it has printed this.
  int count(const std::string& words) const {
    const auto log = process_.log();
    int found = 0;
    for (auto at = log.find(words); at != std::string::npos; at = log.find(words, at + 1)) ++found;
    return found;
  }
  /// Waits until it prints this.
  bool says(const std::string& words) {
    return wait_until([&] { return process_.log().find(words) != std::string::npos; });
  }
  int ends() { return process_.wait(60s).value_or(-1000); }
  /// The object that --json prints at the end.
  nlohmann::json report() const {
    const auto log = process_.log();
    return nlohmann::json::parse(log.substr(log.find("\n{\n") + 1), nullptr, false);
  }
  std::string log() const { return process_.log(); }
  ChildProcess& process() { return process_; }

 private:
  int answers(const std::string& answer) const { return count(answer) + count("not armed: "); }
  static constexpr auto Logged = ChildProcess::Stdout::Logged;
  static std::vector<std::string> command(std::vector<std::string> program,
                                          const std::vector<std::string>& arguments) {
    program.insert(program.end(), arguments.begin(), arguments.end());
    return program;
  }
  ChildProcess process_;
};

/// A server, if there can be one here, and a file that plays 0.2.
struct OnServer {
  std::string in_folder(const std::string& name) const { return (folder.path() / name).string(); }

  std::unique_ptr<SoundServer> server = start_sound_server();
  TemporaryFolder folder;
  std::string tone = folder.write("tone.toml", constant("0.2")).string();
};

}  // namespace tactus::test
