#pragma once
// Thread: [control]

#include <string>
#include <tl/expected.hpp>
#include <utility>
#include <vector>

namespace tactus {

enum class Errc {
  BadArgument,
  BadFile,       ///< cannot be opened, read or written
  Syntax,        ///< a file or an expression that cannot be parsed
  UnknownName,   ///< a node, port, key, unit or element that does not exist
  WrongType,     ///< a number where a string belongs, and the like
  UnitMismatch,  ///< metres where newtons belong
  OutOfRange,
  Duplicate,
  Missing,
  Cycle,  ///< a loop without a frame of delay, or a file that uses itself
  Device,
};

/// Why the control side could not do something: where, what is wrong, what to do.
struct Error {
  enum class Place { None, Option, File };

  Errc code;
  std::string where;   ///< "file:line:column", "--option", or empty
  std::string what;    ///< one sentence without a full stop
  std::string remedy;  ///< what to do, or empty

  Place place() const {
    return where.empty() ? Place::None : where.starts_with("--") ? Place::Option : Place::File;
  }
  /// The same error elsewhere.
  Error at(std::string other) const { return {code, std::move(other), what, remedy}; }
};

/// "where: what; remedy", leaving out what is empty.
std::string to_string(const Error& error);
/// One error a line.
std::string to_string(const std::vector<Error>& errors);

template <class T>
using Result = tl::expected<T, Error>;
using Status = Result<void>;

/// For files: all errors at once, in file order.
template <class T>
using Checked = tl::expected<T, std::vector<Error>>;

inline tl::unexpected<Error> fail(Errc code, std::string where, std::string what, std::string remedy = {}) {
  return tl::unexpected<Error>(Error{code, std::move(where), std::move(what), std::move(remedy)});
}

}  // namespace tactus
