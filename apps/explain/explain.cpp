#include <fmt/format.h>

#include <algorithm>

#include "apps/cli/console.h"
#include "apps/cli/json.h"
#include "apps/cli/target.h"
#include "apps/play/play_report.h"
#include "engine/graph/file/load.h"
#include "engine/graph/plan/compile.h"
#include "engine/nodes/table.h"
#include "engine/runtime/player.h"
#include "engine/runtime/step_times.h"
#include "engine/scene/build_scene.h"
#include "engine/scene/network_report.h"

namespace tactus::app {
namespace {

struct ExplainOptions {
  std::string target;
  std::string rate = "48 kHz";
  int block = 64;
  bool json = false;
};

Json step_json(const Plan& plan, const Step& step, double cost) {
  static constexpr const char* kKinds[] = {"process", "emit", "absorb", "operations", "outside"};
  const auto* vertex = step.vertex < 0 ? nullptr : &plan.vertices[index(step.vertex)];
  const auto what = step.kind == Step::Kind::Operations
                        ? fmt::format("{} operation{}", step.operations, step.operations == 1 ? "" : "s")
                    : step.node < 0 ? "the instrument runs"
                                    : vertex->description();
  return {{"name", vertex == nullptr ? "outside" : vertex->path},
          {"what", what},
          {"how", kKinds[static_cast<int>(step.kind)]},
          {"ns_per_frame", cost}};
}

std::size_t memory_of(const Plan& plan) {
  return plan.arena.size() * sizeof(double) + plan.steps.size() * sizeof(Step) +
         plan.inputs.size() * sizeof(Signal) + plan.outputs.size() * sizeof(double*) +
         plan.operations.size() * sizeof(MicroOperation);
}

/// Notes of a node on how it was made; of one that runs in two halves, once.
std::string about_step(const Plan& plan, const Step& step) {
  return step.node < 0 || step.kind == Step::Kind::Absorb ? std::string{}
                                                          : plan.nodes[index(step.node)]->about();
}

Json left_out_json(const LeftOut& left) { return {{"name", left.path}, {"why", left.reason}}; }

Json explain_engine(Player& engine, const std::string& title, int block) {
  const auto& plan = engine.plan();
  const auto costs = time_steps(engine, block, 300_ms);
  const auto cut_loop_json = [](const LoopReport& loop) -> Json {
    return {
        {"through", loop.paths}, {"delay_frames", loop.delay_frames}, {"sub_block_frames", loop.sub_block}};
  };
  Json json{{"graph", title},
            {"sample_rate_hz", plan.sample_rate.value},
            {"signal_memory_bytes", memory_of(plan)},
            {"network_solvers", networks_json(report_networks(plan, costs))},
            {"about", Json::array()},
            {"sections", Json::array()},
            {"loops", list_of(plan.loops, cut_loop_json)},
            {"left_out", list_of(plan.left_out, left_out_json)}};
  for (const auto& section : plan.sections) {
    Json part{{"loop", section.loop}, {"sub_block_frames", section.sub_block}, {"steps", Json::array()}};
    for (int s = section.first_step; s < section.end_step; ++s) {
      const auto& step = plan.steps[index(s)];
      part["steps"].push_back(step_json(plan, step, costs[index(s)]));
      if (const auto about = about_step(plan, step); !about.empty())
        json["about"].push_back({{"name", part["steps"].back()["name"]}, {"what", about}});
    }
    json["sections"].push_back(part);
  }
  return json;
}

std::string text_of(const Json& json, const char* key) { return json[key].get<std::string>(); }
int frames_of(const Json& json, const char* key) { return json[key].get<int>(); }

void print(const Json& json) {
  fmt::print("{} at {:g} Hz, {} bytes of signals and steps\n\n", text_of(json, "graph"),
             json["sample_rate_hz"].get<double>(), json["signal_memory_bytes"].get<std::size_t>());
  fmt::print("  {:28} {:18} {:11} {:>12}\n", "step", "what", "how", "ns per frame");
  double total = 0;
  for (const auto& section : json["sections"]) {
    const bool loop = section["loop"].get<bool>();
    if (loop) fmt::print("  loop, sub-blocks of {} frames:\n", frames_of(section, "sub_block_frames"));
    for (const auto& step : section["steps"]) {
      const double cost = step["ns_per_frame"].get<double>();
      total += cost;
      fmt::print("  {}{:28} {:18} {:11} {:12.2f}\n", loop ? "  " : "", text_of(step, "name"),
                 text_of(step, "what"), text_of(step, "how"), cost);
    }
  }
  fmt::print("  {:59} {:12.2f}\n\n", "all", total);
  for (const auto& loop : json["loops"])
    fmt::print("loop {}: delay at least {} frames, sub-blocks of {} frames\n",
               fmt::join(loop["through"].get<std::vector<std::string>>(), " -> "),
               frames_of(loop, "delay_frames"), frames_of(loop, "sub_block_frames"));
  for (const auto& network : json["network_solvers"]) fmt::print("{}\n", text_of(network, "words"));
  for (const auto& about : json["about"])
    fmt::print("{}: {}\n", text_of(about, "name"), text_of(about, "what"));
  for (const auto& left : json["left_out"])
    fmt::print("omitted: {} {}\n", text_of(left, "name"), text_of(left, "why"));
}

/// `omitted`: what lies around the engines and is not there.
int finish(const ExplainOptions& options, std::vector<LeftOut> omitted,
           const std::vector<std::pair<std::string, Player*>>& engines) {
  Json all = Json::array();
  for (const auto& [title, engine] : engines) {
    or_exit(engine->prepare(
        {engine->plan().sample_rate, engine->in_channels(), engine->out_channels(), options.block}));
    all.push_back(explain_engine(*engine, title, options.block));
  }
  // Always so, and not worth two lines for people.
  if (options.json)
    omitted.insert(omitted.begin(),
                   {{"sound card", "is not opened: everything runs in the simulation or offline"},
                    {"threads", "are not started: everything runs on the calling thread"}});
  for (const auto& left : omitted) all[0]["left_out"].push_back(left_out_json(left));
  if (options.json) print_json(all.size() == 1 ? all[0] : Json{{"graphs", all}});
  for (const auto& json : all)
    if (!options.json) print(json);
  return kDone;
}

int run_explain(const ExplainOptions& options) {
  const auto target = resolve_target(options.target);
  const auto& file = target.file;
  const auto rate = parse_rate(options.rate);
  std::vector<LeftOut> omitted;
  if (target.scene) {
    const auto loaded = load_scene_leniently(target);
    SceneOptions with;
    with.rate = rate;
    const auto built = or_exit(build_scene(loaded, standard_nodes(), with));
    if (!loaded.scene->converters.on) omitted.push_back({"converters", "are off in this scene"});
    if (built.delay_frames == 0) omitted.push_back({"delay line", "the system delay is 0 frames"});
    return finish(options, std::move(omitted),
                  {{"instrument of " + loaded.scene->name, built.instrument.get()},
                   {"simulation of " + loaded.scene->name, built.plant.get()}});
  }
  const auto loaded = load_graph_leniently(file, target.root());
  CompileOptions compile_options;
  compile_options.sample_rate = rate;
  Player engine{or_exit(compile(loaded, standard_nodes(), compile_options))};
  for (const auto& tap : event_taps(*loaded.spec, standard_nodes()))
    omitted.push_back({"tap " + tap, "is not read here; scenes and `tactus render --events` read it"});
  return finish(options, std::move(omitted), {{loaded.spec->name, &engine}});
}

}  // namespace

void add_explain(CLI::App& app, int& exit_code) {
  auto [command, options] =
      add_command(app, "explain", "Print the nodes that a graph runs, their order and their cost", exit_code,
                  run_explain);
  command
      .add_option(
          "FILE", options.target,
          "instrument, plant or scene file; for a folder, its scene.toml, or else its instrument.toml")
      ->required();
  command.add_option("--rate", options.rate, "sample rate")->capture_default_str();
  add_number(command, "--block", options.block, "block size in frames; for the cost measurement", 1, 4096);
  command.add_flag("--json", options.json, "print the report as JSON");
  command.footer(
      "Examples:\n  tactus explain instruments/haptic_drum\n  tactus explain "
      "instruments/haptic_drum/instrument.toml --json");
}

}  // namespace tactus::app
