#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "backends/backend.h"
#include "tests/support/desk.h"
#include "tests/support/temporary_folder.h"

using namespace tactus;

namespace {

struct Answer {
  int exit;
  nlohmann::json json;
};

Answer check(const test::TemporaryFolder& folder, const std::string& arguments) {
  const auto out = folder.path() / "out.json";
  const int status = std::system(
      (std::string{TACTUS_PROGRAM} + " check --json " + arguments + " > " + out.string() + " 2>/dev/null")
          .c_str());
  std::ifstream text{out};
  return {status / 256, nlohmann::json::parse(text, nullptr, false)};
}

/// Of the spring below.
std::string rig_of(const std::string& device, const std::string& delay = "[delay]\nmeasured = \"2 ms\"\n") {
  return "format = 1\n[device]\n" + device +
         "[inputs]\nplace = { channel = 1, volts_per_full_scale = \"1 V\", sensitivity = \"1 V/m\" }\n"
         "[outputs]\npush = { channel = 1 }\n" +
         delay;
}

std::string spring_of(double stiffness) {
  return "format = 1\nname = \"spring\"\n[inputs]\nplace = { unit = \"m\" }\n[nodes]\n"
         "pull = { type = \"spring\", in = \"place\", stiffness = " +
         std::to_string(stiffness) + " }\n[outputs]\npush = { from = \"pull\", unit = \"N\" }\n" +
         "[delay]\ntested = [\"0 ms\", \"2 ms\"]\n";
}

}  // namespace

TEST_CASE("check: the exit code says whether it holds", "[check]") {
  const test::TemporaryFolder folder;
  const auto file = (folder.path() / "spring.toml").string();
  // 0.1 N s/m / (2 ms + half a frame) = 49.7 N/m; the delay is the longest that it was tested with.
  for (const bool holds : {true, false}) {
    std::ofstream{file} << spring_of(holds ? 45 : 55);
    const auto answer = check(folder, file);
    CHECK(answer.exit == (holds ? 0 : 1));
    REQUIRE(answer.json.is_object());
    CHECK(answer.json["holds"] == holds);
    CHECK(answer.json["delay_ms"].get<double>() == Approx(2));
    CHECK(answer.json["regimes"][0]["stiff"][0]["stable_up_to_n_per_m"].get<double>() ==
          Approx(0.1 / (0.002 + 0.5 / 48000)).epsilon(0.01));
    CHECK(answer.json["runs"].size() > 15);
  }
}

TEST_CASE("check: a high-pass of the rig's output is part of the loop", "[check]") {
  const test::TemporaryFolder folder;
  const auto file = (folder.path() / "spring.toml").string();
  const auto rig = (folder.path() / "desk.toml").string();
  std::ofstream{file} << spring_of(45);
  std::ofstream{rig}
      << "format = 1\n[device]\noutput = \"x\"\n[inputs]\nplace = { channel = 1, volts_per_full_scale "
         "= \"1 V\", sensitivity = \"1 V/m\" }\n[outputs]\npush = { channel = 1, output_highpass = \"2 Hz\" "
         "}\n[delay]\nmeasured = \"2 ms\"\n";
  // m s^2 + (b + m wc) s + b wc + k e^(-s T) = 0 on the border s = jw, with the device of 50 g and 0.1 N s/m:
  // k sin wT = w (b + m wc), k cos wT = m w^2 - b wc.
  const double m = 0.05, b = 0.1, wc = 2 * 3.14159265358979 * 2, T = 0.002 + 0.5 / 48000;
  double low = 1, high = 0.5 * 3.14159265358979 / T;
  for (int step = 0; step < 100; ++step) {
    const double w = 0.5 * (low + high);
    const bool below = std::tan(w * T) * (m * w * w - b * wc) < w * (b + m * wc);
    (below ? low : high) = w;
  }
  const double border = low * (b + m * wc) / std::sin(low * T);
  const auto answer = check(folder, file + " --rig " + rig);
  CHECK(answer.exit == 0);
  REQUIRE(answer.json.is_object());
  CHECK(answer.json["delay_ms"].get<double>() == Approx(2));
  CHECK(answer.json["regimes"][0]["stiff"][0]["stable_up_to_n_per_m"].get<double>() ==
        Approx(border).epsilon(0.01));
  const auto lines = answer.json["output_highpass"].dump();
  CHECK(lines.find("79.58 ms") != std::string::npos);  // 1 / (2 pi 2 Hz)
  CHECK(lines.find("'instrument.pull' must hold a force") != std::string::npos);
  for (const auto& run : answer.json["runs"]) {
    INFO(run["what"]);
    CHECK(run["as_expected"] == true);
  }
}

TEST_CASE("check: an instrument that must hold a force on an AC-coupled output is warned of, others are not",
          "[check]") {
  const test::TemporaryFolder folder;
  const auto file = (folder.path() / "a.toml").string(), rig = (folder.path() / "desk.toml").string();
  const std::string law = GENERATE(as<std::string>{}, "-100 * place", "1 * rest.high");
  std::ofstream{file}
      << "format = 1\n[inputs]\nplace = {}\n[nodes]\nrest = { type = \"one_pole\", in = \"place\", "
         "cutoff = \"40 Hz\" }\n[outputs]\nmotor = { from = \"" +
             law + "\" }\n";
  std::ofstream{rig}
      << "format = 1\n[device]\noutput = \"x\"\n[inputs]\nplace = { channel = 1 }\n[outputs]\nmotor "
         "= { channel = 1, output_highpass = \"5 Hz\" }\n[delay]\nmeasured = \"2 ms\"\n";
  const auto answer = check(folder, file + " --quick --rig " + rig);
  REQUIRE(answer.json.is_object());
  const auto lines = answer.json["output_highpass"].dump();
  CHECK(lines.find("31.83 ms") != std::string::npos);  // 1 / (2 pi 5 Hz)
  CHECK((lines.find("'motor' (from 'place') must hold a force") != std::string::npos) ==
        (law == "-100 * place"));
}

TEST_CASE("check: a rig is judged at the rate of its device", "[check]") {
  const test::Desk desk;
  desk.folder.write("spring.toml", spring_of(45));
  std::vector<std::tuple<std::string, std::string, double>> rates{
      {"output = \"x\"\n", "", 48000},
      {"output = \"x\"\nrate = \"96 kHz\"\n", "", 96000},
      {"output = \"x\"\nrate = \"96 kHz\"\n", " --rate \"32 kHz\"", 32000}};
  for (const auto& backend : haptic_backends()) {
    rates.emplace_back("output = \"" + backend.name + ":Wheel\"\n", "", 8000);
    rates.emplace_back("output = \"" + backend.name + ":Wheel\"\nrate = \"16 kHz\"\n", "", 16000);
  }
  for (const auto& [device, options, rate] : rates) {
    CAPTURE(device, options);
    desk.folder.write("rig.toml", rig_of(device));
    const auto answer = desk.run("check spring.toml --quick --json --rig rig.toml" + options).json();
    REQUIRE(answer.is_object());
    CHECK(answer["sample_rate_hz"].get<double>() == rate);
    CHECK(answer["regimes"][0]["stiff"][0]["stable_up_to_n_per_m"].get<double>() ==
          Approx(0.1 / (0.002 + 0.5 / rate)).epsilon(0.01));
  }
}

TEST_CASE("check: the remedy of a rig without a delay is one of its device", "[check]") {
  const test::Desk desk;
  desk.folder.write("spring.toml", spring_of(45));
  desk.folder.write("rig.toml", rig_of("output = \"x\"\n", ""));
  const std::string command = "check spring.toml --quick --rig rig.toml";
  test::check_exit(desk.run(command), 3, "delay measure --rig rig.toml --delay");
  for (const auto& backend : haptic_backends()) {
    desk.folder.write("rig.toml", rig_of("output = \"" + backend.name + ":Wheel\"\n", ""));
    const auto answer = desk.run(command);
    test::check_exit(answer, 3, "delay reports --delay");
    CHECK(answer.err.find("latency measure") == std::string::npos);
  }
}

TEST_CASE("check: a rig is refused that play refuses", "[check]") {
  const test::Desk desk;
  desk.folder.write("spring.toml", spring_of(45));
  std::vector<std::pair<std::string, std::string>> refused;  // rig, names in the error
  const std::string card = "output = \"loop:cable\"\nsecond = ";
  for (const std::string second : {"loop:cable", "nowhere:Wheel", "Wheel"})
    refused.emplace_back(rig_of(card + "\"" + second + "\"\n"), "rig.toml:2 '" + second + "'");
  for (const auto& backend : haptic_backends())
    refused.emplace_back(
        rig_of("output = \"" + backend.name + ":Pad\"\nsecond = \"" + backend.name + ":Wheel\"\n"),
        "rig.toml:2 '" + backend.name + ":Wheel'");
  refused.emplace_back("format = 1\n[device]\noutput = \"loop:cable\"\n[outputs]\npush = { channel = 1 }\n",
                       "rig.toml:1 'place'");
  for (const auto& [rig, names] : refused) {
    CAPTURE(rig);
    desk.folder.write("rig.toml", rig);
    test::check_exit(desk.run("check spring.toml --quick --delay \"2 ms\" --rig rig.toml"), 3, names);
    test::check_exit(desk.run("play spring.toml --duration \"0.1 s\" --rig rig.toml"), 3, names);
  }
}

TEST_CASE("check: verdict first, one line of what was checked, tables when asked for", "[check]") {
  const test::TemporaryFolder folder;
  const auto file = (folder.path() / "spring.toml").string();
  std::ofstream{file} << spring_of(45);
  const auto print = [&](const std::string& options) {
    const auto out = folder.path() / "out.txt";
    (void)std::system(
        (std::string{TACTUS_PROGRAM} + " check " + file + options + " > " + out.string() + " 2>&1").c_str());
    std::ifstream text{out};
    return std::string{std::istreambuf_iterator<char>{text}, {}};
  };
  const auto brief = print("");
  CHECK(brief.starts_with("stable\n"));
  CHECK(brief.find("\nchecked: ") != std::string::npos);
  CHECK(brief.find("simulation runs; --verbose") != std::string::npos);
  CHECK(brief.find("full-scale square") == std::string::npos);
  const auto all = print(" --verbose");
  CHECK(all.find("full-scale square") != std::string::npos);
  CHECK(all.find("45 N/m") != std::string::npos);
  CHECK(all.find("192 kHz") != std::string::npos);
  CHECK(all.find("e+0") == std::string::npos);
}

TEST_CASE("check: the haptic drum holds in its scene", "[check]") {
  const test::TemporaryFolder folder;
  const auto answer = check(folder, std::string{TACTUS_SOURCE_DIR} + "/instruments/haptic_drum");
  CHECK(answer.exit == 0);
  REQUIRE(answer.json.is_object());
  for (const auto& run : answer.json["runs"]) {
    INFO(run["what"]);
    CHECK(run["as_expected"] == true);
  }
  bool looped = false;
  for (const auto& event : answer.json["events"])
    looped = looped || (event["name"] == "instrument.hit" && event["on_loop"] == true);
  CHECK(looped);
}

TEST_CASE("check: the Cellomobo holds while it is played", "[check][slow]") {
  const test::TemporaryFolder folder;
  const auto answer =
      check(folder, std::string{TACTUS_SOURCE_DIR} + "/instruments/cellomobo/open_string.toml");
  CHECK(answer.exit == 0);
  REQUIRE(answer.json.is_object());
  for (const auto& run : answer.json["runs"]) {
    INFO(run["what"]);
    CHECK(run["as_expected"] == true);
  }
}

TEST_CASE("check: bad files and bad options have their own exit codes", "[check]") {
  const test::TemporaryFolder folder;
  const auto file = (folder.path() / "spring.toml").string();
  std::ofstream{file} << spring_of(45);
  CHECK(check(folder, (folder.path() / "none.toml").string()).exit == 3);
  CHECK(check(folder, file + " --delay \"3 kg\"").exit == 2);
  std::ofstream{file} << "format = 1\n[nodes]\nx = { type = \"sprung\" }\n";
  CHECK(check(folder, file).exit == 3);
}
