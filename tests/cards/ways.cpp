#include "tests/cards/ways.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <stdexcept>

#include "backends/backend.h"
#include "tests/support/skip.h"

namespace tactus::test {
namespace {

namespace fs = std::filesystem;

#ifdef TACTUS_NO_MIXER
const std::string no_mixer = TACTUS_NO_MIXER,
                  jack_plugin = TACTUS_ALSA_PLUGINS "/libasound_module_pcm_jack.so";
#else
const std::string no_mixer, jack_plugin;
#endif

/// Nothing but a device that is the card, and the mixer that RtAudio wants to see.
std::string alsa_config(const std::string& client, int channels) {
  std::string playback, capture;
  for (int c = 0; c < channels; ++c) {
    playback += fmt::format("{} {}:playback_{} ", c, client, c + 1);
    capture += fmt::format("{} {}:capture_{} ", c, client, c + 1);
  }
  return fmt::format(
      "ctl_type.none {{ lib \"{}\" }}\nctl.default {{ type none }}\npcm_type.jack {{ lib \"{}\" }}\n"
      "pcm.default {{ type jack playback_ports {{ {}}} capture_ports {{ {}}} }}\n",
      no_mixer, jack_plugin, playback, capture);
}

}  // namespace

std::unique_ptr<Backend> backend_named(const std::string& name) {
  for (const auto& backend : sound_backends())
    if (backend.name == name) return backend.make();
  throw std::invalid_argument("this build has no backend " + name);
}

MeasureSettings short_measurement(const StreamRequest& request) {
  MeasureSettings settings;
  settings.request = request;
  settings.guard = {DriveGuard::Kind::Audio, {}};
  settings.openings = 1;
  settings.probes = 3;
  return settings;
}

bool has_backend(const std::string& name) {
  const auto& all = sound_backends();
  return std::any_of(all.begin(), all.end(), [&](const BackendType& one) { return one.name == name; });
}

bool has_alsa() {
  if (fs::exists(jack_plugin)) return true;
  test::skip_part("ALSA's JACK plugin is not installed (Debian: apt-get install libasound2-plugins)");
  return false;
}

std::vector<Way> every_way() {
  std::vector<Way> ways;
  for (const auto& backend : sound_backends()) {
    if (backend.name == "jack") continue;  // the others reach cards over JACK and ALSA
    ways.push_back({backend.name + ":jack", backend.make, false});
    if (has_alsa()) ways.push_back({backend.name + ":alsa", backend.make, true});
  }
  return ways;
}

std::unique_ptr<CardOnServer> start_card(const DelayClient::Settings& card,
                                         const SoundServer::Settings& server) {
  return std::make_unique<CardOnServer>(start_sound_server(server), card);
}

AlsaConfig::AlsaConfig(const std::string& text)
    : file_(fs::temp_directory_path() / fmt::format("tactus-alsa-{}.conf", ::getpid())) {
  std::ofstream{file_} << text;
  ::setenv("ALSA_CONFIG_PATH", file_.c_str(), 1);
}

AlsaConfig::~AlsaConfig() {
  ::unsetenv("ALSA_CONFIG_PATH");
  fs::remove(file_);
}

CardOnServer::CardOnServer(std::unique_ptr<SoundServer> begun, const DelayClient::Settings& settings)
    : server(std::move(begun)),
      card(std::make_unique<DelayClient>(settings)),
      settings_(settings),
      alsa_(alsa_config(card->name(), settings.channels)) {}

void CardOnServer::restart() {
  card.reset();
  server->restart();
  card = std::make_unique<DelayClient>(settings_);
}

StreamRequest CardOnServer::request(const Way& way, int inputs, int outputs) const {
  StreamRequest request;
  request.device = way.name + ":" + (way.alsa ? "default" : card->name());
  request.in_channels = inputs;
  request.out_channels = outputs;
  request.block_frames = server->settings().period;
  request.client_name = "tactus-" + std::to_string(::getpid());
  return request;
}

}  // namespace tactus::test
