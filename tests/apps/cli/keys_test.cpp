#include "apps/cli/keys.h"

#include <catch2/catch.hpp>
#include <string>
#include <vector>

using namespace tactus;
using namespace tactus::app;
using namespace std::chrono_literals;

namespace {

/// The keys among these bytes, which come so far apart.
std::vector<Key> keys_of(const std::string& bytes, std::chrono::milliseconds apart = 0ms) {
  KeyDecoder decoder;
  auto now = KeyDecoder::Clock::now();
  std::vector<Key> keys;
  for (const char byte : bytes) {
    const auto key = decoder.decode(static_cast<unsigned char>(byte), now);
    if (key != kNoKey) keys.push_back(key);
    now += apart;
  }
  return keys;
}

}  // namespace

TEST_CASE("keys: control sequences are read to their end, however slowly they arrive", "[live]") {
  const auto apart = GENERATE(0ms, 900ms);
  // rxvt: Ctrl-Up, Shift-Up; xterm: Ctrl-Up, F5, Alt-a; the Linux console: F1; a mouse, a colour report.
  for (const std::string sequence : {"\x1bOa", "\x1b[a", "\x1b[1;5A", "\x1b[15~",
                                     "\x1b"
                                     "a",
                                     "\x1b[[A", "\x1b[<0;3;4m", "\x1bO5A", "\x1b[?1;2c"}) {
    CAPTURE(sequence);
    const auto keys = keys_of("x" + sequence + "y", apart);
    CHECK(keys.front() == 'x');
    CHECK(keys.back() == 'y');
    CHECK((keys.size() == 2 || (keys.size() == 3 && keys[1] >= kUpKey)));
  }
}

TEST_CASE("keys: arrows, in both of their forms", "[live]") {
  const std::vector<Key> arrows = {kUpKey, kDownKey, kRightKey, kLeftKey};
  CHECK(keys_of("\x1b[A\x1b[B\x1b[C\x1b[D") == arrows);
  CHECK(keys_of("\x1bOA\x1bOB\x1bOC\x1bOD") == arrows);
}

TEST_CASE("keys: pasted text is no key", "[live]") {
  CHECK(keys_of("a\x1b[200~aaqm\x1b[A\x1b[201~q") == std::vector<Key>{'a', 'q'});
}

TEST_CASE("keys: a string that the terminal sends is no key", "[live]") {
  // Replies to: what version, which background, which palette entry; APC, PM and SOS.
  for (const std::string reply :
       {"\x1bP>|XTerm(370)m\x1b\\", "\x1b]11;rgb:1a1a/1b1b/1c1c\x1b\\", "\x1b]4;1;rgb:cdcd/0a00/0000\x07",
        "\x1b_aq\x1b\\", "\x1b^aq\x1b\\", "\x1bXaq\x1b\\"}) {
    CAPTURE(reply);
    CHECK(keys_of("x" + reply + "y") == std::vector<Key>{'x', 'y'});
  }
}

TEST_CASE("keys: a string without an end takes no key away for more than a second", "[live]") {
  CHECK(keys_of("\x1b]aaq", 600ms) == std::vector<Key>{'a', 'q'});
  CHECK(keys_of("\x1bPa\x1b[Aq") == std::vector<Key>{kUpKey, 'q'});
}

TEST_CASE("keys: an Escape alone does not take the next key away for more than a second", "[live]") {
  CHECK(keys_of("\x1bq", 1100ms) == std::vector<Key>{'q'});
  CHECK(keys_of("\x1b[q", 1100ms) == std::vector<Key>{'[', 'q'});
}

TEST_CASE("keys: bytes beyond ASCII are none", "[live]") {
  CHECK(keys_of("\xc3\xa4m") == std::vector<Key>{'m'});
}
