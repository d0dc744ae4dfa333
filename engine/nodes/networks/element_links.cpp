#include "engine/nodes/networks/element_types.h"

namespace tactus {
namespace {

using Kind = ElementQuantity::Kind;
using Ends = ElementType::Ends;

}  // namespace

std::vector<ElementType> link_elements() {
  return {
      {.name = "spring",
       .doc = "A spring with a damper beside it. The first end is the lower one.",
       .equation = "force = stiffness e + cubic e^3 + damping e',  e = x_second - x_first - rest",
       .ends = Ends::Between,
       .settings = {},
       .fields = {required("stiffness", "N/m", "force for a metre", 0.0),
                  with_default("cubic", "N/m^3", "stiffens it where it is stretched or pressed far", 0.0,
                               0.0),
                  with_default("damping", "N s/m", "force for a metre a second", 0.0, 0.0),
                  with_default("rest", "m", "length without force", 0.0)},
       .quantities = {kTension, kExtension},
       .example = "hold = { type = \"spring\", between = [\"frame\", \"cone\"], stiffness = \"1000 N/m\" }"},
      {.name = "damper",
       .doc = "A damper between two points.",
       .equation = "force = damping e',  e = x_second - x_first",
       .ends = Ends::Between,
       .settings = {},
       .fields = {required("damping", "N s/m", "force for a metre a second", 0.0)},
       .quantities = {kTension, kExtension},
       .example = "loss = { type = \"damper\", between = [\"frame\", \"cone\"], damping = \"1.2 kg/s\" }"},
      {.name = "coil",
       .doc =
           "A coil in the field of a magnet, driven by a voltage. Its magnet is fixed unless `against` names "
           "a point.",
       .equation = "inductance i' = voltage - resistance i - force_factor (x_on - x_against)',  force = "
                   "force_factor i",
       .ends = Ends::Against,
       .settings = {},
       .fields = {signal("voltage", "V", "at its terminals, held from frame to frame"),
                  required("force_factor", "T m", "Bl"), required("resistance", "ohm", "of the wire", 1e-3),
                  with_default("inductance", "H", "of the coil", 0.0, 0.0)},
       .quantities = {{"current", "A", "pushes `on` up where positive", Kind::Current},
                      {"force", "N", "on `on`", Kind::CoilForce}},
       .example =
           "coil = { type = \"coil\", on = \"cone\", voltage = \"10 V * drive\", force_factor = \"6 T m\", "
           "resistance = \"6.5 ohm\" }"},
  };
}

}  // namespace tactus
