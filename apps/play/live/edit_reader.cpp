#include "apps/play/live/edit_reader.h"

#include <chrono>
#include <new>
#include <system_error>

namespace tactus::app {
namespace {

constexpr std::chrono::milliseconds kLookEvery{50};

}  // namespace

void WatchedFiles::watch(const std::vector<std::filesystem::path>& files) {
  std::map<std::filesystem::path, Stamp> watched;
  for (const auto& file : files)
    watched.emplace(file, files_.contains(file) ? files_[file] : stamp_of_(file));
  files_ = std::move(watched);
}

bool WatchedFiles::changed() {
  bool any = false;
  for (auto& [file, before] : files_) any = std::exchange(before, stamp_of_(file)) != before || any;
  return any;
}

WatchedFiles::Stamp WatchedFiles::read_stamp(const std::filesystem::path& file) {
  std::error_code missing;
  const auto time = std::filesystem::last_write_time(file, missing);
  const auto bytes = missing ? 0 : std::filesystem::file_size(file, missing);
  return missing ? Stamp{} : Stamp{time, bytes};
}

EditReader::EditReader(WatchedFiles files, std::function<Edit()> read)
    : files_(std::move(files)), read_(std::move(read)), thread_([this] { run(); }) {}

EditReader::~EditReader() {
  {
    const std::lock_guard lock{mutex_};
    done_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

std::optional<Edit> EditReader::take() {
  const std::lock_guard lock{mutex_};
  return std::exchange(edit_, std::nullopt);
}

void EditReader::run() {
  std::unique_lock lock{mutex_};
  while (!wake_.wait_for(lock, kLookEvery, [this] { return done_; })) {
    const bool taken = !edit_;
    lock.unlock();
    auto edit = look_again(taken);
    lock.lock();
    if (edit) edit_ = std::move(edit);
  }
}

std::optional<Edit> EditReader::look_again(bool may_read) {
  try {
    return look(may_read);
  } catch (const std::bad_alloc&) {
    return std::nullopt;  // of the few bytes that watching takes: the next look may get them
  }
}

std::optional<Edit> EditReader::look(bool may_read) {
  changed_ = files_.changed() || changed_;
  if (!changed_ || !may_read) return std::nullopt;
  changed_ = false;
  auto edit = read_();
  if (!edit.files.empty()) files_.watch(edit.files);
  return edit;
}

}  // namespace tactus::app
