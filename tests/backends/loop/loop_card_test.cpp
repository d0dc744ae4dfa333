#include "backends/loop/loop_card.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/error_summary.h"

using namespace tactus;

TEST_CASE("loop_card: every name in the list is a card, and says what it is", "[loop]") {
  REQUIRE(loop_cards().size() > 10);
  for (const auto& [name, about, settings] : loop_cards()) {
    CAPTURE(name);
    CHECK(loop_card(name));
    CHECK(std::string{about}.size() > 5);
  }
}

TEST_CASE("loop_card: settings are read in their units, behind a name or alone", "[loop]") {
  const auto card = loop_card("delay=960.25,gain=-20dB,noise=0.001,ppm=-50,blocks=2,bits=16");
  REQUIRE(card);
  CHECK(card->delay == Seconds{0.0});
  CHECK(card->delay_frames == 960.25);
  CHECK(card->gain == Approx(0.1));
  CHECK(card->noise == 0.001);
  CHECK(card->input_ppm == -50.0);
  CHECK(card->delay_blocks == 2);
  CHECK(card->bits == 16);
  CHECK(loop_card("35.5ms")->delay.value == Approx(0.0355));
  CHECK(loop_card("agc,5ms")->agc);
  CHECK(loop_card("agc,5ms")->delay.value == Approx(0.005));
}

TEST_CASE("loop_card: what means nothing, or cannot be, is refused in words", "[loop]") {
  for (const char* text : {"", "nothing", "delay=", "delay=x", "delay=1frames", "=3", "20ms,cable", "-5ms",
                           "delay=1e300", "blocks=1e30", "noise=nan", "clip=2", "gain=inf"}) {
    CAPTURE(text);
    const auto card = loop_card(text);
    REQUIRE_FALSE(card);
    CHECK(card.error().code == Errc::UnknownName);
    CHECK(test::summary(card).find("'" + std::string{text} + "'") != std::string::npos);
  }
}
