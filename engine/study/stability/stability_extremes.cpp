#include "engine/study/stability/stability_extremes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <span>

#include "engine/core/channels.h"
#include "engine/core/index.h"
#include "engine/core/units.h"
#include "engine/graph/file/quantity.h"
#include "engine/guard/guarded.h"
#include "engine/nodes/networks/network.h"
#include "engine/scene/closed_loop.h"
#include "engine/scene/guard_report.h"

namespace tactus {
namespace {

constexpr int kExtremesBlock = 64;
/// At the start of a linear run: the smallest one with half the effect at half the size is used, so that
/// quantisers and contacts do not matter.
constexpr double kPushes[] = {1e-6, 1e-4, 1e-2, 1.0, 100.0};
constexpr double kProportional = 0.05;
constexpr double kPeriod_s = 0.037;  // of impulses

/// An instrument whose sensors are disturbed and whose drives are turned up.
class Disturbed final : public BlockProcessor {
 public:
  Disturbed(BlockProcessor& inner, const ExtremePlan& plan) : inner_(inner), plan_(plan) {}

  Status prepare(const StreamFormat& format) override {
    rate_ = format.sample_rate.value;
    outputs_ = format.out_channels;
    sensors_.resize(format.in_channels, format.max_frames);
    frame_ = 0;
    first_ = 0.0;
    return inner_.prepare(format);
  }

  void process(const BlockIo& io) noexcept override {
    for (int c = 0; c < sensors_.size(); ++c)
      for (int n = 0; n < io.frames; ++n) sensors_[c][n] = io.in[c][n] + disturbance(frame_ + n);
    inner_.process({sensors_.data(), io.out, io.frames});
    for (int c = 0; c < outputs_; ++c)
      for (int n = 0; n < io.frames; ++n) {
        io.out[c][n] *= plan_.drive_gain;
        finite_ = finite_ && std::isfinite(io.out[c][n]);
        watch_growth(std::abs(io.out[c][n]), frame_ + n);
      }
    frame_ += io.frames;
  }
  bool finite() const { return finite_; }
  bool exploded() const { return exploded_; }
  double push = 0.0;  ///< of linear runs, at the start

 private:
  /// In the first half of the run; from then on the energy must not grow.
  double disturbance(std::int64_t frame) const noexcept {
    if (plan_.linear) return static_cast<double>(frame) <= plan_.push_s * rate_ ? push : 0.0;
    const double seconds = static_cast<double>(frame) / rate_;
    if (seconds > plan_.seconds / 2) return 0;
    return plan_.disturbance->at(frame, seconds, static_cast<std::int64_t>(kPeriod_s * rate_));
  }
  /// What the first impulse makes is the gain of the instrument.
  void watch_growth(double size, std::int64_t frame) noexcept {
    if (static_cast<double>(frame) < kPeriod_s * rate_)
      first_ = std::max(first_, size);
    else
      exploded_ = exploded_ || (size > kExploded && size > kGrown * first_);
  }

  BlockProcessor& inner_;
  const ExtremePlan& plan_;
  double rate_ = 48000;
  int outputs_ = 0;
  std::int64_t frame_ = 0;
  ChannelBuffers sensors_;
  double first_ = 0.0;  ///< largest output in the first period
  bool finite_ = true, exploded_ = false;
};

double stored(const Player& engine) {
  double energy = 0;
  for (const auto& node : engine.plan().nodes)
    if (const auto* view = dynamic_cast<const NetworkView*>(node.get()))
      energy += view->network.energy(view->state);
  return energy;
}

constexpr double kGrows = 4, kNothing_J = 1e-9;

/// Largest magnitude in each quarter of a run.
struct Quarters {
  double largest[4] = {};
  void add(double share, double value) {
    auto& quarter = largest[std::min(3, static_cast<int>(4 * share))];
    if (!(quarter >= std::abs(value))) quarter = std::abs(value);
  }
};

void count_faults(const Player& engine, ExtremeRun& run) {
  for (const auto& fault : engine.faults()) run.faults += fault.count;
}

/// Guarded and with converters, as on a card.
ExtremeRun run_guarded(const StabilitySubject& subject, BuiltScene& built, ExtremeRun run) {
  Disturbed disturbed{*built.instrument, run};
  Guarded guarded{disturbed,
                  guarded_channels(built.instrument->plan(),
                                   subject.scene != nullptr ? subject.scene->scene->drives : LimitBook{})};
  ClosedLoop loop{guarded, *built.plant, built.instrument->out_channels(), built.delay_frames,
                  subject.scene != nullptr ? subject.scene->scene->converters : Converters{.on = false}};
  if (!loop.prepare(run.rate, kExtremesBlock)) return run;
  guarded.skip_soft_start();
  guarded.disable_sensor_watch();
  const int frames = static_cast<int>(run.seconds * run.rate.value);
  Quarters energy;
  for (int done = 0; done < frames; done += kExtremesBlock) {
    loop.run(std::min(kExtremesBlock, frames - done), [&](const ClosedLoop::Block& block) {
      for (const auto* drive : block.drives)
        for (int n = 0; n < block.frames; ++n) {
          run.finite = run.finite && std::isfinite(drive[n]);
          run.peak = std::max(run.peak, std::abs(drive[n]));
        }
    });
    energy.add(static_cast<double>(done) / frames, stored(*built.plant) + stored(*built.instrument));
  }
  run.energy_before = std::max({energy.largest[0], energy.largest[1], energy.largest[2]});
  run.energy_after = energy.largest[3];
  run.finite = run.finite && disturbed.finite();
  run.exploded = disturbed.exploded();
  for (GuardEvent event; guarded.take_event(event);)
    run.faded = run.faded || event.kind == GuardEvent::Kind::Feedback;
  // The energy of rolls and rotations varies; that of an unstable system doubles more than once in a quarter.
  run.grew = !(run.energy_after <= kGrows * run.energy_before + kNothing_J);
  count_faults(*built.instrument, run);
  count_faults(*built.plant, run);
  return run;
}

using Sensors = std::vector<std::vector<double>>;

/// The signals of the sensors after a push.
Sensors sensors_after(double push, const StabilitySubject& subject, ExtremeRun& run) {
  Sensors samples;
  auto built = build_world(subject, run.world);
  if (!built) return samples;
  Disturbed disturbed{*built->instrument, run};
  disturbed.push = push;
  ClosedLoop loop{
      disturbed, *built->plant, built->instrument->out_channels(), built->delay_frames, {.on = false}};
  if (!loop.prepare(run.rate, kExtremesBlock)) return samples;
  loop.run(static_cast<int>(run.seconds * run.rate.value), [&](const ClosedLoop::Block& block) {
    samples.resize(index(block.sensors.size()));
    for (int c = 0; c < block.sensors.size(); ++c)
      samples[index(c)].insert(samples[index(c)].end(), block.sensors[c], block.sensors[c] + block.frames);
  });
  run.finite = run.finite && disturbed.finite();
  return samples;
}

/// Amplitude at a frequency in a quarter of a signal, under a Hann window: what decays beside it does not
/// count.
double amplitude_in_quarter(int quarter, std::span<const double> signal, double hertz, Hertz rate) {
  const auto part = signal.subspan(signal.size() / 4 * index(quarter), signal.size() / 4);
  const double frames = static_cast<double>(part.size()), turn = 2 * kPi * hertz / rate.value;
  std::complex<double> sum = 0;
  for (double n = 0; const double x : part) {
    sum += x * (1 - std::cos(2 * kPi * n / frames)) * std::polar(1.0, -turn * n);
    ++n;
  }
  return std::abs(sum) * 2 / frames;
}

/// The response to a small push at the start: sensors with it minus sensors without it.
ExtremeRun run_linear(const StabilitySubject& subject, ExtremeRun run) {
  const auto still = sensors_after(0.0, subject, run);
  const auto moved_by = [&](double push) {
    auto moved = sensors_after(push, subject, run);
    for (std::size_t c = 0; c < moved.size(); ++c)
      for (std::size_t n = 0; n < moved[c].size(); ++n) moved[c][n] -= still[c][n];
    return moved;
  };
  const auto quarters_of = [](const Sensors& moved) {
    Quarters quarters;
    for (const auto& signal : moved)
      for (std::size_t n = 0; n < signal.size(); ++n)
        quarters.add(static_cast<double>(n) / static_cast<double>(signal.size()), signal[n]);
    return quarters;
  };
  Sensors moved;
  Quarters quarters;
  for (const double push : kPushes) {
    moved = moved_by(push);
    quarters = quarters_of(moved);
    const double whole = quarters.largest[1], half = quarters_of(moved_by(0.5 * push)).largest[1];
    if (whole > 0.0 && std::abs(whole - 2.0 * half) < kProportional * whole) break;
  }
  run.energy_before = quarters.largest[1];
  run.energy_after = quarters.largest[3];
  run.grew = run.energy_after > run.energy_before;
  if (run.grew || run.growing_hz == 0) return run;
  // Slowly growing roots stay below others of the loop that decay, for longer than the run lasts.
  run.energy_before = run.energy_after = 0;
  for (const auto& signal : moved) {
    run.energy_before += amplitude_in_quarter(1, signal, run.growing_hz, run.rate);
    run.energy_after += amplitude_in_quarter(3, signal, run.growing_hz, run.rate);
  }
  run.grew = run.energy_after > run.energy_before;
  return run;
}

double impulses(std::int64_t frame, double, std::int64_t period) { return frame % period == 0 ? 1 : 0; }
double non_finite(std::int64_t frame, double, std::int64_t period) {
  if (frame % period == 1) return std::numeric_limits<double>::infinity();
  return frame % period == 0 ? std::numeric_limits<double>::quiet_NaN() : 0;
}

}  // namespace

const std::array<Disturbance, 5> kDisturbances = {
    {{"silence", [](std::int64_t, double, std::int64_t) { return 0.0; }},
     {"impulses", impulses},
     {"full-scale square", [](std::int64_t, double seconds,
                              std::int64_t) { return std::fmod(seconds, 0.02) < 0.01 ? 1.0 : -1.0; }},
     {"NaN", non_finite},
     {"denormals", [](std::int64_t, double, std::int64_t) { return 1e-310; }}}};

std::vector<ExtremePlan> extremes_of(const WorldOptions& world, const Plan& instrument) {
  std::vector<ExtremePlan> plans;
  const auto plan = [&](std::string what) -> ExtremePlan& {
    plans.push_back({.what = std::move(what), .world = world, .disturbance = &kDisturbances[1]});
    return plans.back();
  };
  const auto elsewhere = [&](std::string what) -> ExtremePlan& {
    auto& made = plan(std::move(what));
    made.elsewhere = true;
    return made;
  };
  for (const auto& disturbance : kDisturbances) plan(disturbance.name).disturbance = &disturbance;
  for (const Hertz rate : {8_kHz, 44.1_kHz, 96_kHz, 192_kHz})
    elsewhere(fmt::format("{:g} kHz", rate.value / 1e3)).world.rate = rate;
  for (const double ms : {0.0, 1.0, 5.0, 20.0, 50.0, 100.0})
    elsewhere(fmt::format("delay {:g} ms", ms)).world.delay = Seconds{1e-3 * ms};
  for (const auto& planned : instrument.controls) {
    const auto& control = planned.control;
    for (const double end : {control.range.low, control.range.high}) {
      if (!std::isfinite(end)) continue;
      auto& made = elsewhere(control.name + " = " + in_unit(end, control.unit));
      made.world.set[control.name] = ControlValue{end};
      made.control = control.name;
    }
  }
  return plans;
}

WorldOptions without_gestures(WorldOptions world, const StabilityVerdict& verdict) {
  for (const auto& gesture : verdict.gestures)
    for (const auto& control : verdict.controls)
      if (control.control.name == gesture.control)
        world.set.try_emplace(gesture.control, ControlValue{control.control.value});
  return world;
}

std::vector<ExtremePlan> border_runs(const WorldOptions& world, const StabilityVerdict& verdict) {
  std::vector<ExtremePlan> plans;
  // A measurable motion leaves the range where the linear model is right.
  if (verdict.nonlinear) return plans;
  // A loop that an event opens and closes has no border; that of what is sampled less often is not computed.
  if (verdict.sampled || std::ranges::any_of(verdict.events, &EventPlace::on_loop)) return plans;
  const LoopVerdict* loop = nullptr;
  for (const auto& other : verdict.regimes.front().loops) {
    if (!other.drive) continue;
    if (loop != nullptr) return plans;  // two drives: turning one up is not turning both up
    loop = &other;
  }
  if (loop == nullptr || loop->growth_below >= 0 || loop->growth_above <= 0) return plans;
  // What creeps away is hidden by what still swings.
  if (loop->margin.border_hz == 0) return plans;
  constexpr double kShortest = 0.5, kLongest = 20;
  for (const bool above : {false, true}) {
    const double growth = std::abs(above ? loop->growth_above : loop->growth_below);
    const double cycles = 12 / loop->margin.border_hz;
    plans.push_back(
        {.what = fmt::format("{} at {} of its stability limit", loop->at, above ? "1.02" : "0.98"),
         .world = world,
         .seconds = std::clamp(std::max(1 / growth, cycles), kShortest, kLongest),
         .drive_gain = (above ? 1.02 : 0.98) * loop->margin.border,
         .linear = true,
         .push_s = 0.1 / loop->margin.border_hz,
         .growing_hz = above ? loop->growing_hz : 0,
         .expected = !above,
         .elsewhere = true});
  }
  // Dry friction would hide the growth: the border is that of the system without it, before gestures begin.
  for (auto& plan : plans) {
    plan.world = without_gestures(plan.world, verdict);
    plan.world.friction = plan.world.gestures = false;
  }
  return plans;
}

Checked<ExtremeRun> run_extreme(const StabilitySubject& subject, const ExtremePlan& plan) {
  const auto run_for = [&](double seconds) -> Checked<ExtremeRun> {
    auto built = build_world(subject, plan.world);
    if (!built) return tl::unexpected(built.error());
    ExtremeRun run{plan};
    run.seconds = seconds;
    run.rate = built->instrument->plan().sample_rate;
    run.delay_s = built->delay_frames / run.rate.value;
    return run.linear ? run_linear(subject, std::move(run)) : run_guarded(subject, *built, std::move(run));
  };
  auto run = run_for(plan.seconds);
  if (!run || run->linear || !run->grew) return run;
  // An instrument that throws gains energy until it plays; a loop gains it for longer, or until the guard
  // fades it.
  constexpr double kLonger = 4;
  run = run_for(kLonger * plan.seconds);
  if (run) run->grew = run->grew || run->faded;
  return run;
}

void exclude_player_energy(std::vector<ExtremeRun>& runs) {
  const auto silence = std::ranges::find(runs, kDisturbances[0].name, &ExtremeRun::what);
  if (silence == runs.end() || silence->grew) return;
  const double initial_energy = silence->energy_after;
  for (auto& run : runs)
    if (!run.linear) run.grew = run.grew && !(run.energy_after <= kGrows * initial_energy + kNothing_J);
}

}  // namespace tactus
