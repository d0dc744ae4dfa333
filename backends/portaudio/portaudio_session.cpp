#include "backends/portaudio/portaudio_session.h"

#include <portaudio.h>

#include <algorithm>
#include <map>
#if __has_include(<pa_jack.h>)
#include <pa_jack.h>
#endif

#include "backends/library_calls.h"

namespace tactus {
namespace {

/// Of the whole program, and never destroyed: PortAudio may still be at work when it ends.
struct Program {
  std::weak_ptr<PortAudioSession> session;
  std::string over;         ///< why PortAudio may not be called any more; empty: it may
  std::string client_name;  ///< PortAudio keeps the pointer
};
Program& program() {
  static auto& one = *new Program;
  return one;
}

tl::unexpected<Error> over() { return fail(Errc::Device, "", program().over, "restart the program"); }

Status checked(PaError code) {
  if (code >= paNoError) return {};
  std::string message = Pa_GetErrorText(code);
  if (const auto* host = Pa_GetLastHostErrorInfo(); code == paUnanticipatedHostError && host->errorText)
    message += std::string{": "} + host->errorText;
  if (code == paInvalidSampleRate)
    return fail(Errc::BadArgument, "", "the device does not support this rate", "omit the rate");
  return fail(Errc::Device, "", "PortAudio: " + message, "see tactus doctor");
}

std::string name_of(const PaHostApiInfo& api) {
  static const std::map<PaHostApiTypeId, std::string> names{
      {paALSA, "alsa"}, {paASIO, "asio"}, {paCoreAudio, "core"}, {paDirectSound, "ds"}, {paJACK, "jack"},
      {paMME, "mme"},   {paOSS, "oss"},   {paWASAPI, "wasapi"},  {paWDMKS, "wdmks"}};
  const auto name = names.find(api.type);
  return name != names.end() ? name->second : api.name;
}

/// "HDA Intel: Analog (hw:0,0)" -> "HDA Intel: Analog": cards are numbered in the order in which they come.
std::string without_number(std::string name) { return name.substr(0, name.rfind(" (hw:")); }

LibraryDevice described(int index) {
  const auto& info = *Pa_GetDeviceInfo(index);
  const auto& api = *Pa_GetHostApiInfo(info.hostApi);
  LibraryDevice found{{}, name_of(api), info.name, index};
  auto& device = found.device;
  device.id = "portaudio:" + found.api + ":" + without_number(info.name);
  device.name = std::string{info.name} + " (" + api.name + ")";
  device.in_channels = info.maxInputChannels;
  device.out_channels = info.maxOutputChannels;
  device.default_rate = Hertz{info.defaultSampleRate};
  if (api.type == paJACK) device.sample_rates = {device.default_rate};
  return found;
}

/// PortAudio takes all clients whose names end like a JACK client's for that one, and would open their ports.
bool may_be_taken_for_another(const LibraryDevice& one, const std::vector<LibraryDevice>& all) {
  return one.api == "jack" && std::any_of(all.begin(), all.end(), [&](const LibraryDevice& other) {
           return other.api == "jack" && other.index != one.index && other.name.ends_with(one.name);
         });
}

int play_nothing(const void*, void*, unsigned long, const PaStreamCallbackTimeInfo*, PaStreamCallbackFlags,
                 void*) {
  return paContinue;
}

}  // namespace

bool portaudio_is_over() { return !program().over.empty(); }

void portaudio_lost_jack() {
  if (!portaudio_is_over())
    program().over = "the JACK server ended, and PortAudio's JACK client cannot reconnect";
}

Status in_portaudio(std::function<int()> call) {
  if (portaudio_is_over()) return over();
  if (const auto code = result_with_timeout(std::move(call))) return checked(*code);
  program().over = "PortAudio does not respond any more";
  return over();
}

Result<std::shared_ptr<PortAudioSession>> PortAudioSession::enter(const std::string& client_name) {
  if (portaudio_is_over()) return over();
  if (auto session = program().session.lock()) return session;
#if __has_include(<pa_jack.h>)
  program().client_name = client_name.substr(0, 32);
  PaJack_SetClientName(program().client_name.c_str());
#else
  static_cast<void>(client_name);
#endif
  if (auto status = in_portaudio([] { return Pa_Initialize(); }); !status)
    return tl::unexpected(status.error());
  std::shared_ptr<PortAudioSession> session{new PortAudioSession};
  program().session = session;
  return session;
}

PortAudioSession::PortAudioSession() {
  const auto jack = Pa_HostApiTypeIdToHostApiIndex(paJACK);
  if (jack < 0) return;
  has_jack_ = true;
  if (Pa_GetHostApiInfo(jack)->deviceCount > 0) jack_device_ = Pa_HostApiDeviceIndexToDeviceIndex(jack, 0);
}

PortAudioSession::~PortAudioSession() {
  if (occupied_ && !answers()) return;
  static_cast<void>(in_portaudio([] { return Pa_Terminate(); }));
}

std::vector<LibraryDevice> PortAudioSession::devices() const {
  std::vector<LibraryDevice> all, devices;
  for (int index = 0; index < Pa_GetDeviceCount(); ++index) all.push_back(described(index));
  number_same_ids(all);
  std::copy_if(all.begin(), all.end(), std::back_inserter(devices),
               [&](const LibraryDevice& one) { return !may_be_taken_for_another(one, all); });
  const auto output = Pa_GetDefaultOutputDevice();
  const auto wanted = output != paNoDevice ? output : Pa_GetDefaultInputDevice();
  for (auto& one : devices) one.device.is_default = one.index == wanted;
  return devices;
}

bool PortAudioSession::answers() {
  if (portaudio_is_over()) return false;
  if (jack_device_ < 0) return true;
  const bool there = in_portaudio([device = jack_device_] {
                       PaStreamParameters one{};
                       one.device = device;
                       one.channelCount = 1;
                       one.sampleFormat = paFloat32;
                       const bool in = Pa_GetDeviceInfo(device)->maxInputChannels > 0;
                       PaStream* stream = nullptr;
                       const auto code =
                           Pa_OpenStream(&stream, in ? &one : nullptr, in ? nullptr : &one,
                                         Pa_GetDeviceInfo(device)->defaultSampleRate,
                                         paFramesPerBufferUnspecified, paNoFlag, play_nothing, nullptr);
                       return code == paNoError ? Pa_CloseStream(stream) : code;
                     }).has_value();
  if (!there) portaudio_lost_jack();
  return there;
}

}  // namespace tactus
