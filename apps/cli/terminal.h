#pragma once
// Thread: [any]

#include <string_view>

namespace tactus::app {

/// [control, first of all] Where a program is started with standard streams closed, the next file that it
/// opens takes their place, and its bytes would be read as keys: they are opened on /dev/null then.
void open_standard_streams();

/// Columns of the terminal at standard error; 0 if it is none.
int terminal_columns();
/// Lines of it; 0 if it is none.
int terminal_rows();

/// Writes to standard error as long as it takes. Holds no lock, so that other threads can end the program
/// meanwhile. False: nobody reads it any more.
bool write_to_stderr(std::string_view text) noexcept;

}  // namespace tactus::app
