#if defined(TACTUS_PROGRAM) && defined(__unix__)

#include <sys/wait.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>

#include "tests/support/temporary_folder.h"

using namespace tactus;

namespace {

struct Rendered {
  int exit_code;
  std::string text;
};

/// `tactus render` of a graph with one drive, for 2 s.
Rendered render(const std::string& nodes) {
  const test::TemporaryFolder folder;
  const auto file = folder.write("test.toml", "format = 1\nname = \"test\"\n[nodes]\n" + nodes +
                                                  "\n[outputs]\nshaker = { from = \"x\" }\n");
  const auto out = folder.path() / "out.txt";
  std::string command = TACTUS_PROGRAM;
  command += " render " + file.string() + " --duration '2 s' >" + out.string() + " 2>&1";
  const int status = std::system(command.c_str());
  std::ifstream text{out};
  return {WEXITSTATUS(status), {std::istreambuf_iterator<char>{text}, {}}};
}

}  // namespace

TEST_CASE("render: a plain loud tone is left alone, and one beyond a limit names what would allow it",
          "[apps]") {
  const auto plain = render(R"(x = { type = "sine", level = 0.45, frequency = "400 Hz" })");
  INFO(plain.text);
  CHECK(plain.exit_code == 0);
  CHECK(plain.text.find("drive guard") == std::string::npos);
  // 0.45 at 4 kHz moves by 11,300 full scales a second.
  const auto steep = render(R"(x = { type = "sine", level = 0.45, frequency = "4 kHz" })");
  INFO(steep.text);
  CHECK(steep.exit_code == 0);
  CHECK(steep.text.find("--raise-limit shaker.slew=") != std::string::npos);
  CHECK(steep.text.find("feedback") == std::string::npos);
}

TEST_CASE("render: a loop that grows is faded, and the exit code is 1", "[apps]") {
  const auto loop = render(R"(kick = { type = "sine", level = 0.01, frequency = "100 Hz" }
x = "kick + 1.5 * echo"
echo = { type = "delay", in = "x", time = "5 ms" })");
  INFO(loop.text);
  CHECK(loop.exit_code == 1);
  CHECK(loop.text.find("shaker: feedback at 0.") != std::string::npos);
  CHECK(loop.text.find("the ceiling clipped it") != std::string::npos);
  CHECK(loop.text.find("--raise-limit") == std::string::npos);
}

#endif
