#pragma once

#include <atomic>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "remote/remote.h"

namespace tactus::test {

/// A target that records the orders that it is given.
class FakeRemoteTarget : public RemoteTarget {
 public:
  FakeRemoteTarget() { describe({{"strength", ""}, {"hold", "ms"}, {"level", "dB"}, {"fixed", "Hz"}}); }

  struct Control {
    std::string name, unit;
  };
  /// Plain numbers and Hz run from 0 to 1 (SI), ms from 2 to 100, dB from -60 to 0.
  void describe(const std::vector<Control>& controls,
                const std::vector<std::string>& instrument_events = {}) {
    auto next =
        std::make_shared<RemoteDescription>(RemoteDescription{"fake",
                                                              std::vector<RemoteControl>(controls.size()),
                                                              {"strike"},
                                                              {"mic"},
                                                              {"woofer"},
                                                              {"ceiling", "soft start"}});
    for (std::size_t c = 0; c < controls.size(); ++c) {
      auto& control = next->controls[c];
      control.name = controls[c].name;
      control.number = 10 + static_cast<int>(c);
      control.unit_name = controls[c].unit;
      control.unit = *parse_unit(controls[c].unit);
      const bool time = control.unit_name == "ms", level = control.unit_name == "dB";
      control.low = time ? 0.002 : level ? 0.001 : 0.0;
      control.high = time ? 0.1 : 1.0;
      control.value = control.high;
      control.constant = control.name == "fixed";
    }
    next->events = instrument_events;
    next->world_delay_s = world_delay;
    next->worlds = worlds;
    if (!learnt.empty()) next->controls[0].osc = learnt;
    for (std::size_t c = 0; c < hid.size(); ++c) next->controls[c].hid = hid[c];
    description_ = std::move(next);
  }

  std::shared_ptr<const RemoteDescription> description() const override { return description_; }
  bool post(std::span<const RemoteOrder> bundle) override {
    if (!room) return false;
    bundles.emplace_back(bundle.begin(), bundle.end());
    return true;
  }
  void disarm() noexcept override {
    ++times_disarmed;
    is_armed = false;
  }
  void mute(bool on) noexcept override { is_muted = on; }
  bool armed() const noexcept override { return is_armed; }
  bool muted() const noexcept override { return is_muted; }
  int disarms() const noexcept override { return times_disarmed; }
  Result<int> order_arm() override {
    ++arms;
    if (!why_not_armed.empty()) return fail(Errc::BadArgument, "", why_not_armed, "");
    return kArming;
  }
  void keep_alive(int arming) noexcept override { alives += arming == kArming; }
  RemoteMeters take_meters() override { return {{0.5}, {0.25}, {7.0, 0.0}, 0.125}; }
  bool take_event(RemoteEvent& event) override {
    if (events.empty()) return false;
    event = events.front();
    events.pop_front();
    return true;
  }
  std::int64_t late() const noexcept override { return 3; }
  bool learn_address(const std::string& address) override {
    if (!learning) return false;
    learnt = address;
    return true;
  }

  static constexpr int kArming = 17;
  bool learn_hid(const RigHid& source) override {
    if (learning) learnt_hid = source;
    return learning;
  }

  std::vector<RigHid> hid;  ///< of the first controls that are described
  std::optional<RigHid> learnt_hid;
  bool room = true, learning = false;
  std::optional<double> world_delay;  ///< of what is described
  std::vector<RemoteWorld> worlds;    ///< likewise
  std::string learnt;                 ///< the OSC address of the first control that is described
  // Set by the thread of a server.
  std::atomic<bool> is_armed{false}, is_muted{false};
  std::atomic<int> times_disarmed{0}, arms{0}, alives{0};
  std::string why_not_armed;
  std::vector<std::vector<RemoteOrder>> bundles;
  std::deque<RemoteEvent> events;

 private:
  std::shared_ptr<const RemoteDescription> description_;
};

}  // namespace tactus::test
