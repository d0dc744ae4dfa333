#include "apps/cli/printer.h"

#include <fmt/format.h>

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "apps/cli/terminal.h"
#include "engine/core/printable.h"

namespace tactus::app {

namespace {

/// The cursor goes back to the beginning of the first line.
std::string drawn(const std::string& status) {
  if (status.empty()) return "";
  const auto more_lines = std::count(status.begin(), status.end(), '\n');
  return status + (more_lines > 0 ? fmt::format("\x1b[{}A\r", more_lines) : "\r");
}

}  // namespace

/// Outlives the printer where its thread hangs in a write.
struct Printer::Shared {
  std::mutex mutex;  ///< never held while writing
  std::condition_variable changed;
  std::deque<std::string> messages;
  std::size_t dropped = 0;
  std::optional<std::string> next_status;
  std::string shown;        ///< the status on the screen
  std::string first, last;  ///< what is written before and after everything else
  bool done = false, ended = false;

  bool has_work() const { return done || next_status || !messages.empty() || !first.empty(); }
  std::string take_text();
  void run();
};

std::string Printer::Shared::take_text() {
  auto text = std::exchange(first, {});
  if (!shown.empty()) text += "\r\x1b[J";
  for (const auto& message : messages) text += message + "\n";
  if (dropped > 0) text += fmt::format("{} more messages were not printed\n", dropped);
  if (next_status) shown = *next_status;
  text += done ? last : drawn(shown);
  messages.clear();
  dropped = 0;
  next_status.reset();
  return text;
}

void Printer::Shared::run() {
  std::unique_lock lock{mutex};
  while (!ended) {
    changed.wait(lock, [this] { return has_work(); });
    const bool is_last = done;
    const auto text = take_text();
    lock.unlock();
    (void)write_to_stderr(text);
    lock.lock();
    ended = is_last;
  }
  changed.notify_all();
}

Printer::Printer(std::string first, std::string last) : shared_(std::make_shared<Shared>()) {
  shared_->first = std::move(first);
  shared_->last = std::move(last);
  std::thread{[shared = shared_] { shared->run(); }}.detach();
}

Printer::~Printer() { finish(); }

void Printer::print(std::string message) noexcept {
  const std::lock_guard lock{shared_->mutex};
  if (shared_->messages.size() < kMostMessages)
    shared_->messages.push_back(printable(std::move(message), true));
  else
    ++shared_->dropped;
  shared_->changed.notify_all();
}

void Printer::status(std::string lines) noexcept {
  const std::lock_guard lock{shared_->mutex};
  shared_->next_status = std::move(lines);
  shared_->changed.notify_all();
}

void Printer::finish(std::chrono::milliseconds patience) noexcept {
  std::unique_lock lock{shared_->mutex};
  shared_->done = true;
  shared_->changed.notify_all();
  shared_->changed.wait_for(lock, patience, [this] { return shared_->ended; });
}

}  // namespace tactus::app
