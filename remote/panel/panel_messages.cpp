#include "remote/panel/panel_messages.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

namespace tactus {
namespace {

using Json = nlohmann::json;

constexpr int kProtocol = 1;

/// Names come from files: bytes that are no UTF-8 are replaced.
std::string text_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

/// JSON has no infinity.
Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

template <class List, class Make>
Json list(const List& from, Make make) {
  Json all = Json::array();
  for (const auto& item : from) all.push_back(make(item));
  return all;
}

Json shares(const std::vector<std::optional<double>>& values) {
  return list(values, [](const auto& value) { return value ? number(*value) : Json(nullptr); });
}

Json heat_json(const RemoteState& state) {
  Json all = Json::array();
  for (std::size_t o = 0; o < std::min(state.coil.size(), state.body.size()); ++o)
    all.push_back(state.coil[o] && state.body[o]
                      ? Json{{"coil", number(*state.coil[o])}, {"body", number(*state.body[o])}}
                      : Json(nullptr));
  return all;
}

Json numbers(const std::vector<double>& values) { return list(values, number); }

Json named(const std::vector<std::string>& names) {
  return list(names, [](const auto& name) { return Json{{"name", name}}; });
}

std::string text_of(const RigHid& hid) { return fmt::format("{} {}", name_of(hid.part), hid.number); }

Json control_json(const RemoteControl& control) {
  const auto shown = [&](double si) { return number(control.unit.from_si(si)); };
  return {{"name", control.name},
          {"unit", control.unit_name},
          {"low", std::isfinite(control.low) ? shown(control.low) : Json(nullptr)},
          {"high", std::isfinite(control.high) ? shown(control.high) : Json(nullptr)},
          {"value", shown(control.initial)},
          {"taper", "linear"},
          {"constant", control.constant},
          {"midi", control.midi},
          {"osc", control.osc},
          {"hid", control.hid ? text_of(*control.hid) : ""},
          {"about", control.about}};
}

Json output_json(const PictureOutput& output) {
  return {{"name", output.name},
          {"drive", output.drive},
          {"limits", list(output.limits, [](const PictureLimit& limit) {
             return Json{{"name", limit.name}, {"value", limit.value}, {"source", limit.source}};
           })}};
}

Json node_json(const PictureNode& node) {
  return {{"path", node.path},
          {"type", node.type},
          {"about", node.about},
          {"file", node.file},
          {"line", node.line},
          {"loop", node.loop},
          {"left_out", node.left_out},
          {"inputs", list(node.inputs,
                          [](const auto& input) {
                            return Json{{"port", input.port}, {"from", input.from}};
                          })},
          {"outputs", node.outputs}};
}

void add_picture(const Picture& picture, Json& json) {
  json["file"] = picture.file;
  json["device"] = picture.device;
  json["sample_rate"] = picture.sample_rate_hz;
  json["block"] = picture.block;
  json["latency"] = {{"seconds", picture.latency_s ? number(*picture.latency_s) : Json(nullptr)},
                     {"known", !picture.latency_s         ? "unknown"
                               : picture.latency_measured ? "measured"
                                                          : "assumed"}};
  json["outputs"] = list(picture.outputs, output_json);
  json["signals"] = list(picture.signals, [](const PictureSignal& signal) {
    return Json{{"name", signal.name}, {"unit", signal.unit}, {"node", signal.node}};
  });
  json["graph"] = {{"nodes", list(picture.nodes, node_json)},
                   {"loops", list(picture.loops, [](const PictureLoop& loop) {
                      return Json{{"paths", loop.paths}, {"delay_frames", loop.delay_frames}};
                    })}};
  json["text"] = list(picture.files, [](const PictureFile& file) {
    return Json{{"file", file.name}, {"text", file.text}};
  });
}

Json world_json(const RemoteWorld& world) {
  return {{"name", world.name},
          {"bodies", list(world.looks.bodies,
                          [](const BodyLook& look) {
                            return Json{{"name", look.name},
                                        {"shape", look.shape},
                                        {"moves", look.moves},
                                        {"normal", look.normal},
                                        {"offset", look.offset}};
                          })},
          {"handles", world.looks.handles}};
}

/// A millionth is less than a screen shows.
Json rounded(double value) { return number(std::round(value * 1e6) / 1e6); }

/// One list of numbers: place, quaternion, size.
Json pose_json(const BodyPose& pose) {
  if (!pose.present) return nullptr;
  Json all = Json::array();
  for (const double value : pose.position) all.push_back(rounded(value));
  for (const double value : pose.turn) all.push_back(rounded(value));
  for (const double value : pose.size) all.push_back(rounded(value));
  return all;
}

Json handle_json(const HandlePose& handle) {
  Json all = Json::array();
  for (const double value : handle.position) all.push_back(rounded(value));
  all.push_back(handle.holds);
  return all;
}

/// "instrument.toml:3:7" into its parts, as far as there are any.
Json error_json(const Error& error) {
  Json json = {
      {"file", error.where}, {"line", 0}, {"column", 0}, {"what", error.what}, {"remedy", error.remedy}};
  std::array<int, 2> numbers{};
  auto where = std::string_view{error.where};
  int found = 0;
  for (; found < 2; ++found) {
    const auto colon = where.rfind(':');
    const auto digits = colon == where.npos ? "" : where.substr(colon + 1);
    if (digits.empty() || digits.size() > 8 || digits.find_first_not_of("0123456789") != digits.npos) break;
    numbers[static_cast<std::size_t>(found)] = std::stoi(std::string{digits});
    where = where.substr(0, colon);
  }
  json["file"] = where;
  json["line"] = found == 0 ? 0 : numbers[static_cast<std::size_t>(found - 1)];
  json["column"] = found == 2 ? numbers[0] : 0;
  return json;
}

/// Of each output, of each stage of its guard.
Json guard_json(const RemoteMeters& meters) {
  const auto outputs = meters.outputs.size();
  Json guard = Json::array();
  for (std::size_t o = 0; o < outputs; ++o) {
    const auto stages = meters.guard.size() / outputs;
    Json counts = Json::array();
    for (std::size_t s = 0; s < stages; ++s) counts.push_back(meters.guard[o * stages + s]);
    guard.push_back(std::move(counts));
  }
  return guard;
}

template <class Number>
void append(std::string& bytes, Number value) {
  static_assert(std::endian::native == std::endian::little);
  const auto at = bytes.size();
  bytes.resize(at + sizeof value);
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

}  // namespace

std::string description_text(const RemoteDescription& description) {
  Json json = {{"kind", "description"},
               {"protocol", kProtocol},
               {"name", description.instrument},
               {"controls", list(description.controls, control_json)},
               {"gestures", named(description.gestures)},
               {"inputs", named(description.inputs)},
               {"guard_stages", description.guard_stages},
               {"events", description.events},
               {"presets", description.presets}};
  if (!description.worlds.empty()) json["worlds"] = list(description.worlds, world_json);
  if (description.world_delay_s) json["delay"] = number(*description.world_delay_s);
  add_picture(description.picture ? *description.picture : Picture{}, json);
  return text_of(json);
}

std::string edit_text(const RemoteEdit& edit) {
  return text_of({{"kind", "edit"}, {"errors", list(edit.errors, error_json)}});
}

std::string verdict_text(const RemoteVerdict& verdict) {
  return text_of(
      {{"kind", "verdict"}, {"delay", verdict.delay_s}, {"stable", verdict.stable}, {"text", verdict.text}});
}

std::string scope_text(const RemoteScope& scope) {
  return text_of({{"kind", "scope"},
                  {"id", scope.id},
                  {"signals", scope.signals},
                  {"refused", list(scope.refused, [](const auto& refused) {
                     return Json{{"name", refused.first}, {"why", refused.second}};
                   })}});
}

std::string event_text(const RemoteEvent& event) {
  static constexpr std::array kKinds = {"message", "guard", "armed", "muted", "trigger", "impact", "message"};
  const bool trigger = event.kind == RemoteEvent::Kind::Trigger;
  return text_of({{"kind", "event"},
                  {"frame", event.frame},
                  {"time", event.time_s},
                  {"what", kKinds[static_cast<std::size_t>(event.kind)]},
                  {"text", event.text},
                  {"value", trigger ? number(event.level) : Json(event.value)}});
}

std::string answer_text(const std::string& to, std::int64_t number) {
  return text_of({{"kind", "answer"}, {"to", to}, {"number", number}});
}

std::string error_text(const std::string& to, const std::string& error) {
  return text_of({{"kind", "answer"}, {"to", to}, {"error", error}});
}

std::string state_text(const RemoteDescription& description, const RemoteMeters& meters,
                       const RemoteState& state, const PanelState& panel) {
  Json json = {
      {"kind", "state"},
      {"armed", panel.armed},
      {"muted", panel.muted},
      {"owner", panel.owner},
      {"controls", list(description.controls,
                        [](const auto& control) { return number(control.unit.from_si(control.value)); })},
      {"inputs", numbers(meters.inputs)},
      {"outputs", numbers(meters.outputs)},
      {"guard", guard_json(meters)}};
  json.update({{"frame", state.frame},
               {"time", state.time_s},
               {"drives", state.drives},
               {"stream", state.stream},
               {"load", number(state.load)},
               {"load_worst", number(state.worst_load)},
               {"xruns", state.xruns},
               {"lost_frames", state.lost_frames},
               {"faults", list(state.faults,
                               [](const auto& fault) {
                                 return Json{{"node", fault.first}, {"count", fault.second}};
                               })},
               {"heat", heat_json(state)},
               {"excursion", shares(state.excursion)}});
  if (panel.levels) json["levels"] = numbers(state.signals);
  if (panel.bodies != nullptr)
    json["bodies"] = list(panel.bodies->worlds, [](const BodyPoses& poses) {
      return Json{{"bodies", list(poses.bodies, pose_json)}, {"handles", list(poses.handles, handle_json)}};
    });
  return text_of(json);
}

std::string scope_bytes(const ScopeChunk& chunk) {
  std::string bytes;
  append(bytes, std::uint8_t{1});
  append(bytes, static_cast<std::uint8_t>(chunk.traces));
  append(bytes, std::uint16_t{0});
  append(bytes, chunk.id);
  append(bytes, static_cast<std::uint32_t>(chunk.bin));
  append(bytes, static_cast<std::uint32_t>(chunk.bins));
  append(bytes, static_cast<double>(chunk.frame));
  const auto per_trace = static_cast<std::size_t>(ScopeChunk::kMostBins * chunk.per_bin());
  for (int t = 0; t < chunk.traces; ++t)
    for (std::size_t v = 0; v < static_cast<std::size_t>(chunk.bins * chunk.per_bin()); ++v)
      append(bytes, chunk.values[static_cast<std::size_t>(t) * per_trace + v]);
  return bytes;
}

}  // namespace tactus
