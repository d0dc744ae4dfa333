#include "backends/second_device/two_devices.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "backends/second_device/timed_values.h"
#include "engine/core/channels.h"

namespace tactus {

/// Guarded blocks with the channels of one device alone.
class GuardedPart : public GuardedBlocks {
 protected:
  GuardedPart() = default;
};

namespace {

constexpr Seconds kInputDelay{2e-3};     // a poll of the second device, and as much for its thread being late
constexpr Seconds kOutputDelay{2.5e-3};  // the same, and half of the millisecond that is averaged
constexpr Seconds kSlice{1e-3};
constexpr Seconds kPatience{0.02};  // without a new value outputs of the second device come to zero
constexpr double kLargestStep = 0.1;

using Now = std::function<double()>;

double steady_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Of the channels of the processor, those of each device.
struct Split {
  explicit Split(const std::vector<int>& map) {
    for (std::size_t c = 0; c < map.size(); ++c) {
      const bool of_second = map[c] >= kSecondDevice;
      (of_second ? second : first).push_back(static_cast<int>(c));
      (of_second ? second_map : first_map).push_back(of_second ? map[c] - kSecondDevice : map[c]);
    }
  }
  std::vector<int> first, second;          ///< channels of the processor
  std::vector<int> first_map, second_map;  ///< channels of the device
};

/// What both threads use.
struct Exchange {
  Exchange(const StreamRequest& request, Now clock)
      : now(std::move(clock)), in(request.in_map), out(request.out_map) {}
  const Now now;
  Split in, out;
  TimedValues inputs, outputs;  ///< of the second device
};

/// The blocks of the first device.
class FirstPart final : public GuardedPart {
 public:
  FirstPart(std::shared_ptr<Exchange> exchange, GuardedBlocks& processor)
      : exchange_(std::move(exchange)), processor_(processor) {}

  Status prepare(const StreamFormat& format) override {
    const auto &in = exchange_->in, &out = exchange_->out;
    second_in_.resize(static_cast<int>(in.second.size()), format.max_frames);
    second_out_.resize(static_cast<int>(out.second.size()), format.max_frames);
    in_.resize(in.first.size() + in.second.size());
    out_.resize(out.first.size() + out.second.size());
    for (std::size_t c = 0; c < in.second.size(); ++c)
      in_[index(in.second[c])] = second_in_[static_cast<int>(c)];
    for (std::size_t c = 0; c < out.second.size(); ++c)
      out_[index(out.second[c])] = second_out_[static_cast<int>(c)];
    frame_s_ = 1 / format.sample_rate.value;
    clock_ = BlockClock{format.sample_rate.value};
    slice_frames_ = static_cast<int>(frames_in(kSlice, format.sample_rate));
    slice_ = {};
    sliced_ = 0;
    auto whole = format;
    whole.in_channels = static_cast<int>(in_.size());
    whole.out_channels = static_cast<int>(out_.size());
    return processor_.prepare(whole);
  }
  void process(const BlockIo& io) noexcept override {
    const double start = clock_.start(exchange_->now(), io.frames);
    fill_inputs(start, io.frames);
    processor_.process(whole(io));
    send_outputs(start, io.frames);
  }
  bool finish(const BlockIo& io) noexcept override {
    const double start = clock_.start(exchange_->now(), io.frames);
    const bool at_zero = processor_.finish(whole(io));
    send_outputs(start, io.frames);
    return at_zero;
  }
  void note_pause(Seconds pause) noexcept override { processor_.note_pause(pause); }
  void note_gap(std::int64_t frames) noexcept override { processor_.note_gap(frames); }
  Seconds closing_time() const noexcept override { return processor_.closing_time(); }
  void disable_dead_mans_switch() noexcept override { processor_.disable_dead_mans_switch(); }

 private:
  BlockIo whole(const BlockIo& io) noexcept {
    const auto &in = exchange_->in.first, &out = exchange_->out.first;
    for (std::size_t c = 0; c < in.size(); ++c) in_[index(in[c])] = io.in[c];
    for (std::size_t c = 0; c < out.size(); ++c) out_[index(out[c])] = io.out[c];
    return {in_.data(), out_.data(), io.frames};
  }
  /// A frame that comes in now was captured while the block before was played.
  void fill_inputs(double start, int frames) noexcept {
    auto& line = exchange_->inputs;
    for (int n = 0; n < frames; ++n) {
      const double seconds = start + (n + 1 - frames) * frame_s_ - kInputDelay.value;
      line.advance(seconds);
      for (int c = 0; c < second_in_.size(); ++c) second_in_[c][n] = line.at(index(c), seconds);
    }
  }
  void send_outputs(double start, int frames) noexcept {
    if (second_out_.size() == 0) return;
    for (int n = 0; n < frames; ++n) {
      for (int c = 0; c < second_out_.size(); ++c) slice_.values[index(c)] += second_out_[c][n];
      if (++sliced_ < slice_frames_) continue;
      for (auto& value : slice_.values) value /= sliced_;
      slice_.seconds = start + (n + 0.5 - 0.5 * sliced_) * frame_s_;  // its middle
      exchange_->outputs.write(slice_);
      slice_ = {};
      sliced_ = 0;
    }
  }

  std::shared_ptr<Exchange> exchange_;
  GuardedBlocks& processor_;
  ChannelBuffers second_in_, second_out_;
  std::vector<const double*> in_;
  std::vector<double*> out_;
  double frame_s_ = 0.0;
  BlockClock clock_{1.0};
  TimedValues::Point slice_;
  int slice_frames_ = 1, sliced_ = 0;
};

/// The blocks of the second device, which are a millisecond long.
class SecondPart final : public GuardedPart {
 public:
  explicit SecondPart(std::shared_ptr<Exchange> exchange) : exchange_(std::move(exchange)) {}

  Status prepare(const StreamFormat&) override {
    levels_.assign(exchange_->out.second.size(), 0.0);
    return {};
  }
  void process(const BlockIo& io) noexcept override {
    TimedValues::Point read{exchange_->now(), {}};
    for (std::size_t c = 0; c < exchange_->in.second.size(); ++c) read.values[c] = io.in[c][io.frames - 1];
    exchange_->inputs.write(read);

    const double seconds = read.seconds - kOutputDelay.value;
    auto& line = exchange_->outputs;
    line.advance(seconds);
    const bool silent = seconds > line.newest() + kPatience.value;
    for (std::size_t c = 0; c < levels_.size(); ++c) {
      auto& level = levels_[c];
      level = silent ? level - std::clamp(level, -kLargestStep, kLargestStep) : line.at(c, seconds);
      std::fill_n(io.out[c], io.frames, level);
    }
  }
  bool finish(const BlockIo& io) noexcept override {
    for (std::size_t c = 0; c < levels_.size(); ++c) std::fill_n(io.out[c], io.frames, 0.0);
    return true;
  }
  void note_pause(Seconds) noexcept override {}
  void note_gap(std::int64_t) noexcept override {}
  Seconds closing_time() const noexcept override { return 0_s; }
  void disable_dead_mans_switch() noexcept override {}

 private:
  std::shared_ptr<Exchange> exchange_;
  std::vector<double> levels_;
};

class TwoDeviceStream final : public Stream {
 public:
  TwoDeviceStream(std::shared_ptr<Exchange> exchange, GuardedBlocks& processor)
      : exchange_(std::move(exchange)), first_part_(exchange_, processor), second_part_(exchange_) {}
  ~TwoDeviceStream() override { static_cast<void>(stop()); }

  Status open(Backend& first, Backend& second, const StreamRequest& request) {
    const auto &in = exchange_->in, &out = exchange_->out;
    auto at_second = second_request(request);
    auto at_first = request;
    at_first.second_device.clear();
    at_first.in_map = in.first_map;
    at_first.out_map = out.first_map;
    at_first.in_channels = static_cast<int>(in.first.size());
    at_first.out_channels = static_cast<int>(out.first.size());
    auto opened_second = second.open(at_second, second_part_);
    if (!opened_second) return tl::unexpected(opened_second.error());
    auto opened_first = first.open(at_first, first_part_);
    if (!opened_first) return tl::unexpected(opened_first.error());
    second_ = std::move(*opened_second);
    first_ = std::move(*opened_first);
    granted_ = first_->granted();
    granted_.format.in_channels = request.in_channels;
    granted_.format.out_channels = request.out_channels;
    const auto& of_second = second_->granted();
    granted_.second = {of_second.device, of_second.input, of_second.output, kInputDelay, kOutputDelay};
    granted_.digital_inputs = digital_inputs(request.in_channels);
    granted_.comes_back = granted_.comes_back && of_second.comes_back;
    return {};
  }

  const StreamGranted& granted() const override { return granted_; }
  Status start(const std::function<void()>& ready) override {
    if (auto status = second_->start(); !status) return status;
    auto status = first_->start(ready);
    if (!status) static_cast<void>(second_->stop());
    return status;
  }
  Status stop() override {
    auto of_first = first_ ? first_->stop() : Status{};
    auto of_second = second_ ? second_->stop() : Status{};
    return of_first ? of_second : of_first;
  }
  StreamState state() const override {
    const auto of_first = first_->state(), of_second = second_->state();
    for (const auto worst : {StreamState::Lost, StreamState::Stalled})
      if (of_first == worst || of_second == worst) return worst;
    return of_first;
  }
  Health health() const override { return first_->health(); }
  int block_frames() const override { return first_->block_frames(); }
  std::vector<OtherWriter> other_writers() const override {
    auto writers = first_->other_writers();
    for (auto& writer : writers) writer.output = exchange_->out.first[index(writer.output)];
    return writers;
  }
  bool take_output_cut() override { return first_->take_output_cut(); }
  std::string take_note() override {
    if (second_->state() == StreamState::Lost && !std::exchange(loss_noted_, true))
      return "the second device, '" + granted_.second->device + "', was disconnected";
    auto note = first_->take_note();
    return note.empty() ? second_->take_note() : note;
  }

 private:
  StreamRequest second_request(const StreamRequest& request) const {
    const auto &in = exchange_->in, &out = exchange_->out;
    StreamRequest of_second;
    of_second.device = request.second_device;
    of_second.in_map = in.second_map;
    of_second.out_map = out.second_map;
    of_second.in_channels = static_cast<int>(in.second.size());
    of_second.out_channels = static_cast<int>(out.second.size());
    if (request.previous && request.previous->second) {
      of_second.previous.emplace();
      of_second.previous->input = request.previous->second->input;
      of_second.previous->output = request.previous->second->output;
    }
    return of_second;
  }
  /// As each device says, in the order of the processor.
  std::vector<bool> digital_inputs(int inputs) const {
    std::vector<bool> digital(index(inputs));
    const auto take = [&](const std::vector<int>& channels, const std::vector<bool>& of_device) {
      for (std::size_t c = 0; c < std::min(channels.size(), of_device.size()); ++c)
        digital[index(channels[c])] = of_device[c];
    };
    take(exchange_->in.first, first_->granted().digital_inputs);
    take(exchange_->in.second, second_->granted().digital_inputs);
    return digital;
  }

  std::shared_ptr<Exchange> exchange_;
  FirstPart first_part_;
  SecondPart second_part_;
  std::unique_ptr<Stream> second_, first_;
  StreamGranted granted_;
  bool loss_noted_ = false;
};

class TwoDevices final : public Backend {
 public:
  TwoDevices(std::unique_ptr<Backend> first, std::unique_ptr<Backend> second, Now now)
      : first_(std::move(first)), second_(std::move(second)), now_(std::move(now)) {}

  std::string name() const override { return first_->name(); }
  Result<std::vector<Device>> devices() override { return first_->devices(); }
  Result<std::unique_ptr<Stream>> open(const StreamRequest& request, GuardedBlocks& processor) override {
    auto exchange = std::make_shared<Exchange>(request, now_);
    const auto &in = exchange->in, &out = exchange->out;
    if (in.second.empty() && out.second.empty()) return first_->open(request, processor);
    if (in.first.empty() && out.first.empty())
      return fail(Errc::BadArgument, "",
                  "no channel of '" + request.device + "' is used, and it brings the blocks",
                  "make '" + request.second_device + "' the output device");
    if (std::max(in.second.size(), out.second.size()) > TimedValues::kMost)
      return fail(Errc::OutOfRange, "",
                  fmt::format("more than {} channels of a second device", TimedValues::kMost),
                  "leave some out");
    auto stream = std::make_unique<TwoDeviceStream>(exchange, processor);
    if (auto status = stream->open(*first_, *second_, request); !status)
      return tl::unexpected(status.error());
    return stream;
  }
  std::shared_ptr<MidiInputs> midi_inputs(std::chrono::milliseconds interval) override {
    return first_->midi_inputs(interval);
  }

 private:
  std::unique_ptr<Backend> first_, second_;
  Now now_;
};

}  // namespace

std::unique_ptr<Backend> make_two_devices(std::unique_ptr<Backend> first, std::unique_ptr<Backend> second,
                                          std::function<double()> clock) {
  return std::make_unique<TwoDevices>(std::move(first), std::move(second),
                                      clock ? std::move(clock) : steady_seconds);
}

}  // namespace tactus
