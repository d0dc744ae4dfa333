// A mixer without a knob, for ALSA: RtAudio sees the device "default" only where a mixer of that name opens,
// and a machine without a sound card has none.

#include <alsa/asoundlib.h>
#include <alsa/control_external.h>

namespace {

void close_mixer(snd_ctl_ext_t* mixer) { delete mixer; }
int count(snd_ctl_ext_t*) { return 0; }
int list(snd_ctl_ext_t*, unsigned, snd_ctl_elem_id_t*) { return -EINVAL; }
snd_ctl_ext_key_t find(snd_ctl_ext_t*, const snd_ctl_elem_id_t*) { return SND_CTL_EXT_KEY_NOT_FOUND; }

const snd_ctl_ext_callback_t callbacks = [] {
  snd_ctl_ext_callback_t those{};
  those.close = close_mixer;
  those.elem_count = count;
  those.elem_list = list;
  those.find_elem = find;
  return those;
}();

}  // namespace

extern "C" {
SND_CTL_PLUGIN_DEFINE_FUNC(none) {
  (void)root;
  (void)conf;
  auto* mixer = new snd_ctl_ext_t{};
  mixer->version = SND_CTL_EXT_VERSION;
  mixer->poll_fd = -1;
  mixer->callback = &callbacks;
  const int wrong = snd_ctl_ext_create(mixer, name, mode);
  if (wrong == 0) *handlep = mixer->handle;
  return wrong;
}
SND_CTL_PLUGIN_SYMBOL(none);
}
