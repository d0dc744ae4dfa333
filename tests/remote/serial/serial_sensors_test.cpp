#include "remote/serial/serial_sensors.h"

#include <catch2/catch.hpp>
#include <mutex>

#include "remote/stream_clock.h"
#include "tests/remote/fake_remote_target.h"
#include "tests/remote/serial/serial_device.h"
#include "tests/support/desk.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/terminal_process.h"
#include "tests/support/wait_until.h"

using namespace tactus;

namespace {

/// What a thread posts.
class Target final : public test::FakeRemoteTarget {
 public:
  bool post(std::span<const RemoteOrder> bundle) override {
    const std::lock_guard lock{mutex_};
    posted_.emplace_back(bundle.begin(), bundle.end());
    return true;
  }
  void report(std::string text) override {
    const std::lock_guard lock{mutex_};
    reports_.push_back(std::move(text));
  }
  std::vector<std::vector<RemoteOrder>> posted() const {
    const std::lock_guard lock{mutex_};
    return posted_;
  }
  std::vector<std::string> reports() const {
    const std::lock_guard lock{mutex_};
    return reports_;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<std::vector<RemoteOrder>> posted_;
  std::vector<std::string> reports_;
};

}  // namespace

TEST_CASE("serial sensors: names of devices", "[remote][serial]") {
  CHECK(parse_serial_device("/dev/ttyACM0")->baud == 115200);
  CHECK(parse_serial_device("/dev/ttyUSB0@57600")->device == "/dev/ttyUSB0");
  CHECK(parse_serial_device("/dev/ttyUSB0@57600")->baud == 57600);
  for (const auto* wrong : {"", "@9600", "/dev/x@", "/dev/x@y", "/dev/x@5"})
    CHECK_FALSE(parse_serial_device(wrong));
  test::FakeRemoteTarget target;
  const auto missing = SerialSensors::open({"/dev/no_such_port"}, target);
  REQUIRE_FALSE(missing);
  CHECK(missing.error().code == Errc::Device);
}

TEST_CASE("serial sensors: the terminal that has the stop keys is none", "[remote][serial]") {
  const test::TemporaryFolder folder;
  const auto wire = folder.write("wire.toml", "format = 1\n[outputs]\nout = { from = \"0.1\" }\n");
  const auto* terminal = GENERATE("/dev/tty", "/proc/self/fd/0");
  test::TerminalProcess play{
      {TACTUS_PROGRAM, "play", wire.string(), "--backend", "loop", "--serial", terminal}};
  CHECK(play.shows("the terminal of this program is no sensor"));
  CHECK(play.wait() == 4);
}

TEST_CASE("serial sensors: nor is it one where the standard streams lead elsewhere", "[remote][serial]") {
  const test::TemporaryFolder folder;
  const auto wire = folder.write("wire.toml", "format = 1\n[outputs]\nout = { from = \"0.1\" }\n");
  const auto said = folder.path() / "said.txt";
  const auto command = std::string{TACTUS_PROGRAM} + " play " + wire.string() +
                       " --backend loop --serial $(tty) </dev/null >/dev/null 2>" + said.string();
  test::TerminalProcess play{{"/bin/sh", "-c", command}};
  CHECK(play.wait() == 4);
  CHECK(test::text_of(said).find("the terminal of this program is no sensor") != std::string::npos);
}

TEST_CASE("serial sensors: lines set controls in their unit and range, one bundle each", "[remote][serial]") {
  const test::TemporaryFolder folder;
  test::SerialDevice device{folder.path() / "port"};
  device.plug_in();
  Target target;
  const auto sensors = SerialSensors::open({(folder.path() / "port").string()}, target);
  REQUIRE(sensors);
  const double before = system_seconds();
  device.send("strength 0.25 hold 20\nlevel -20\nstrength 99\nnothing 1\nfixed 1\nst");
  device.send("rength 0.75\n\xff\xfe 12\nstrength 0.1 *00\n");
  REQUIRE(test::wait_until([&] { return (*sensors)->counts().lines == 8; }));
  const auto posted = target.posted();
  REQUIRE(posted.size() == 4);
  REQUIRE(posted[0].size() == 2);
  CHECK(posted[0][0].value == 0.25);
  CHECK(posted[0][1].value == Approx(0.02));
  CHECK(posted[1][0].value == Approx(0.1));
  CHECK(posted[2][0].value == 1.0);
  CHECK(posted[3][0].value == 0.75);
  for (const auto& bundle : posted) {
    CHECK(bundle[0].time_s >= before + SerialSensors::kDelay.value);
    CHECK(bundle[0].time_s <= system_seconds() + SerialSensors::kDelay.value);
  }
  CHECK((*sensors)->counts().refused == 2);
  CHECK((*sensors)->counts().changes == 5);
  const auto reports = target.reports();
  REQUIRE(reports.size() == 4);
  CHECK(reports[0].find("strength: it runs from 0 to 1") != std::string::npos);
  CHECK(reports[1].find("there is no control 'nothing' that can be changed") != std::string::npos);
  CHECK(reports[3].find("the line '?? 12' is refused") != std::string::npos);
}

TEST_CASE("serial sensors: a device that is unplugged is used again when it returns", "[remote][serial]") {
  const test::TemporaryFolder folder;
  test::SerialDevice device{folder.path() / "port"};
  device.plug_in();
  Target target;
  const auto sensors = SerialSensors::open({(folder.path() / "port").string()}, target);
  REQUIRE(sensors);
  device.send("strength 0.1\nstrength 0.");
  REQUIRE(test::wait_until([&] { return (*sensors)->counts().lines == 1; }));
  device.unplug();
  REQUIRE(test::wait_until([&] { return target.reports().size() == 1; }));
  CHECK(target.reports()[0].ends_with("port is gone: its controls stay where they are"));
  device.plug_in();
  REQUIRE(test::wait_until([&] { return target.reports().size() == 2; }));
  device.send("strength 0.5\n");
  REQUIRE(test::wait_until([&] { return target.posted().size() == 2; }));
  CHECK(target.posted()[1][0].value == 0.5);
}
