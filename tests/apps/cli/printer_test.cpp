#include "apps/cli/printer.h"

#include <fcntl.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <regex>
#include <string>

#include "tests/support/wait_until.h"

using namespace tactus;
using app::Printer;
using namespace std::chrono_literals;

namespace {

/// Standard error of this process is a pipe, for the life of this object.
class StderrPipe {
 public:
  StderrPipe() : before_(::dup(STDERR_FILENO)) {
    REQUIRE(::pipe(ends_) == 0);
    ::dup2(ends_[1], STDERR_FILENO);
    ::fcntl(ends_[0], F_SETFL, O_NONBLOCK);
  }
  ~StderrPipe() {
    ::dup2(before_, STDERR_FILENO);
    for (const int end : {before_, ends_[0], ends_[1]}) ::close(end);
  }
  void fill() {
    ::fcntl(ends_[1], F_SETFL, O_NONBLOCK);
    const std::string bytes(4096, 'x');
    while (::write(ends_[1], bytes.data(), bytes.size()) > 0) continue;
    ::fcntl(ends_[1], F_SETFL, 0);
  }
  /// Reads until this was written.
  bool shows(const std::string& words) {
    return test::wait_until([&] {
      char bytes[4096];
      for (auto count = ::read(ends_[0], bytes, sizeof bytes); count > 0;
           count = ::read(ends_[0], bytes, sizeof bytes))
        text.append(bytes, static_cast<std::size_t>(count));
      return text.find(words) != std::string::npos;
    });
  }

  std::string text;

 private:
  int before_, ends_[2] = {-1, -1};
};

}  // namespace

TEST_CASE("printer: messages come in order, with the latest status below them", "[live]") {
  StderrPipe err;
  Printer printer{"begin ", " end"};
  printer.status("one\ntwo");
  REQUIRE(err.shows("one\ntwo\x1b[1A\r"));
  printer.print("message");
  REQUIRE(err.shows("\r\x1b[Jmessage\none\ntwo\x1b[1A\r"));
  printer.finish();
  REQUIRE(err.shows("\r\x1b[J end"));
  CHECK(err.text.starts_with("begin one"));
}

TEST_CASE("printer: no name of another program is a command for the terminal", "[live]") {
  StderrPipe err;
  Printer printer{"", " end"};
  printer.print("from '\x1b]0;title\x07\x1b[2J\xc2\x9b'\nsecond line");
  printer.finish();
  REQUIRE(err.shows(" end"));
  CHECK(err.text.starts_with("from '?]0;title??[2J?'\nsecond line\n"));
}

TEST_CASE("printer: nobody waits for a pipe that is full, and what is too much is counted", "[live]") {
  StderrPipe err;
  err.fill();
  Printer printer{"", " end"};
  constexpr int kLines = 2500;
  for (int line = 0; line < kLines; ++line) {
    printer.print("line " + std::to_string(line));
    printer.status("status " + std::to_string(line));
  }
  printer.finish(10ms);
  REQUIRE(err.shows(" end"));
  CHECK(err.text.find("line 0\n") != std::string::npos);
  int printed = 0, counted = 0;
  const std::regex line{"line [0-9]+\n"}, more{"([0-9]+) more messages were not printed"};
  for (std::sregex_iterator found{err.text.begin(), err.text.end(), line}; found != std::sregex_iterator{};
       ++found)
    ++printed;
  for (std::sregex_iterator found{err.text.begin(), err.text.end(), more}; found != std::sregex_iterator{};
       ++found)
    counted += std::stoi((*found)[1]);
  CHECK(printed + counted == kLines);
  CHECK(printed <= 2000);  // a thousand that are being written, and a thousand that wait
}
