#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "tests/cards/sdl/hid_gadget.h"

namespace tactus::test {

/// Usages of a force-feedback device: Device Class Definition for Physical Interface Devices (PID) 1.0,
/// USB Implementers' Forum 1999.
enum Pid : int {
  kSetEffectReport = 0x21,
  kBlockIndex = 0x22,
  kParameterBlockOffset = 0x23,
  kEffectType = 0x25,
  kEtConstant = 0x26,
  kEtSine = 0x31,
  kEtSpring = 0x40,
  kEtDamper = 0x41,
  kEtInertia = 0x42,
  kEtFriction = 0x43,
  kDuration = 0x50,
  kGain = 0x52,
  kTriggerButton = 0x53,
  kTriggerRepeatInterval = 0x54,
  kDirectionEnable = 0x56,
  kDirection = 0x57,
  kSetEnvelopeReport = 0x5a,
  kAttackLevel = 0x5b,
  kAttackTime = 0x5c,
  kFadeLevel = 0x5d,
  kFadeTime = 0x5e,
  kSetConditionReport = 0x5f,
  kCenterOffset = 0x60,
  kPositiveCoefficient = 0x61,
  kNegativeCoefficient = 0x62,
  kPositiveSaturation = 0x63,
  kNegativeSaturation = 0x64,
  kDeadBand = 0x65,
  kSetPeriodicReport = 0x6e,
  kOffset = 0x6f,
  kMagnitude = 0x70,
  kPhase = 0x71,
  kPeriod = 0x72,
  kSetConstantForceReport = 0x73,
  kEffectOperationReport = 0x77,
  kEffectOperation = 0x78,
  kStart = 0x79,
  kStartSolo = 0x7a,
  kStop = 0x7b,
  kLoopCount = 0x7c,
  kDeviceGainReport = 0x7d,
  kDeviceGain = 0x7e,
  kPoolReport = 0x7f,
  kRamPoolSize = 0x80,
  kSimultaneousEffects = 0x83,
  kBlockLoadReport = 0x89,
  kBlockLoadStatus = 0x8b,
  kLoadSuccess = 0x8c,
  kLoadFull = 0x8d,
  kLoadError = 0x8e,
  kBlockFreeReport = 0x90,
  kDeviceControlReport = 0x95,
  kDeviceControl = 0x96,
  kEnableActuators = 0x97,
  kDisableActuators = 0x98,
  kStopAllEffects = 0x99,
  kReset = 0x9a,
  kPause = 0x9b,
  kContinue = 0x9c,
  kStartDelay = 0xa7,
  kManagedPool = 0xa9,
  kCreateNewEffectReport = 0xab,
  kRamPoolAvailable = 0xac,
};

/// A wheel of the USB PID class: steering and a pedal, eight buttons, and six types of effects, which the
/// kernel's usbhid drives (hid-pidff). It does what a wheel's firmware does with reports, but for the force.
class UsbWheel {
 public:
  static constexpr const char* kName = "Tactus PID Wheel";
  static constexpr int kFullScale = 10'000;  ///< of magnitudes, coefficients and saturations
  static constexpr int kFullGain = 255;
  static constexpr int kSteeringScale = 32767;

  /// An effect in the wheel.
  struct Effect {
    int type = 0;               ///< kEt…
    std::map<int, int> fields;  ///< of the reports so far; of a condition those of the first axis
    bool plays = false;
    int starts = 0, stops = 0;
    int changes = 0;  ///< of its force or condition
  };

  /// The host may address `slots` effects; the memory of the wheel is full with `memory` of them. Skips as
  /// HidGadget.
  UsbWheel(int slots, int memory);
  explicit UsbWheel(int slots) : UsbWheel(slots, slots) {}

  /// The memory of a wheel that is plugged in is empty.
  void plug();
  void unplug();
  /// As HidGadget::send.
  void steer(int position) const;

  std::vector<Effect> effects() const;
  /// That of a type which plays.
  std::optional<Effect> playing(int type) const;
  int gain() const;  ///< of the device
  /// Reports that contradict the descriptor or the state of the wheel, a line each.
  std::string errors() const;

 private:
  using Fields = std::map<int, int>;

  void take(const Bytes& bytes);
  Bytes give(int identifier) const;
  void apply(int report, const Fields& fields);
  void error(const std::string& text) { errors_ += text + "\n"; }
  void create(int type);
  void control(int command);
  void clear();

  int slots_, memory_;
  mutable std::mutex mutex_;
  std::map<int, Effect> effects_;  ///< by block index
  int loaded_ = 0;                 ///< block index of the effect created last; 0: the memory was full
  int gain_ = 0;
  std::string errors_;
  HidGadget gadget_;  ///< last: its threads call the wheel
};

}  // namespace tactus::test
