#include "engine/nodes/table.h"

#include "engine/nodes/networks/network.h"

namespace tactus {

// Each is defined beside its node.
NodeType sine_type(), noise_type(), wavetable_type(), sample_type(), curve_type();
NodeType clip_type(), map_type(), mix_type(), quantiser_type(), slew_type(), hysteresis_type();
NodeType envelope_type(), decay_type(), adsr_type(), onset_type();
NodeType one_pole_type(), low_pass_type(), high_pass_type(), band_pass_type(), modal_type();
NodeType dc_blocker_type(), difference_type(), velocity_type();
NodeType delay_type(), string_type(), align_type();
NodeType threshold_type(), sample_hold_type(), latch_type(), counter_type();
NodeType spring_type(), damper_type(), wall_type(), terrain_type(), modal_body_type(), waveguide_type();

namespace {

struct Family {
  const char* name;
  std::vector<NodeType (*)()> types;  ///< in the order of the reference
};

const Family kFamilies[] = {
    {"generators",
     {sine_type, noise_type, wavetable_type,
#if defined(TACTUS_HAS_SNDFILE)
      sample_type,
#endif
      curve_type}},
    {"shapers", {clip_type, map_type, mix_type, quantiser_type, slew_type, hysteresis_type}},
    {"envelopes", {envelope_type, decay_type, adsr_type, onset_type}},
    {"filters",
     {one_pole_type, low_pass_type, high_pass_type, band_pass_type, fir_type, modal_type, dc_blocker_type,
      difference_type, velocity_type}},
    {"delays", {delay_type, string_type, align_type}},
    {"logic", {threshold_type, sample_hold_type, latch_type, counter_type}},
    {"mechanics", {spring_type, damper_type, wall_type, terrain_type, modal_body_type, waveguide_type}},
};

}  // namespace

const NodeTable& standard_nodes() {
  static const std::vector<NodeType> types = [] {
    std::vector<NodeType> all;
    for (const auto& family : kFamilies)
      for (const auto type : family.types) all.emplace_back(type()).group = family.name;
    return all;
  }();
  static const NodeTable table = [] {
    NodeTable all{.types = {}, .network = network_type};
    for (const auto& type : types) all.types.push_back(&type);
    return all;
  }();
  return table;
}

}  // namespace tactus
