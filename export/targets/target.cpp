#include "export/targets/target.h"

#include <array>

#include "engine/core/named.h"

namespace tactus {
namespace {

constexpr std::size_t kAvrBytes = 7680;  ///< of the 8192 of an ATmega2560; the rest is the stack

constexpr std::array kTargets = {
    ExportTarget{"c", "C99 for any processor", RecurrenceForm::Grid, "double", 0, c_files},
    ExportTarget{"library", "the same as a library that CMake builds and installs", RecurrenceForm::Grid,
                 "double", 0, library_files},
    ExportTarget{"pd", "a signal object of Pure Data", RecurrenceForm::Grid, "double", 0, pd_files},
    ExportTarget{"cortex-m", "a program for a Cortex-M4F, which qemu runs", RecurrenceForm::Plain, "float", 1,
                 c_files, cortex_m_files},
    ExportTarget{"avr", "a program for an ATmega328P or ATmega2560, which simavr runs", RecurrenceForm::Plain,
                 "q16", 2, c_files, avr_files, true, kAvrBytes},
    ExportTarget{"arduino", "a sketch for an Arduino with such a processor", RecurrenceForm::Plain, "q16", 2,
                 c_files, arduino_files, true, kAvrBytes},
};

}  // namespace

const ExportTarget* find_export_target(std::string_view name) { return find_named(kTargets, name); }

std::vector<std::string> export_target_names() { return names_of(kTargets); }

}  // namespace tactus
