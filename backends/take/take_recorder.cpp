#include "backends/take/take_recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

namespace tactus {
namespace {

constexpr auto kWriteEvery = std::chrono::milliseconds{20};
constexpr Seconds kLeastMemory{0.1};

}  // namespace

Result<std::unique_ptr<TakeRecorder>> TakeRecorder::start(const std::filesystem::path& wav, TakeHeader header,
                                                          Seconds memory) {
  const auto frames =
      static_cast<std::int64_t>(frames_in(std::max(memory, kLeastMemory), header.sample_rate));
  auto ring = std::make_unique<TakeRing>(static_cast<int>(header.inputs.size()),
                                         static_cast<int>(header.outputs.size()), frames);
  auto writer = TakeWriter::create(wav, header, *ring);
  if (!writer) return tl::unexpected(writer.error());
  return std::unique_ptr<TakeRecorder>{
      new TakeRecorder{std::move(header), std::move(ring), std::move(*writer)}};
}

TakeRecorder::TakeRecorder(TakeHeader header, std::unique_ptr<TakeRing> ring, TakeWriter writer)
    : sample_rate_(header.sample_rate),
      ring_(std::move(ring)),
      writer_(std::move(writer)),
      thread_([this] { run(); }) {}

TakeRecorder::~TakeRecorder() { (void)finish(); }

// The disk is written to without the lock: who asks for the status never waits for it.
void TakeRecorder::run() {
  std::unique_lock lock{mutex_};
  for (bool last = false; !last;) {
    last = done_;
    for (auto& edit : std::exchange(edits_, {})) writer_.add_edit(std::move(edit));
    lock.unlock();
    if (last)
      writer_.finish();
    else
      (void)writer_.work();
    lock.lock();
    status_.recorded = Seconds{static_cast<double>(writer_.frames()) / sample_rate_.value};
    status_.error = writer_.error();
    if (!last) wake_.wait_for(lock, kWriteEvery, [this] { return done_; });
  }
}

void TakeRecorder::note_edit(TakeEdit edit) {
  const std::lock_guard lock{mutex_};
  edits_.push_back(std::move(edit));
}

TakeStatus TakeRecorder::status() const {
  const std::lock_guard lock{mutex_};
  auto status = status_;
  status.dropped_frames = ring_->dropped_frames();
  status.lost_entries = ring_->lost_entries();
  status.restarted = ring_->restarted();
  status.messages = messages_of(status);
  return status;
}

std::vector<std::string> TakeRecorder::finish() {
  if (!thread_.joinable()) return {};
  {
    const std::lock_guard lock{mutex_};
    done_ = true;
  }
  wake_.notify_one();
  thread_.join();
  return status().messages;
}

std::vector<std::string> TakeRecorder::messages_of(const TakeStatus& status) const {
  const double dropped_s = static_cast<double>(status.dropped_frames) / sample_rate_.value;
  std::vector<std::string> messages;
  if (!status.error.empty())
    messages.push_back(fmt::format("the take ends at {:.3f} s: {}", status.recorded.value, status.error));
  else if (status.dropped_frames > 0)
    messages.push_back(
        fmt::format("the disk was too slow: {:.3f} s of the take are missing and marked as gaps", dropped_s));
  if (status.lost_entries > 0)
    messages.push_back(fmt::format("{} changes were not recorded: the take cannot be replayed bit for bit",
                                   status.lost_entries));
  if (status.restarted)
    messages.push_back(
        fmt::format("the stream restarted at {:.3f} s; the take ends there", status.recorded.value));
  if (ring_->rounded_sensors() > 0)
    messages.push_back(fmt::format("{} sensor samples were rounded: the take cannot be replayed bit for bit",
                                   ring_->rounded_sensors()));
  return messages;
}

}  // namespace tactus
