#include "tests/backends/every_backend.h"

#include <unistd.h>

#include "backends/backend.h"
#include "tests/cards/ways.h"
#include "tests/support/sound_server.h"

namespace tactus::test {
namespace {

Subject live_subject(std::unique_ptr<Backend> backend, std::shared_ptr<void> stands_on) {
  Subject subject;
  subject.stands_on.push_back(std::move(stands_on));
  subject.backend = std::move(backend);
  subject.request.in_channels = 2;
  subject.request.out_channels = 1;
  subject.request.client_name = "tactus-" + std::to_string(::getpid());
  return subject;
}

/// Plays to the device "system" of a real JACK server.
std::optional<Subject> on_jack_server(const BackendType& backend) {
  std::shared_ptr<SoundServer> server = start_sound_server();
  auto subject = live_subject(backend.make(), std::move(server));
  // No other device; without any name PortAudio would abort.
  subject.stands_on.push_back(std::make_shared<AlsaConfig>("pcm.absent { type hw card 9 }\n"));
  return subject;
}

/// Plays to ALSA's default device.
std::optional<Subject> on_alsa(const Way& way) {
  if (!has_alsa()) return std::nullopt;
  std::shared_ptr<CardOnServer> rig = start_card();
  const auto device = rig->request(way, 2, 1).device;
  auto subject = live_subject(way.backend(), std::move(rig));
  if (subject.backend->devices()->front().id != device) subject.request.device = device;
  return subject;
}

}  // namespace

std::vector<MakeSubject> every_backend() {
  std::vector<MakeSubject> all = {loop_subject};
  for (const auto& backend : sound_backends())
    all.emplace_back([&backend] { return on_jack_server(backend); });
  for (const auto& way : every_way())
    if (way.alsa) all.emplace_back([way] { return on_alsa(way); });
  return all;
}

}  // namespace tactus::test
