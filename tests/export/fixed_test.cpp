#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "tests/export/compiled_programs.h"

using namespace tactus;
using namespace tactus::test;

namespace {

constexpr double kFixedRate = 20000;

ExportOptions integers(const char* number) {
  auto options = exact_options();
  options.number = find_number_type(number);
  options.sample_rate = Hertz{kFixedRate};
  return options;
}

const std::string kFixedHead =
    "format = 1\nname = \"graph\"\n[inputs]\nx = { range = [-2, 2] }\ny = { range = [-0.5, 3] }\n"
    "[controls]\nc = { value = 0.7, range = [-1, 2], smooth = \"0 ms\" }\n";

std::string graph_of(const std::string& nodes, const std::string& output = "1 N * z") {
  return kFixedHead + "[nodes]\n" + nodes + "\n[outputs]\nout = { from = \"" + output +
         "\", unit = \"N\" }\n";
}

/// A program in integers beside the engine, which gets the same numbers.
class IntegersBeside {
 public:
  IntegersBeside(const std::string& text, const ExportOptions& options)
      : graph_(parse_graph_leniently(text, "test.toml")), options_(options) {
    auto program = write_fixed_program(graph_, standard_nodes(), options);
    if (!program) throw std::runtime_error(full_text(program.error()));
    program_ = *program;
    if (std::system(TACTUS_C_COMPILER " --version > /dev/null 2>&1") != 0) skip("there is no C compiler");
    folder_.write("graph.h", fixed_header(program_));
    folder_.write("graph_numbers.h", fixed_numbers(program_));
    folder_.write("graph.c", fixed_source(program_));
    folder_.write("test.c",
                  "#include \"graph.h\"\nstatic graph program;\nvoid test_init(void);\nvoid test_step(const "
                  "graph_number*, graph_number*);\n"
                  "void test_init(void) { graph_init(&program); }\n"
                  "void test_step(const graph_number* in, graph_number* out) { graph_alive(&program); "
                  "graph_step(&program, in, out); }\n");
    const auto command = "cd " + folder_.path().string() +
                         " && " TACTUS_C_COMPILER
                         " -std=c99 -pedantic -Wall -Wextra -O1 -fsanitize=signed-integer-overflow,bounds "
                         "-fsanitize-undefined-trap-on-error"
                         " -shared -fPIC graph.c test.c -o graph.so > messages 2>&1";
    if (std::system(command.c_str()) != 0)
      throw std::runtime_error("it does not compile: see " + folder_.path().string());
    library_ = dlopen((folder_.path() / "graph.so").c_str(), RTLD_NOW | RTLD_LOCAL);
    if (library_ == nullptr) throw std::runtime_error(dlerror());
    reinterpret_cast<void (*)()>(dlsym(library_, "test_init"))();
  }
  ~IntegersBeside() {
    if (library_ != nullptr) dlclose(library_);
  }
  IntegersBeside(const IntegersBeside&) = delete;

  /// Largest distance of the first output to the engine's, for inputs that are random, jump between the ends
  /// of their ranges, or stay.
  double distance(int frames, unsigned seed) {
    std::mt19937 random{seed};
    const auto count = program_.inputs.size();
    Channels in(count, std::vector<double>(static_cast<std::size_t>(frames)));
    std::vector<std::vector<std::int32_t>> numbers(
        count, std::vector<std::int32_t>(static_cast<std::size_t>(frames)));
    for (std::size_t c = 0; c < count; ++c) {
      const auto& value = program_.inputs[c].value;
      for (std::size_t n = 0; n < in[c].size(); ++n) {
        const auto which = (n / 50) % 3;
        const double t = std::generate_canonical<double, 30>(random);
        double x = which == 0    ? t
                   : which == 1  ? std::round(t)
                   : n % 50 == 0 ? t
                                 : (in[c][n - 1] - value.range.low) / (value.range.high - value.range.low);
        x = value.range.low + x * (value.range.high - value.range.low);
        numbers[c][n] = static_cast<std::int32_t>(std::trunc(std::ldexp(x, value.exponent)));
        in[c][n] = std::ldexp(numbers[c][n], -value.exponent);
      }
    }
    auto engine = engine_for(graph_, options_);
    const auto expected = run(engine, in, frames, {64});
    double largest = 0;
    const auto given = step_all(numbers, frames);
    for (std::size_t n = 0; n < given.size(); ++n)
      largest = std::max(
          largest, std::abs(std::ldexp(given[n], -program_.outputs[0].value.exponent) - expected[0][n]));
    return largest;
  }
  double bound() const { return program_.outputs[0].value.error; }
  double step() const { return program_.outputs[0].value.step(); }
  const FixedProgram& program() const { return program_; }

 private:
  std::vector<double> step_all(const std::vector<std::vector<std::int32_t>>& in, int frames) const {
    return program_.bits == 16 ? steps<std::int16_t>(in, frames) : steps<std::int32_t>(in, frames);
  }
  template <class Number>
  std::vector<double> steps(const std::vector<std::vector<std::int32_t>>& in, int frames) const {
    const auto step = reinterpret_cast<void (*)(const Number*, Number*)>(dlsym(library_, "test_step"));
    std::vector<Number> now(in.size() + 1), out(program_.outputs.size());
    std::vector<double> given;
    for (std::size_t n = 0; n < static_cast<std::size_t>(frames); ++n) {
      for (std::size_t c = 0; c < in.size(); ++c) now[c] = static_cast<Number>(in[c][n]);
      step(now.data(), out.data());
      given.push_back(out[0]);
    }
    return given;
  }

  LoadedGraph graph_;
  ExportOptions options_;
  FixedProgram program_;
  TemporaryFolder folder_;
  void* library_ = nullptr;
};

std::string refusal_of(const std::string& text, const char* number = "q16") {
  const auto program =
      write_fixed_program(parse_graph_leniently(text, "test.toml"), standard_nodes(), integers(number));
  return program ? "" : full_text(program.error());
}

/// Nodes whose programs decide nothing, so that their bounds are those of all frames; and steps of the output
/// within which the error of 16 bits stays: bounds that say nothing would be useless.
struct Bounded {
  const char* nodes;
  double steps;
  const char* output = "1 N * z";  ///< with a unit: plain numbers are limited to full scale
};
const Bounded kBounded[] = {
    {"z = \"x + y\"", 3},
    {"z = \"x - 1.5 * y\"", 4},
    {"z = \"x * y\"", 2},
    {"z = \"c * x + 0.25 * y\"", 6},
    {"z = \"x / 3 + y / c2\"\nc2 = \"c + 2\"", 30},
    {"z = \"min(x, y) + max(c, x)\"", 6},
    {"z = \"abs(x) * abs(y)\"", 4},
    {"z = \"clamp(5 * x * y, -1, 0.3)\"", 30},
    {"z = \"sin(x) + exp(-y)\"", 20},
    {"z = \"sqrt(y + 1) * tanh(x)\"", 20},
    {"z = \"pow(y + 1, 1.5)\"", 40},
    {"z = { type = \"clip\", in = \"40 * x * y\", low = -0.5, high = 0.8 }", 200},
    {"z = { type = \"one_pole\", in = \"x\", cutoff = \"300 Hz\" }", 8},
    {"z = { type = \"one_pole\", in = \"x\", cutoff = \"20 Hz\", form = \"matched\" }", 8},
    {"z = \"p.high\"\np = { type = \"one_pole\", in = \"x\", cutoff = \"2 kHz\" }", 16},
    {"z = { type = \"dc_blocker\", in = \"y\", cutoff = \"10 Hz\" }", 16},
    {"z = { type = \"velocity\", in = \"x\", cutoff = \"500 Hz\" }", 16, "1 N s * z"},
    {"z = { type = \"difference\", in = \"x\" }", 4, "1 N s * z"},
    {"z = { type = \"low_pass\", in = \"x\", cutoff = \"1 kHz\" }", 3},
    {"z = { type = \"high_pass\", in = \"x\", cutoff = \"40 Hz\" }", 3},
    {"z = { type = \"band_pass\", in = \"y\", frequency = \"440 Hz\", q = 5 }", 3},
    {"z = { type = \"envelope\", in = \"x\", attack = \"1 ms\", release = \"20 ms\" }", 30},
    {"z = { type = \"delay\", in = \"x\", time = \"0.5 ms\", interpolation = \"none\" }", 1},
    {"z = { type = \"hysteresis\", in = \"x\", width = \"0.2 * abs(c)\" }", 16},
    {"z = { type = \"map\", in = \"x\", points = [[-1, 2], [0, 0], [1.5, 1]] }", 80},
    {"z = \"x + 0.5 * before\"\nbefore = { type = \"delay\", in = \"z\", time = \"1 / system.rate\", "
     "interpolation = \"none\" }",
     8},
};

}  // namespace

TEST_CASE("export: programs in integers stay within their bounds", "[export][fixed]") {
  const auto& bounded = GENERATE(from_range(std::begin(kBounded), std::end(kBounded)));
  for (const char* number : {"q16", "q31"}) {
    CAPTURE(bounded.nodes, number);
    IntegersBeside programs{graph_of(bounded.nodes, bounded.output), integers(number)};
    CHECK(programs.distance(3000, 1) <= programs.bound());
    if (programs.program().bits == 16) CHECK(programs.bound() <= bounded.steps * programs.step());
  }
}

TEST_CASE("export: random expressions in integers stay within their bounds", "[export][fixed]") {
  std::mt19937 random{7};
  const auto pick = [&](int count) { return static_cast<int>(random() % static_cast<unsigned>(count)); };
  const std::function<std::string(int)> expression = [&](int depth) -> std::string {
    static const char* const leaves[] = {"x", "y", "c", "0.3", "-1.7", "12", "0.001"};
    if (depth == 0) return leaves[pick(7)];
    const auto a = expression(depth - 1), b = expression(depth - 1 - pick(depth));
    switch (pick(9)) {
      case 0:
        return "(" + a + " + " + b + ")";
      case 1:
        return "(" + a + " - " + b + ")";
      case 2:
        return "(" + a + " * " + b + ")";
      case 3:
        return "min(" + a + ", " + b + ")";
      case 4:
        return "max(" + a + ", " + b + ")";
      case 5:
        return "abs(" + a + ")";
      case 6:
        return "(-" + a + ")";
      case 7:
        return "clamp(" + a + ", -0.9, 1.3)";
      default:
        return "(" + a + " / (2 + abs(" + b + ")))";
    }
  };
  for (int i = 0; i < 60; ++i) {
    const auto text = graph_of("z = \"" + expression(4) + " + 0 * x\"");
    const char* const number = i % 2 == 0 ? "q16" : "q31";
    CAPTURE(i, text, number);
    IntegersBeside programs{text, integers(number)};
    CHECK(programs.distance(300, static_cast<unsigned>(i)) <= programs.bound() + 1e-12);
  }
}

TEST_CASE("export: events in integers come in the frame of the engine's", "[export][fixed]") {
  const auto* nodes = GENERATE(
      "hit = { type = \"threshold\", in = \"x\", level = 0.5, hysteresis = 0.25, hold = \"2 ms\" }\n"
      "z = { type = \"decay\", trigger = \"hit\", time = \"6 ms\", level = 0.8 }",
      "z = { type = \"latch\", set = \"x > 1\", reset = \"y > 2\" }",
      "z = { type = \"toggle\", trigger = \"x > 1\" }",
      "z = { type = \"sample_hold\", in = \"y\", trigger = \"x > 1\" }",
      "z = { type = \"state\", in = \"clamp(z + 0.25, 0, 8)\", trigger = \"x > 1\" }",
      "z = \"select(x > y, x, 2 * y) * (x >= 0.5) + floor(x)\"");
  // Levels are multiples of the steps, so that no comparison depends on rounding.
  for (const char* number : {"q16", "q31"}) {
    CAPTURE(nodes, number);
    IntegersBeside programs{graph_of(nodes), integers(number)};
    CHECK(programs.program().decisions.empty());
    CHECK(programs.distance(3000, 2) <= programs.bound() + 1e-12);
  }
}

TEST_CASE("export: the bound of a leaky sum is that of its geometric series", "[export][fixed]") {
  // z[n] = x + 3/4 z[n - 1]: what a frame adds to the error grows to four times as much, and |z| to 8.
  IntegersBeside programs{graph_of("z = \"x + 0.75 * before\"\nbefore = { type = \"delay\", in = \"z\", time "
                                   "= \"1 / system.rate\", interpolation = \"none\" }"),
                          integers("q16")};
  const auto& z = programs.program().outputs[0].value;
  CHECK(z.range.high >= 8);
  CHECK(z.range.high < 17);
  CHECK(programs.distance(3000, 3) <= programs.bound());
}

TEST_CASE("export: what has no scale in integers is named", "[export][fixed]") {
  const std::string plain =
      "format = 1\nname = \"graph\"\n[inputs]\nx = { unit = \"m\" }\n[outputs]\nout = { from = \"x / 1 m\" "
      "}\n";
  CHECK_THAT(refusal_of(plain),
             Catch::Contains("input 'x' has no range") && Catch::Contains("give it one in [inputs]"));
  CHECK(refusal_of(graph_of("z = \"x\"")).empty());
  CHECK_THAT(refusal_of(graph_of("z = { type = \"noise\" }")),
             Catch::Contains("noise 'z' has no form in integers"));
  CHECK_THAT(refusal_of(graph_of("z = \"y / x\"")), Catch::Contains("'z' divides by what may be 0"));
  CHECK_THAT(refusal_of(graph_of("z = \"x + before\"\nbefore = { type = \"delay\", in = \"z\", time = \"1 / "
                                 "system.rate\", interpolation = \"none\" }")),
             Catch::Contains("may grow without limit") && Catch::Contains("clamp"));
  CHECK_THAT(refusal_of(graph_of("z = { type = \"low_pass\", in = \"x\", cutoff = \"100 Hz + 10 Hz * y\" }")),
             Catch::Contains("its 'cutoff' changes"));
}

TEST_CASE("export: the guard in integers starts softly, limits and fades out", "[export][fixed]") {
  auto options = integers("q16");
  GuardedChannel channel;
  channel.limits.ceiling = 0.5;
  channel.limits.slew_per_second = 1e5;
  channel.limits.soft_start = 10_ms;
  channel.limits.fade_out = 5_ms;
  options.limits = [channel](const OutputChannel&) { return channel; };
  const auto program =
      write_fixed_program(parse_graph_leniently("format = 1\nname = \"graph\"\n[inputs]\nx = { range = [-1, "
                                                "1] }\n[outputs]\nout = { from = \"x\" }\n",
                                                "test.toml"),
                          standard_nodes(), options);
  REQUIRE(program);
  const auto source = fixed_source(*program);
  // 0.5 is 8192 of 2^14, 5 a frame of 1e5 a second is more than what there is, and the gain takes 200 and 100
  // frames of 2^30.
  CHECK_THAT(source, Catch::Contains("{8192, 32767, 5368709UL, 10737418UL}"));
}

TEST_CASE("export: limits in integers are rounded downwards, and refused below one step", "[export][fixed]") {
  const auto program = [](double slew, double ceiling, const char* number) {
    auto options = integers(number);
    GuardedChannel channel;
    channel.limits.ceiling = ceiling;
    channel.limits.slew_per_second = slew;
    options.limits = [channel](const OutputChannel&) { return channel; };
    return write_fixed_program(
        parse_graph_leniently(
            "format = 1\nname = \"graph\"\n[inputs]\nx = { range = [-1, 1] }\n[outputs]\nout "
            "= { from = \"x\" }\n",
            "test.toml"),
        standard_nodes(), options);
  };
  // At 20 kHz a step of 2^-14 a frame is 1.2207 a second: 500 a second are 409.6 steps. 0.3 is 4915.2 of
  // them.
  const auto rounded = program(500, 0.3, "q16");
  REQUIRE(rounded);
  CHECK_THAT(fixed_source(*rounded), Catch::Contains("{4915, 409, "));
  CHECK(program(1.23, 0.3, "q16"));
  const auto refused = program(1.21, 0.3, "q16");
  REQUIRE_FALSE(refused);
  CHECK_THAT(refused.error().front().what, Catch::Contains("'out', 1.21 a second, is less than one step"));
  CHECK(program(1.21, 0.3, "q31"));
}

TEST_CASE("export: a project for each microcontroller has what it is built from", "[export][fixed]") {
  struct Project {
    const char *target, *number;
    std::vector<std::string> files;
  };
  const auto project = GENERATE(
      Project{"avr",
              "q16",
              {"Makefile", "README.md", "board.h", "graph.c", "graph.h", "graph_numbers.h", "main.c",
               "simulate.c"}},
      Project{
          "avr", "float", {"Makefile", "README.md", "board.h", "graph.c", "graph.h", "main.c", "simulate.c"}},
      Project{"arduino",
              "q16",
              {"README.md", "board.h", "graph.c", "graph.h", "graph_export.ino", "graph_numbers.h"}},
      Project{"cortex-m",
              "float",
              {"Makefile", "README.md", "count_instructions.c", "graph.c", "graph.h", "main.c",
               "mps2_an386.ld", "startup.c"}});
  CAPTURE(project.target, project.number);
  auto options = integers(project.number);
  options.target = find_export_target(project.target);
  const auto files =
      export_graph(parse_graph_leniently(graph_of("z = \"x + y\""), "test.toml"), standard_nodes(), options);
  REQUIRE(files);
  std::vector<std::string> names;
  for (const auto& file : *files) {
    names.push_back(file.name);
    CHECK_THAT(file.text,
               !Catch::Contains("TACTUS_") && !Catch::Contains("tactus_") && !Catch::Contains("@NAME@"));
  }
  std::ranges::sort(names);
  CHECK(names == project.files);
}

TEST_CASE("export: a converter needs the range of its input", "[export][fixed]") {
  auto options = integers("float");
  options.target = find_export_target("avr");
  const auto files = export_graph(
      parse_graph_leniently(
          "format = 1\n[inputs]\nx = { unit = \"m\" }\n[outputs]\nout = { from = \"x / 1 m\" }\n",
          "test.toml"),
      standard_nodes(), options);
  REQUIRE_FALSE(files);
  CHECK_THAT(full_text(files.error()),
             Catch::Contains("input 'x' has no range, so that the converter has no scale"));
}
