#pragma once

// Thread: [control].

#include "engine/graph/node_type.h"

namespace tactus {

inline InputPort filtered_input(std::string doc = "signal to filter") {
  return {.name = "in", .unit = "any", .doc = std::move(doc)};
}

/// Clamped to [1e-6 fs, 0.49 fs]; changes at the start of a group of eight frames.
inline InputPort cutoff_input(std::string doc, std::optional<double> fallback = std::nullopt) {
  return {.name = "cutoff", .unit = "Hz", .doc = std::move(doc), .fallback = fallback, .low = 0};
}

inline InputPort q_input(std::string doc, double fallback) {
  return {.name = "q", .unit = "", .doc = std::move(doc), .fallback = fallback, .low = 0.01, .high = 1000};
}

inline OutputPort filtered_output(std::string name, std::string doc) {
  return {.name = std::move(name), .unit = "=in", .doc = std::move(doc)};
}

}  // namespace tactus
