#include "backends/silence_library_logs.h"

#if defined(TACTUS_HAS_ALSA)
#include <alsa/asoundlib.h>
#endif
#if defined(TACTUS_HAS_JACK)
#include <jack/jack.h>
#endif

namespace tactus {
namespace {

#if defined(TACTUS_HAS_ALSA)
void ignore_alsa(const char*, int, const char*, int, const char*, ...) {}
#endif
#if defined(TACTUS_HAS_JACK)
void ignore_jack(const char*) {}
#endif

}  // namespace

void silence_library_logs() {
#if defined(TACTUS_HAS_ALSA)
  snd_lib_error_set_handler(ignore_alsa);
#endif
#if defined(TACTUS_HAS_JACK)
  jack_set_error_function(ignore_jack);
  jack_set_info_function(ignore_jack);
#endif
}

}  // namespace tactus
