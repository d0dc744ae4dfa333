#include "engine/nodes/networks/element_types.h"
#include "engine/nodes/world/world_elements.h"

namespace tactus {

std::span<const WorldQuantity> world_quantities() {
  static const std::vector<WorldQuantity> quantities{
      {"energy", "J", "kinetic and potential energy of all bodies"},
      {"depth", "m", "deepest penetration of two bodies"},
      {"refused", "", "steps that were not computed, or without some contacts, because memory ran out"}};
  return quantities;
}

const SectionType& world_options() {
  static const SectionType section{
      "A world",
      {quantity_field("rate", "Hz", 1, 1e6, "steps a second; the nearest whole number of frames is a step",
                      "1 kHz"),
       choice_field("solver", {"direct", "iterative"},
                    "direct: exact, its time grows with the cube of the contacts that hang together; "
                    "iterative: its time grows with their number",
                    "direct"),
       whole_field("iterations", 1, 1000, "of the iterative solver", "20"),
       whole_field("contacts", 1, 10000, "most points of contact in a step", "6 for each body, and 16"),
       quantity_field("erp", "", 0, 1, "share of a penetration that is corrected in a step", "0.2"),
       quantity_field("cfm", "s/kg", 0, kUnlimited, "compliance of contacts over the step: 0 is rigid", "0"),
       quantity_field("stiffness", "N/m", 0, kUnlimited, "of contacts, instead of erp and cfm; with damping"),
       quantity_field("damping", "N s/m", 0, kUnlimited, "of contacts, instead of erp and cfm"),
       quantity_field("bounce_speed", "m/s", 0, kUnlimited, "slower impacts do not bounce", "1 cm/s"),
       quantity_field("correction_speed", "m/s", 0, kUnlimited,
                      "highest speed at which penetration is corrected", "not limited")},
      {},
      {"stiffness", "damping"}};
  return section;
}

}  // namespace tactus
