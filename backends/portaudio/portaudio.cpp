#include <portaudio.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

#if __has_include(<pa_linux_alsa.h>)
#include <pa_linux_alsa.h>
#endif

#include "backends/card_stream.h"
#include "backends/find_device.h"
#include "backends/library_calls.h"
#include "backends/portaudio/portaudio_session.h"
#include "backends/realtime_thread.h"

namespace tactus {
namespace {

constexpr int kPriority = 70;    // below a sound server's, above everything ordinary
constexpr int kMaxBlock = 4096;  // [frames] where the driver chooses; longer ones are cut
constexpr int kUsualPeriods = 2;
constexpr std::chrono::milliseconds kGone{1000};

/// All that PortAudio touches, kept alive by any call that hangs.
struct Line {
  std::shared_ptr<PortAudioSession> session;
  PaStream* stream = nullptr;
  std::unique_ptr<CardCallback> card;  ///< before the start
  bool jack = false;
  bool own_thread = false;  ///< that PortAudio made; others are the driver's
  int out_planes = 0;
  // Of the library's thread:
  bool begun = false;
  double reported_at = -1.0;  ///< [s]
};

/// What was given up, for the rest of the program's life.
std::vector<std::shared_ptr<Line>>& left_behind() {
  static auto& lines = *new std::vector<std::shared_ptr<Line>>;
  return lines;
}

/// A driver's buffer may be cut into several blocks, which all carry its flags and its time.
void count_gaps(Line& line, double time, PaStreamCallbackFlags flags) noexcept {
  const bool input = (flags & (paInputUnderflow | paInputOverflow)) != 0;
  const bool output = (flags & (paOutputUnderflow | paOutputOverflow)) != 0;
  if ((!input && !output) || time == std::exchange(line.reported_at, time)) return;
  if (line.jack) {  // it does not report where: both are always there
    line.card->gap(Gap::Server);
    return;
  }
  if (input) line.card->gap(Gap::Input);
  if (output) line.card->gap(Gap::Output);
}

int bring_block(const void* in, void* out, unsigned long frames, const PaStreamCallbackTimeInfo* time,
                PaStreamCallbackFlags flags, void* user) {
  auto& line = *static_cast<Line*>(user);
  if (line.own_thread && !std::exchange(line.begun, true)) static_cast<void>(become_realtime(kPriority));
  count_gaps(line, time->currentTime, flags);
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

PaStreamParameters parameters(const LibraryDevice& at, int channels, bool input, const StreamRequest& request,
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

Status open_line(const std::shared_ptr<Line>& line, const LibraryDevice& input, const LibraryDevice& output,
                 const StreamRequest& request, StreamGranted& granted) {
  const double rate = granted.format.sample_rate.value;
  const int ins = channels_to_open(request.in_channels, request.in_map);
  line->out_planes = channels_to_open(request.out_channels, request.out_map);
  const auto from = parameters(input, ins, true, request, rate);
  const auto to = parameters(output, line->out_planes, false, request, rate);
  // Asked for a certain block, PortAudio's ALSA part divides by zero or aborts at some: a latency it takes.
  const int block = line->own_thread ? 0 : request.block_frames.value_or(0);
#if __has_include(<pa_linux_alsa.h>)
  if (line->own_thread) PaAlsa_SetNumPeriods(std::max(1, request.periods.value_or(kUsualPeriods) - 1));
#endif
  line->session->occupied(true);
  if (auto status = in_portaudio([=] {
        return Pa_OpenStream(&line->stream, from.channelCount > 0 ? &from : nullptr,
                             to.channelCount > 0 ? &to : nullptr, rate, static_cast<unsigned long>(block),
                             paNoFlag, bring_block, line.get());
      });
      !status)
    return status;
  const auto* info = Pa_GetStreamInfo(line->stream);
  granted.block_frames = block;
  granted.format.max_frames = block > 0 ? block : kMaxBlock;
  if (ins > 0) granted.input_latency_frames = believable(info->inputLatency, rate);
  if (line->out_planes > 0) granted.output_latency_frames = believable(info->outputLatency, rate);
  granted.xruns_move_delay = line->own_thread;
  granted.comes_back = !line->session->has_jack();
  if (std::abs(info->sampleRate - rate) < 0.5) return {};
  return fail(Errc::BadArgument, "", "'" + granted.device + "' does not run at this rate", "omit the rate");
}

/// A stream of a JACK server that died is left as it is.
void close(std::shared_ptr<Line> line) {
  const auto session = line->session;
  if (session->answers() && in_portaudio([line] { return Pa_CloseStream(line->stream); }))
    session->occupied(false);
  else
    left_behind().push_back(std::move(line));
}

class PortAudioStream final : public CardStream {
 public:
  PortAudioStream(std::shared_ptr<Line> line, StreamGranted granted)
      : CardStream(std::move(granted)), line_(std::move(line)) {}
  ~PortAudioStream() override {
    static_cast<void>(stop());
    close(std::move(line_));
  }

 private:
  CardCallback& card() const override { return *line_->card; }
  bool lost() const override {
    if (lost_ || portaudio_is_over()) return true;
    if (!running()) return false;
    // ALSA's JACK plugin waits for ever when its server is gone.
    lost_ = (line_->own_thread && card().stalled(kGone)) || Pa_IsStreamActive(line_->stream) != 1;
    if (lost_ && line_->jack) portaudio_lost_jack();
    return lost_;
  }
  Status start_library() override {
    return in_portaudio([line = line_] { return Pa_StartStream(line->stream); });
  }
  Status stop_library(bool) override {
    if (lost_ || portaudio_is_over()) return {};
    return in_portaudio([line = line_] { return Pa_StopStream(line->stream); });
  }

  std::shared_ptr<Line> line_;
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
    silence_library_logs();
    const auto session = PortAudioSession::enter("tactus-devices");
    if (!session) return tl::unexpected(session.error());
    return devices_of((*session)->devices());
  }
  Result<std::unique_ptr<Stream>> open(const StreamRequest& request, Guarded& processor) override {
    silence_library_logs();
    const auto session = PortAudioSession::enter(request.client_name);
    if (!session) return tl::unexpected(session.error());
    const auto found = (*session)->devices();
    const auto choice = choose(found, request);
    if (!choice) return tl::unexpected(choice.error());
    const auto& input = found[choice->input];
    const auto& output = found[choice->output];
    auto line = std::make_shared<Line>();
    line->session = *session;
    line->jack = output.api == "jack";
    line->own_thread = output.api == "alsa" || output.api == "oss";
    auto granted = choice->granted;
    auto status = open_line(line, input, output, request, granted);
    if (status) status = processor.prepare(granted.format);
    if (!status) {
      if (line->stream != nullptr) close(std::move(line));
      return tl::unexpected(status.error());
    }
    line->card = std::make_unique<CardCallback>(processor, request, granted, true);
    return std::make_unique<PortAudioStream>(std::move(line), std::move(granted));
  }
};

}  // namespace

std::unique_ptr<Backend> make_portaudio_backend() { return std::make_unique<PortAudioBackend>(); }

}  // namespace tactus
