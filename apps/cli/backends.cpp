#include "apps/cli/backends.h"

#include <fmt/format.h>

#include <algorithm>

#include "backends/find_device.h"
#include "backends/loop/loop.h"
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

/// The simulated cards are there for whoever names them, and never found by chance.
constexpr Maker kSimulated{"loop", make<LoopBackend>};

/// Those that `name` means: all for sound cards if it is empty.
std::vector<Maker> makers_of(const std::string& name) {
  if (name == kSimulated.name) return {kSimulated};
  std::vector<Maker> meant;
  std::copy_if(makers().begin(), makers().end(), std::back_inserter(meant),
               [&](const Maker& maker) { return name.empty() || name == maker.name; });
  return meant;
}

/// "jack" of "jack:system", if there is such a backend.
std::string backend_of(const std::string& id) {
  const auto colon = id.find(':');
  const auto name = colon == std::string::npos ? "" : id.substr(0, colon);
  return makers_of(name).size() == 1 ? name : "";
}

/// What `maker` reaches, and, where it can, the device that `id` describes.
std::unique_ptr<Backend> made(const Maker& maker, const std::string& id) {
  if (maker.name != std::string{kSimulated.name}) return maker.make();
  auto simulated = std::make_unique<LoopBackend>();
  (void)simulated->add(id);
  return simulated;
}

}  // namespace

std::vector<std::string> card_backends() {
  std::vector<std::string> names;
  for (const auto& maker : makers()) names.emplace_back(maker.name);
  return names;
}

const char* no_card_backend() {
  return "this program was built without any library for sound cards: install JACK, RtAudio or PortAudio and "
         "build it again";
}

Result<std::unique_ptr<Backend>> make_card_backend(const std::string& name) {
  if (!name.empty())
    for (const auto& maker : makers_of(name)) return maker.make();
  return fail(
      Errc::UnknownName, "--backend", "this program has no backend '" + name + "'",
      makers().empty() ? no_card_backend() : fmt::format("it has {}", fmt::join(card_backends(), ", ")));
}

std::vector<BackendDevices> list_devices(const std::string& backend) {
  std::vector<BackendDevices> all;
  for (const auto& maker : makers_of(backend)) all.push_back({maker.name, maker.make()->devices()});
  return all;
}

Result<ChosenDevices> choose_devices(const std::string& backend, const std::string& output,
                                     const std::string& input) {
  if (!backend.empty())
    if (auto known = make_card_backend(backend); !known) return tl::unexpected(known.error());
  const auto& wanted = output.empty() ? input : output;
  const auto named = backend.empty() ? backend_of(wanted) : backend;
  std::vector<Device> others;
  std::string reasons;
  for (const auto& maker : makers_of(named)) {
    auto there = made(maker, wanted);
    const auto devices = there->devices();
    if (!devices || devices->empty()) {
      reasons += fmt::format("{}{}: {}", reasons.empty() ? "" : "; ", maker.name,
                             devices ? "it sees no device" : to_string(devices.error()));
      continue;
    }
    auto out = find_device(*devices, wanted);
    if (!out && out.error().code != Errc::UnknownName) return tl::unexpected(out.error());
    if (!out) {
      others.insert(others.end(), devices->begin(), devices->end());
      continue;
    }
    auto in = input.empty() ? out : find_device(*devices, input);
    if (!in) return tl::unexpected(in.error());
    return ChosenDevices{std::move(there), std::move(*out), std::move(*in)};
  }
  if (const auto missing = find_device(others, wanted); !others.empty() && !missing)
    return tl::unexpected(missing.error());
  return fail(Errc::Device, "",
              wanted.empty() ? "there is no sound device" : "there is no device '" + wanted + "'",
              makers().empty() ? no_card_backend() : reasons);
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
