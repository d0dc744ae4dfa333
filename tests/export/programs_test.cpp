#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "engine/guard/drive_guard.h"
#include "export/c_names.h"
#include "export/targets/memory.h"
#include "tests/export/compiled_programs.h"
#include "tests/support/graphs/node_runner.h"

using namespace tactus;
using namespace tactus::test;

namespace {

constexpr double kRate = 48000;

const std::string kWire = "format = 1\nname = \"wire\"\n[inputs]\nx = {}\n[outputs]\ny = { from = \"x\" }\n";

/// The limits of a drive without those stages that are not exported.
DriveLimits exported_limits() {
  auto limits = conservative_limits();
  limits.dc = {};
  return limits;
}

ExportOptions guarded_options(DriveGuard::Kind kind) {
  auto options = exact_options();
  options.limits = [kind](const OutputChannel&) { return GuardedChannel{kind, exported_limits()}; };
  return options;
}

/// Hits of noise that decay, each 0.1 s.
Channels hits(std::size_t channels, int frames) {
  Channels in;
  for (std::size_t c = 0; c < channels; ++c) {
    in.push_back(noise(frames, static_cast<unsigned>(c + 1)));
    for (int n = 0; n < frames; ++n) in[c][static_cast<std::size_t>(n)] *= std::exp(-(n % 4800) / 400.0);
  }
  return in;
}

LoadedGraph shipped(const std::string& instrument) {
  const std::filesystem::path root = std::filesystem::path{TACTUS_SOURCE_DIR} / "instruments";
  return load_graph_leniently(root / instrument / "instrument.toml", root);
}

bool all_finite_and_below(const Samples& samples, double ceiling) {
  return std::ranges::all_of(samples, [&](double x) { return std::abs(x) <= ceiling; });
}

}  // namespace

TEST_CASE("export: shipped instruments give the bits of the engine", "[export]") {
  constexpr int kFrames = 48000;
  constexpr const char* kNames[] = {"wall",     "haptic_drum", "cellomobo",
                                    "membrane", "rope",        "templates/bowed_string"};
  CompiledPrograms programs;
  std::map<std::string, std::string> programs_of;
  for (const char* name : kNames) {
    const auto graph = shipped(name);
    REQUIRE(programs.add(graph, exact_options()) == "");
    programs_of[name] = c_identifier(graph.spec->name);
  }
  programs.compile("-O2");
  for (const char* name : kNames) {
    INFO(name);
    auto engine = engine_for(shipped(name), exact_options());
    const auto in = hits(engine.plan().input_names.size(), kFrames);
    const auto expected = run(engine, in, kFrames, {64});
    CHECK(first_difference(programs.run(programs_of[name], in, kFrames), expected) == "");
    for (const auto& channel : expected) CHECK(std::ranges::any_of(channel, [](double x) { return x != 0; }));
  }
}

TEST_CASE("export: the guard gives the bits of the engine's: ceiling, soft start and slew",
          "[export][guard]") {
  constexpr int kFrames = 48000;
  const auto kind = GENERATE(DriveGuard::Kind::Drive, DriveGuard::Kind::Audio);
  CompiledPrograms programs;
  REQUIRE(programs.add(kWire, guarded_options(kind)) == "");
  programs.compile();
  Samples in = noise(kFrames, 1, -2, 2);
  in[30000] = std::numeric_limits<double>::quiet_NaN();
  in[30001] = std::numeric_limits<double>::infinity();
  const auto running = programs.start("wire");
  Samples out(kFrames);
  for (std::size_t n = 0; n < out.size(); ++n) {
    running.alive();
    running.step(&in[n], &out[n]);
  }
  DriveGuard guard{kind, exported_limits(), Hertz{kRate}, {false, false}};
  guard.set_open(true, 0);
  auto expected = in;
  expected[30000] = expected[30001] = 0;  // the input of the program is finite
  guard.process(expected.data(), kFrames, 0);
  CHECK(first_difference({out}, {expected}) == "");
  CHECK(all_finite_and_below(out, exported_limits().ceiling));
  if (kind == DriveGuard::Kind::Audio) return;
  // The wave is steeper than the limit, so that the steepest step is the limit but for rounding.
  double steepest = 0;
  for (std::size_t n = 1; n < out.size(); ++n) steepest = std::max(steepest, std::abs(out[n] - out[n - 1]));
  CHECK(steepest == Approx(exported_limits().slew_per_second / kRate).epsilon(1e-12));
}

TEST_CASE("export: floats exceed no limit, however slow, and are refused where none could be as slow",
          "[export][guard]") {
  const double ceiling = 0.3,
               slew = GENERATE(0.01, 0.013, 1.0);  // a step of 2^-25 a frame is 0.0014 a second
  auto options = exact_options();
  options.number = find_number_type("float");
  options.limits = [&](const OutputChannel&) {
    GuardedChannel channel{DriveGuard::Kind::Drive, exported_limits()};
    channel.limits.ceiling = ceiling;
    channel.limits.slew_per_second = slew;
    return channel;
  };
  CompiledPrograms programs;
  REQUIRE(programs.add(kWire, options) == "");
  programs.compile();
  const auto running = programs.start("wire");
  double before = 0, steepest = 0, highest = 0;
  for (int n = 0; n < (1.0 + 1.5 * ceiling / slew) * kRate; ++n) {
    const double in = n % 3000 < 100 ? -1 : 1;
    double out = 0;
    running.alive();
    running.step(&in, &out);
    steepest = std::max(steepest, std::abs(out - before));
    highest = std::max(highest, std::abs(out));
    before = out;
  }
  CHECK(highest <= ceiling);
  CHECK(highest > 0.9 * ceiling);
  CHECK(steepest <= slew / kRate);
  CHECK(steepest > 0.85 * slew / kRate);
}

TEST_CASE("export: a slew limit below the spacing of floats is refused", "[export][guard]") {
  auto options = exact_options();
  options.number = find_number_type("float");
  options.limits = [](const OutputChannel&) {
    GuardedChannel channel{DriveGuard::Kind::Drive, exported_limits()};
    channel.limits.ceiling = 0.3;
    channel.limits.slew_per_second = 0.0014;  // 2^-25 a frame is 0.00143
    return channel;
  };
  const auto graph = parse_graph_leniently(kWire, "wire.toml");
  const auto refused = write_program(graph, standard_nodes(), options);
  REQUIRE_FALSE(refused);
  CHECK_THAT(refused.error().front().what, Catch::Contains("0.0014 a second, is less than one step"));
}

TEST_CASE("export: outputs fade out 500 ms after the last sign of life, and come back softly",
          "[export][guard]") {
  CompiledPrograms programs;
  REQUIRE(programs.add(kWire, guarded_options(DriveGuard::Kind::Drive)) == "");
  programs.compile();
  const auto running = programs.start("wire");
  const double level = 0.25, soft_start = 0.5 * kRate, fade_out = 0.01 * kRate;
  const auto at = [&](int frames) {
    double out = 0;
    for (int n = 0; n < frames; ++n) running.step(&level, &out);
    return out;
  };
  CHECK(at(100) == 0);  // no sign of life yet
  for (int n = 0; n < 24001; n += 1000) {
    running.alive();
    at(1000);
  }
  running.alive();
  CHECK(at(24000) == level);  // frames 0 to 23999 since the sign
  CHECK(at(1) == level);      // the ramp begins
  CHECK(at(static_cast<int>(fade_out / 2)) == Approx(level / 2));
  CHECK(at(static_cast<int>(fade_out / 2)) == 0);
  CHECK(at(100000) == 0);
  running.alive();
  CHECK(at(1) == 0);
  CHECK(at(static_cast<int>(soft_start / 4)) == Approx(level / 4));
}

TEST_CASE("export: a loop that explodes starts anew, and no output is ever non-finite", "[export]") {
  const std::string text =
      "format = 1\nname = \"explosion\"\n[inputs]\nx = {}\n[nodes]\n"
      "y = { type = \"delay\", in = \"x + 3 * y\", time = \"1 / system.rate\", interpolation = \"none\" }\n"
      "[outputs]\ny = { from = \"y\" }\n";
  constexpr int kFrames = 6400;
  CompiledPrograms programs;
  REQUIRE(programs.add(text, exact_options()) == "");
  programs.compile();
  const Channels in{Samples(kFrames, 1.0)};
  const auto out = programs.run("explosion", in, kFrames)[0];
  CHECK(all_finite_and_below(out, std::numeric_limits<double>::max()));
  // y[n] = (3^n - 1) / 2 exceeds the largest double, 1.8e308 = 3^646.5 / 2, at n = 647, which frame 646 works
  // out: silent from there to frame 704.
  CHECK(out[645] > 1e307);
  for (std::size_t n = 646; n < 704; ++n) CHECK(out[n] == 0);
  for (std::size_t n = 0; n < 640; ++n) CHECK(out[704 + n] == out[n]);
  // The engine resets the loop, which is all that there is here.
  auto engine = engine_for(parse_graph_leniently(text, "test.toml"), exact_options());
  CHECK(first_difference({out}, run(engine, in, kFrames, {64})) == "");
}

TEST_CASE("export: what cannot be exported is reported all at once, with its place and what to change",
          "[export]") {
  const std::string text =
      "format = 1\n[inputs]\nx = { unit = \"N\" }\n[networks.one]\nsolver = "
      "\"reference\"\n"
      "m = { type = \"mass\", mass = \"1 kg\" }\npush = { type = \"force\", on = \"m\", force = \"x\" }\n"
      "[networks.two]\nsolver = \"reference\"\nm = { type = \"mass\", mass = \"2 kg\" }\npush = { type = "
      "\"force\", on = \"m\", "
      "force = \"x\" }\n"
      "[outputs]\ny = { from = \"(one.m.position + two.m.position) / 1 m\" }\n";
  const auto program =
      write_program(parse_graph_leniently(text, "test.toml"), standard_nodes(), exact_options());
  REQUIRE(!program);
  REQUIRE(program.error().size() == 2);
  CHECK(program.error()[0].where == "test.toml:4:11");
  CHECK(program.error()[1].where == "test.toml:8:11");
  for (const auto& error : program.error()) {
    CHECK(error.code == Errc::BadArgument);
    CHECK_THAT(error.remedy, Catch::Contains("solver = \"auto\""));
  }
}

TEST_CASE("export: only values that no other check covers are tested for being finite", "[export]") {
  const auto checked = [](const std::string& nodes, const std::string& from) {
    const auto text =
        "format = 1\n[inputs]\nx = {}\n[nodes]\n" + nodes + "[outputs]\ny = { from = \"" + from + "\" }\n";
    return write_program(parse_graph_leniently(text, "test.toml"), standard_nodes(), exact_options())
        ->checked;
  };
  const std::string low = "u = { type = \"low_pass\", in = \"x\", cutoff = \"1 kHz\" }\n";
  CHECK(checked(low, "0.5 * u + x") == std::vector<std::string>{"y"});
  // The clip ends what is not finite, and gives nothing that is not.
  CHECK(checked(low + "c = { type = \"clip\", in = \"u\", low = -1, high = 1 }\n", "c") ==
        std::vector<std::string>{"u"});
  CHECK(checked("p = { type = \"decay\", trigger = \"x\", time = \"1 ms\" }\n", "0.5 * p").empty());
}

TEST_CASE("export: a program holds nothing that its graph does not use", "[export]") {
  const auto program =
      write_program(parse_graph_leniently(kWire, "test.toml"), standard_nodes(), exact_options());
  REQUIRE(program);
  CHECK(program->members.empty());
  const auto files = exact_options().target->files(*program);
  const auto& source = files[1].text;
  CHECK(source.find("filter") == std::string::npos);
  CHECK(source.find("guard") == std::string::npos);
  CHECK(std::ranges::count(source, '\n') < 60);
}

TEST_CASE("export: the size of the state is what the compiler makes of it, and what is too large is named",
          "[export]") {
  CompiledPrograms programs;
  REQUIRE(programs.add(shipped("cellomobo"), exact_options()) == "");
  programs.compile("-O0");
  CHECK(state_bytes(programs.program("cellomobo"), machine_types()[0]) == programs.start("cellomobo").size());
  auto options = exact_options();
  options.most_bytes = 100;
  const auto files = export_graph(
      parse_graph_leniently(
          "format = 1\n[inputs]\nx = {}\n[nodes]\necho = { type = \"delay\", in = \"x\", time = \"10 ms\" "
          "}\n[outputs]\ny = { from = \"echo\" }\n",
          "test.toml"),
      standard_nodes(), options);
  REQUIRE(!files);
  REQUIRE(files.error().size() >= 2);
  CHECK(files.error()[1].where == "test.toml:5:1");
  // 480 frames and four taps: 512, four mirrored, and the place of the next one.
  CHECK(files.error()[1].what == "echo: delay takes 4132 bytes");
}

TEST_CASE("export: a network that is too large is named with all that it takes", "[export]") {
  const std::string text =
      "format = 1\nname = \"large\"\n[inputs]\nx = {}\n[networks.string]\nsolver = \"explicit\"\n"
      "c = { type = \"chain\", masses = 100, mass = \"1 g\", stiffness = \"1 kN/m\" }\n"
      "push = { type = \"force\", on = \"c.5\", force = \"x * 1 N\" }\n"
      "ear = { type = \"probe\", on = \"c.50\" }\n[outputs]\ny = { from = \"string.ear.position / 1 m\" }\n";
  CompiledPrograms programs;
  REQUIRE(programs.add(text, exact_options()) == "");
  programs.compile("-O0");
  CHECK(state_bytes(programs.program("large"), machine_types()[0]) == programs.start("large").size());
  auto options = exact_options();
  options.most_bytes = 2000;
  const auto files = export_graph(parse_graph_leniently(text, "test.toml"), standard_nodes(), options);
  REQUIRE(!files);
  REQUIRE(files.error().size() == 2);
  CHECK(files.error()[1].where == "test.toml:5:11");
  // Place, way and change of 100 masses and a fixed point, a force and the input of the last frame.
  CHECK(files.error()[1].what == "string: network takes " + std::to_string(8 * (3 * 101 + 2)) + " bytes");
}

TEST_CASE("export: what many voices do alike is written once, as a loop, and gives the bits of the engine",
          "[export]") {
  constexpr int kFrames = 4800;
  const std::string voices = R"(format = 1
name = "voices"
[inputs]
x = {}
[controls]
gain = { value = 0.9, range = [0, 0.99] }
[nodes]
u = { type = "low_pass", in = "x", voices = 24, cutoff = { from = "300 Hz", to = "4 kHz" } }
d = { type = "delay", in = "s", voices = 24, time = { from = "3 ms", to = "5 ms" } }
loss = { type = "one_pole", in = "d", cutoff = "5 kHz" }
s = "u + gain * loss"
y = { type = "clip", in = "s", low = -0.5, high = 0.5 }
sum = { type = "mix", in = "y" }
[outputs]
out = { from = "sum / 8" }
)";
  CompiledPrograms programs;
  REQUIRE(programs.add(voices, exact_options()) == "");
  programs.compile("-O3");
  auto engine = engine_for(parse_graph_leniently(voices, "voices.toml"), exact_options());
  const auto in = hits(1, kFrames);
  const auto expected = run(engine, in, kFrames, {64});
  CHECK(first_difference(programs.run("voices", in, kFrames), expected) == "");

  const auto program =
      write_program(parse_graph_leniently(voices, "voices.toml"), standard_nodes(), exact_options());
  REQUIRE(program);
  CHECK(program->frame.size() < 24);  // fewer than one of each voice
  CHECK(std::ranges::any_of(program->members, [](const ProgramMember& member) {
    return member.declaration.find(" u[24]") != std::string::npos;
  }));
}

TEST_CASE("export: eight lanes are one loop, from inputs to outputs, and give the bits of the engine",
          "[export]") {
  constexpr int kFrames = 4800;
  const std::string walls = R"toml(format = 1
name = "walls"
[inputs]
x = { unit = "m", lanes = 8 }
[nodes]
v = { type = "velocity", in = "x", cutoff = "200 Hz" }
force = { type = "wall", position = "x", velocity = "v", stiffness = "800 N/m", damping = "2 N s/m" }
[outputs]
out = { from = "max(force, -10 N)", unit = "N" }
)toml";
  CompiledPrograms programs;
  REQUIRE(programs.add(walls, exact_options()) == "");
  programs.compile("-O3");
  auto engine = engine_for(parse_graph_leniently(walls, "walls.toml"), exact_options());
  const auto in = hits(8, kFrames);
  CHECK(first_difference(programs.run("walls", in, kFrames), run(engine, in, kFrames, {64})) == "");
  const auto& frame = programs.program("walls").frame;
  CHECK(std::ranges::count(frame, 8, &Statement::lanes) == 1);
  CHECK(std::ranges::count(frame, 0, &Statement::lanes) == 1);  // whether all lanes are finite
}

TEST_CASE("export: lanes whose common name means something else in the program get another one", "[export]") {
  const std::string voices = R"(format = 1
name = "clash"
[inputs]
x = {}
[nodes]
c = { type = "low_pass", in = "x", voices = 16, cutoff = { from = "300 Hz", to = "4 kHz" } }
out = { type = "clip", in = "c", low = -0.5, high = 0.5 }
sum = { type = "mix", in = "out" }
[outputs]
y = { from = "sum / 8" }
)";
  constexpr int kFrames = 480;
  CompiledPrograms programs;
  REQUIRE(programs.add(voices, exact_options()) == "");
  programs.compile();
  auto engine = engine_for(parse_graph_leniently(voices, "clash.toml"), exact_options());
  const auto in = hits(1, kFrames);
  CHECK(first_difference(programs.run("clash", in, kFrames), run(engine, in, kFrames, {64})) == "");
}

TEST_CASE("export: a value that is not finite in one of many lanes starts all nodes anew", "[export]") {
  constexpr int kFrames = 640;
  const std::string lanes = R"(format = 1
name = "lanes"
[inputs]
x = { lanes = 16 }
[nodes]
s = "x + 0.5 * d"
d = { type = "delay", in = "s", time = "1 ms" }
[outputs]
out = { from = "1e300 * s * s" }
)";
  CompiledPrograms programs;
  REQUIRE(programs.add(lanes, exact_options()) == "");
  programs.compile("-O3");
  Channels in(16, Samples(kFrames, 0.25));
  in[9][100] = 1e200;  // its square is not finite
  const auto out = programs.run("lanes", in, kFrames);
  for (std::size_t lane = 0; lane < 16; ++lane) {
    INFO(lane);
    CHECK(out[lane][99] == 1e300 * 0.4375 * 0.4375);  // twice around the loop: 0.25 + 0.125 + 0.0625
    CHECK(std::all_of(out[lane].begin() + 100, out[lane].begin() + 128, [](double y) { return y == 0; }));
    CHECK(out[lane][128] == 1e300 * 0.0625);  // from the start
  }
}

TEST_CASE("export: for a processor whose doubles are floats a program calculates with floats", "[export]") {
  auto options = exact_options();
  for (const auto& [target, number] : {std::pair{"avr", "float"}, {"cortex-m", "double"}, {"c", "double"}}) {
    options.target = find_export_target(target);
    REQUIRE(options.target != nullptr);
    const auto program = write_program(parse_graph_leniently(kWire, "wire.toml"), standard_nodes(), options);
    REQUIRE(program);
    CHECK(std::string{program->number->name} == number);
  }
}
