#include "engine/graph/file/read_graph.h"
#include "engine/rig/profile.h"
#include "engine/scene/file/scene_spec.h"
#include "engine/scene/measures/measure.h"

namespace tactus {
namespace {

using FieldKind = FieldType::Kind;

FieldType from_field(const char* doc, const char* fallback) {
  return quantity_field("from", "s", 0, kLongestTime_s, doc, fallback);
}
FieldType to_field() { return quantity_field("to", "s", 0, kLongestTime_s, "end of the window", "the end"); }

// Whole numbers in a file are doubles: above 2^53 they would not come out as they were written.
constexpr double kMaxSeed = 9007199254740991.0;

}  // namespace

const SectionType& scene_fields() {
  static const SectionType gesture{
      "an input as a function of time",
      {required(field("points", FieldKind::Points, "[[time, value], …] with ascending times")),
       choice_field("curve", {"linear", "step", "smooth"}, "interpolation between two points", "linear"),
       about_field()}};
  static const SectionType drive{
      "actuator protected by the drive guard; without a profile: conservative limits",
      actuator_fields(),
      {},
      {"profile", "volts_per_full_scale"}};
  static const SectionType port{
      "a port between a motor and the plant, at which the delivered energy is summed",
      {required(text_field("force", "output of a part in N, such as \"plant.motor\"")),
       required(text_field("position", "output of a part in m, such as \"plant.arm\"")),
       required(quantity_field("active_up_to", "J", 0, 1e6, "energy that the instrument may deliver")),
       about_field()}};
  static const SectionType expectation{
      "an expected value, checked after the scene",
      {required(choice_field("measure", value_names(), "name of a measure")),
       text_field("of", "recorded signal, such as \"instrument.hit\"", "the role of the measure"),
       from_field("start of the window", "0 s"), to_field(),
       field("min", FieldKind::Any, "smallest allowed value"),
       field("max", FieldKind::Any, "largest allowed value"), about_field()},
      {"min", "max"}};
  static const SectionType accuracy{
      "a measure that every solver must reproduce",
      {required(choice_field("measure", error_names(), "name of a measure")),
       required(text_field("of", "recorded signal, such as \"plant.tip\"")),
       from_field("start of the window", "0 s"), to_field(),
       field("exact", FieldKind::Any, "theoretical value; default: a reference solution"),
       field("scale", FieldKind::Any,
             "value that counts as a relative error of 1; default: that of the reference"),
       about_field()}};
  static const SectionType converter{"converters of the simulated sound card",
                                     {whole_field("bits", 1, 32, "resolution", "24"),
                                      field("off", FieldKind::Flag, "no quantisation and no clipping")}};
  static const SectionType playability{
      "criteria of tactus study playability",
      {required(choice_field("kind", {"roll", "tone"},
                             "kind of playing")),  // in the order of Playability::Kind
       from_field("start of the evaluated window", "1 s"), to_field(),
       only("roll", text_field("hits", "trigger of a detected strike", "the role hit")),
       only("roll", text_field("contact", "contact force of the strikes", "the role contact")),
       only("roll", whole_field("fewest", 1, 100, "minimum number of strikes in any second", "10")),
       only("roll", choice_field("roll", {"even", "gallop", "backwards", "any"},  // as Playability::Roll
                                 "what the roll should be", "even")),
       only("roll", quantity_field("rate", "Hz", 1, 200, "strikes a second that it should have", "any rate")),
       only("tone", text_field("sound", "monitor output", "the role monitor")),
       only("tone",
            quantity_field("pitch", "Hz", 1, 20e3, "expected pitch, or a signal such as \"wanted.pitch\"")),
       only("tone",
            quantity_field("begin", "s", 0, kLongestTime_s, "time at which the player starts", "0 s")),
       only("tone",
            quantity_field("quiet", "", 1e-9, 1, "level below which the tone counts as silent", "-60 dB")),
       about_field()}};
  static const SectionType role = [] {
    SectionType roles{"signals and controls used by measures, reports and studies", {}};
    for (const auto& type : role_types()) roles.fields.push_back(text_field(type.name, type.doc));
    return roles;
  }();
  static const SectionType shown{"the part of the scene that the plot shows",
                                 {from_field("start of the plot", "0 s"), to_field()}};
  static const SectionType comparison{"a second run of the scene with other control values",
                                      {required(text_field("name", "name, such as \"without the pulse\""))}};
  static const SectionType section{
      "a scene",
      joined(heading_fields(),
             {quantity_field("rate", "Hz", 1e3, 768e3, "sample rate", "48 kHz"),
              quantity_field("delay", "s", 0, 10, "system delay", "0 s"),
              required(quantity_field("duration", "s", 1e-3, kLongestTime_s, "duration of the scene")),
              quantity_field(
                  "monitor", "", 0, 1e4,
                  "gain of the monitor output in its sound file and on speakers, such as \"12 dB\"", "0 dB"),
              whole_field("seed", 0, kMaxSeed, "seed of all random numbers"),
              required({"parts", FieldKind::Reference, "graphs and their connections", {"part"}}),
              entries_field("gestures", gesture, "gestures of the player"),
              section_field("converters", converter),
              entries_field("drives", drive, "actuators on the instrument's outputs"),
              entries_field("ports", port, "ports at which energy is exchanged between instrument and plant"),
              section_field("roles", role),
              entries_field("expect", expectation, "expected values, checked after the scene"),
              entries_field("accuracy", accuracy, "measures compared by tactus study work-precision"),
              section_field("playability", playability), section_field("compare", comparison),
              section_field("show", shown)})};
  return section;
}

}  // namespace tactus
