#include "engine/core/error.h"

#include <catch2/catch.hpp>

using namespace tactus;

TEST_CASE("error: its place is an option, a file or none, also after it moved", "[core]") {
  const Error nowhere{Errc::OutOfRange, "", "too large", ""};
  CHECK(nowhere.place() == Error::Place::None);
  CHECK(nowhere.at("--rate").place() == Error::Place::Option);
  CHECK(nowhere.at("--rate").at("wall.toml:12:8").place() == Error::Place::File);
  CHECK(to_string(nowhere.at("wall.toml:12:8")) == "wall.toml:12:8: too large");
}
