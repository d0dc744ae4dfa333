#include <SDL.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <mutex>
#include <span>
#include <thread>

#include "backends/card_callback.h"
#include "backends/find_device.h"
#include "backends/realtime_thread.h"
#include "backends/sdl/effect_timer.h"
#include "backends/sdl/joystick_place.h"
#include "backends/sdl/wave_effect.h"

namespace tactus {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr auto kPoll = 1ms;    // a block: the device is read, and written, once
constexpr auto kLate = 100ms;  // later blocks are left out
constexpr int kPollRate_hz = 1000;
constexpr int kPriority = 70;
constexpr double kFullTurn = 34.9;  // [rad/s] of the gyroscope at full scale: 2,000 degrees a second
constexpr Uint32 kRumbleLength_ms = 500;

/// SDL's joysticks and gamepads, for as long as somebody uses them.
class Library {
 public:
  Library() {
    SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1");
    SDL_SetHint(SDL_HINT_JOYSTICK_ALLOW_BACKGROUND_EVENTS, "1");
    ready_ = SDL_InitSubSystem(kParts) == 0;
  }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;
  ~Library() {
    if (ready_) SDL_QuitSubSystem(kParts);
  }
  bool ready() const { return ready_; }

 private:
  static constexpr Uint32 kParts = SDL_INIT_JOYSTICK | SDL_INIT_GAMECONTROLLER | SDL_INIT_HAPTIC;
  bool ready_ = false;
};

tl::unexpected<Error> failed(const std::string& what) {
  return fail(Errc::Device, "", fmt::format("{}: {}", what, SDL_GetError()), "see tactus doctor");
}

/// What an output is in the device.
struct Output {
  enum class Kind { RumbleLow, RumbleHigh, Effect, Wave, WaveSetting };
  Kind kind = Kind::Effect;
  std::string name;
  Uint16 type = 0;           ///< of an effect
  int axis = 0;              ///< of a force
  std::size_t settings = 0;  ///< of a wave: the first of its outputs
};

struct EffectType {
  Uint16 type;
  const char* name;
  Output::Kind kind = Output::Kind::Effect;
};

/// The effects that a device may have, in the order of the outputs. SDL 2 has no square wave.
constexpr std::array<EffectType, 8> kEffects{
    {{SDL_HAPTIC_SINE, "sine", Output::Kind::Wave},
     {SDL_HAPTIC_SPRING, "spring"},
     {SDL_HAPTIC_DAMPER, "damper"},
     {SDL_HAPTIC_INERTIA, "inertia"},
     {SDL_HAPTIC_FRICTION, "friction"},
     {SDL_HAPTIC_TRIANGLE, "triangle", Output::Kind::Wave},
     {SDL_HAPTIC_SAWTOOTHUP, "sawtooth up", Output::Kind::Wave},
     {SDL_HAPTIC_SAWTOOTHDOWN, "sawtooth down", Output::Kind::Wave}}};
constexpr int kMostForceAxes = 2;
constexpr Uint16 kConditions =  // a report for each axis
    SDL_HAPTIC_SPRING | SDL_HAPTIC_DAMPER | SDL_HAPTIC_INERTIA | SDL_HAPTIC_FRICTION;
constexpr int kReportsOfCreation = 3;  // it is created, and has a direction, a length and an envelope

Sint16 scaled(double level) { return static_cast<Sint16>(std::lround(32767 * std::clamp(level, -1.0, 1.0))); }

/// The effect of an output at a level. A positive force pushes towards positive positions of its axis; an
/// effect of the device's own has the strength |level|.
SDL_HapticEffect effect_of(const Output& output, double level) {
  SDL_HapticEffect effect{};
  effect.type = output.type;
  const auto length = static_cast<Uint32>(EffectTimer::kLength.count());
  const auto strength = scaled(std::abs(level));
  if (output.type == SDL_HAPTIC_CONSTANT) {
    effect.constant.direction.type = SDL_HAPTIC_CARTESIAN;
    effect.constant.direction.dir[output.axis] = -1;  // where it comes from
    effect.constant.length = length;
    effect.constant.level = scaled(level);
  } else {
    effect.condition.direction.type = SDL_HAPTIC_CARTESIAN;
    effect.condition.direction.dir[0] = 1;
    effect.condition.length = length;
    for (int axis = 0; axis < 3; ++axis) {
      effect.condition.right_sat[axis] = effect.condition.left_sat[axis] = 0xffff;
      effect.condition.right_coeff[axis] = effect.condition.left_coeff[axis] = strength;
    }
  }
  return effect;
}

SDL_HapticEffect effect_of(const Output& output, const Wave& wave) {
  SDL_HapticEffect effect{};
  auto& periodic = effect.periodic;
  periodic.type = output.type;
  periodic.direction.type = SDL_HAPTIC_CARTESIAN;
  periodic.direction.dir[0] = 1;
  periodic.length = static_cast<Uint32>(wave.length_ms);
  periodic.period = static_cast<Uint16>(wave.period_ms);
  periodic.magnitude = static_cast<Sint16>(wave.magnitude);
  periodic.offset = static_cast<Sint16>(wave.offset);
  periodic.phase = static_cast<Uint16>(wave.phase);
  periodic.attack_length = static_cast<Uint16>(wave.attack_ms);
  periodic.attack_level = static_cast<Uint16>(wave.attack_level);
  periodic.fade_length = static_cast<Uint16>(wave.fade_ms);
  return effect;
}

/// A joystick, wheel or gamepad with all that it has.
class OpenDevice {
 public:
  /// nullptr: it went away.
  static std::shared_ptr<OpenDevice> open(int index) {
    auto* joystick = SDL_JoystickOpen(index);
    return joystick == nullptr ? nullptr : std::make_shared<OpenDevice>(index, joystick);
  }
  OpenDevice(int index, SDL_Joystick* joystick) : joystick_(joystick) {
    if (SDL_IsGameController(index) == SDL_TRUE) pad_ = SDL_GameControllerOpen(index);
    if (SDL_JoystickIsHaptic(joystick) == SDL_TRUE) haptic_ = SDL_HapticOpenFromJoystick(joystick);
    name_inputs();
    name_outputs();
    effects_.resize(outputs.size());
    levels_.resize(outputs.size());
  }
  OpenDevice(const OpenDevice&) = delete;
  OpenDevice& operator=(const OpenDevice&) = delete;
  ~OpenDevice() {
    if (haptic_ != nullptr) SDL_HapticClose(haptic_);
    if (pad_ != nullptr) SDL_GameControllerClose(pad_);
    SDL_JoystickClose(joystick_);
  }

  bool attached() const { return SDL_JoystickGetAttached(joystick_) == SDL_TRUE; }

  /// The inputs as they are now.
  void read(std::vector<double>& values) {
    std::size_t at = 0;
    for (int a = 0; a < SDL_JoystickNumAxes(joystick_); ++a)
      values[at++] = std::max(-1.0, SDL_JoystickGetAxis(joystick_, a) / 32767.0);
    for (int h = 0; h < SDL_JoystickNumHats(joystick_); ++h) {
      const auto hat = SDL_JoystickGetHat(joystick_, h);
      values[at++] = ((hat & SDL_HAT_RIGHT) != 0) - ((hat & SDL_HAT_LEFT) != 0);
      values[at++] = ((hat & SDL_HAT_UP) != 0) - ((hat & SDL_HAT_DOWN) != 0);
    }
    for (int b = 0; b < SDL_JoystickNumButtons(joystick_); ++b)
      values[at++] = SDL_JoystickGetButton(joystick_, b);
    if (gyroscope_) {
      std::array<float, 3> turn{};
      (void)SDL_GameControllerGetSensorData(pad_, SDL_SENSOR_GYRO, turn.data(), 3);
      for (const float speed : turn)
        values[at++] = std::clamp(static_cast<double>(speed) / kFullTurn, -1.0, 1.0);
    }
  }

  /// Sends what changed, one output after the other as the budget allows. Levels are from -1 to 1.
  void write(const std::vector<double>& levels, Clock::time_point now) {
    for (std::size_t n = 0, first = next_; n < outputs.size(); ++n) {
      const auto output = (first + n) % outputs.size();
      const auto kind = outputs[output].kind;
      const int reports = kind == Output::Kind::Effect      ? write_effect(output, levels, now)
                          : kind == Output::Kind::Wave      ? write_wave(output, levels, now)
                          : kind == Output::Kind::RumbleLow ? write_rumble(levels, now)
                                                            : 0;
      if (reports == 0) continue;
      budget_.spend(reports, now);
      next_ = output + 1;
    }
  }
  /// Nothing moves any more.
  void silence() {
    if (rumbles_ && !rumble_is_effect_) SDL_JoystickRumble(joystick_, 0, 0, 0);
    if (haptic_ != nullptr) SDL_HapticStopAll(haptic_);
  }
  /// [any] How often the device did not take an effect.
  std::int64_t refused() const { return refused_; }

  std::vector<std::string> inputs;
  std::vector<Output> outputs;

 private:
  struct Effect {
    int id = -1;
    EffectTimer timer;
    WaveEffect wave;  ///< in place of the timer
  };

  void name_inputs() {
    for (int a = 0; a < SDL_JoystickNumAxes(joystick_); ++a) inputs.push_back(fmt::format("axis {}", a));
    for (int h = 0; h < SDL_JoystickNumHats(joystick_); ++h)
      for (const auto* direction : {"x", "y"}) inputs.push_back(fmt::format("hat {} {}", h, direction));
    for (int b = 0; b < SDL_JoystickNumButtons(joystick_); ++b) inputs.push_back(fmt::format("button {}", b));
    gyroscope_ = pad_ != nullptr && SDL_GameControllerHasSensor(pad_, SDL_SENSOR_GYRO) == SDL_TRUE &&
                 SDL_GameControllerSetSensorEnabled(pad_, SDL_SENSOR_GYRO, SDL_TRUE) == 0;
    if (gyroscope_)
      for (const auto* axis : {"x", "y", "z"}) inputs.push_back(fmt::format("gyroscope {}", axis));
  }

  /// Forces and effects need a slot each, and both motors one. The settings of waves are the last outputs.
  void name_outputs() {
    rumbles_ = SDL_JoystickHasRumble(joystick_) == SDL_TRUE;
    if (rumbles_) {
      outputs.push_back({Output::Kind::RumbleLow, "rumble low"});
      outputs.push_back({Output::Kind::RumbleHigh, "rumble high"});
    }
    if (haptic_ == nullptr) return;
    const auto can = SDL_HapticQuery(haptic_);
    rumble_is_effect_ = rumbles_ && (can & SDL_HAPTIC_LEFTRIGHT) != 0;
    auto slots = SDL_HapticNumEffects(haptic_) - (rumbles_ ? 1 : 0);
    const auto add = [&](const EffectType& effect, int axis = 0) {
      if ((can & effect.type) != 0 && slots-- > 0)
        outputs.push_back({effect.kind, effect.name, effect.type, axis});
    };
    for (int axis = 0; axis < std::clamp(SDL_HapticNumAxes(haptic_), 1, kMostForceAxes); ++axis)
      add({SDL_HAPTIC_CONSTANT, axis == 0 ? "force x" : "force y"}, axis);
    for (const auto& effect : kEffects) add(effect);
    const auto effects = outputs.size();
    for (std::size_t o = 0; o < effects; ++o) {
      if (outputs[o].kind != Output::Kind::Wave) continue;
      outputs[o].settings = outputs.size();
      for (const auto& setting : kWaveSettings)
        outputs.push_back({Output::Kind::WaveSetting, outputs[o].name + " " + setting.name});
    }
  }

  // These return how many reports a device of the USB PID class gets.

  /// Both motors.
  int write_rumble(const std::vector<double>& levels, Clock::time_point now) {
    std::array<Uint16, 2> strength{};
    bool sends = false;
    for (std::size_t o = 0; o < 2; ++o) {
      sends |= next_order(o, levels, now) != EffectTimer::Order::None;
      strength[o] = static_cast<Uint16>(std::lround(65535 * std::clamp(std::abs(levels[o]), 0.0, 1.0)));
    }
    return sends ? rumble(strength[0], strength[1]) : 0;
  }
  /// An effect of the device, where it can be one: that of SDL_JoystickRumble lasts 65 s in Linux' drivers,
  /// and ends earlier only as long as SDL is called.
  int rumble(Uint16 low, Uint16 high) {
    if (!rumble_is_effect_) return SDL_JoystickRumble(joystick_, low, high, kRumbleLength_ms), 1;
    auto& id = effects_[0].id;
    if (low == 0 && high == 0) return stop(id);
    SDL_HapticEffect effect{};
    effect.leftright = {SDL_HAPTIC_LEFTRIGHT, kRumbleLength_ms, static_cast<Uint16>(low / 2),
                        static_cast<Uint16>(high / 2)};  // full scale is 32767
    const int reports = upload(id, effect);
    return reports + run(id);
  }

  EffectTimer::Order next_order(std::size_t output, const std::vector<double>& levels,
                                Clock::time_point now) {
    return effects_[output].timer.next(levels[output], now, budget_.allows(now));
  }
  /// An effect that the device refused is tried again when it would be restarted.
  int write_effect(std::size_t output, const std::vector<double>& levels, Clock::time_point now) {
    using Order = EffectTimer::Order;
    const double level = levels[output];
    const auto order = next_order(output, levels, now);
    auto& id = effects_[output].id;
    if (order == Order::None || (id < 0 && order == Order::Change)) return 0;
    if (order == Order::Stop) return stop(id);
    int reports = 0;
    if (id < 0 || levels_[output] != level) {
      auto effect = effect_of(outputs[output], level);
      reports = upload(id, effect);
      levels_[output] = level;
    }
    return order == Order::Change ? reports : reports + run(id);
  }
  int write_wave(std::size_t output, const std::vector<double>& levels, Clock::time_point now) {
    auto& [id, timer, effect] = effects_[output];
    const auto settings = std::span{levels}.subspan(outputs[output].settings, kWaveSettings.size());
    const auto step = effect.next(wave_of(levels[output], settings), now, budget_.allows(now));
    if (step.stops) return stop(id);
    int reports = 0;
    if (step.uploads && (id >= 0 || step.runs)) {
      auto sent = effect_of(outputs[output], step.wave);
      reports = upload(id, sent, step.reports);
    }
    if (id < 0) effect.forget();
    return step.runs ? reports + run(id) : reports;
  }
  /// Creates the effect, or changes it. `reports`: of the change.
  int upload(int& id, SDL_HapticEffect& effect, int reports = 1) {
    if (id < 0) reports = 1 + kReportsOfCreation;
    if ((effect.type & kConditions) != 0) reports += kMostForceAxes - 1;
    const bool sent = id < 0 ? (id = SDL_HapticNewEffect(haptic_, &effect)) >= 0
                             : SDL_HapticUpdateEffect(haptic_, id, &effect) == 0;
    if (!sent) ++refused_;
    return reports;
  }
  int run(int id) {
    if (id < 0) return 0;
    if (SDL_HapticRunEffect(haptic_, id, 1) != 0) ++refused_;
    return 1;
  }
  int stop(int id) { return id < 0 ? 0 : (SDL_HapticStopEffect(haptic_, id), 1); }

  SDL_Joystick* joystick_;
  SDL_GameController* pad_ = nullptr;
  SDL_Haptic* haptic_ = nullptr;
  bool rumbles_ = false, rumble_is_effect_ = false, gyroscope_ = false;
  std::vector<Effect> effects_;  ///< one for each output
  std::vector<double> levels_;   ///< in the device
  ReportBudget budget_;
  std::size_t next_ = 0;  ///< output that may send first
  std::atomic<std::int64_t> refused_{0};
};

/// Its place, and the numbers of its maker, model and version. Empty: unknown.
std::string hardware_of(int index) {
  const auto* path = SDL_JoystickPathForIndex(index);
  const auto place = path == nullptr ? "" : joystick_place(path);
  return place.empty()
             ? ""
             : fmt::format("{} {:04x}:{:04x}:{:04x}", place, SDL_JoystickGetDeviceVendor(index),
                           SDL_JoystickGetDeviceProduct(index), SDL_JoystickGetDeviceProductVersion(index));
}

Device described(int index) {
  Device device;
  const auto* name = SDL_JoystickNameForIndex(index);
  device.library_name = name == nullptr ? "unnamed" : name;
  device.id = "sdl:" + device.library_name;
  device.name = device.library_name + " (joysticks and gamepads)";
  device.index = index;
  device.api = "sdl";
  device.hardware = hardware_of(index);
  device.default_rate = kHapticRate;
  device.block_frames = 8;
  if (const auto opened = OpenDevice::open(index)) {
    device.in_channels = static_cast<int>(opened->inputs.size());
    device.out_channels = static_cast<int>(opened->outputs.size());
    device.in_names = opened->inputs;
    for (const auto& output : opened->outputs) device.out_names.push_back(output.name);
  }
  return device;
}

Result<std::vector<Device>> list_devices() {
  const Library library;
  if (!library.ready()) return failed("SDL finds no joysticks");
  SDL_JoystickUpdate();
  std::vector<Device> devices;
  for (int i = 0; i < SDL_NumJoysticks(); ++i) devices.push_back(described(i));
  distinguish_same_ids(devices);
  return devices;
}

/// All that the thread touches.
struct Line {
  Library library;
  std::shared_ptr<OpenDevice> device;
  std::unique_ptr<CardCallback> card;
  int frames = 8;  ///< of a block
  std::atomic<bool> stops{false}, lost{false};
  std::atomic<double> reports_hz{0.0};
};

/// Blocks of a device, a millisecond each. Inputs move from their value in the block before to the present
/// one in a straight line, so that they are a block late; an output is its mean over the block.
class Pacer {
 public:
  explicit Pacer(Line& line)
      : line_(line),
        now_(line.device->inputs.size()),
        before_(line.device->inputs.size()),
        levels_(line.device->outputs.size()) {
    in_.assign(now_.size(), std::vector<float>(index(line.frames)));
    out_.assign(levels_.size(), std::vector<float>(index(line.frames)));
    for (const auto& channel : in_) from_.push_back(channel.data());
    for (auto& channel : out_) to_.push_back(channel.data());
  }

  void run() {
    (void)become_realtime(kPriority);
    SDL_JoystickUpdate();
    line_.device->read(before_);
    for (auto next = Clock::now(); !line_.stops; std::this_thread::sleep_until(next += kPoll)) {
      if (Clock::now() - next > kLate) next = Clock::now();
      if (!turn(Clock::now())) break;
    }
    line_.device->silence();
  }

 private:
  bool turn(Clock::time_point now) {
    SDL_JoystickUpdate();
    if (!line_.device->attached()) return line_.lost = true, false;
    line_.device->read(now_);
    count_reports(now_ != before_, now);
    const auto frames = static_cast<std::size_t>(line_.frames);
    for (std::size_t c = 0; c < in_.size(); ++c)
      for (std::size_t n = 0; n < frames; ++n)
        in_[c][n] = static_cast<float>(
            std::lerp(before_[c], now_[c], static_cast<double>(n + 1) / static_cast<double>(frames)));
    before_ = now_;
    line_.card->block(from_.data(), to_.data(), static_cast<int>(to_.size()), line_.frames);
    for (std::size_t c = 0; c < out_.size(); ++c) {
      double sum = 0.0;
      for (const float sample : out_[c]) sum += static_cast<double>(sample);
      levels_[c] = sum / static_cast<double>(frames);
    }
    line_.device->write(levels_, now);
    return true;
  }

  /// The most in a second so far: a device that rests reports nothing.
  void count_reports(bool changed, Clock::time_point now) {
    reports_ += changed ? 1 : 0;
    if (now - counted_ < 1s) return;
    line_.reports_hz = std::max(line_.reports_hz.load(), static_cast<double>(reports_));
    reports_ = 0;
    counted_ = now;
  }

  Line& line_;
  std::vector<double> now_, before_, levels_;
  std::vector<std::vector<float>> in_, out_;
  std::vector<const float*> from_;
  std::vector<float*> to_;
  int reports_ = 0;
  Clock::time_point counted_ = Clock::now();
};

class SdlStream final : public CardStream<Line> {
 public:
  using CardStream::CardStream;
  ~SdlStream() override { static_cast<void>(stop()); }

  std::string take_note() override {
    if (const auto refused = line_->device->refused(); refused > 0 && !std::exchange(refusal_noted_, true))
      return granted().device + " took not every effect: it has no slot left, or no such effect";
    const auto reports = line_->reports_hz.load();
    if (reports < kLeastReports || reports < 1.5 * noted_reports_) return {};
    noted_reports_ = reports;
    return fmt::format("{} reports its position {:.0f} times a second", granted().device, reports);
  }

 private:
  static constexpr double kLeastReports = 20.0;

  bool lost() const override { return line_->lost; }
  Status start_library() override {
    line_->stops = false;
    thread_ = std::thread{[line = line_] { Pacer{*line}.run(); }};
    return {};
  }
  Status stop_library(bool) override {
    line_->stops = true;
    if (thread_.joinable()) thread_.join();
    return {};
  }

  std::thread thread_;
  bool refusal_noted_ = false;
  double noted_reports_ = 0.0;
};

/// Joysticks, wheels and gamepads through SDL 2. A device is "sdl:<its name>". Its inputs are axes, hats and
/// buttons (-1 to 1, 0 or 1) and the gyroscope (2,000 degrees a second are full scale), its outputs the
/// motors of a gamepad, the forces of a wheel or joystick, and the device's own effects, whose strength is
/// the output; periodic ones have further outputs (kWaveSettings). It is read and written every millisecond,
/// whatever the rate is; none is the default device.
class SdlBackend final : public Backend {
 public:
  std::string name() const override { return "sdl"; }
  Result<std::vector<Device>> devices() override { return list_devices(); }
  Result<std::unique_ptr<Stream>> open(const StreamRequest& request, GuardedBlocks& processor) override {
    const auto found = list_devices();
    if (!found) return tl::unexpected(found.error());
    auto wanted = request;
    wanted.block_frames.reset();  // the device's own
    const auto choice = choose(*found, wanted);
    if (!choice) return tl::unexpected(choice.error());
    if (choice->input.id != choice->output.id)
      return fail(Errc::BadArgument, "", "inputs and outputs are of two devices", "name one");
    auto granted = choice->granted;
    auto line = std::make_shared<Line>();
    line->frames = static_cast<int>(std::lround(granted.format.sample_rate.value / kPollRate_hz));
    if (line->frames * kPollRate_hz != std::lround(granted.format.sample_rate.value))
      return fail(Errc::BadArgument, "",
                  "the sample rate of '" + granted.device + "' must be a multiple of 1 kHz",
                  "omit the rate, for 8 kHz");
    SDL_JoystickUpdate();
    line->device = OpenDevice::open(choice->output.index);
    if (line->device == nullptr) return failed("'" + granted.device + "' cannot be opened");
    granted.block_frames = granted.format.max_frames = line->frames;
    granted.input_latency_frames = line->frames;
    granted.digital_inputs.assign(index(request.in_channels), true);
    if (auto status = processor.prepare(granted.format); !status) return tl::unexpected(status.error());
    return std::make_unique<SdlStream>(std::move(line), granted, request, processor);
  }
};

}  // namespace

std::unique_ptr<Backend> make_sdl_backend() { return std::make_unique<SdlBackend>(); }

}  // namespace tactus
