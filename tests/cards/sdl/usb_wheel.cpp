#include "tests/cards/sdl/usb_wheel.h"

#include <fmt/format.h>

#include <algorithm>

namespace tactus::test {
namespace {

constexpr int kBytesOfEffect = 32;  // in the wheel's memory

/// Usage pages, and usages beyond those of the class.
constexpr int kDesktopPage = 0x01, kButtonPage = 0x09, kOrdinalPage = 0x0a, kPidPage = 0x0f;
constexpr int kJoystick = 0x04, kX = 0x30, kY = 0x31;
constexpr int kButtons = 8;

enum class Unit { None, Milliseconds, Centidegrees };

/// A field of a report. One with choices has the number of one of them, from 1, and is a logical collection.
struct Field {
  int usage;
  int bytes;
  int least, most;
  Unit unit = Unit::None;
  std::vector<int> choices{};
};

enum class Kind : std::uint8_t { Input = 0x80, Output = 0x90, Feature = 0xb0 };

struct Report {
  int usage;
  int identifier;
  Kind kind;
  std::vector<Field> fields;
};

constexpr int kInputIdentifier = 1, kBlockLoadIdentifier = 0x22, kPoolIdentifier = 0x23;
constexpr int kFull = UsbWheel::kFullScale;
constexpr int kLongest = 32767;  // [ms]
constexpr int kTurn = 35'999;    // [0.01 degrees]

Field choice(int usage, std::vector<int> choices) {
  return {usage, 1, 1, static_cast<int>(choices.size()), Unit::None, std::move(choices)};
}
Field duration(int usage) { return {usage, 2, 0, kLongest, Unit::Milliseconds}; }

/// All reports of the class that the wheel has: usage, identifier, kind and fields, these with usage, bytes
/// and logical range. Output reports come through the interrupt endpoint, feature reports through the control
/// pipe.
std::vector<Report> pid_reports(int slots) {
  const Field block{kBlockIndex, 1, 1, slots};
  const auto type =
      choice(kEffectType, {kEtConstant, kEtSine, kEtSpring, kEtDamper, kEtInertia, kEtFriction});
  return {
      {kSetEffectReport,
       0x11,
       Kind::Output,
       {block,
        type,
        duration(kDuration),
        duration(kTriggerRepeatInterval),
        duration(kStartDelay),
        {kGain, 1, 0, UsbWheel::kFullGain},
        {kTriggerButton, 1, 0, kButtons},
        {kDirectionEnable, 1, 0, 1},
        {kDirection, 2, 0, kTurn, Unit::Centidegrees}}},
      {kSetEnvelopeReport,
       0x12,
       Kind::Output,
       {block,
        {kAttackLevel, 2, 0, kFull},
        {kFadeLevel, 2, 0, kFull},
        duration(kAttackTime),
        duration(kFadeTime)}},
      {kSetConditionReport,
       0x13,
       Kind::Output,
       {block,
        {kParameterBlockOffset, 1, 0, 1},
        {kCenterOffset, 2, -kFull, kFull},
        {kPositiveCoefficient, 2, -kFull, kFull},
        {kNegativeCoefficient, 2, -kFull, kFull},
        {kPositiveSaturation, 2, 0, kFull},
        {kNegativeSaturation, 2, 0, kFull},
        {kDeadBand, 2, 0, kFull}}},
      {kSetPeriodicReport,
       0x14,
       Kind::Output,
       {block,
        {kMagnitude, 2, 0, kFull},
        {kOffset, 2, -kFull, kFull},
        {kPhase, 2, 0, kTurn, Unit::Centidegrees},
        duration(kPeriod)}},
      {kSetConstantForceReport, 0x15, Kind::Output, {block, {kMagnitude, 2, -kFull, kFull}}},
      {kEffectOperationReport,
       0x16,
       Kind::Output,
       {block, choice(kEffectOperation, {kStart, kStartSolo, kStop}), {kLoopCount, 1, 0, 255}}},
      {kBlockFreeReport, 0x17, Kind::Output, {block}},
      {kDeviceControlReport,
       0x18,
       Kind::Output,
       {choice(kDeviceControl,
               {kEnableActuators, kDisableActuators, kStopAllEffects, kReset, kPause, kContinue})}},
      {kDeviceGainReport, 0x19, Kind::Output, {{kDeviceGain, 1, 0, UsbWheel::kFullGain}}},
      {kCreateNewEffectReport, 0x21, Kind::Feature, {type}},
      {kBlockLoadReport,
       kBlockLoadIdentifier,
       Kind::Feature,
       {block,
        choice(kBlockLoadStatus, {kLoadSuccess, kLoadFull, kLoadError}),
        {kRamPoolAvailable, 2, 0, 32767}}},
      {kPoolReport,
       kPoolIdentifier,
       Kind::Feature,
       {{kRamPoolSize, 2, 0, 32767}, {kSimultaneousEffects, 1, 0, 255}, {kManagedPool, 1, 0, 1}}},
  };
}

/// Builds a report descriptor: Device Class Definition for Human Interface Devices 1.11, section 6.2.2.
/// Every item has four bytes of data, so that a usage contains its page.
class ReportDescriptor {
 public:
  enum Item : std::uint8_t {
    kCollection = 0xa0,
    kEnd = 0xc0,
    kLogicalMinimum = 0x14,
    kLogicalMaximum = 0x24,
    kUnitExponent = 0x54,
    kUnit = 0x64,
    kReportSize = 0x74,
    kReportIdentifier = 0x84,
    kReportCount = 0x94,
    kUsage = 0x08
  };
  enum Collection { kApplication = 1, kLogical = 2 };
  static constexpr int kArray = 0, kVariable = 2;  ///< of an input, output or feature item

  Bytes bytes;

  void item(int tag, int value) {
    bytes.push_back(static_cast<std::uint8_t>(tag | 3));
    for (int shift = 0; shift < 32; shift += 8)
      bytes.push_back(static_cast<std::uint8_t>(static_cast<std::uint32_t>(value) >> shift));
  }
  void usage(int page, int number) { item(kUsage, page << 16 | number); }
  void begin(Collection kind, int page, int number) {
    usage(page, number);
    item(kCollection, kind);
  }
  void end() { bytes.push_back(kEnd); }
  void shape(int bits, int count, int least, int most) {
    item(kReportSize, bits);
    item(kReportCount, count);
    item(kLogicalMinimum, least);
    item(kLogicalMaximum, most);
  }
  void unit(Unit unit) {
    // SI seconds (0x1001) times 10^-3; degrees (0x14) times 10^-2. An exponent has four bits.
    item(kUnit, unit == Unit::Milliseconds ? 0x1001 : unit == Unit::Centidegrees ? 0x14 : 0);
    item(kUnitExponent, unit == Unit::Milliseconds ? 0xd : unit == Unit::Centidegrees ? 0xe : 0);
  }
  void field(const Field& field, Kind kind) {
    const bool direction = field.usage == kDirection;  // a collection of directions, here of one
    const bool collects = direction || !field.choices.empty();
    if (collects) begin(kLogical, kPidPage, field.usage);
    if (direction)
      usage(kOrdinalPage, 1);
    else if (field.choices.empty())
      usage(kPidPage, field.usage);
    for (const int choice : field.choices) usage(kPidPage, choice);
    shape(8 * field.bytes, 1, field.least, field.most);
    unit(field.unit);
    item(static_cast<int>(kind), field.choices.empty() ? kVariable : kArray);
    if (collects) end();
  }
  void report(const Report& report) {
    begin(kLogical, kPidPage, report.usage);
    item(kReportIdentifier, report.identifier);
    for (const auto& each : report.fields) field(each, report.kind);
    end();
  }
};

Bytes report_descriptor(int slots) {
  ReportDescriptor descriptor;
  descriptor.begin(ReportDescriptor::kApplication, kDesktopPage, kJoystick);
  descriptor.item(ReportDescriptor::kReportIdentifier, kInputIdentifier);
  for (const int axis : {kX, kY}) descriptor.usage(kDesktopPage, axis);
  descriptor.shape(16, 2, -UsbWheel::kSteeringScale, UsbWheel::kSteeringScale);
  descriptor.item(static_cast<int>(Kind::Input), ReportDescriptor::kVariable);
  for (int button = 1; button <= kButtons; ++button) descriptor.usage(kButtonPage, button);
  descriptor.shape(1, kButtons, 0, 1);
  descriptor.item(static_cast<int>(Kind::Input), ReportDescriptor::kVariable);
  for (const auto& report : pid_reports(slots)) descriptor.report(report);
  descriptor.end();
  return descriptor.bytes;
}

void append_number(Bytes& bytes, int value, int count) {
  for (int at = 0; at < count; ++at)
    bytes.push_back(static_cast<std::uint8_t>(static_cast<unsigned>(value) >> (8 * at)));
}

/// The number at the begin of `bytes`; a field whose least value is negative has a sign.
int number(const std::uint8_t* bytes, const Field& field) {
  int value = bytes[0];
  if (field.bytes == 2) value |= bytes[1] << 8;
  return field.bytes == 2 && field.least < 0 ? static_cast<std::int16_t>(value) : value;
}

int bytes_of(const Report& report) {
  int bytes = 1;  // the identifier
  for (const auto& field : report.fields) bytes += field.bytes;
  return bytes;
}

}  // namespace

UsbWheel::UsbWheel(int slots, int memory)
    : slots_(slots),
      memory_(memory),
      gadget_("Tactus", "PID Wheel",
              {report_descriptor(slots), [this](const Bytes& bytes) { take(bytes); },
               [this](std::uint8_t identifier) { return give(identifier); }}) {}

void UsbWheel::plug() {
  {
    const std::lock_guard lock{mutex_};
    clear();
  }
  gadget_.plug();
}
void UsbWheel::unplug() { gadget_.unplug(); }

void UsbWheel::steer(int position) const {
  Bytes report{kInputIdentifier};
  append_number(report, position, 2);
  append_number(report, 0, 2);  // the pedal
  append_number(report, 0, 1);  // the buttons
  gadget_.send(report);
}

std::vector<UsbWheel::Effect> UsbWheel::effects() const {
  const std::lock_guard lock{mutex_};
  std::vector<Effect> all;
  for (const auto& [block, effect] : effects_) all.push_back(effect);
  return all;
}
std::optional<UsbWheel::Effect> UsbWheel::playing(int type) const {
  for (const auto& effect : effects())
    if (effect.type == type && effect.plays) return effect;
  return std::nullopt;
}
int UsbWheel::gain() const {
  const std::lock_guard lock{mutex_};
  return gain_;
}
std::string UsbWheel::errors() const {
  const std::lock_guard lock{mutex_};
  return errors_;
}

void UsbWheel::take(const Bytes& bytes) {
  const std::lock_guard lock{mutex_};
  const auto all = pid_reports(slots_);
  const auto report = std::ranges::find(all, bytes.empty() ? 0 : bytes[0], &Report::identifier);
  if (report == all.end() || std::ssize(bytes) < bytes_of(*report))
    return error("a report that is not in the descriptor, or too short");
  Fields fields;
  const auto* at = bytes.data() + 1;
  for (const auto& field : report->fields) {
    const int value = number(at, field);
    at += field.bytes;
    if (value < field.least || value > field.most)
      return error(fmt::format("report {:#x}: field {:#x} is {}", report->usage, field.usage, value));
    fields[field.usage] = field.choices.empty() ? value : field.choices[static_cast<std::size_t>(value - 1)];
  }
  apply(report->usage, fields);
}

void UsbWheel::apply(int report, const Fields& fields) {
  if (report == kDeviceControlReport) return control(fields.at(kDeviceControl));
  if (report == kDeviceGainReport) return void(gain_ = fields.at(kDeviceGain));
  if (report == kCreateNewEffectReport) return create(fields.at(kEffectType));
  const auto found = effects_.find(fields.contains(kBlockIndex) ? fields.at(kBlockIndex) : 0);
  if (found == effects_.end())
    return error(fmt::format("report {:#x} for an effect that is not in memory", report));
  auto& effect = found->second;
  if (report == kBlockFreeReport) return void(effects_.erase(found));
  if (report == kEffectOperationReport) {
    effect.plays = fields.at(kEffectOperation) != kStop;
    ++(effect.plays ? effect.starts : effect.stops);
    return;
  }
  if (report == kSetEffectReport && fields.at(kEffectType) != effect.type)
    error(fmt::format("effect of type {:#x} set as type {:#x}", effect.type, fields.at(kEffectType)));
  if (report == kSetConditionReport && fields.at(kParameterBlockOffset) != 0) return;
  if (report != kSetEffectReport && report != kSetEnvelopeReport) ++effect.changes;
  for (const auto& [usage, value] : fields) effect.fields[usage] = value;
}

void UsbWheel::create(int type) {
  loaded_ = 0;
  if (std::ssize(effects_) >= memory_) return;
  for (loaded_ = 1; effects_.contains(loaded_);) ++loaded_;
  effects_[loaded_].type = type;
}

void UsbWheel::control(int command) {
  if (command == kReset) clear();
  if (command == kStopAllEffects)
    for (auto& [block, effect] : effects_) effect.plays = false;
}

void UsbWheel::clear() {
  effects_.clear();
  loaded_ = 0;
}

Bytes UsbWheel::give(int identifier) const {
  const std::lock_guard lock{mutex_};
  const int free_bytes = kBytesOfEffect * (memory_ - static_cast<int>(effects_.size()));
  Bytes report{static_cast<std::uint8_t>(identifier)};
  if (identifier == kBlockLoadIdentifier) {
    append_number(report, loaded_, 1);
    append_number(report, loaded_ > 0 ? 1 : 2, 1);  // success, or full
    append_number(report, free_bytes, 2);
  } else if (identifier == kPoolIdentifier) {
    append_number(report, kBytesOfEffect * memory_, 2);
    append_number(report, memory_, 1);
    append_number(report, 1, 1);  // the wheel manages its memory itself
  } else {
    return {};
  }
  return report;
}

}  // namespace tactus::test
