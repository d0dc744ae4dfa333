#include <RtAudio.h>
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <thread>
#include <utility>

#include "backends/alsa_devices.h"
#include "backends/card_callback.h"
#include "backends/find_device.h"
#include "backends/jack_names.h"
#include "backends/library_calls.h"
#include "backends/realtime_thread.h"
#include "engine/core/index.h"

namespace tactus {
namespace {

using Clock = std::chrono::steady_clock;
using Devices = std::vector<Device>;
using std::chrono::milliseconds;

constexpr int kPriority = 70;      // below a sound server's, above everything ordinary
constexpr int kUsualBlock = 256;   // [frames] where the driver lets us choose and the request does not
constexpr int kUsualPeriods = 2;   // the fewest that a driver takes
constexpr int kErrorsInARow = 16;  // a device that is still there recovers sooner

constexpr milliseconds kGiveUp{100};  // for closing what is lost anyway

/// "RtApiAlsa::probeDeviceOpen: the device won't open." -> "the device won't open"
std::string plain_message(std::string text) {
  if (const auto colon = text.find(": "); colon != std::string::npos) text.erase(0, colon + 2);
  text.erase(text.find_last_not_of(".! ") + 1);
  return text;
}

/// All that RtAudio touches, kept alive by any call that hangs. Destroying it closes the devices.
class Line {
 public:
  Line(const std::string& api, const StreamRequest& request)
      : in_(index(channels_to_open(request.in_channels, request.in_map))),
        out_(index(channels_to_open(request.out_channels, request.out_map))),
        silence_until_lost_(silence_until_lost(api)),
        library_{RtAudio::getCompiledApiByName(api)} {
    library_.showWarnings(false);
    const auto which = library_.getCurrentApi();
    jack = which == RtAudio::UNIX_JACK;
    own_thread_ = which == RtAudio::LINUX_ALSA || which == RtAudio::LINUX_PULSE;
  }
  /// [control] `granted` has the rate; the latencies of the driver are added.
  Status open(const Device& input, const Device& output, const StreamRequest& request,
              StreamGranted& granted) {
    auto status = checked([&] {
      rate_ = static_cast<unsigned>(granted.format.sample_rate.value);
      auto block = static_cast<unsigned>(request.block_frames.value_or(kUsualBlock));
      RtAudio::StreamOptions options;
      // Asked for a real-time thread, those that RtAudio makes itself write to stderr: they are raised here.
      options.flags = RTAUDIO_NONINTERLEAVED | (own_thread_ ? 0 : RTAUDIO_SCHEDULE_REALTIME);
      options.priority = kPriority;
      options.numberOfBuffers = static_cast<unsigned>(request.periods.value_or(kUsualPeriods));
      options.streamName = request.client_name;
      open_both(input, output, block, options);
      // With JACK the outputs are open before the inputs are looked for, and shift the list.
      if (jack && !in_.empty() && !out_.empty()) {
        if (const auto there = now_at(input.library_name); there != unsigned(input.index)) {
          library_.closeStream();
          open_once(there, unsigned(output.index), block, options);
          if (now_at(input.library_name) != there)
            throw RtAudioError{"JACK clients changed in the meantime; try again"};
        }
      }
      granted.block_frames = granted.format.max_frames = static_cast<int>(block);
      granted.periods = jack ? 0 : static_cast<int>(options.numberOfBuffers);
      granted.xruns_move_delay = own_thread_;
      const auto latency = static_cast<double>(library_.getStreamLatency());
      if (latency > 0 && in_.empty()) granted.output_latency_frames = latency;
      if (latency > 0 && out_.empty()) granted.input_latency_frames = latency;
    });
    // PipeWire lists the outputs that are open by then first, and RtAudio takes them for the device.
    if (!status && jack && !in_.empty() && !out_.empty())
      status.error().remedy = "use --device 'jack:" + output.library_name +
                              "': with PipeWire, RtAudio cannot open inputs and outputs together";
    return status;
  }
  /// [control & stopped] Blocks begin to flow.
  Status start() {
    return checked([this] { library_.startStream(); });
  }
  /// [control] Stops after the last block has been played. Never `stopStream`, which waits for blocks that
  /// may not come.
  Status halt(milliseconds buffered) {
    return checked([&] {
      if (own_thread_) std::this_thread::sleep_for(buffered);
      if (!lost() && library_.isStreamRunning()) library_.abortStream();
    });
  }
  /// [control] Neither `start` nor `halt` may be called any more.
  bool lost() const {
    return lost_ || !library_.isStreamOpen() ||
           (silence_until_lost_ && card && card->stalled(*silence_until_lost_));
  }

  std::unique_ptr<CardCallback> card;  ///< before the start
  std::atomic<bool> abandoned{false};
  bool jack = false;

 private:
  template <class Call>
  static Status checked(Call call) {
    std::string message;
    error_message_ = &message;
    try {
      call();
    } catch (const std::exception& error) {
      message = error.what();
    }
    error_message_ = nullptr;
    if (message.empty()) return {};
    return fail(Errc::Device, "", "RtAudio: " + plain_message(message), "see tactus doctor");
  }

  static void on_error(RtAudioError::Type type, const std::string& text) {
    const bool warning = type == RtAudioError::WARNING || type == RtAudioError::DEBUG_WARNING;
    if (error_message_ != nullptr && !warning) *error_message_ = text;
    if (at_work_ == nullptr) return;
    at_work_->failed_ = true;
    // It will never call again, although the stream counts as running.
    if (text.find("buffer size has changed") != std::string::npos) at_work_->lost_ = true;
  }

  /// Two devices of one ALSA card may be the ends of one wire (snd-aloop): the inputs, which RtAudio opens
  /// second, then have as many channels as the outputs were opened with, and the other way round.
  void open_both(const Device& input, const Device& output, unsigned& block,
                 RtAudio::StreamOptions& options) {
    const auto open = [&] { open_once(unsigned(input.index), unsigned(output.index), block, options); };
    const bool two = !in_.empty() && !out_.empty() && input.index != output.index;
    const std::pair wanted{static_cast<int>(in_.size()), static_cast<int>(out_.size())};
    try {
      open();
    } catch (const RtAudioError& error) {
      const auto both = std::max(in_.size(), out_.size());
      if (jack || !two) throw;
      in_.resize(both);
      out_.resize(both);
      try {
        open();
      } catch (const RtAudioError&) {
        throw RtAudioError{"open: " + two_devices_text(input, output, wanted, rate_) + "; " +
                           plain_message(error.what())};
      }
    }
  }
  void open_once(unsigned input, unsigned output, unsigned& block, RtAudio::StreamOptions& options) {
    RtAudio::StreamParameters in{input, static_cast<unsigned>(in_.size()), 0};
    RtAudio::StreamParameters out{output, static_cast<unsigned>(out_.size()), 0};
    library_.openStream(out_.empty() ? nullptr : &out, in_.empty() ? nullptr : &in, RTAUDIO_FLOAT32, rate_,
                        &block, bring_block, this, &options, on_error);
  }

  /// The index of the JACK client `name`, now that our own is in the list too; one beyond the list: it is
  /// gone.
  unsigned now_at(const std::string& name) {
    unsigned index = 0;
    for (const unsigned count = library_.getDeviceCount(); index < count; ++index)
      if (library_.getDeviceInfo(index).name == name) break;
    return index;
  }

  /// RtAudio's own threads do not notice that their device is gone: every call fails at once, and they turn
  /// as fast as they can.
  bool keeps_pace(unsigned frames) noexcept {
    const std::chrono::duration<double> lasts{frames / static_cast<double>(rate_)};
    const auto now = Clock::now();
    failures_ = failed_ && now - last_block_ < lasts / 2 ? failures_ + 1 : 0;
    failed_ = false;
    last_block_ = now;
    if (failures_ >= kErrorsInARow) lost_ = true;
    if (lost_) std::this_thread::sleep_for(lasts);
    return !lost_;
  }

  static int bring_block(void* out, void* in, unsigned frames, double, RtAudioStreamStatus status,
                         void* line) noexcept {
    auto& self = *static_cast<Line*>(line);
    at_work_ = &self;
    if (self.own_thread_ && !std::exchange(self.begun_, true)) static_cast<void>(become_realtime(kPriority));
    auto* const in_samples = static_cast<const float*>(in);
    auto* const out_samples = static_cast<float*>(out);
    // Where one of two devices is lost the other still plays: it hears silence until it is faded.
    const bool hears = self.keeps_pace(frames) && in_samples != nullptr;
    for (std::size_t c = 0; c < self.in_.size(); ++c) self.in_[c] = hears ? in_samples + c * frames : nullptr;
    for (std::size_t c = 0; c < self.out_.size(); ++c) self.out_[c] = out_samples + c * frames;
    if (!self.lost_)
      self.card->gaps(self.jack, (status & RTAUDIO_INPUT_OVERFLOW) != 0,
                      (status & RTAUDIO_OUTPUT_UNDERFLOW) != 0);
    self.card->block(self.in_.data(), self.out_.data(), static_cast<int>(self.out_.size()),
                     static_cast<int>(frames));
    return 0;
  }

  std::vector<const float*> in_;
  std::vector<float*> out_;
  bool own_thread_ = false;  ///< that RtAudio made; others are the driver's
  const std::optional<milliseconds> silence_until_lost_;
  unsigned rate_ = 48000;
  std::atomic<bool> lost_{false};
  // Of the library's thread:
  bool begun_ = false;
  bool failed_ = false;  // since the last block
  int failures_ = 0;
  Clock::time_point last_block_;
  // RtAudio's error callback does not say which stream it is about. On a control thread the message is stored
  // here; on a stream's own thread the stream is known.
  static inline thread_local std::string* error_message_ = nullptr;
  static inline thread_local Line* at_work_ = nullptr;

  RtAudio library_;  // closed before the rest goes
};

/// A call that may hang. What hangs is left to itself.
template <class Call>
Status in_time(const std::shared_ptr<Line>& line, Call call) {
  if (auto status = result_with_timeout([line, call] { return call(*line); })) return *status;
  line->abandoned = true;
  return fail(Errc::Device, "", "RtAudio does not respond", "restart the sound server");
}

/// Devices close with the last who holds the line, on a thread that may hang.
void close(std::shared_ptr<Line> line) {
  const auto patience = line->lost() ? kGiveUp : milliseconds{2000};
  call_with_timeout([line = std::move(line)] {}, patience);
}

Device described(const std::string& api, unsigned index, const RtAudio::DeviceInfo& info) {
  Device device;
  device.api = api;
  device.library_name = info.name;
  device.index = static_cast<int>(index);
  device.id = "rtaudio:" + api + ":" + info.name;
  device.name = info.name + " (" + RtAudio::getApiDisplayName(RtAudio::getCompiledApiByName(api)) + ")";
  device.in_channels = static_cast<int>(info.inputChannels);
  device.out_channels = static_cast<int>(info.outputChannels);
  for (const auto rate : info.sampleRates) device.sample_rates.push_back(Hertz{static_cast<double>(rate)});
  device.default_rate = Hertz{static_cast<double>(info.preferredSampleRate)};
  device.is_default = info.isDefaultOutput;
  device.ambiguous = api == "alsa" && info.name == "default";
  return device;
}

/// Whether RtAudio's ALSA devices from number `first` on are these, in ALSA's order.
bool is_aligned(const Devices& found, const std::vector<AlsaDevice>& pcms, int first) {
  return std::all_of(found.begin(), found.end(), [&](const Device& device) {
    const auto at = index(device.index - first);
    return device.library_name == "default" ||
           (at < pcms.size() &&
            device.library_name == "hw:" + pcms[at].name + "," + std::to_string(pcms[at].device));
  });
}

/// Hardware of RtAudio's ALSA devices. Of the `count` that it lists, "default" comes before the hardware (or
/// after it, until RtAudio 5.1), if there is one. None is assigned when cards came or went meanwhile.
void add_hardware(Devices& found, int count, const std::vector<AlsaDevice>& pcms) {
  if (alsa_devices() != pcms) return;
  int first = count - static_cast<int>(pcms.size());
  if (!is_aligned(found, pcms, first)) first = 0;
  if (!is_aligned(found, pcms, first)) return;
  for (auto& device : found)
    if (device.library_name != "default") device.hardware = pcms[index(device.index - first)].hardware;
}

Devices probe(RtAudio::Api api) {
  Devices found;
  unsigned count = 0;
  const bool alsa = api == RtAudio::LINUX_ALSA;
  // Of a JACK client whose name is a regular expression it may find no port.
  const bool jack = api == RtAudio::UNIX_JACK;
  const auto pcms = alsa ? alsa_devices() : std::vector<AlsaDevice>{};
  try {
    RtAudio library{api};
    library.showWarnings(false);
    count = library.getDeviceCount();
    for (unsigned i = 0; i < count; ++i) {
      const auto info = library.getDeviceInfo(i);
      const bool usable =
          info.probed && info.inputChannels + info.outputChannels > 0 && !info.sampleRates.empty();
      if (usable || (jack && !info.name.empty()))
        found.push_back(described(RtAudio::getApiName(api), i, info));
    }
  } catch (const std::exception&) {  // a device went away while it was asked: those before it are there
  }
  if (alsa) add_hardware(found, static_cast<int>(count), pcms);
  return jack ? own_ports_only(std::move(found), JackSearch::Anywhere, jack_ports()) : found;
}

/// The outputs' default of the first API that has one, or else the first device with inputs.
void one_default(Devices& devices) {
  auto chosen =
      std::find_if(devices.begin(), devices.end(), [](const Device& found) { return found.is_default; });
  if (chosen == devices.end()) chosen = devices.begin();
  for (auto one = devices.begin(); one != devices.end(); ++one) one->is_default = one == chosen;
}

/// Every device that can be opened now, or those of one API alone where `text` begins like an id of it.
/// Errors: Device when an API does not answer and no other has a device.
Result<Devices> rtaudio_devices(const std::string& text) {
  std::vector<RtAudio::Api> apis;
  RtAudio::getCompiledApi(apis);
  const auto named = std::find_if(apis.begin(), apis.end(), [&](RtAudio::Api api) {
    return text.starts_with("rtaudio:" + RtAudio::getApiName(api) + ":");
  });
  if (named != apis.end()) apis = {*named};
  Devices devices;
  std::string silent;
  for (const auto api : apis) {
    // ALSA opens every device; servers answer at once or never.
    const auto found = result_with_timeout([api] { return probe(api); },
                                           api == RtAudio::LINUX_ALSA ? listing_patience() : kPatience,
                                           "RtAudio is still looking for devices; this may take 30 s");
    if (!found) {
      silent = RtAudio::getApiDisplayName(api);
      continue;
    }
    devices.insert(devices.end(), found->begin(), found->end());
  }
  if (devices.empty() && !silent.empty())
    return fail(Errc::Device, "", silent + " does not respond", "restart its server");
  distinguish_same_ids(devices);
  one_default(devices);
  return devices;
}

class RtAudioStream final : public CardStream<Line> {
 public:
  using CardStream::CardStream;
  ~RtAudioStream() override {
    static_cast<void>(stop());
    close(std::move(line_));
  }

 private:
  bool lost() const override { return line_->abandoned || line_->lost(); }
  Status start_library() override {
    return asked([](Line& line) { return line.start(); });
  }
  Status stop_library(bool finished) override {
    const auto buffered = milliseconds{static_cast<int>(
        1e3 * granted().periods * granted().block_frames / granted().format.sample_rate.value + 1)};
    return asked([=](Line& line) { return line.halt(finished ? buffered : milliseconds{0}); });
  }
  /// A JACK stream that hung is never closed, for the rest of the program's life: by the time it could be,
  /// its server may have died, the library's own thread may be closing it, and libjack may know another
  /// server.
  template <class Call>
  Status asked(Call call) {
    static auto& left_behind = *new std::vector<std::shared_ptr<Line>>;
    auto status = in_time(line_, call);
    if (line_->abandoned && line_->jack) left_behind.push_back(line_);
    return status;
  }
};

/// Sound cards through RtAudio 5: JACK, ALSA and PulseAudio on Linux, CoreAudio on macOS, WASAPI and ASIO on
/// Windows, whatever the library was compiled for. A device is "rtaudio:<api>:<its name>". The default device
/// is that of the first API that has one.
///
/// With JACK the server chooses the block, and RtAudio hands over input that is one block old. A change of
/// the server's block size ends the stream for good (Lost): RtAudio cannot go on, but opening it again works.
class RtAudioBackend final : public Backend {
 public:
  std::string name() const override { return "rtaudio"; }
  Result<std::vector<Device>> devices() override {
    silence_library_logs();
    return rtaudio_devices("");
  }
  Result<std::unique_ptr<Stream>> open(const StreamRequest& request, GuardedBlocks& processor) override {
    silence_library_logs();
    const auto cards = alsa_devices();
    const auto found = rtaudio_devices(request.device);
    if (!found) return tl::unexpected(found.error());
    const auto choice = choose(*found, request);
    if (!choice) return tl::unexpected(choice.error());
    auto line = std::make_shared<Line>(choice->output.api, request);
    const auto granted = std::make_shared<StreamGranted>(choice->granted);
    auto status = in_time(line, [=, choice = *choice](Line& opened) {
      return opened.open(choice.input, choice.output, request, *granted);
    });
    if (!status) return tl::unexpected(status.error());
    status = same_cards(cards);
    if (status) status = processor.prepare(granted->format);
    if (!status) {
      close(std::move(line));
      return tl::unexpected(status.error());
    }
    return std::make_unique<RtAudioStream>(std::move(line), *granted, request, processor);
  }
};

}  // namespace

std::unique_ptr<Backend> make_rtaudio_backend() { return std::make_unique<RtAudioBackend>(); }

}  // namespace tactus
