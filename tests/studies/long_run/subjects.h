#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

// What plays for hours.

namespace tactus::study {

/// A row of the table: a quantity at the beginning, at the end, and what theory says of it.
struct Row {
  std::string quantity, at_start, at_end, bound;
  bool right = true;
};

/// Something that advances frame by frame.
class Subject {
 public:
  virtual ~Subject() = default;
  virtual double rate() const = 0;
  virtual void advance(std::int64_t frames) = 0;
  /// [control] At the beginning and at the end: looks at a window, which it plays.
  virtual void look() = 0;
  /// [control] What changed between the first look and the last one.
  virtual std::vector<Row> rows() const = 0;
};

struct Entry {
  std::string name;
  std::string about;
  std::function<std::unique_ptr<Subject>()> make;
};
const std::vector<Entry>& subjects();

}  // namespace tactus::study
