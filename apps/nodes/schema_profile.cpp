#include "apps/nodes/schema_files.h"

namespace tactus::schema {
namespace {

Json terminals() {
  return object("the terminals",
                {{"resistance", quantity("of the coil, cold", 0.01, 1e6)},
                 {"peak", quantity("the most volts", 1e-3, 1000)},
                 {"slew", quantity("the most volts a second; no limit if left out", 1e-3, 1e9)},
                 {"soft_start", quantity("time from silence to full", 0, 60)},
                 {"fade_out", quantity("time to silence", 0, 1)}},
                {"resistance", "peak", "soft_start", "fade_out"});
}

Json heat() {
  return object("what it stands in heat",
                {{"power", quantity("steady, leads to the limit in the end", 1e-3, 1e5)},
                 {"coil_time", quantity("time constant of the coil", 0.01, 1e5)},
                 {"body_time", quantity("time constant of the body around it", 0.01, 1e6)},
                 {"coil_share", quantity("of the rise that lies between coil and body", 0.01, 0.99)},
                 {"rise", quantity("kelvin above the room", 1, 500)}},
                {"power", "coil_time", "body_time", "coil_share", "rise"});
}

Json travel() {
  return object("how far its mass may go",
                {{"limit", quantity("to either side", 1e-6, 1)},
                 {"mass", quantity("that moves", 1e-6, 100)},
                 {"stiffness", quantity("of its suspension", 1e-3, 1e9)},
                 {"damping", quantity("without the coil", 0, 1e6)},
                 {"force_factor", quantity("Bl", 1e-3, 1e4)}},
                {"limit", "mass", "stiffness", "damping", "force_factor"});
}

Json direct() {
  return object("direct current",
                {{"level", quantity("may last for ever", 1e-6, 1000)},
                 {"time", quantity("that the mean may lie above it", 0, 3600)}},
                {"level", "time"});
}

}  // namespace

Json profile() {
  auto keys = heading();
  keys["drive"] = terminals();
  keys["heat"] = heat();
  keys["travel"] = travel();
  keys["direct"] = direct();
  return object("what an actuator stands", std::move(keys), {"format", "drive"});
}

}  // namespace tactus::schema
