#pragma once
// Thread: [control], with Python's lock (GIL) unless a function says otherwise

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "engine/core/error.h"
#include "engine/core/units.h"
#include "engine/graph/plan/compile.h"
#include "engine/scene/file/find_target.h"

namespace tactus::python {

namespace py = pybind11;

/// Errors of the engine. Thrown with the lock or without it; becomes a tactus.Error.
struct Failure {
  std::vector<Error> errors;
};
/// The user pressed Ctrl-C: Python's exception is already set.
struct Interrupted {};

inline Failure failure(Error error) { return {{std::move(error)}}; }
inline Failure failure(std::vector<Error> errors) { return {std::move(errors)}; }

/// The value of a result; with the lock or without it. Throws a Failure with its errors.
template <class T, class E>
T or_throw(tl::expected<T, E> result) {
  if (!result) throw failure(std::move(result.error()));
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

/// Called at every block, without the lock, on the thread that called from Python. Throws Interrupted after
/// Ctrl-C.
class InterruptCheck {
 public:
  void operator()() {
    const auto now = Clock::now();
    if (now - last_ < kEvery) return;
    last_ = now;
    if (pending()) throw Interrupted{};
  }
  /// Whatever the time. True: Python's exception is set.
  static bool pending();

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kEvery{50};  // other threads want the lock too
  Clock::time_point last_ = Clock::now();
};

/// An array of numbers, frame by frame.
using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// A copy.
py::array array_of(const std::vector<double>& values);
/// The same memory, which `owner` keeps; it cannot be written to.
template <class Owner>
py::array view_of(const std::vector<double>& values, const std::shared_ptr<Owner>& owner) {
  const py::capsule base{new std::shared_ptr<Owner>{owner},
                         [](void* kept) { delete static_cast<std::shared_ptr<Owner>*>(kept); }};
  py::array_t<double> view{static_cast<py::ssize_t>(values.size()), values.data(), base};
  view.attr("setflags")(py::arg("write") = false);
  return view;
}

/// A number in SI, or a string with a unit such as "-40 dB". Throws a Failure: Syntax, at the argument
/// `what`.
ControlValue control_value(const py::handle& value, const std::string& what);
std::map<std::string, ControlValue> control_values(const py::dict& values);
/// The same for a quantity in `unit` between two bounds. Throws a Failure: Syntax, UnitMismatch, OutOfRange.
double quantity(const py::handle& value, const char* unit, const std::string& what, double least,
                double most);
/// Nothing of None.
std::optional<Seconds> seconds_of(const py::object& value, const std::string& what, double least,
                                  double most);
std::optional<Hertz> rate_of(const py::object& value);

/// What Python calls an instrument or a scene by.
struct Place {
  std::string text;      ///< a path or a name; or the file itself
  bool is_text = false;  ///< the latter
  std::string shipped;   ///< the folder of the shipped instruments
};
/// What errors in such a text are reported of.
inline constexpr const char* kTextName = "<text>";
/// The file. Without the lock. Throws a Failure: BadFile.
Target target_of(const Place& place, FolderMeans means);

/// As a list of (code, where, what, remedy), which tactus.Error is made from.
py::list error_list(const std::vector<Error>& errors);

// Each adds its functions to the module.
void add_instrument(py::module_& module);
void add_scenes(py::module_& module);
void add_latency(py::module_& module);

}  // namespace tactus::python
