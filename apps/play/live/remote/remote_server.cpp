#include "apps/play/live/remote/remote_server.h"

#include <fmt/format.h>

#include "apps/cli/console.h"
#ifdef TACTUS_HAS_OSC
#include "remote/osc/osc_server.h"
#endif

namespace tactus::app {

#ifdef TACTUS_HAS_OSC
namespace {

class LiveOsc final : public RemoteServer {
 public:
  LiveOsc(const OscOptions& options, Session& session, Performer& performer, Hertz sample_rate)
      : target_(session, performer, sample_rate),
        server_(or_exit(OscServer::open(options, target_), kUsage)) {}
  LiveRemote& target() override { return target_; }
  std::string announcement() const override { return server_->announcement(); }
  std::string summary() const override {
    const auto counts = server_->counts();
    const auto delay = target_.delay();
    auto text = fmt::format("OSC       {} packets, {} refused, {} sent", counts.packets,
                            counts.refused_packets, counts.answers);
    if (target_.late() > 0) text += fmt::format(", {} bundles too late", target_.late());
    if (delay.changes > 0)
      text += fmt::format("; from packet to queue {:.2f} ms (longest {:.1f} ms)", delay.mean_ms,
                          delay.longest_ms);
    return text;
  }

 private:
  LiveRemote target_;
  std::unique_ptr<OscServer> server_;
};

}  // namespace
#endif

std::unique_ptr<RemoteServer> make_remote_server(const RemoteOptions& options, Session& session,
                                                 Performer& performer, Hertz sample_rate) {
  if (options.osc.empty()) {
    if (options.osc_arm)
      exit_with({Errc::BadArgument, "--osc-arm", "there is no remote control", "give --osc PORT too"});
    return nullptr;
  }
#ifdef TACTUS_HAS_OSC
  auto at = or_exit(parse_osc_address(options.osc), kUsage);
  at.arm_from_elsewhere = options.osc_arm;
  return std::make_unique<LiveOsc>(at, session, performer, sample_rate);
#else
  (void)session, (void)performer, (void)sample_rate;
  exit_with({Errc::Missing, "--osc", "this program was built without OSC",
             "install liboscpack-dev and libboost-dev, and build it again"});
#endif
}

}  // namespace tactus::app
