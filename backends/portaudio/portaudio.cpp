#include <portaudio.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <map>
#include <utility>

#if __has_include(<pa_jack.h>)
#include <pa_jack.h>
#endif
#if __has_include(<pa_linux_alsa.h>)
#include <pa_linux_alsa.h>
#endif

#include "backends/alsa_devices.h"
#include "backends/card_callback.h"
#include "backends/find_device.h"
#include "backends/jack_names.h"
#include "backends/library_calls.h"
#include "backends/realtime_thread.h"

namespace tactus {
namespace {

constexpr int kPriority = 70;    // below a sound server's, above everything ordinary
constexpr int kMaxBlock = 4096;  // [frames] where the driver chooses; longer ones are cut
constexpr int kUsualPeriods = 2;

class Session;
struct Line;

/// Of the whole program, and never destroyed: PortAudio may still be at work when it ends.
struct Program {
  std::weak_ptr<Session> session;
  std::string over;         ///< why PortAudio may not be called any more; empty: it may
  std::string client_name;  ///< PortAudio keeps the pointer
  std::vector<std::shared_ptr<Line>> left_behind;  ///< what was given up
};
Program& program() {
  static auto& one = *new Program;
  return one;
}

bool is_over() { return !program().over.empty(); }

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

/// Calls PortAudio on a thread that may hang; `call` owns what it touches and returns a PaError. Errors:
/// Device, BadArgument.
Status in_portaudio(std::function<int()> call, std::chrono::milliseconds patience = kPatience,
                    const std::string& slow = {}) {
  if (is_over()) return over();
  if (const auto code = result_with_timeout(std::move(call), patience, slow)) return checked(*code);
  program().over = "PortAudio does not respond any more";
  return over();
}

/// No function of PortAudio may be called any more in this program: its JACK server is gone.
void lose_jack() {
  if (!is_over()) program().over = "the JACK server ended, and PortAudio's JACK client cannot reconnect";
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

/// "(hw:1,0)" at the end of the name of a device of ALSA's card 1: where that is connected, and its device
/// number. Empty for what is no card's own device, as "default".
std::string alsa_hardware_of(const std::string& name) {
  int card = 0, device = 0;
  const auto at = name.rfind(" (hw:");
  if (at == std::string::npos || std::sscanf(name.c_str() + at, " (hw:%d,%d)", &card, &device) != 2)
    return {};
  const auto hardware = alsa_hardware(card);
  return hardware.empty() ? "" : hardware + "," + std::to_string(device);
}

Device described(int index) {
  const auto& info = *Pa_GetDeviceInfo(index);
  const auto& api = *Pa_GetHostApiInfo(info.hostApi);
  Device device;
  device.api = name_of(api);
  device.library_name = info.name;
  device.index = index;
  device.id = "portaudio:" + device.api + ":" + without_number(info.name);
  device.name = std::string{info.name} + " (" + api.name + ")";
  if (api.type == paALSA) {
    device.hardware = alsa_hardware_of(info.name);
    device.ambiguous = device.library_name.find("(hw:") == std::string::npos;
  }
  device.in_channels = info.maxInputChannels;
  device.out_channels = info.maxOutputChannels;
  device.default_rate = Hertz{info.defaultSampleRate};
  if (api.type == paJACK) device.sample_rates = {device.default_rate};
  return device;
}

int play_nothing(const void*, void*, unsigned long, const PaStreamCallbackTimeInfo*, PaStreamCallbackFlags,
                 void*) {
  return paContinue;
}

/// PortAudio between Pa_Initialize and Pa_Terminate: at most one of them in a program, shared by all streams.
class Session {
 public:
  /// The one there is, or a new one under this name for JACK. Errors: Device.
  static Result<std::shared_ptr<Session>> enter([[maybe_unused]] const std::string& client_name) {
    silence_library_logs();
    if (is_over()) return over();
    if (auto session = program().session.lock()) return session;
#if __has_include(<pa_jack.h>)
    program().client_name = client_name.substr(0, 32);
    PaJack_SetClientName(program().client_name.c_str());
#endif
    if (auto status = in_portaudio([] { return Pa_Initialize(); }, listing_patience(),
                                   "PortAudio is still looking for devices; this may take 30 s");
        !status)
      return tl::unexpected(status.error());
    std::shared_ptr<Session> session{new Session};
    program().session = session;
    return session;
  }
  ~Session() {
    if (!occupied || answers()) static_cast<void>(in_portaudio([] { return Pa_Terminate(); }));
  }

  /// As of when the session began.
  std::vector<Device> devices() const {
    std::vector<Device> devices;
    for (int index = 0; index < Pa_GetDeviceCount(); ++index) devices.push_back(described(index));
    distinguish_same_ids(devices);
    if (jack_device_ >= 0) {
      const auto ports = result_with_timeout([] { return jack_ports(); }, kPatience);
      devices = own_ports_only(std::move(devices), JackSearch::AtEndOfName,
                               ports.value_or(std::vector<JackPort>{}));
    }
    const auto output = Pa_GetDefaultOutputDevice();
    const auto wanted = output != paNoDevice ? output : Pa_GetDefaultInputDevice();
    for (auto& one : devices) one.is_default = one.index == wanted;
    return devices;
  }

  /// Before a function that hangs or aborts if the JACK server is gone: is it there? If not, no function is
  /// called any more.
  bool answers() const {
    if (is_over()) return false;
    if (jack_device_ < 0) return true;
    const auto open_and_close = [device = jack_device_] {
      PaStreamParameters one{};
      one.device = device;
      one.channelCount = 1;
      one.sampleFormat = paFloat32;
      const auto& info = *Pa_GetDeviceInfo(device);
      const bool in = info.maxInputChannels > 0;
      PaStream* stream = nullptr;
      const auto code =
          Pa_OpenStream(&stream, in ? &one : nullptr, in ? nullptr : &one, info.defaultSampleRate,
                        paFramesPerBufferUnspecified, paNoFlag, play_nothing, nullptr);
      return code == paNoError ? Pa_CloseStream(stream) : code;
    };
    if (in_portaudio(open_and_close)) return true;
    lose_jack();
    return false;
  }

  const bool has_jack = Pa_HostApiTypeIdToHostApiIndex(paJACK) >= 0;
  bool occupied = false;  ///< a stream is open: from now on the state must be queried

 private:
  Session() {
    const auto jack = Pa_HostApiTypeIdToHostApiIndex(paJACK);
    if (has_jack && Pa_GetHostApiInfo(jack)->deviceCount > 0)
      jack_device_ = Pa_HostApiDeviceIndexToDeviceIndex(jack, 0);
  }

  int jack_device_ = -1;  ///< any, if there is one
};

/// All that PortAudio touches, kept alive by any call that hangs.
struct Line {
  std::shared_ptr<Session> session;
  PaStream* stream = nullptr;
  std::unique_ptr<CardCallback> card;  ///< before the start
  bool jack = false;
  bool own_thread = false;  ///< that PortAudio made; others are the driver's
  std::optional<std::chrono::milliseconds> silence_until_lost;
  int out_planes = 0;
  // Of the library's thread:
  bool begun = false;
  double reported_at = -1.0;  ///< [s]
};

int bring_block(const void* in, void* out, unsigned long frames, const PaStreamCallbackTimeInfo* time,
                PaStreamCallbackFlags flags, void* user) {
  auto& line = *static_cast<Line*>(user);
  if (line.own_thread && !std::exchange(line.begun, true)) static_cast<void>(become_realtime(kPriority));
  const bool input = (flags & (paInputUnderflow | paInputOverflow)) != 0;
  const bool output = (flags & (paOutputUnderflow | paOutputOverflow)) != 0;
  // A driver's buffer may be cut into several blocks, which all carry its flags and its time.
  if ((input || output) && time->currentTime != std::exchange(line.reported_at, time->currentTime))
    line.card->gaps(line.jack, input, output);
  line.card->block(static_cast<const float* const*>(in), static_cast<float* const*>(out), line.out_planes,
                   static_cast<int>(frames));
  return paContinue;
}

/// [frames] PortAudio's JACK client reports a port's latency less a block, which may be below zero and is
/// then taken for a day.
std::optional<double> believable(double seconds, double rate) {
  if (std::isfinite(seconds) && seconds > 0.0 && seconds < 10.0) return seconds * rate;
  return std::nullopt;
}

PaStreamParameters parameters(const Device& at, int channels, bool input, const StreamRequest& request,
                              double rate) {
  const auto* info = Pa_GetDeviceInfo(at.index);
  PaStreamParameters wanted{};
  wanted.device = at.index;
  wanted.channelCount = channels;
  wanted.sampleFormat = paFloat32 | paNonInterleaved;
  wanted.suggestedLatency = input ? info->defaultLowInputLatency : info->defaultLowOutputLatency;
  // Latency is what waits besides the block in work.
  if (request.block_frames)
    wanted.suggestedLatency =
        std::max(1, request.periods.value_or(kUsualPeriods) - 1) * *request.block_frames / rate;
  return wanted;
}

// Asked for a certain block, PortAudio's ALSA part divides by zero or aborts at some: a latency it takes.
int fixed_block(const Line& line, const StreamRequest& request) {
  return line.own_thread ? 0 : request.block_frames.value_or(0);
}

/// With so many channels of both devices.
Status open_once(const std::shared_ptr<Line>& line, const Device& input, const Device& output,
                 std::pair<int, int> channels, const StreamRequest& request, double rate) {
  line->out_planes = channels.second;
  const auto from = parameters(input, channels.first, true, request, rate);
  const auto to = parameters(output, channels.second, false, request, rate);
  return in_portaudio([=, block = fixed_block(*line, request)] {
    // Dithered, zeros would not be played as zeros.
    return Pa_OpenStream(&line->stream, from.channelCount > 0 ? &from : nullptr,
                         to.channelCount > 0 ? &to : nullptr, rate, static_cast<unsigned long>(block),
                         paDitherOff, bring_block, line.get());
  });
}

/// Where a driver has an even number of channels and an odd one is opened, PortAudio's ALSA part plays the
/// last of them on the next channel too, which nothing guards: an even number is opened.
int outputs_to_open(const StreamRequest& request, const Device& output) {
  const int count = channels_to_open(request.out_channels, request.out_map);
  return output.api == "alsa" && count < output.out_channels ? count + count % 2 : count;
}

/// Two devices of one ALSA card may be the ends of one wire (snd-aloop), which then has as many channels at
/// one end as at the other.
Status open_both(const std::shared_ptr<Line>& line, const Device& input, const Device& output,
                 const StreamRequest& request, double rate) {
  const std::pair wanted{channels_to_open(request.in_channels, request.in_map),
                         outputs_to_open(request, output)};
  auto status = open_once(line, input, output, wanted, request, rate);
  const bool two = wanted.first > 0 && wanted.second > 0 && input.index != output.index;
  if (status || is_over() || input.api != "alsa" || !two) return status;
  const int both = std::max(wanted.first, wanted.second);
  status = open_once(line, input, output, {both, both}, request, rate);
  if (!status)
    status.error().what = two_devices_text(input, output, wanted, rate) + "; " + status.error().what;
  return status;
}

Status open_line(const std::shared_ptr<Line>& line, const Device& input, const Device& output,
                 const StreamRequest& request, StreamGranted& granted) {
  const double rate = granted.format.sample_rate.value;
  const int block = fixed_block(*line, request);
#if __has_include(<pa_linux_alsa.h>)
  if (line->own_thread) PaAlsa_SetNumPeriods(std::max(1, request.periods.value_or(kUsualPeriods) - 1));
#endif
  line->session->occupied = true;
  if (auto status = open_both(line, input, output, request, rate); !status) return status;
  const auto* info = Pa_GetStreamInfo(line->stream);
  granted.block_frames = block;
  granted.format.max_frames = block > 0 ? block : kMaxBlock;
  if (request.in_channels > 0) granted.input_latency_frames = believable(info->inputLatency, rate);
  if (line->out_planes > 0) granted.output_latency_frames = believable(info->outputLatency, rate);
  granted.xruns_move_delay = line->own_thread;
  granted.comes_back = !line->session->has_jack;
  if (std::abs(info->sampleRate - rate) < 0.5) return {};
  return fail(Errc::BadArgument, "", "'" + granted.device + "' does not run at this rate", "omit the rate");
}

/// A stream of a JACK server that died is left as it is.
void close(std::shared_ptr<Line> line) {
  const auto session = line->session;
  if (session->answers() && in_portaudio([line] { return Pa_CloseStream(line->stream); }))
    session->occupied = false;
  else
    program().left_behind.push_back(std::move(line));
}

class PortAudioStream final : public CardStream<Line> {
 public:
  using CardStream::CardStream;
  ~PortAudioStream() override {
    static_cast<void>(stop());
    close(std::move(line_));
  }

 private:
  bool lost() const override {
    if (lost_ || is_over()) return true;
    if (!running()) return false;
    lost_ = (line_->silence_until_lost && line_->card->stalled(*line_->silence_until_lost)) ||
            Pa_IsStreamActive(line_->stream) != 1;
    if (lost_ && line_->jack) lose_jack();
    return lost_;
  }
  Status start_library() override {
    return in_portaudio([line = line_] { return Pa_StartStream(line->stream); });
  }
  /// PortAudio drains ALSA's buffer; a device without hardware (ALSA's plugin for JACK) plays what it holds
  /// in a circle until it is closed.
  std::int64_t buffered_frames() const override {
    return line_->own_thread ? std::llround(2 * granted().output_latency_frames.value_or(kMaxBlock)) : 0;
  }
  Status stop_library(bool) override {
    if (lost_ || is_over()) return {};
    return in_portaudio([line = line_] { return Pa_StopStream(line->stream); });
  }

  mutable bool lost_ = false;
};

/// Sound cards through PortAudio 19: JACK, ALSA and OSS on Linux, CoreAudio on macOS, WASAPI, ASIO and more
/// on Windows. A device is "portaudio:<api>:<its name>". While a stream is open, the list of devices is as of
/// its opening. PortAudio lists no rates but JACK's.
///
/// Where the request leaves the block out, blocks are as long as the driver's (granted as 0); any other
/// length costs up to one block of delay. ALSA takes the wish and is granted as 0.
///
/// PortAudio cannot leave a JACK server that died: its functions hang or abort the program. So when the
/// server goes, no function of it is called any more, and every later call of this class returns that
/// Error. That concerns streams of other APIs too, opened while a JACK server ran: `granted().comes_back`.
class PortAudioBackend final : public Backend {
 public:
  std::string name() const override { return "portaudio"; }
  Result<std::vector<Device>> devices() override {
    return Session::enter("tactus-devices").map([](const auto& session) { return session->devices(); });
  }
  Result<std::unique_ptr<Stream>> open(const StreamRequest& request, GuardedBlocks& processor) override {
    const auto session = Session::enter(request.client_name);
    if (!session) return tl::unexpected(session.error());
    const auto cards = alsa_devices();
    const auto choice = choose((*session)->devices(), request);
    if (!choice) return tl::unexpected(choice.error());
    const auto& [input, output, chosen] = *choice;
    auto line = std::make_shared<Line>();
    line->session = *session;
    line->jack = output.api == "jack";
    line->own_thread = output.api == "alsa" || output.api == "oss";
    line->silence_until_lost = silence_until_lost(output.api);
    auto granted = chosen;
    auto status = open_line(line, input, output, request, granted);
    if (status) status = same_cards(cards);
    if (status) status = processor.prepare(granted.format);
    if (!status) {
      if (line->stream != nullptr) close(std::move(line));
      return tl::unexpected(status.error());
    }
    return std::make_unique<PortAudioStream>(std::move(line), std::move(granted), request, processor);
  }
};

}  // namespace

std::unique_ptr<Backend> make_portaudio_backend() { return std::make_unique<PortAudioBackend>(); }

}  // namespace tactus
