
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
      "a value over time",
      {required(field("points", FieldKind::Points, "[[time, value], …], times increase")),
       choice_field("curve", {"linear", "step", "smooth"}, "from point to point", "linear"), about_field()}};
  static const SectionType drive{"what the drive guard has to protect; cautious limits without a profile",
                                 actuator_fields(),
                                 {},
                                 {"profile", "volts_per_full_scale"}};
  static const SectionType port{
      "where a motor moves the plant: the energy that it gives is added up",
      {required(text_field("force", "output of a part, in N: \"plant.motor\"")),
       required(text_field("position", "output of a part, in m: \"plant.arm\"")),
       required(quantity_field("active_up_to", "J", 0, 1e6, "energy that the instrument may give")),
       about_field()}};
  static const SectionType expectation{
      "what must hold when the scene was played",
      {required(choice_field("measure", value_names(), "what is measured")),
       text_field("of", "a recorded signal, as in \"instrument.hit\"", "the role of the measure"),
       from_field("start of the window", "0 s"), to_field(), field("min", FieldKind::Any, "least value"),
       field("max", FieldKind::Any, "greatest value"), about_field()},
      {"min", "max"}};
  static const SectionType accuracy{
      "what must come out right with every solver",
      {required(choice_field("measure", error_names(), "what is compared")),
       required(text_field("of", "a signal, as in \"plant.tip\"")), from_field("start of the window", "0 s"),
       to_field(), field("exact", FieldKind::Any, "what theory says; compared with a reference if left out"),
       field("scale", FieldKind::Any, "an error of 1; of the reference if left out"), about_field()}};
  static const SectionType converter{"of the simulated sound card",
                                     {whole_field("bits", 1, 32, "resolution", "24"),
                                      field("off", FieldKind::Flag, "neither quantises nor clips")}};
  static const SectionType playability{
      "what playing well means, for tactus study playability",
      {required(
           choice_field("kind", {"roll", "tone"}, "what is played")),  // in the order of Playability::Kind
       from_field("start of the evaluated window", "1 s"), to_field(),
       only("roll", text_field("hits", "the trigger of a detected strike", "the role hit")),
       only("roll", text_field("contact", "the contact force of the strikes", "the role contact")),
       only("roll", whole_field("fewest", 1, 100, "strikes in its worst second", "10")),
       only("tone", text_field("sound", "the monitor output", "the role monitor")),
       only("tone",
            quantity_field("pitch", "Hz", 1, 20e3, "the expected note, or a signal: \"wanted.pitch\"")),
       only("tone", quantity_field("begin", "s", 0, kLongestTime_s, "when the player starts", "0 s")),
       only("tone", quantity_field("quiet", "", 1e-9, 1, "the level below which it is silent", "-60 dB")),
       about_field()}};
  static const SectionType role = [] {
    SectionType roles{"the signals that measures and reports use", {}};
    for (const auto& type : role_types()) roles.fields.push_back(text_field(type.name, type.doc));
    return roles;
  }();
  static const SectionType comparison{"the scene once more with some controls elsewhere",
                                      {required(text_field("name", "as in \"without the pulse\""))}};
  static const SectionType section{
      "a scene", joined(heading_fields(),
                        {quantity_field("rate", "Hz", 1e3, 768e3, "sample rate", "48 kHz"),
                         quantity_field("delay", "s", 0, 10, "system delay", "0 s"),
                         required(quantity_field("duration", "s", 1e-3, kLongestTime_s, "how long it lasts")),
                         whole_field("seed", 0, kMaxSeed, "of everything random"),
                         required({.key = "parts",
                                   .kind = FieldKind::Reference,
                                   .doc = "graphs and how they are wired",
                                   .unit = "part"}),
                         entries_field("gestures", gesture, "how the player moves"),
                         section_field("converters", converter),
                         entries_field("drives", drive, "what the instrument's outputs move"),
                         entries_field("ports", port, "where energy goes between instrument and plant"),
                         section_field("roles", role), entries_field("expect", expectation, "what must hold"),
                         entries_field("accuracy", accuracy, "what a study of solvers compares"),
                         section_field("playability", playability), section_field("compare", comparison)})};
  return section;
}

}  // namespace tactus
