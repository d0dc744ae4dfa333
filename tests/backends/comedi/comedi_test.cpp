// The backend for data acquisition cards, without one. On a driver of a real kernel: tests/cards/comedi.
#include <comedilib.h>

#include <catch2/catch.hpp>

#include "backends/acquisition_backends.h"
#include "backends/comedi/comedi_settings.h"
#include "backends/comedi/converter_range.h"
#include "backends/described_devices.h"
#include "engine/core/named.h"

using namespace tactus;

TEST_CASE("converter range: volts are those of Comedi, and every raw value comes back") {
  const auto [low, high, most] = GENERATE(std::tuple{-10.0, 10.0, 65535u}, std::tuple{-5.0, 5.0, 4095u},
                                          std::tuple{0.0, 10.0, 65535u}, std::tuple{-1.0, 4.0, 255u});
  const ConverterRange range{low, high, most};
  comedi_range reference{};
  reference.min = low;
  reference.max = high;
  reference.unit = UNIT_volt;
  comedi_set_global_oor_behavior(COMEDI_OOR_NUMBER);
  for (unsigned raw = 0; raw <= most; ++raw) {
    const double share = range.share(raw);
    REQUIRE(share * range.full_scale() == Approx(comedi_to_phys(raw, &reference, most)).margin(1e-12 * high));
    REQUIRE(std::abs(share) <= 1.0);
    REQUIRE(range.raw(share) == raw);
  }
}

TEST_CASE("converter range: any voltage is converted to the nearest step, and limited at the ends") {
  const ConverterRange range{-10.0, 10.0, 65535};
  CHECK(range.full_scale() == 10.0);
  CHECK(range.step() == Approx(20.0 / 65535));
  for (double share = -1.0; share <= 1.0; share += 0.000123)
    REQUIRE(std::abs(range.share(range.raw(share)) - share) <= 0.5 * range.step() / 10.0 + 1e-12);
  CHECK(range.raw(1.5) == 65535);
  CHECK(range.raw(-1.5) == 0);
  const ConverterRange unipolar{0.0, 5.0, 4095};
  CHECK(unipolar.raw(0.0) == 0);
  CHECK(unipolar.raw(-1.0) == 0);  // it has no negative voltage
  CHECK(unipolar.raw(1.0) == 4095);
}

TEST_CASE("comedi settings: a file and what follows it") {
  const auto plain = comedi_settings("/dev/comedi0");
  REQUIRE(plain);
  CHECK(plain->file == "/dev/comedi0");
  CHECK_FALSE(plain->in_range);
  CHECK(plain->pace == PacedSettings{});
  const auto full =
      comedi_settings("/dev/comedi1,in_range=2,out_range=0,reference=diff,wait=busy,core=3,priority=70");
  REQUIRE(full);
  CHECK(full->file == "/dev/comedi1");
  CHECK(full->in_range == 2);
  CHECK(full->out_range == 0);
  CHECK(full->reference == ComediSettings::Reference::Differential);
  CHECK(full->pace.wait == SystemTimer::Wait::Busy);
  CHECK(full->pace.core == 3);
  CHECK(full->pace.priority == 70);
}

TEST_CASE("comedi settings: what means nothing is an error that names the setting and its values") {
  const auto [text, named] =
      GENERATE(std::pair{"/dev/comedi0,speed=3", "in_range"}, std::pair{"/dev/comedi0,wait=long", "timer"},
               std::pair{"/dev/comedi0,core=-1", "1023"}, std::pair{"/dev/comedi0,priority=99", "89"},
               std::pair{"/dev/comedi0,in_range", "number"});
  const auto settings = comedi_settings(text);
  REQUIRE_FALSE(settings);
  CHECK(settings.error().code == Errc::BadArgument);
  CHECK(settings.error().remedy.find(named) != std::string::npos);
}

TEST_CASE("comedi: a file that is not there is an error with a remedy") {
  const auto backend = find_named(acquisition_backends(), "comedi")->make();
  CHECK(backend->name() == "comedi");
  auto* described = dynamic_cast<DescribedDevices*>(backend.get());
  REQUIRE(described != nullptr);
  CHECK(described->add("comedi:0").error().code == Errc::UnknownName);
  const auto missing = described->add("comedi:/dev/no_such_card");
  REQUIRE_FALSE(missing);
  CHECK(missing.error().code == Errc::Device);
  CHECK(missing.error().remedy.find("modprobe") != std::string::npos);
  const auto other = described->add("comedi:/dev/null");  // a file of another kind
  REQUIRE_FALSE(other);
  CHECK(other.error().code == Errc::Device);
}
