#pragma once

// Thread: [control]

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/error.h"
#include "engine/graph/file/value.h"

namespace tactus {

/// By file, line and column of `where`, those of the file `first` before all others; errors of one place
/// stay in order.
void sort_by_place(std::vector<Error>& errors, std::string_view first = {});

/// "'a', 'b' and 'c'"
std::string listed(std::span<const std::string> names);

/// The candidate with the fewest letters to change, if that is few enough to be what was meant; else "".
std::string nearest_name(std::string_view wrong, std::span<const std::string> candidates);

/// "'key'", "'key' of owner"
std::string key_of(std::string_view key, const std::string& owner);

/// "did you mean 'x'?", else `otherwise`, else the list of all `known`.
std::string suggest(std::string_view wrong, std::span<const std::string> known,
                    const std::string& otherwise = {});

/// Gathers the errors of a file, so that all of them come back in one go.
class ErrorList {
 public:
  ErrorList() = default;
  /// Those of `first`, the file that the user named, come before those of the files that it uses.
  explicit ErrorList(const Source& first) : first_(first.file ? *first.file : std::string{}) {}

  void add(Errc code, const Source& at, std::string what, std::string remedy);
  void add(Error error) { list_.push_back(std::move(error)); }
  void add(std::vector<Error> errors);
  /// What is allowed and probably not meant.
  void warn(Errc code, const Source& at, std::string what, std::string remedy);

  /// "unknown key 'xyz'; did you mean 'inputs'?" for each key that is not in `known`; with an owner "delay
  /// 'a' has no 'xyz'; …".
  void unknown_keys(const Value::Table& table, std::span<const std::string> known,
                    const std::string& owner = {});

  /// The string called `key`; "" if there is none, and an error if it is something else.
  std::string text(const Value::Table& table, std::string_view key, const std::string& owner = {});

  /// The value, or nothing and an error.
  template <class T>
  const T* keep(const Result<T>& result) {
    if (!result) add(result.error());
    return result ? &*result : nullptr;
  }

  bool any() const { return !list_.empty(); }
  /// All of them, by place, each once.
  std::vector<Error> take();
  std::vector<Error> take_warnings();

 private:
  std::string first_;
  std::vector<Error> list_, warnings_;
};

}  // namespace tactus
