#include "apps/play/live/remote/remote_server.h"

#include <fmt/format.h>

#include <optional>

#include "apps/cli/console.h"
#include "apps/cli/open_link.h"
#include "remote/shared_remote.h"
#ifdef TACTUS_HAS_OSC
#include "remote/osc/osc_server.h"
#endif
#ifdef TACTUS_HAS_HID
#include "remote/hid/hid_sensors.h"
#endif
#ifdef TACTUS_HAS_RTMIDI
#include "remote/midi/midi_sender.h"
#endif
#ifdef TACTUS_HAS_PANEL
#include "remote/panel/panel_server.h"
#endif
#ifdef TACTUS_HAS_SERIAL
#include "remote/serial/serial_sensors.h"
#endif

namespace tactus::app {
namespace {

/// One server, with its share of the target.
struct Service {
  virtual ~Service() = default;
  virtual std::string announcement() const = 0;
  virtual std::string summary() const = 0;
};

[[noreturn, maybe_unused]] void not_built_in(const char* option, const char* what, const char* packages) {
  exit_with({Errc::Missing, option, fmt::format("this program was built without {}", what),
             fmt::format("install {}, and build it again", packages)});
}

#ifdef TACTUS_HAS_OSC
class OscService final : public Service {
 public:
  OscService(const RemoteOptions& options, std::unique_ptr<RemoteTarget> share, const LiveRemote& target)
      : share_(std::move(share)), target_(target) {
    auto at = or_exit(parse_osc_address(options.osc), kUsage);
    at.arm_from_elsewhere = options.osc_arm;
    server_ = or_exit(OscServer::open(at, *share_), kUsage);
  }
  std::string announcement() const override { return server_->announcement(); }
  std::string summary() const override {
    const auto counts = server_->counts();
    const auto delay = target_.delay();
    auto text = fmt::format("OSC       {} packets, {} refused, {} sent", counts.packets,
                            counts.refused_packets, counts.answers);
    if (delay.changes > 0)
      text += fmt::format("; from packet to queue {:.2f} ms (longest {:.1f} ms)", delay.mean_ms,
                          delay.longest_ms);
    return text;
  }

 private:
  std::unique_ptr<RemoteTarget> share_;
  const LiveRemote& target_;
  std::unique_ptr<OscServer> server_;
};
#endif

#ifdef TACTUS_HAS_SERIAL
class SerialService final : public Service {
 public:
  SerialService(const std::string& device, std::unique_ptr<RemoteTarget> share)
      : options_(or_exit(parse_serial_device(device), kUsage)),
        share_(std::move(share)),
        sensors_(or_exit(SerialSensors::open(options_, *share_), kDevice)) {}
  std::string announcement() const override {
    return fmt::format("serial    {} at {} baud; values take effect {:g} ms after they come", options_.device,
                       options_.baud, 1e3 * SerialSensors::kDelay.value);
  }
  std::string summary() const override {
    const auto counts = sensors_->counts();
    auto text = fmt::format("serial    {}: {} lines, {} refused, {} values", options_.device, counts.lines,
                            counts.refused, counts.changes);
    if (counts.dropped > 0) text += fmt::format(", {} lines dropped", counts.dropped);
    return text;
  }

 private:
  SerialOptions options_;
  std::unique_ptr<RemoteTarget> share_;
  std::unique_ptr<SerialSensors> sensors_;
};
#endif

#ifdef TACTUS_HAS_HID
class HidService final : public Service {
 public:
  HidService(const std::string& device, std::unique_ptr<RemoteTarget> share)
      : share_(std::move(share)), sensors_(or_exit(HidSensors::open(device, *share_), kDevice)) {}
  std::string announcement() const override {
    return fmt::format("HID       joysticks, gamepads and pedals; values take effect {:g} ms after they come",
                       1e3 * HidSensors::kDelay.value);
  }
  std::string summary() const override { return fmt::format("HID       {} values", sensors_->changes()); }

 private:
  std::unique_ptr<RemoteTarget> share_;
  std::unique_ptr<HidSensors> sensors_;
};
#endif

#ifdef TACTUS_HAS_RTMIDI
class MidiService final : public Service {
 public:
  MidiService(const RemoteOptions& options, std::unique_ptr<RemoteTarget> share) : share_(std::move(share)) {
    auto messages = options.midi_messages;
    if (messages.empty()) messages = default_midi_out(share_->description()->events);
    if (messages.empty())
      exit_with({Errc::Missing, "--midi-out", "the instrument has no event that could be sent",
                 "name controls under [midi_out] in a rig"});
    for (const auto& message : messages)
      if (message.kind == RigMidiOut::Kind::Note)
        text_ += fmt::format("; {}: note {} in channel {}", message.name, message.number, message.channel);
      else if (message.kind == RigMidiOut::Kind::Controller)
        text_ +=
            fmt::format("; {}: controller {} in channel {}", message.name, message.number, message.channel);
      else
        text_ += fmt::format("; {}: clock", message.name);
    auto output = or_exit(open_midi_output(options.midi, *options.midi_out), kDevice);
    sender_ = or_exit(MidiSender::start(std::move(output), std::move(messages), *share_), kUsage);
  }
  std::string announcement() const override { return "MIDI out  " + sender_->output().name() + text_; }
  std::string summary() const override { return fmt::format("MIDI out  {} messages", sender_->sent()); }

 private:
  std::unique_ptr<RemoteTarget> share_;
  std::string text_;
  std::unique_ptr<MidiSender> sender_;
};
#endif

#ifdef TACTUS_HAS_PANEL
class PanelService final : public Service {
 public:
  PanelService(const RemoteOptions& options, std::unique_ptr<RemoteTarget> share) : share_(std::move(share)) {
    auto at = or_exit(parse_panel_address(*options.panel), kUsage);
    at.arm_from_elsewhere = options.panel_arm;
    server_ = or_exit(PanelServer::open(at, *share_), kUsage);
    if (!options.no_browser) opened_.emplace(server_->link());
  }
  std::string announcement() const override { return "panel     " + server_->link(); }
  std::string summary() const override {
    const auto counts = server_->counts();
    return fmt::format("panel     {} messages, {} refused, {} changes", counts.messages, counts.refused,
                       counts.orders);
  }

 private:
  std::unique_ptr<RemoteTarget> share_;
  std::unique_ptr<PanelServer> server_;
  std::optional<OpenedLink> opened_;
};
#endif

class LiveServer final : public RemoteServer {
 public:
#ifdef TACTUS_HAS_RTMIDI
  /// What only the rig asks for does not keep the instrument from playing.
  void add_midi(const RemoteOptions& options) {
    try {
      services_.push_back(std::make_unique<MidiService>(options, shared_.share()));
    } catch (const CommandError& error) {
      const bool device = !error.errors.empty() && error.errors.front().code == Errc::Device;
      if (!options.midi_by_rig || !device) throw;
      notes_.push_back("no MIDI messages are sent: " + error.errors.front().what);
    }
  }
#endif

  LiveServer(const RemoteOptions& options, Session& session, Performer& performer, Hertz sample_rate)
      : target_(session, performer, sample_rate, options.panel.has_value()), shared_(target_) {
    if (!options.osc.empty()) {
#ifdef TACTUS_HAS_OSC
      services_.push_back(std::make_unique<OscService>(options, shared_.share(), target_));
#else
      not_built_in("--osc", "OSC", "liboscpack-dev and libboost-dev");
#endif
    }
#ifdef TACTUS_HAS_SERIAL
    for (const auto& device : options.serial)
      services_.push_back(std::make_unique<SerialService>(device, shared_.share()));
#else
    if (!options.serial.empty()) not_built_in("--serial", "serial ports", "libboost-dev");
#endif
    if (options.hid) {
#ifdef TACTUS_HAS_HID
      services_.push_back(std::make_unique<HidService>(*options.hid, shared_.share()));
#else
      not_built_in("--hid", "joysticks and gamepads", "libsdl2-dev");
#endif
    }
    if (options.midi_out) {
#ifdef TACTUS_HAS_RTMIDI
      add_midi(options);
#else
      not_built_in("--midi-out", "MIDI", "librtmidi-dev");
#endif
    }
    if (options.panel) {
#ifdef TACTUS_HAS_PANEL
      services_.push_back(std::make_unique<PanelService>(options, shared_.share()));
#else
      not_built_in("--panel", "the panel", "libboost-dev");
#endif
    }
  }
  LiveRemote& target() override { return target_; }
  std::vector<std::string> announcements() const override {
    std::vector<std::string> lines;
    for (const auto& service : services_) lines.push_back(service->announcement());
    lines.insert(lines.end(), notes_.begin(), notes_.end());
    return lines;
  }
  std::vector<std::string> summaries() const override {
    std::vector<std::string> lines;
    for (const auto& service : services_) lines.push_back(service->summary());
    if (target_.late() > 0)
      lines.push_back(
          fmt::format("remote    {} changes came after the time of their time tag", target_.late()));
    return lines;
  }

 private:
  LiveRemote target_;
  SharedRemote shared_;
  std::vector<std::unique_ptr<Service>> services_;
  std::vector<std::string> notes_;
};

}  // namespace

std::unique_ptr<RemoteServer> make_remote_server(const RemoteOptions& options, Session& session,
                                                 Performer& performer, Hertz sample_rate) {
  const auto needs = [](bool missing, const char* option, const char* remedy) {
    if (missing) exit_with({Errc::BadArgument, option, "there is no such remote control", remedy});
  };
  needs(options.osc_arm && options.osc.empty(), "--osc-arm", "give --osc PORT too");
  needs(options.panel_arm && !options.panel, "--panel-arm", "give --panel too");
  if (!options.any()) return nullptr;
  return std::make_unique<LiveServer>(options, session, performer, sample_rate);
}

}  // namespace tactus::app
