#pragma once
// Thread: [any]

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "remote/stream_clock.h"

namespace tactus {

/// One line of a serial sensor: "ribbon 0.512", "@1234567 ribbon 0.512 force 12.5 *4F".
struct SerialLine {
  struct Value {
    std::string control;
    double value = 0.0;  ///< in the unit of the control
  };
  std::optional<std::uint32_t> micros;  ///< clock of the sensor, which wraps
  std::vector<Value> values;
};

/// Nothing: it is no such line, or its checksum is wrong.
std::optional<SerialLine> parse_serial_line(std::string_view line);

/// The lines in a stream of bytes. One that is too long is refused as a whole.
class SerialLines {
 public:
  static constexpr std::size_t kLongest = 256;

  /// Calls `use` for each line that ends in `bytes`, without its end.
  template <class Use>
  void add(std::string_view bytes, Use use) {
    for (const char byte : bytes) {
      if (byte == '\n' || byte == '\r') {
        if (too_long_)
          ++refused_;
        else if (!line_.empty())
          use(std::string_view{line_});
        clear();
      } else if (line_.size() < kLongest) {
        line_ += byte;
      } else {
        too_long_ = true;
      }
    }
  }
  void clear() {
    line_.clear();
    too_long_ = false;
  }
  std::int64_t refused() const { return refused_; }

 private:
  std::string line_;
  bool too_long_ = false;
  std::int64_t refused_ = 0;
};

/// Counts on from a clock of 32 bits, which wraps after 71 minutes.
class WideMicros {
 public:
  std::int64_t widen(std::uint32_t micros) {
    last_ += static_cast<std::int32_t>(micros - static_cast<std::uint32_t>(last_));
    return last_;
  }

 private:
  std::int64_t last_ = 0;
};

/// When lines were made, plus the time that they take on average, by the system clock. Ports deliver lines
/// late and in lumps: where the sensor states its own time, a loop follows it and takes that jitter off.
class SerialClock {
 public:
  /// `farthest_s`: from the arrival of a line.
  explicit SerialClock(double farthest_s) : farthest_s_(farthest_s) {}

  void restart() { clock_.restart(); }
  double time_of(const std::optional<std::uint32_t>& micros, double arrival_s) {
    if (!micros) return arrival_s;
    const auto now = wide_.widen(*micros);
    clock_.update(arrival_s, now);
    if (!clock_.known()) return arrival_s;
    return std::clamp(clock_.time_of(static_cast<double>(now)), arrival_s - farthest_s_,
                      arrival_s + farthest_s_);
  }

 private:
  double farthest_s_;
  WideMicros wide_;
  StreamClock clock_{Hertz{1e6}};
};

}  // namespace tactus
