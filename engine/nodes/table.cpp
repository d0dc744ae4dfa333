#include "engine/nodes/table.h"

#include "engine/nodes/networks/network.h"
#include "engine/nodes/other_names.h"
#include "engine/nodes/world/world.h"

namespace tactus {

// Each is defined beside its node.
NodeType sine_type(), saw_type(), square_type(), triangle_type(), phasor_type(), wavetable_type();
NodeType noise_type(), random_walk_type(), sample_type(), curve_type();
NodeType clip_type(), shaper_type(), map_type(), mix_type(), crossfade_type(), quantiser_type(), slew_type(),
    hysteresis_type();
NodeType envelope_type(), decay_type(), adsr_type(), onset_type(), pitch_type(), stroke_type();
NodeType one_pole_type(), low_pass_type(), high_pass_type(), band_pass_type(), modal_type();
NodeType dc_blocker_type(), difference_type(), velocity_type();
NodeType delay_type(), string_type(), align_type(), event_delay_type();
NodeType clock_type(), sequence_type(), poly_type(), threshold_type(), sample_hold_type(), latch_type(),
    toggle_type(), counter_type(), state_type(), interval_type();
NodeType spring_type(), damper_type(), wall_type(), terrain_type(), modal_body_type(), waveguide_type(),
    actuator_inverse_type();
NodeType two_link_type(), five_bar_type(), delta_type(), six_axis_type(), proxy_type();

namespace {

struct Family {
  const char* name;
  std::vector<NodeType (*)()> types;  ///< in the order of the reference
};

const Family kFamilies[] = {
    {"generators",
     {sine_type, saw_type, square_type, triangle_type, wavetable_type, phasor_type, noise_type,
      random_walk_type,
#if defined(TACTUS_HAS_SNDFILE)
      sample_type,
#endif
      curve_type}},
    {"shapers",
     {clip_type, shaper_type, map_type, mix_type, crossfade_type, quantiser_type, slew_type,
      hysteresis_type}},
    {"envelopes", {envelope_type, decay_type, adsr_type, onset_type, pitch_type, stroke_type}},
    {"filters",
     {one_pole_type, low_pass_type, high_pass_type, band_pass_type, fir_type, modal_type, dc_blocker_type,
      difference_type, velocity_type}},
    {"delays", {delay_type, string_type, align_type, event_delay_type}},
    {"logic",
     {clock_type, sequence_type, poly_type, threshold_type, sample_hold_type, latch_type, toggle_type,
      counter_type, state_type, interval_type}},
    {"mechanics",
     {spring_type, damper_type, wall_type, terrain_type, modal_body_type, waveguide_type,
      actuator_inverse_type}},
    {"arms", {two_link_type, five_bar_type, delta_type, six_axis_type, proxy_type}},
};

Checked<std::shared_ptr<const NodeType>> network_or_world_type(const NetworkSpec& spec) {
  return spec.world ? world_type(spec) : network_type(spec);
}

}  // namespace

const NodeTable& standard_nodes() {
  static const std::vector<NodeType> types = [] {
    std::vector<NodeType> all;
    for (const auto& family : kFamilies)
      for (const auto type : family.types) all.emplace_back(type()).group = family.name;
    return all;
  }();
  static const NodeTable table = [] {
    NodeTable all{.types = {}, .network = network_or_world_type, .other_name = other_name};
    for (const auto& type : types) all.types.push_back(&type);
    return all;
  }();
  return table;
}

}  // namespace tactus
