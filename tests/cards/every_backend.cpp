#include "tests/backends/every_backend.h"

#include <unistd.h>

#include "tests/cards/ways.h"
#include "tests/support/sound_server.h"
#ifdef TACTUS_HAS_jack
#include "backends/jack/jack.h"
#endif
#ifdef TACTUS_HAS_rtaudio
#include "backends/rtaudio/rtaudio.h"
#endif
#ifdef TACTUS_HAS_portaudio
#include "backends/portaudio/portaudio.h"
#endif

namespace tactus::test {
namespace {

Subject live_subject(std::unique_ptr<Backend> backend, std::shared_ptr<void> stands_on) {
  Subject subject;
  subject.stands_on.push_back(std::move(stands_on));
  subject.backend = std::move(backend);
  subject.request.in_channels = 2;
  subject.request.out_channels = 1;
  subject.request.client_name = "tactus-" + std::to_string(::getpid());
  subject.live = true;
  return subject;
}

/// A backend that plays to the device "system" of a real JACK server.
template <class AnyBackend>
std::optional<Subject> on_jack_server() {
  std::shared_ptr<SoundServer> server = start_sound_server();
  auto subject = live_subject(std::make_unique<AnyBackend>(), std::move(server));
  // No other device; without any name PortAudio would abort.
  subject.stands_on.push_back(std::make_shared<AlsaConfig>("pcm.absent { type hw card 9 }\n"));
  return subject;
}

/// One that plays to ALSA's default device before any other.
template <class AnyBackend>
std::optional<Subject> on_alsa() {
  if (!has_alsa()) return std::nullopt;
  std::shared_ptr<CardOnServer> rig = start_card();
  return live_subject(std::make_unique<AnyBackend>(), std::move(rig));
}

}  // namespace

std::vector<MakeSubject> every_backend() {
  return {
      offline_subject,
      simulated_subject,
      loop_subject,
#ifdef TACTUS_HAS_jack
      on_jack_server<JackBackend>,
#endif
#ifdef TACTUS_HAS_rtaudio
      on_jack_server<RtAudioBackend>,
#endif
#ifdef TACTUS_HAS_portaudio
      on_jack_server<PortAudioBackend>,
      on_alsa<PortAudioBackend>,
#endif
  };
}

}  // namespace tactus::test
