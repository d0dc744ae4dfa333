#include "engine/core/printable.h"

#include <catch2/catch.hpp>

using namespace tactus;

TEST_CASE("printable: what a terminal would obey or not show is a question mark", "[core]") {
  CHECK(printable("\x1b[2J\x7f\r") == "?[2J??");
  CHECK(printable("a\nb") == "a?b");
  CHECK(printable("a\nb", true) == "a\nb");
  CHECK(printable("\u009b2J") == "?2J");
  CHECK(printable("\u202eabc\u202c \u2066\u2069\u200f\u061c\u2028\ufeff\u200b") == "?abc? ???????");
}

TEST_CASE("printable: letters of any language stay, also those cut short", "[core]") {
  const auto kept = GENERATE("Größe 5 µm", "Ω … “→”", "日本語", "مرحبا", "\xe2\x80", "\xd8", "\xef\xbb");
  CHECK(printable(kept) == kept);
}
