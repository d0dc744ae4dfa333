#include "backends/take/take_recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "engine/core/index.h"

namespace tactus {
namespace {

constexpr auto kRelaxed = std::memory_order_relaxed;
constexpr auto kWriteEvery = std::chrono::milliseconds{20};
constexpr Seconds kLeastMemory{0.1};
/// How much a take may lose when the program is killed, besides what the ring holds.
constexpr Seconds kSettleEvery{0.2};

}  // namespace

TakeRing::TakeRing(int in_channels, int out_channels, std::int64_t frames)
    : in_channels_(in_channels),
      out_channels_(out_channels),
      capacity_(frames),
      samples_(index(frames) * index(channels())) {}

void TakeRing::applied(const JournalEntry& entry) noexcept {
  // Frames only ever grow, until somebody prepares the stream anew.
  if (entry.frame < next_frame_) restarted_.store(true, kRelaxed);
  if (restarted()) return;
  if (!events_.push(entry)) lost_entries_.fetch_add(1, kRelaxed);
}

void TakeRing::observe(const BlockIo& io, std::int64_t first_frame) noexcept {
  if (first_frame < next_frame_) restarted_.store(true, kRelaxed);
  if (restarted()) return;
  if (gap_.frames == 0) gap_ = {next_frame_, first_frame - next_frame_};  // not there from the beginning
  const auto at = written_.load(kRelaxed);
  if (at - read_.load(std::memory_order_acquire) + io.frames <= capacity_ && close_gap()) {
    copy(io, at);
    written_.store(at + io.frames, std::memory_order_release);
  } else {
    gap_.frames += io.frames;
    dropped_.fetch_add(io.frames, kRelaxed);
  }
  next_frame_ = first_frame + io.frames;
}

/// A gap must be known before what follows it.
bool TakeRing::close_gap() noexcept {
  if (gap_.frames > 0 && !events_.push(gap_)) return false;
  gap_ = {};
  return true;
}

void TakeRing::copy(const BlockIo& io, std::int64_t at) noexcept {
  const auto width = index(channels());
  std::int64_t rounded = 0;
  for (int done = 0; done < io.frames;) {
    const auto slot = (at + done) % capacity_;
    const int frames = static_cast<int>(std::min<std::int64_t>(io.frames - done, capacity_ - slot));
    float* to = samples_.data() + index(slot) * width;
    for (int c = 0; c < in_channels_; ++c, ++to)
      for (int n = 0; n < frames; ++n) {
        const double sensor = io.in[c][done + n];
        const auto kept = static_cast<float>(sensor);
        rounded += static_cast<double>(kept) == sensor ? 0 : 1;
        to[index(n) * width] = kept;
      }
    for (int c = 0; c < out_channels_; ++c, ++to)
      for (int n = 0; n < frames; ++n) to[index(n) * width] = as_recorded(io.out[c][done + n]);
    done += frames;
  }
  if (rounded > 0) rounded_.fetch_add(rounded, kRelaxed);
}

TakeRing::Segment TakeRing::front(std::int64_t written) const noexcept {
  const auto read = read_.load(kRelaxed);
  const auto slot = read % capacity_;
  return {samples_.data() + index(slot) * index(channels()), std::min(written - read, capacity_ - slot)};
}

Result<TakeWriter> TakeWriter::create(const std::filesystem::path& wav, const TakeHeader& header,
                                      TakeRing& ring) {
  const auto journal = journal_path(wav);
  std::error_code ignored;
  if (std::filesystem::exists(journal, ignored))
    return fail(Errc::BadFile, journal.string(), "the journal of this take already exists",
                "choose another name, or move the file");
  auto file = GrowingWav::create(wav, header.sample_rate, ring.channels());
  if (!file) return tl::unexpected(file.error());
  TakeWriter writer{std::move(*file), journal, header, ring};
  if (writer.journal_) return writer;
  std::filesystem::remove(wav, ignored);
  return fail(Errc::BadFile, journal.string(), "it cannot be written",
              "check that the folder is writable and the disk has free space");
}

TakeWriter::TakeWriter(GrowingWav wav, std::filesystem::path journal, const TakeHeader& header,
                       TakeRing& ring)
    : wav_(std::move(wav)),
      journal_path_(std::move(journal)),
      journal_(journal_path_, std::ios::binary),
      ring_(&ring),
      settle_every_(static_cast<std::int64_t>(frames_in(kSettleEvery, header.sample_rate))) {
  journal_ << journal_line(header) << std::flush;
}

bool TakeWriter::work() {
  const auto written = ring_->written();
  drain_events();
  if (error_.empty())
    if (const auto status = write_samples(written); !status) fail_with(status.error().what);
  if (error_.empty() && wav_.frames() - settled_ >= settle_every_) settle();
  return error_.empty();
}

void TakeWriter::drain_events() {
  for (TakeEvent event; ring_->pop(event);) {
    const auto* entry = std::get_if<JournalEntry>(&event);
    if (entry == nullptr)
      write_gap(std::get<TakeGap>(event));
    else if (entry->kind == JournalEntry::Kind::Replacement)
      replaced_.push_back(entry->frame);
    else if (error_.empty())
      journal_ << journal_line(*entry);
  }
  while (!replaced_.empty() && !edits_.empty()) {
    edits_.front().frame = replaced_.front();
    if (error_.empty()) journal_ << journal_line(edits_.front());
    edits_.pop_front();
    replaced_.pop_front();
  }
}

void TakeWriter::write_gap(const TakeGap& gap) {
  gaps_.push_back(gap);
  if (error_.empty()) journal_ << journal_line(gap);
}

/// Missing frames are zeros, so that frame n of the file is frame n of the stream.
Status TakeWriter::write_samples(std::int64_t written) {
  for (auto segment = ring_->front(written); segment.frames > 0 || !gaps_.empty();
       segment = ring_->front(written)) {
    if (!gaps_.empty() && gaps_.front().frame == wav_.frames()) {
      if (auto status = wav_.append_silence(gaps_.front().frames); !status) return status;
      gaps_.pop_front();
      continue;
    }
    if (!gaps_.empty()) segment.frames = std::min(segment.frames, gaps_.front().frame - wav_.frames());
    if (segment.frames == 0) break;  // the gap lies behind what was written so far
    if (auto status = wav_.append(segment.samples, segment.frames); !status) return status;
    ring_->drop_front(segment.frames);
  }
  return {};
}

void TakeWriter::settle() {
  progress_.complete = replaced_.empty() ? wav_.frames() : std::min(wav_.frames(), replaced_.front());
  progress_.lost_entries = ring_->lost_entries();
  progress_.rounded_sensors = ring_->rounded_sensors();
  journal_ << journal_line(progress_) << std::flush;
  if (!journal_) return fail_with(why_not_written());
  if (const auto status = wav_.settle(); !status) return fail_with(status.error().what);
  settled_ = wav_.frames();
}

void TakeWriter::fail_with(const std::string& what) {
  error_ = what;
  wav_.save_what_is_there();
}

void TakeWriter::finish() {
  (void)work();
  if (const auto& gap = ring_->open_gap(); gap.frames > 0) {
    write_gap(gap);
    (void)work();
  }
  if (error_.empty()) settle();
  progress_.ended = !error_.empty() ? error_ : ring_->restarted() ? "the stream restarted" : "";
  progress_.finished = true;
  if (journal_) journal_ << journal_line(progress_) << std::flush;
}

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
  status.messages = messages();
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

std::vector<std::string> TakeRecorder::messages() const {
  const double dropped_s = static_cast<double>(ring_->dropped_frames()) / sample_rate_.value;
  std::vector<std::string> messages;
  if (!status_.error.empty())
    messages.push_back(fmt::format("the take ends at {:.3f} s: {}", status_.recorded.value, status_.error));
  else if (dropped_s > 0)
    messages.push_back(
        fmt::format("the disk was too slow: {:.3f} s of the take are missing and marked as gaps", dropped_s));
  if (ring_->lost_entries() > 0)
    messages.push_back(fmt::format("{} changes were not recorded: the take cannot be replayed bit for bit",
                                   ring_->lost_entries()));
  if (ring_->restarted())
    messages.push_back(
        fmt::format("the stream restarted at {:.3f} s; the take ends there", status_.recorded.value));
  if (ring_->rounded_sensors() > 0)
    messages.push_back(fmt::format("{} sensor samples were rounded: the take cannot be replayed bit for bit",
                                   ring_->rounded_sensors()));
  return messages;
}

}  // namespace tactus
