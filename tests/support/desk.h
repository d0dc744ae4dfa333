#pragma once

#include <sys/wait.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "tests/support/temporary_folder.h"

namespace tactus::test {

inline std::string text_of(const std::filesystem::path& file) {
  std::ifstream in{file};
  return {std::istreambuf_iterator<char>{in}, {}};
}

/// What the program did.
struct Ran {
  int exit = -1;
  std::string out, err;
  nlohmann::json json() const { return nlohmann::json::parse(out, nullptr, false); }
};

/// A folder with the files of a test, where the program runs and keeps what it measures.
class Desk {
 public:
  /// `before`: for the shell, as in "ulimit -v 100000;". `input`: what it reads from stdin.
  Ran run(const std::string& arguments, const std::string& before = {}, const std::string& input = {}) const {
    folder.write("in.txt", input);
    const auto command = "cd " + folder.path().string() + " && " + before +
                         " XDG_STATE_HOME=" + state().string() + " " + TACTUS_PROGRAM + " " + arguments +
                         " > out.txt 2> err.txt < in.txt";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, text_of(file("out.txt")), text_of(file("err.txt"))};
  }
  std::filesystem::path file(const std::string& name) const { return folder.path() / name; }
  std::filesystem::path state() const { return folder.path() / "state"; }

  TemporaryFolder folder;
};

/// `names`: all of them stand in the output, in this order.
inline void check_exit(const Ran& ran, int exit, const std::string& names) {
  INFO(ran.out << ran.err);
  CHECK(ran.exit == exit);
  std::size_t at = 0;
  std::istringstream words{names};
  for (std::string word; words >> word;) {
    CAPTURE(word);
    at = (ran.out + ran.err).find(word, at);
    CHECK(at != std::string::npos);
  }
}

}  // namespace tactus::test
