#include "apps/cli/keys.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

using namespace tactus;
using namespace tactus::app;
using namespace std::chrono_literals;

namespace {

/// The keys among these bytes, which come so far apart; what follows an Escape, at most `after_escape` later.
std::vector<Key> keys_of(const std::string& bytes, std::chrono::milliseconds apart = 0ms,
                         std::chrono::milliseconds after_escape = 50ms) {
  KeyDecoder decoder;
  auto now = KeyDecoder::Clock::now();
  std::vector<Key> keys;
  for (const char byte : bytes) {
    const auto key = decoder.decode(static_cast<unsigned char>(byte), now);
    if (key != kNoKey) keys.push_back(key);
    now += byte == '\x1b' ? std::min(apart, after_escape) : apart;
  }
  return keys;
}

/// The same without those that only disarm.
std::vector<Key> other_keys_of(const std::string& bytes, std::chrono::milliseconds apart = 0ms) {
  auto keys = keys_of(bytes, apart);
  std::erase(keys, kDisarmKey);
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
    const auto keys = other_keys_of("x" + sequence + "y", apart);
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

TEST_CASE("keys: the keyboard protocols of kitty and xterm that another program left on", "[live]") {
  CHECK(keys_of("\x1b[99;5u") == std::vector<Key>{kStopKey});
  CHECK(keys_of("\x1b[27;5;99~") == std::vector<Key>{kStopKey});
  CHECK(keys_of("\x1b[113u\x1b[109;1u\x1b[77;2u") == std::vector<Key>{'q', 'm', 'm'});
  // An a only disarms, with Caps Lock too (modifier 64); with Alt a key is none, and neither is its release.
  CHECK(keys_of("\x1b[97u\x1b[97;65u") == std::vector<Key>{kDisarmKey, kDisarmKey});
  CHECK(keys_of("\x1b[113;3u\x1b[113;1:3u\x1b[57352u\x1b[200u").empty());
}

TEST_CASE("keys: pasted text is no key", "[live]") {
  CHECK(other_keys_of("a\x1b[200~aaqm\x1b[A\x1b[201~q") == std::vector<Key>{'a', 'q'});
  CHECK(other_keys_of("\x1b[200~q\x1b[201~q", 75ms) == std::vector<Key>{'q'});
}

TEST_CASE("keys: the start of a paste without its end takes no key away for more than a second", "[live]") {
  const auto keys = keys_of("\x1b[200~" + std::string(10, 'q'), 300ms);
  CHECK(keys == std::vector<Key>(7, 'q'));  // after 300, 600 and 900 ms it was text
}

TEST_CASE("keys: an a disarms wherever it is, and is a key of its own only alone", "[live]") {
  const std::vector<Key> disarms = {kDisarmKey};
  CHECK(keys_of("\x1b"
                "a") == disarms);
  CHECK(keys_of("\x1b"
                "A") == disarms);
  for (const std::string begin : {"\x1b[", "\x1bO", "\x1b[1;5", "\x1b[200~", "\x1b]11;", "\x1bP", "\x1b[M"}) {
    CAPTURE(begin);
    CHECK(keys_of(begin + "a") == disarms);
  }
}

TEST_CASE("keys: a mouse report is no key, and its bytes may arrive one by one", "[live]") {
  const auto apart = GENERATE(0ms, 300ms);
  CHECK(other_keys_of("\x1b[M qm\x1b[M#qmm", apart) == std::vector<Key>{'m'});
  CHECK(keys_of("\x1b[M a!", apart) == std::vector<Key>{kDisarmKey});
  CHECK(keys_of("\x1b[M\x1b[A", apart) == std::vector<Key>{kUpKey});
}

TEST_CASE("keys: with Caps Lock they are the same", "[live]") {
  CHECK(keys_of("AMQLSH") == std::vector<Key>{'a', 'm', 'q', 'l', 's', 'h'});
}

TEST_CASE("keys: a string that the terminal sends is no key", "[live]") {
  // Replies to: what version, which background, which palette entry; APC, PM and SOS.
  for (const std::string reply :
       {"\x1bP>|XTerm(370)m\x1b\\", "\x1b]11;rgb:1a1a/1b1b/1c1c\x1b\\", "\x1b]4;1;rgb:cdcd/0a00/0000\x07",
        "\x1b_aq\x1b\\", "\x1b^aq\x1b\\", "\x1bXaq\x1b\\"}) {
    CAPTURE(reply);
    CHECK(other_keys_of("x" + reply + "y") == std::vector<Key>{'x', 'y'});
  }
}

TEST_CASE("keys: a string without an end takes no key away for more than a second", "[live]") {
  CHECK(keys_of("\x1b]qqq", 600ms) == std::vector<Key>{'q', 'q'});
  CHECK(keys_of("\x1bPq\x1b[Aq") == std::vector<Key>{kUpKey, 'q'});
}

TEST_CASE("keys: an Escape alone does not take the next key away for more than 50 ms", "[live]") {
  CHECK(keys_of("\x1bq", 51ms, 51ms) == std::vector<Key>{'q'});
  CHECK(keys_of("\x1b"
                "a",
                51ms, 51ms) == std::vector<Key>{'a'});
  CHECK(keys_of("\x1bq", 50ms).empty());
  CHECK(keys_of("\x1b[q", 1001ms) == std::vector<Key>{'q'});
}

TEST_CASE("keys: bytes beyond ASCII are none", "[live]") {
  CHECK(keys_of("\xc3\xa4m") == std::vector<Key>{'m'});
}
