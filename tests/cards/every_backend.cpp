#include "tests/backends/every_backend.h"

#include <unistd.h>

#include "tests/support/sound_server.h"
#ifdef TACTUS_HAS_jack
#include "backends/jack/jack.h"
#endif

namespace tactus::test {
namespace {

/// A backend that plays to the device "system" of a real JACK server.
template <class AnyBackend>
std::optional<Subject> on_jack_server() {
  std::shared_ptr<SoundServer> server = start_sound_server();
  if (!server) return std::nullopt;
  Subject subject;
  subject.stands_on.push_back(std::move(server));
  subject.backend = std::make_unique<AnyBackend>();
  subject.request.in_channels = 2;
  subject.request.out_channels = 1;
  subject.request.client_name = "tactus-" + std::to_string(::getpid());
  subject.live = true;
  return subject;
}

}  // namespace

std::vector<MakeSubject> every_backend() {
  return {
      offline_subject,
      simulated_subject,
#ifdef TACTUS_HAS_jack
      on_jack_server<JackBackend>,
#endif
  };
}

}  // namespace tactus::test
