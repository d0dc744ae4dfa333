#include "apps/cli/backends.h"

#include <fmt/format.h>

#include <algorithm>

#include "backends/find_device.h"
#include "backends/loop/loop.h"
#include "backends/sound_backends.h"
#if defined(TACTUS_HAS_RTMIDI)
#include "backends/rtmidi/rtmidi.h"
#endif

namespace tactus::app {
namespace {

/// The simulated cards: only used when they are named.
const SoundBackend& simulated() {
  static const SoundBackend loop{"loop", [] { return std::unique_ptr<Backend>{new LoopBackend}; }};
  return loop;
}

/// The backend called `name`; all for sound cards if it is empty.
std::vector<SoundBackend> backends_called(const std::string& name) {
  if (name == simulated().name) return {simulated()};
  std::vector<SoundBackend> found;
  std::copy_if(sound_backends().begin(), sound_backends().end(), std::back_inserter(found),
               [&](const SoundBackend& backend) { return name.empty() || name == backend.name; });
  return found;
}

/// "jack" of "jack:system", if there is such a backend.
std::string backend_of(const std::string& id) {
  const auto colon = id.find(':');
  const auto name = colon == std::string::npos ? "" : id.substr(0, colon);
  return backends_called(name).size() == 1 ? name : "";
}

/// A simulated card is made from its description in `id`.
std::unique_ptr<Backend> make_backend(const SoundBackend& backend, const std::string& id) {
  if (backend.name != simulated().name) return backend.make();
  auto loop = std::make_unique<LoopBackend>();
  (void)loop->add(id);
  return loop;
}

}  // namespace

std::vector<std::string> card_backends() {
  std::vector<std::string> names;
  for (const auto& backend : sound_backends()) names.push_back(backend.name);
  return names;
}

const char* no_card_backend() {
  return "this program was built without any library for sound cards: install JACK, RtAudio or PortAudio and "
         "build again";
}

Result<std::unique_ptr<Backend>> make_card_backend(const std::string& name) {
  if (!name.empty())
    for (const auto& backend : backends_called(name)) return backend.make();
  return fail(Errc::UnknownName, "--backend", "this program has no backend '" + name + "'",
              sound_backends().empty() ? no_card_backend()
                                       : fmt::format("it has {}", fmt::join(card_backends(), ", ")));
}

std::vector<BackendDevices> list_devices(const std::string& backend) {
  std::vector<BackendDevices> all;
  for (const auto& called : backends_called(backend)) all.push_back({called.name, called.make()->devices()});
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
  for (const auto& called : backends_called(named)) {
    auto made = make_backend(called, wanted);
    const auto devices = made->devices();
    if (!devices || devices->empty()) {
      reasons += fmt::format("{}{}: {}", reasons.empty() ? "" : "; ", called.name,
                             devices ? "no device" : to_string(devices.error()));
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
    return ChosenDevices{std::move(made), std::move(*out), std::move(*in)};
  }
  if (const auto missing = find_device(others, wanted); !others.empty() && !missing)
    return tl::unexpected(missing.error());
  return fail(Errc::Device, "", wanted.empty() ? "no sound device" : "there is no device '" + wanted + "'",
              sound_backends().empty() ? no_card_backend() : reasons);
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
