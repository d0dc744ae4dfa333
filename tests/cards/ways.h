#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "backends/backend.h"
#include "latency/measurement.h"
#include "tests/support/sound_server.h"

namespace tactus::test {

/// A library, and the API of it over which a card is reached.
struct Way {
  std::string name;  ///< "rtaudio:jack"
  std::unique_ptr<Backend> (*backend)();
  bool alsa = false;
};
/// Whether this build has a library.
bool has_backend(const std::string& name);
/// A library of this build.
std::unique_ptr<Backend> backend_named(const std::string& name);

/// One opening and three probes, on an output that is guarded as sound.
MeasureSettings short_measurement(const StreamRequest& request);
/// Whether ALSA's JACK plugin is installed; if not, a part of the test case is skipped.
bool has_alsa();
/// Every library but JACK itself, over JACK and over ALSA.
std::vector<Way> every_way();

/// All that ALSA knows, while this is there.
class AlsaConfig {
 public:
  explicit AlsaConfig(const std::string& text);
  ~AlsaConfig();

 private:
  std::filesystem::path file_;
};

/// A real server, a card of known delay on it, and the same card as ALSA's default device.
class CardOnServer {
 public:
  CardOnServer(std::unique_ptr<SoundServer> begun, const DelayClient::Settings& settings);

  /// After the server was killed: both begin again, under their names.
  void restart();
  /// For the card.
  StreamRequest request(const Way& way, int inputs, int outputs) const;

  std::unique_ptr<SoundServer> server;
  std::unique_ptr<DelayClient> card;

 private:
  DelayClient::Settings settings_;
  AlsaConfig alsa_;
};

/// Skips the test case where no JACK server can run.
std::unique_ptr<CardOnServer> start_card(const DelayClient::Settings& card = {},
                                         const SoundServer::Settings& server = {});

}  // namespace tactus::test
