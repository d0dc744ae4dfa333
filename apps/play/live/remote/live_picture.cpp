#include "apps/play/live/remote/live_picture.h"

#include <algorithm>
#include <map>
#include <set>

#include "engine/core/index.h"
#include "engine/graph/file/load.h"
#include "engine/graph/semantics/expression.h"

namespace tactus::app {
namespace {

/// What one graph adds to a picture.
class Drawer {
  using Kind = Vertex::Kind;

 public:
  /// `prefix`: of all its names.
  Drawer(const Plan& plan, std::string prefix, Picture& picture)
      : plan_(plan), prefix_(std::move(prefix)), picture_(picture), expressions_(named_expressions(plan)) {}

  void run() {
    find_loops();
    for (int v = 0; v < std::ssize(plan_.vertices); ++v) add(v);
    for (const auto& channel : plan_.channels) add_output(channel);
    for (const auto& left : plan_.left_out) {
      PictureNode node;
      node.path = prefix_ + left.path;
      node.left_out = left.reason;
      picture_.nodes.push_back(std::move(node));
    }
  }

 private:
  const Vertex& at(int v) const { return plan_.vertices[index(v)]; }

  void find_loops() {
    for (const auto& loop : plan_.loops) {
      const auto number = static_cast<int>(picture_.loops.size());
      picture_.loops.push_back({{}, loop.delay_frames});
      for (const auto& path : loop.paths) {
        if (loop_of_.try_emplace(path, number).second) picture_.loops.back().paths.push_back(prefix_ + path);
      }
    }
  }

  void add(int v) {
    const auto& vertex = at(v);
    switch (vertex.kind) {
      case Kind::Input:
        return add_source(vertex, "input", vertex.path, {});
      case Kind::Node:
        if (vertex.type != nullptr) add_node(vertex);
        return;
      case Kind::Operation:
        if (const auto named = expressions_.find(vertex.path);
            named != expressions_.end() && named->second == v)
          add_expression(vertex);
        return;
      default:
        return;
    }
  }

  PictureNode begin(const Vertex& vertex, const std::string& path) {
    PictureNode node;
    node.path = prefix_ + path;
    if (vertex.at.file) node.file = *vertex.at.file;
    node.line = vertex.at.line;
    if (const auto loop = loop_of_.find(vertex.path); loop != loop_of_.end()) node.loop = loop->second;
    return node;
  }

  void add_source(const Vertex& vertex, const char* type, const std::string& name, const std::string& about) {
    auto node = begin(vertex, name);
    node.type = type;
    node.about = about;
    node.outputs = {prefix_ + name};
    picture_.nodes.push_back(std::move(node));
  }

  void add_node(const Vertex& vertex) {
    const auto& type = *vertex.type;
    auto node = begin(vertex, vertex.path);
    node.type = type.name;
    node.about = type.summary + (type.equation.empty() ? "" : "\n" + type.equation);
    for (std::size_t i = 0; i < std::min(vertex.in.size(), type.inputs.size()); ++i)
      add_input(type.inputs[i].name, vertex.in[i], node);
    for (int port = 0; port < std::ssize(type.outputs); ++port)
      for (int lane = 0; lane < vertex.width; ++lane)
        node.outputs.push_back(prefix_ + signal_name(vertex, port, lane));
    picture_.nodes.push_back(std::move(node));
  }

  void add_expression(const Vertex& vertex) {
    auto node = begin(vertex, vertex.path);
    node.type = "expression";
    for (const auto& wire : vertex.in) add_input("", wire, node);
    node.outputs = {prefix_ + vertex.path};
    picture_.nodes.push_back(std::move(node));
  }

  void add_output(const OutputChannel& channel) {
    if (channel.use == OutputUse::Tap) return;
    PictureNode node;
    node.path = prefix_ + "out/" + channel.name;
    node.type = "output";
    add_input("", channel.from, node);
    node.outputs = {node.path};
    picture_.nodes.push_back(std::move(node));
  }

  /// Where several signals make an input, one entry for each.
  void add_input(const std::string& port, const Wire& wire, PictureNode& node) {
    std::set<int> seen;
    std::vector<std::string> names;
    find_sources(wire, seen, names);
    for (const auto& name : names) node.inputs.push_back({port, name});
  }

  void find_sources(const Wire& wire, std::set<int>& seen, std::vector<std::string>& names) {
    const auto& vertex = at(wire.vertex);
    const auto add = [&](const std::string& name) {
      if (std::ranges::find(names, name) == names.end()) names.push_back(name);
    };
    if (vertex.kind == Kind::Constant) {
      if (names.empty()) {
        if (const auto value = plan_.constant(wire)) add(short_number(*value));
      }
      return;
    }
    if (vertex.kind == Kind::Input) return add(prefix_ + vertex.path);
    if (vertex.kind == Kind::Control) return add(prefix_ + plan_.controls[index(vertex.index)].control.name);
    if (vertex.kind == Kind::SystemDelay) return add("system.delay");
    if (vertex.kind == Kind::Node && vertex.type != nullptr)
      return add(prefix_ + signal_name(vertex, wire.port, std::max(0, wire.lane)));
    if (vertex.kind == Kind::Operation && expressions_.contains(vertex.path) &&
        expressions_.at(vertex.path) == wire.vertex)
      return add(prefix_ + vertex.path);
    if (!seen.insert(wire.vertex).second) return;
    for (const auto& in : vertex.in)
      if (at(in.vertex).kind != Kind::Constant) find_sources(in, seen, names);
  }

  static std::string short_number(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.4g", value);
    return text;
  }

  const Plan& plan_;
  std::string prefix_;
  Picture& picture_;
  std::map<std::string, int> expressions_, loop_of_;
};

PictureOutput picture_of(const std::string& name, const GuardedChannel& guard) {
  PictureOutput output{name, guard.kind == DriveGuard::Kind::Drive, {}};
  for (const auto& origin : guard.origins)
    output.limits.push_back({origin.limit, limit_text(origin.limit, origin.value), origin.source});
  return output;
}

}  // namespace

Picture make_picture(Performer& performer, const LiveScope& scope) {
  Picture picture;
  for (std::size_t c = 0; c < performer.outputs.size(); ++c)
    picture.outputs.push_back(picture_of(
        performer.outputs[c], c < performer.guards.size() ? performer.guards[c] : GuardedChannel{}));
  Drawer{performer.instrument().plan(), "", picture}.run();
  if (auto* plant = performer.plant()) Drawer{plant->plan(), "plant/", picture}.run();
  for (const auto& signal : scope.signals()) {
    const auto dot = signal.name.rfind('.');
    const bool is_node =
        std::ranges::any_of(picture.nodes, [&](const auto& node) { return node.path == signal.name; });
    picture.signals.push_back(
        {signal.name, to_string(signal.of.dimension),
         is_node || dot == std::string::npos ? signal.name : signal.name.substr(0, dot)});
  }
  if (!performer.files.empty()) picture.file = performer.files.front().string();
  return picture;
}

std::vector<PictureFile> read_files(const std::vector<std::filesystem::path>& files) {
  std::vector<PictureFile> texts;
  std::set<std::filesystem::path> seen;
  for (const auto& file : files) {
    if (!seen.insert(file).second) continue;
    if (auto text = read_graph_text(file)) texts.push_back({file.string(), std::move(*text)});
  }
  return texts;
}

}  // namespace tactus::app
