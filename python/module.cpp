#include <algorithm>
#include <array>
#include <exception>
#include <limits>

#include "engine/graph/file/quantity.h"
#include "python/convert.h"

namespace tactus::python {
namespace {

/// In the order of Errc.
constexpr std::array<const char*, 11> kCodes{"BadArgument", "BadFile",      "Syntax",     "UnknownName",
                                             "WrongType",   "UnitMismatch", "OutOfRange", "Duplicate",
                                             "Missing",     "Cycle",        "Device"};
static_assert(kCodes.size() == static_cast<std::size_t>(Errc::Device) + 1);

std::string argument(const std::string& what) { return "argument '" + what + "'"; }

/// What Python's value says in a file.
Value written(const py::handle& value, const std::string& what) {
  if (py::isinstance<py::str>(value)) return {py::cast<std::string>(value), {}};
  try {
    return {py::cast<double>(py::float_{py::reinterpret_borrow<py::object>(value)}), {}};
  } catch (const py::error_already_set&) {
    throw failure({Errc::WrongType, argument(what), "is neither a number nor a quantity",
                   "give a number in SI, or a string such as \"10 ms\""});
  }
}

void translate(std::exception_ptr thrown) {
  try {
    if (thrown) std::rethrow_exception(thrown);
  } catch (const Failure& failed) {
    const auto type = py::module_::import("tactus.errors").attr("Error");
    PyErr_SetObject(type.ptr(), type.attr("of")(error_list(failed.errors)).ptr());
  } catch (const Interrupted&) {
    // Python's own exception is set.
  }
}

}  // namespace

bool InterruptCheck::pending() {
  const py::gil_scoped_acquire lock;
  return PyErr_CheckSignals() != 0;
}

py::array array_of(const std::vector<double>& values) {
  return py::array_t<double>{static_cast<py::ssize_t>(values.size()), values.data()};
}

ControlValue control_value(const py::handle& value, const std::string& what) {
  auto read = read_quantity(written(value, what));
  if (!read) throw failure(read.error().at(argument(what)));
  return *read;
}

std::map<std::string, ControlValue> control_values(const py::dict& values) {
  std::map<std::string, ControlValue> read;
  for (const auto& [key, value] : values) {
    const auto name = py::cast<std::string>(py::str(key));
    read[name] = control_value(value, name);
  }
  return read;
}

double quantity(const py::handle& value, const char* unit, const std::string& what, double least,
                double most) {
  const auto known_unit = *parse_unit(unit);
  const auto read = read_quantity(written(value, what), known_unit, what);
  if (!read) throw failure(read.error().at(argument(what)));
  if (*read >= least && *read <= most) return *read;
  throw failure({Errc::OutOfRange, argument(what),
                 "'" + py::cast<std::string>(py::str(value)) + "' is out of range",
                 limits_text(least, most, known_unit)});
}

std::optional<Seconds> seconds_of(const py::object& value, const std::string& what, double least,
                                  double most) {
  if (value.is_none()) return std::nullopt;
  return Seconds{quantity(value, "s", what, least, most)};
}

std::optional<Hertz> rate_of(const py::object& value) {
  if (value.is_none()) return std::nullopt;
  return Hertz{quantity(value, "Hz", "sample_rate", 1e3, 768e3)};
}

Target target_of(const Place& place, FolderMeans means) {
  return or_throw(find_target(place.text, means, instrument_folders(place.shipped)));
}

py::list error_list(const std::vector<Error>& errors) {
  py::list list;
  for (const auto& error : errors)
    list.append(
        py::make_tuple(kCodes[static_cast<std::size_t>(error.code)], error.where, error.what, error.remedy));
  return list;
}

}  // namespace tactus::python

PYBIND11_MODULE(_tactus, module) {
  namespace py = pybind11;
  using namespace tactus::python;
  module.doc() = "The engine behind the package tactus. Its functions are not meant to be called directly.";
  py::register_exception_translator(translate);
  module.attr("source_instruments") = TACTUS_SOURCE_DIR "/instruments";
  module.attr("version") = TACTUS_VERSION;
  add_instrument(module);
  add_scenes(module);
  add_latency(module);
}
