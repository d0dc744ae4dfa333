#pragma once
// Thread: [any]

#include <chrono>
#include <memory>
#include <string>

namespace tactus::app {

/// Prints on standard error from a thread of its own, so that a stopped terminal or a full pipe blocks no
/// other thread. Messages are queued, up to a limit, and counted beyond it; of the status only the latest one
/// is drawn, below the messages. When the reader is gone, everything is dropped. Never throws.
class Printer {
 public:
  static constexpr std::size_t kMostMessages = 1000;

  /// `first` and `last`: control sequences that are written before and after everything else.
  explicit Printer(std::string first = {}, std::string last = {});
  /// Finishes.
  ~Printer();
  Printer(const Printer&) = delete;
  Printer& operator=(const Printer&) = delete;

  void print(std::string message) noexcept;
  /// Lines without the last line end. For terminals alone.
  void status(std::string lines) noexcept;
  /// Removes the status and waits until all is written, for `patience` at most: the thread is then left
  /// alone.
  void finish(std::chrono::milliseconds patience = std::chrono::seconds{1}) noexcept;

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
};

}  // namespace tactus::app
