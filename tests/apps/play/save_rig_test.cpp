#include "apps/play/save_rig.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>
#include <sstream>

#include "apps/cli/console.h"
#include "apps/cli/rig_files.h"
#include "engine/graph/file/load.h"
#include "engine/rig/check_rig.h"
#include "tests/support/error_summary.h"
#include "tests/support/parse_graph.h"
#include "tests/support/temporary_folder.h"

using namespace tactus;
using tactus::test::parse_graph;
using namespace tactus::app;

namespace {

const std::string kRoot{TACTUS_SOURCE_DIR "/instruments"};
const ProfilePlaces kProfiles{{}, {}, {kRoot}};

std::shared_ptr<const GraphSpec> drum() { return *load_graph(kRoot + "/haptic_drum/instrument.toml", kRoot); }

Rig::Device device() {
  Rig::Device device;
  device.output = "jack:system";
  device.rate = 48_kHz;
  device.block = 64;
  return device;
}

struct Talk {
  Rig rig;
  std::string shown;
};

Talk talk(const std::string& answers, bool defaults = false, int outputs = 4) {
  std::istringstream in{answers};
  std::ostringstream out;
  auto rig = ask_for_rig(*drum(), device(), 2, outputs, kProfiles, {in, out, defaults});
  return {std::move(rig), out.str()};
}

}  // namespace

TEST_CASE("save_rig: all defaults give a rig that fits, with conservative limits", "[rig]") {
  const auto asked = talk("", true);
  CHECK(asked.shown.empty());
  const auto rig = parse_rig(to_text(asked.rig), "rig.toml", kProfiles);
  REQUIRE(rig);
  CHECK(to_string(check_rig(*rig, *drum())).empty());
  CHECK(rig->inputs[0].channels == std::vector{1});
  CHECK(rig->outputs[0].channels == std::vector{1});
  CHECK(rig->outputs[1].channels == std::vector{2});
  CHECK(rig->outputs[0].drive.limits().ceiling == conservative_limits().ceiling);
  CHECK(rig->device.block == 64);
}

TEST_CASE("save_rig: a card with too few outputs leaves the last ones out", "[rig]") {
  const auto asked = talk("", true, 1);
  CHECK(asked.rig.outputs[1].channels.empty());
}

TEST_CASE("save_rig: answers become the rig, and nonsense is asked again", "[rig]") {
  const auto asked = talk(
      "7\ntwo\n2\n"         // microphone: no channel 7
      "1 V\n3 m\n50 mV\n"   // volts, a sensitivity in metres, one in volts
      "3\nwofer\nwoofer\n"  // the woofer's channel and profile
      "\n10 V\n"            // its volts have no default
      "3\n1\n"              // sound cannot share its channel
      "4\n");               // another actuator
  INFO(asked.shown);
  const auto rig = parse_rig(to_text(asked.rig), "rig.toml", kProfiles);
  REQUIRE(rig);
  CHECK(rig->inputs[0].channels == std::vector{2});
  CHECK(rig->inputs[0].scale() == Approx(20));
  CHECK(rig->outputs[0].channels == std::vector{3});
  CHECK(rig->outputs[0].drive.profile == "woofer");
  CHECK(rig->outputs[0].drive.limits().heat->watts_at_full_scale == Approx(100 / 6.5));
  CHECK(rig->outputs[1].channels == std::vector{1});
  CHECK(rig->actuator_on(4) != nullptr);
  for (const auto* name : {"channel 7", "1 to 2", "'two'", "'woofer'", "channel 3"})
    CHECK(asked.shown.find(name) != std::string::npos);
}

TEST_CASE("save_rig: a drive of which no more is known stays an actuator, whatever the instrument becomes",
          "[rig]") {
  const auto rig = parse_rig(to_text(talk("", true).rig), "rig.toml", kProfiles);
  REQUIRE(rig);
  REQUIRE(rig->actuator_on(1) != nullptr);
  CHECK_FALSE(rig->actuator_on(1)->has_actuator());
  CHECK(rig->actuator_on(2) == nullptr);  // sound
  auto later = *drum();
  for (auto& output : later.outputs) output.use = OutputUse::Audio;
  const auto errors = check_rig(*rig, later);
  REQUIRE(errors.size() == 1);
  CHECK(errors.front().what == "'woofer' is an audio output, but channel 1 drives an actuator");
}

TEST_CASE("save_rig: a profile's file is where the rig will look for it", "[rig]") {
  const test::TemporaryFolder folder;
  std::ifstream shipped{kRoot + "/profiles/woofer.toml"};
  const std::string text{std::istreambuf_iterator<char>{shipped}, {}};
  const auto in_desk = folder.write("desk/mine.toml", text), elsewhere = folder.write("mine2.toml", text);
  std::istringstream in{"1\n1 V\n50 mV\n1\n" + elsewhere.string() +
                        "\n../mine2.toml\nmine2.toml\nmine.toml\n10 V\n2\nnone\n"};
  std::ostringstream out;
  const auto file = folder.path() / "desk/rig.toml";
  const auto rig = ask_for_rig(*drum(), device(), 2, 4, profile_places(file), {in, out, false});
  INFO(out.str());
  CHECK(rig.outputs[0].drive.profile == "mine.toml");
  folder.write("desk/rig.toml", to_text(rig));
  CHECK(open_rig(file).outputs[0].drive.profile_file == in_desk);
}

TEST_CASE("change_rig: what was edited since the rig was read stays", "[rig]") {
  const test::TemporaryFolder folder;
  const auto rig_with = [](const std::string& device, const std::string& drive) {
    return "format = 1\n[device]\noutput = \"" + device + "\"\n[outputs]\ndrive = { channel = 1" + drive +
           " }\n";
  };
  const auto file = folder.write("rig.toml", rig_with("card", ""));
  const auto read = open_rig(file);
  const auto set_delay = [](Rig& rig) { rig.measured_delay = 10_ms; };
  folder.write("rig.toml", rig_with("card", ", ceiling = 0.05"));
  CHECK(change_rig(file, read.device, set_delay).empty());
  CHECK(open_rig(file).outputs[0].drive.ceiling == 0.05);
  CHECK(open_rig(file).measured_delay == Seconds{10_ms});
  CHECK_FALSE(open_rig((folder.path() / "rig.toml~")).measured_delay);

  folder.write("rig.toml", rig_with("card", ", ceiling = 0.05, ceilling = 1"));
  CHECK(folder.strip(test::summary(change_rig(file, read.device, set_delay))).starts_with("rig.toml:5:"));
  folder.write("rig.toml", rig_with("other", ""));
  CHECK(
      folder.strip(test::summary(change_rig(file, read.device, set_delay))).starts_with("rig.toml BadFile"));
  CHECK_FALSE(open_rig(file).measured_delay);
}

TEST_CASE("save_rig: the end of the input is an error that names the remedy", "[rig]") {
  try {
    (void)talk("1\n");
    FAIL("no error");
  } catch (const CommandError& error) {
    REQUIRE(error.errors.size() == 1);
    CHECK(error.errors[0].code == Errc::Missing);
    CHECK(error.errors[0].where == "--save-rig");
    CHECK(error.errors[0].remedy.find("--yes") != std::string::npos);
  }
}

TEST_CASE("save_rig: a port in newtons is asked for its sensitivity in volts for one", "[rig]") {
  const auto graph = parse_graph(
      "format = 1\n[inputs]\nforce = { unit = \"N\" }\n[outputs]\nout = { from = \"force / 1 N\" }\n",
      "i.toml");
  REQUIRE(graph);
  const auto ask = [&](const std::string& answers) {
    std::istringstream in{answers};
    std::ostringstream out;
    const auto rig = ask_for_rig(**graph, device(), 2, 1, kProfiles, {in, out, answers.empty()});
    CHECK(to_string(check_rig(*parse_rig(to_text(rig), "rig.toml", kProfiles), **graph)).empty());
    return rig.inputs[0].scale();
  };
  CHECK(ask("1\n2 V\n50 mV/N\n1\n\n") == Approx(40));
  CHECK(ask("") == 1.0);
}

TEST_CASE("save_rig: a file that is there is overwritten only with a yes or by force", "[rig]") {
  const test::TemporaryFolder folder;
  const auto file = folder.write("rig.toml", "mine");
  const auto text = [&] {
    std::ifstream in{file};
    return std::string{std::istreambuf_iterator<char>{in}, {}};
  };
  const auto rig = talk("", true).rig;
  std::ostringstream out;
  for (const auto* no : {"", "\n", "no\n", "nonsense\n"}) {
    std::istringstream in{no};
    const auto status = save_rig(rig, file, {in, out}, false);
    REQUIRE_FALSE(status);
    CHECK(text() == "mine");
  }
  std::istringstream yes{"yes\n"}, nothing;
  REQUIRE(save_rig(rig, file, {yes, out}, false));
  CHECK(text() == to_text(rig));
  folder.write("rig.toml", "mine");
  REQUIRE(save_rig(rig, file, {nothing, out}, true));
  CHECK(text() == to_text(rig));
  CHECK(folder.strip(test::summary(save_rig(rig, folder.path() / "no" / "rig.toml", {nothing, out},
                                            false))) == "no/rig.toml BadFile");
}
