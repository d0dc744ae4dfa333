#include "apps/backends.h"

#include <fmt/format.h>

#include <algorithm>

#include "backends/find_device.h"
#if defined(TACTUS_HAS_JACK)
#include "backends/jack/jack.h"
#endif
#if defined(TACTUS_HAS_RTAUDIO)
#include "backends/rtaudio/rtaudio.h"
#endif
#if defined(TACTUS_HAS_PORTAUDIO)
#include "backends/portaudio/portaudio.h"
#endif
#if defined(TACTUS_HAS_RTMIDI)
#include "backends/rtmidi/rtmidi.h"
#endif

namespace tactus::app {
namespace {

struct Maker {
  const char* name;
  std::unique_ptr<Backend> (*make)();
};

template <class Kind>
std::unique_ptr<Backend> make() {
  return std::make_unique<Kind>();
}

const std::vector<Maker>& makers() {
  static const std::vector<Maker> all = {
#if defined(TACTUS_HAS_JACK)
    {"jack", make<JackBackend>},
#endif
#if defined(TACTUS_HAS_RTAUDIO)
    {"rtaudio", make<RtAudioBackend>},
#endif
#if defined(TACTUS_HAS_PORTAUDIO)
    {"portaudio", make<PortAudioBackend>},
#endif
  };
  return all;
}

/// "jack" of "jack:system", if there is such a backend.
std::string backend_of(const std::string& id) {
  const auto name = id.substr(0, id.find(':'));
  const auto names = card_backends();
  return id.find(':') != std::string::npos && std::count(names.begin(), names.end(), name) > 0 ? name : "";
}

std::string reasons(const std::vector<BackendDevices>& asked) {
  std::string text;
  for (const auto& [backend, devices] : asked)
    text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", backend,
                        devices ? "it sees no device" : to_string(devices.error()));
  return text;
}

/// Several backends often reach the same card: the first of them that knows `text` counts.
Result<Device> find_one(const std::vector<BackendDevices>& asked, const std::string& text) {
  std::vector<Device> all;
  for (const auto& each : asked) {
    if (!each.devices || each.devices->empty()) continue;
    auto found = find_device(*each.devices, text);
    if (found || found.error().code != Errc::UnknownName) return found;
    all.insert(all.end(), each.devices->begin(), each.devices->end());
  }
  if (!all.empty()) return find_device(all, text);
  return fail(Errc::Device, "",
              text.empty() ? "there is no sound device" : "there is no device '" + text + "'",
              asked.empty() ? "this program was built without any library for sound cards" : reasons(asked));
}

}  // namespace

std::vector<std::string> card_backends() {
  std::vector<std::string> names;
  for (const auto& maker : makers()) names.emplace_back(maker.name);
  return names;
}

Result<std::unique_ptr<Backend>> make_card_backend(const std::string& name) {
  for (const auto& maker : makers())
    if (name == maker.name) return maker.make();
  return fail(Errc::UnknownName, "--backend", "this program has no backend '" + name + "'",
              makers().empty() ? "it was built without any library for sound cards: install JACK, RtAudio or "
                                 "PortAudio and build it again"
                               : fmt::format("it has {}", fmt::join(card_backends(), ", ")));
}

std::vector<BackendDevices> list_devices(const std::string& backend) {
  std::vector<BackendDevices> all;
  for (const auto& maker : makers())
    if (backend.empty() || backend == maker.name) all.push_back({maker.name, maker.make()->devices()});
  return all;
}

Result<ChosenDevices> choose_devices(const std::string& backend, const std::string& output,
                                     const std::string& input) {
  if (!backend.empty())
    if (auto made = make_card_backend(backend); !made) return tl::unexpected(made.error());
  const auto named = backend.empty() ? backend_of(output.empty() ? input : output) : backend;
  const auto asked = list_devices(named);
  auto out = find_one(asked, output.empty() ? input : output);
  if (!out) return tl::unexpected(out.error());
  auto in = input.empty() ? out : find_one(asked, input);
  if (!in) return tl::unexpected(in.error());
  if (backend_of(in->id) != backend_of(out->id))
    return fail(Errc::BadArgument, "--input-device",
                fmt::format("'{}' and '{}' belong to different backends", in->id, out->id),
                "choose two devices of one backend");
  auto made = make_card_backend(backend_of(out->id));
  if (!made) return tl::unexpected(made.error());
  return ChosenDevices{std::move(*made), std::move(*out), std::move(*in)};
}

std::unique_ptr<MidiInputs> make_midi_inputs([[maybe_unused]] const std::string& api) {
#if defined(TACTUS_HAS_RTMIDI)
  RtMidiSettings settings;
  settings.api = api;
  return make_rtmidi(settings);
#else
  return nullptr;
#endif
}

}  // namespace tactus::app
