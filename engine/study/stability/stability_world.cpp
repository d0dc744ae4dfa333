#include "engine/study/stability/stability_world.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/core/dimension.h"
#include "engine/core/index.h"
#include "engine/core/port_name.h"
#include "engine/graph/file/load.h"
#include "engine/guard/guarded.h"
#include "engine/nodes/networks/network_elements.h"
#include "engine/scene/guard_report.h"
#include "engine/study/stability/stability_loops.h"
#include "engine/study/sweep/scene_variants.h"

namespace tactus {
namespace {

constexpr double kSettleSeconds = 0.05;

/// Between two moments, by more than what is left of a decay, and 0.1 mm: a step of a sensor.
bool moves(double before, double now) {
  return std::abs(now - before) > std::max(1e-4, 0.01 * std::max(std::abs(now), std::abs(before)));
}

/// An instrument whose drives are disconnected, and some of whose inputs are held.
class Disconnected final : public BlockProcessor {
 public:
  Disconnected(BlockProcessor& inner, const std::vector<HeldInput>& held) : inner_(inner), held_(held) {}
  Status prepare(const StreamFormat& format) override {
    outputs_ = format.out_channels;
    half_period_ = std::max(1, static_cast<int>(0.002 * format.sample_rate.value));
    sensors_.resize(format.in_channels, format.max_frames);
    last_.assign(index(format.in_channels), 0.0);
    return inner_.prepare(format);
  }
  void process(const BlockIo& io) noexcept override {
    for (int c = 0; c < sensors_.size(); ++c) {
      std::copy_n(io.in[c], io.frames, sensors_[c]);
      last_[index(c)] = io.in[c][io.frames - 1];
    }
    for (const auto& held : held_)
      for (int n = 0; n < io.frames; ++n)
        sensors_[held.channel][n] +=
            held.alternates && (frame_ + n) / half_period_ % 2 == 1 ? -held.level : held.level;
    inner_.process({sensors_.data(), io.out, io.frames});
    for (int c = 0; c < outputs_; ++c) std::fill_n(io.out[c], io.frames, 0.0);
    frame_ += io.frames;
  }

  /// Of each input, before something was added.
  const std::vector<double>& last() const { return last_; }

 private:
  BlockProcessor& inner_;
  const std::vector<HeldInput>& held_;
  ChannelBuffers sensors_;
  std::vector<double> last_;
  int outputs_ = 0, half_period_ = 1;
  std::int64_t frame_ = 0;
};

/// Watches when nodes of a plan sample, frame by frame.
class ClockWatch {
 public:
  explicit ClockWatch(const Plan& plan) {
    for (const auto& step : plan.steps) {
      const auto* type =
          step.kind == Step::Kind::Process ? plan.vertices[index(step.vertex)].type.get() : nullptr;
      if (type == nullptr || sampling_trigger(*type) < 0) continue;
      watched_.push_back({plan.nodes[index(step.node)].get(),
                          plan.inputs[index(step.first_in + sampling_trigger(*type))].data});
    }
  }
  void next() {
    for (auto& w : watched_) {
      const bool high = *w.trigger >= 0.5;
      if (high && !w.high) {
        const int apart = w.last < 0 ? 0 : frame_ - w.last;
        if (w.apart > 0 && apart != w.apart) w.regular = false;
        w.seen += w.apart > 0;
        w.apart = apart;
        w.last = frame_;
      }
      w.high = high;
    }
    ++frame_;
  }
  void note(SamplingClocks& clocks) const {
    for (const auto& w : watched_) clocks[w.node] = w.regular && w.seen > 0 ? w.apart : 0;
  }

 private:
  struct Watched {
    const Node* node;
    const double* trigger;
    bool high = false, regular = true;
    int last = -1, apart = 0, seen = 0;
  };
  std::vector<Watched> watched_;
  int frame_ = 0;
};

/// What an assumed device can be: a point that moves, or a rotor.
struct DeviceAxis {
  const char *network, *motion, *mass_unit, *damping_unit;
  Dimension force, position, velocity;
  double square_radius;  ///< the mass and the damping of a rotor are at this distance [m^2]
};
const DeviceAxis kDeviceAxes[] = {
    {"device", kTranslation, "kg", "N s/m", {1, 1, -2}, {1}, {1, 0, -1}, 1},
    {"rotor", kRotation, "kg m^2", "N m s/rad", {2, 1, -2}, {0, 0, 0, 0, 1}, {0, 0, -1, 0, 1}, kSquareRadius},
};

bool is_position(const DeviceAxis& axis, const Dimension& d) {
  return d == axis.position && d.radian == axis.position.radian;
}
bool is_velocity(const DeviceAxis& axis, const Dimension& d) {
  return d == axis.velocity && d.radian == axis.velocity.radian;
}
/// Whether an output pushes an assumed device.
bool is_force(const Dimension& dimension) {
  return std::ranges::any_of(kDeviceAxes, [&](const DeviceAxis& axis) { return axis.force == dimension; });
}

/// The dimension of each input channel.
std::vector<Dimension> dimensions_of(const GraphSpec& graph) {
  std::vector<Dimension> dimensions;
  for (const auto& input : graph.inputs)
    dimensions.insert(dimensions.end(), static_cast<std::size_t>(input.lanes), input.dimension);
  return dimensions;
}

/// An output as it reaches the device.
struct Drive {
  Dimension dimension;
  std::string signal;
};

/// One axis of the assumed device: its network, pushed by those drives that are forces of its kind; sets
/// `from` of its sensors. "" where no drive and sensor belong to it.
std::string axis_text(const DeviceAxis& axis, const std::vector<Drive>& drives,
                      const std::vector<Dimension>& sensors, const AssumedDevice& device,
                      std::vector<std::string>& from) {
  std::string push;
  for (const auto& drive : drives)
    if (drive.dimension == axis.force) push += (push.empty() ? "" : " + ") + drive.signal;
  bool sensed = false;
  for (std::size_t s = 0; s < sensors.size() && !push.empty(); ++s) {
    const bool place = is_position(axis, sensors[s]), speed = is_velocity(axis, sensors[s]);
    if (place || speed) from[s] = fmt::format("{}.tip.{}", axis.network, place ? "position" : "velocity");
    sensed = sensed || place || speed;
  }
  if (!sensed) return {};
  return fmt::format(
      "[networks.{}]\nsolver = \"exact\"\nmotion = \"{}\"\nframe = {{ type = \"ground\" }}\n"
      "tip = {{ type = \"mass\", mass = \"{:.17g} {}\" }}\n"
      "drag = {{ type = \"damper\", between = [\"frame\", \"tip\"], damping = \"{:.17g} {}\" }}\n"
      "push = {{ type = \"force\", on = \"tip\", force = \"{}\" }}\n",
      axis.network, axis.motion, axis.square_radius * device.mass, axis.mass_unit,
      axis.square_radius * device.damping, axis.damping_unit, push);
}

/// The assumed device as a graph: forces and torques act on it behind the card's high-passes, its positions
/// and velocities are the sensors; other channels stay open.
std::string device_text(const Plan& instrument, const std::vector<Dimension>& sensors,
                        const WorldOptions& options) {
  std::vector<Drive> drives;
  std::string inputs, outputs, nodes, networks;
  for (const auto& channel : instrument.channels) {
    if (channel.use == OutputUse::Tap) continue;
    const auto name = fmt::format("d{}", drives.size());
    inputs += fmt::format("{} = {{ unit = \"{}\" }}\n", name, to_string(channel.dimension));
    const auto highpass = options.output_highpass.find(port_of(channel.name));
    const bool coupled = highpass != options.output_highpass.end();
    if (coupled)
      nodes += fmt::format("h{0} = {{ type = \"one_pole\", in = \"{0}\", cutoff = \"{1:.17g} Hz\" }}\n", name,
                           highpass->second.value);
    drives.push_back({channel.dimension, coupled ? "h" + name + ".high" : name});
  }
  std::vector<std::string> from(sensors.size(), "0");
  for (const auto& axis : kDeviceAxes) networks += axis_text(axis, drives, sensors, options.device, from);
  for (std::size_t s = 0; s < sensors.size(); ++s)
    outputs += fmt::format("s{} = {{ from = \"{}\", unit = \"{}\" }}\n", s, from[s], to_string(sensors[s]));
  return "format = 1\n[inputs]\n" + inputs + "[nodes]\n" + nodes + "[outputs]\n" + outputs + networks;
}

Checked<BuiltScene> build_alone(const StabilitySubject& subject, const WorldOptions& options) {
  CompileOptions with;
  with.sample_rate = options.rate.value_or(48_kHz);
  with.system_delay = options.delay.value_or(0_s);
  with.controls = options.set;
  with.vectorise = options.vectorise;
  auto instrument = compile(*subject.instrument, *subject.table, with);
  if (!instrument) return tl::unexpected(instrument.error());
  CompiledScene scene;
  scene.delay_frames = static_cast<int>(std::lround(frames_in(with.system_delay, with.sample_rate)));
  with.controls.clear();
  with.closed_outside = scene.delay_frames == 0;
  const auto text = device_text(**instrument, dimensions_of(*subject.instrument->spec), options);
  auto plant = compile(parse_graph_leniently(text, "the assumed device"), *subject.table, with);
  if (!plant) return tl::unexpected(plant.error());
  scene.instrument = std::move(*instrument);
  scene.plant = std::move(*plant);
  return BuiltScene{std::move(scene)};
}

/// The same scene without any normal force at the frictions of its networks: its small-signal model is exact
/// for the rest.
LoadedScene without_friction(LoadedScene loaded) {
  if (!loaded.scene) return loaded;
  loaded.scene = with_networks_changed(
      std::move(*loaded.scene),
      [](NetworkSpec& network, const std::string&) {
        for (auto& element : network.elements) {
          const auto* type = find_element(element.type);
          if (type == nullptr || type->force_field.empty()) continue;
          std::erase_if(element.fields, [&](const Field& field) { return field.key == type->force_field; });
          element.fields.push_back({type->force_field, element.at, {0.0, element.at}});
        }
      },
      true);
  return loaded;
}

}  // namespace

Checked<BuiltScene> build_world(const StabilitySubject& subject, const WorldOptions& options) {
  if (subject.instrument != nullptr) return build_alone(subject, options);
  if (options.friction && options.gestures) return build_scene(*subject.scene, *subject.table, options);
  auto scene = options.friction ? *subject.scene : without_friction(*subject.scene);
  if (scene.scene && !options.gestures)
    for (auto& gesture : scene.scene->gestures)
      if (!gesture.points.empty()) gesture.points.resize(1);
  return build_scene(scene, *subject.table, options);
}

Checked<RestingWorld> RestingWorld::make(const StabilitySubject& subject, const WorldOptions& options,
                                         const std::vector<HeldInput>& held) {
  auto resting = options;
  resting.vectorise = false;
  auto built = build_world(subject, resting);
  if (!built) return tl::unexpected(built.error());
  RestingWorld world{std::move(*built)};
  world.alone_ = subject.instrument != nullptr;
  world.rest(held);
  return world;
}

/// Frame by frame, so that the last value of each signal is at the front of its buffer.
void RestingWorld::rest(const std::vector<HeldInput>& held) {
  const int frames = static_cast<int>(kSettleSeconds * rate().value);
  Disconnected instrument{*built_.instrument, held};
  ClockWatch own{built_.instrument->plan()}, around{built_.plant->plan()};
  ClosedLoop loop{
      instrument, *built_.plant, built_.instrument->out_channels(), built_.delay_frames, {.on = false}};
  std::vector<double> halfway;
  int frame = 0;
  if (loop.prepare(rate(), 1))
    loop.run(frames, [&](const ClosedLoop::Block&) {
      own.next(), around.next();
      if (++frame == frames / 2) halfway = instrument.last();
    });
  resting_ = instrument.last();
  for (std::size_t c = 0; c < halfway.size(); ++c)
    moving_ |= !unit_of_place(static_cast<int>(c)).empty() && moves(halfway[c], resting_[c]);
  own.note(clocks_);
  around.note(clocks_);
}

ClosedGraph RestingWorld::closed(const Regime& regime) const {
  ClosedGraph closed;
  const auto terminals = add_plan(closed.graph, instrument(), clocks_, regime, "instrument.");
  const auto& channels = instrument().channels;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    if (channels[c].use == OutputUse::Tap) continue;
    const int drive = closed.graph.add_signal(channels[c].name);
    if (terminals.channels[c] >= 0) closed.graph.join(terminals.channels[c], drive);
    closed.drives.push_back(drive);
  }
  join_plant(closed, regime, terminals);
  return closed;
}

void RestingWorld::join_plant(ClosedGraph& closed, const Regime& regime, const Terminals& instrument) const {
  auto& graph = closed.graph;
  const auto plant = add_plan(graph, built_.plant->plan(), clocks_, regime, "");
  for (std::size_t d = 0; d < closed.drives.size() && d < plant.inputs.size(); ++d)
    if (plant.inputs[d] >= 0) graph.delay(closed.drives[d], plant.inputs[d], built_.delay_frames);
  const auto wires = output_names(built_.plant->plan()).size();
  for (std::size_t s = 0; s < wires && s < instrument.inputs.size(); ++s)
    if (plant.channels[s] >= 0 && instrument.inputs[s] >= 0)
      graph.join(plant.channels[s], instrument.inputs[s]);
  for (const auto& network : graph.networks)
    if (network->whole() && network->driven_row >= 0)
      closed.mobility = [network](std::complex<double> z) {
        const auto& response = network->response();
        return response.by_modes() ? response.at(z, network->driven_row, network->test_force)
                                   : response.at(z)(network->driven_row, network->test_force);
      };
}

bool RestingWorld::outside_known() const {
  const auto& wires = built_.plant->plan().channels;
  return !alone_ || std::ranges::any_of(wires, [](const auto& wire) { return !wire.signal.constant(); });
}

std::vector<int> RestingWorld::moved_inputs() const {
  LinearGraph graph;
  const auto terminals = add_plan(graph, built_.plant->plan(), clocks_, {}, "");
  std::vector<bool> reached(graph.signals.size(), alone_);
  for (const int input : terminals.inputs)
    if (input >= 0) reached[index(input)] = true;
  for (bool further = true; std::exchange(further, false);)
    for (const auto& edge : graph.edges)
      if (reached[index(edge.from)] && !reached[index(edge.to)]) reached[index(edge.to)] = further = true;
  std::vector<int> moved;
  for (int c = 0; c < std::ssize(instrument().input_names); ++c) {
    const int sensor = index(c) < terminals.channels.size() ? terminals.channels[index(c)] : -1;
    if (alone_ || (sensor >= 0 && reached[index(sensor)])) moved.push_back(c);
  }
  return moved;
}

std::string RestingWorld::unit_of_place(int channel) const {
  const auto& sensors = built_.plant->plan().channels;
  if (alone_ || index(channel) >= sensors.size()) return "";
  const auto& dimension = sensors[index(channel)].dimension;
  return dimension == Dimension{.metre = 1} || dimension == Dimension{.radian = 1} ? to_string(dimension)
                                                                                   : "";
}

std::vector<Interval> played_ranges(const StabilitySubject& subject, const WorldOptions& options) {
  if (subject.scene == nullptr) return {};
  auto built = build_world(subject, options);
  if (!built) return {};
  const auto& scene = *subject.scene->scene;
  const auto& plan = built->instrument->plan();
  Guarded guarded{*built->instrument, guarded_channels(plan, scene.drives)};
  ClosedLoop loop{guarded, *built->plant, built->instrument->out_channels(), built->delay_frames,
                  scene.converters};
  constexpr int kBlock = 64;
  constexpr double kMostSeconds = 8;
  if (!loop.prepare(plan.sample_rate, kBlock)) return {};
  guarded.skip_soft_start();
  guarded.disable_sensor_watch();
  std::vector<Interval> ranges(plan.input_names.size(), Interval{kUnlimited, -kUnlimited});
  const double seconds = std::min(scene.duration.value, kMostSeconds);
  loop.run(static_cast<int>(seconds * plan.sample_rate.value), [&](const ClosedLoop::Block& block) {
    for (std::size_t c = 0; c < ranges.size() && index(block.sensors.size()) > c; ++c)
      for (int n = 0; n < block.frames; ++n) {
        const double x = block.sensors[static_cast<int>(c)][n];
        if (!std::isfinite(x)) continue;
        ranges[c] = {std::min(ranges[c].low, x), std::max(ranges[c].high, x)};
      }
  });
  return ranges;
}

std::vector<OpenPair> RestingWorld::open_pairs(LinearGraph& graph, const Regime& regime) const {
  std::vector<OpenPair> pairs;
  if (!alone_) return pairs;
  const auto terminals = add_plan(graph, instrument(), clocks_, regime, "instrument.");
  const auto& outside = built_.plant->plan();
  for (std::size_t i = 0; i < terminals.inputs.size(); ++i)
    for (std::size_t c = 0; c < terminals.channels.size(); ++c) {
      const auto& channel = instrument().channels[c];
      const bool joined = is_force(channel.dimension) && !outside.channels[i].signal.constant();
      if (channel.use == OutputUse::Drive && !joined && terminals.inputs[i] >= 0 &&
          terminals.channels[c] >= 0)
        pairs.push_back(
            {instrument().input_names[i], channel.name, terminals.inputs[i], terminals.channels[c]});
    }
  return pairs;
}

LinearGraph RestingWorld::with_laws_of_loops() const {
  auto graph = closed({.all_paths = true}).graph;
  if (!outside_known()) return graph;
  std::vector<bool> looping(graph.signals.size(), false);
  for (const auto& loop : loops_of(graph, true))
    for (const int signal : loop) looping[index(signal)] = true;
  std::erase_if(graph.laws,
                [&](const Nonlinearity& law) { return law.signal < 0 || !looping[index(law.signal)]; });
  return graph;
}

std::vector<Regime> RestingWorld::regimes(double push) const {
  std::vector<Regime> regimes(1);
  if (moving_) regimes.front().name = fmt::format("in motion at {:g} ms", 1e3 * kSettleSeconds);
  const auto free = with_laws_of_loops();
  const auto places = free.has_touched ? operating_points(free.laws) : std::vector<OperatingPoint>{};
  for (const auto& place : places)
    regimes.push_back({.name = place.name, .certain = place.certain, .touched = true, .moved = place.moved});
  Regime all{.name = "everything touched", .touched = true};
  std::size_t contacts = 0;
  for (std::size_t n = 0; n < free.networks.size(); ++n) {
    const auto& names = free.networks[n]->recipe.contacts;
    auto& touching = all.contacts[free.network_paths[n]];
    touching.push = push;
    for (std::size_t c = 0; c < names.size(); ++c) {
      touching.contacts.push_back(static_cast<int>(c));
      if (++contacts > 4) continue;
      Regime one{.name = names[c] + " closed"};
      one.contacts[free.network_paths[n]] = {{static_cast<int>(c)}, push};
      regimes.push_back(std::move(one));
    }
  }
  const bool more = contacts > 1 || (contacts > 0 && free.has_touched);
  if (contacts > 4) regimes.resize(1 + places.size());
  if (!more) return regimes;
  if (places.size() < 2) regimes.push_back(all);
  for (std::size_t p = 0; places.size() > 1 && p < places.size(); ++p) {
    auto& one = regimes.emplace_back(all);
    one.name += ", " + places[p].name;
    one.moved = places[p].moved;
    one.certain = places[p].certain;
  }
  return regimes;
}

}  // namespace tactus
