#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "apps/commands.h"
#include "apps/console.h"
#include "engine/graph/nearest.h"
#include "engine/nodes/reference.h"
#include "engine/nodes/table.h"

namespace tactus::app {
namespace {

struct NodesOptions {
  std::string name;
  bool json = false;
  bool markdown = false;
};

int run(const NodesOptions& options) {
  const auto& table = standard_nodes();
  if (options.markdown) {
    fmt::print("{}", reference_markdown(table));
    return kDone;
  }
  if (options.json) {
    auto all = nlohmann::ordered_json::array();
    for (const auto* type : table.types)
      if (options.name.empty() || type->name == options.name) {
        auto ports = nlohmann::ordered_json::array();
        for (const auto& port : type->inputs)
          ports.push_back({{"name", port.name}, {"unit", port.unit}, {"doc", port.doc}});
        auto outputs = nlohmann::ordered_json::array();
        for (const auto& port : type->outputs)
          outputs.push_back({{"name", port.name}, {"unit", port.unit}, {"doc", port.doc}});
        auto settings = nlohmann::ordered_json::array();
        for (const auto& setting : type->settings)
          settings.push_back({{"name", setting.name}, {"doc", setting.doc}});
        all.push_back({{"name", type->name},
                       {"group", type->group},
                       {"summary", type->summary},
                       {"equation", type->equation},
                       {"example", type->example},
                       {"inputs", ports},
                       {"outputs", outputs},
                       {"settings", settings}});
      }
    fmt::print("{}\n", all.dump(2));
    return kDone;
  }
  if (options.name.empty()) {
    fmt::print("{}", reference_overview(table));
    return kDone;
  }
  if (options.name == "network") {
    fmt::print("{}", network_reference());
    return kDone;
  }
  if (const auto* type = table.find(options.name)) {
    fmt::print("{}", reference_text(*type));
    return kDone;
  }
  std::vector<std::string> names;
  for (const auto* type : table.types) names.push_back(type->name);
  const auto near = nearest_name(options.name, names);
  fmt::print(stderr, "there is no node type '{}'; {}\n", options.name,
             near.empty() ? "`tactus nodes` lists them all" : "did you mean '" + near + "'?");
  return kUsage;
}

}  // namespace

void add_nodes(CLI::App& app, int& exit_code) {
  auto* command = app.add_subcommand("nodes", "What a graph file can be made of");
  auto options = std::make_shared<NodesOptions>();
  command->add_option("NAME", options->name, "one type in full; `network` for the elements of networks");
  command->add_flag("--json", options->json, "for machines");
  command->add_flag("--markdown", options->markdown, "the whole reference (docs/nodes.md is made with it)");
  command->footer("Examples:\n  tactus nodes\n  tactus nodes onset\n  tactus nodes network");
  command->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace tactus::app
