#pragma once
// Thread: [control]

#include <string>

#include "backends/take/take.h"

namespace tactus {

/// The lines of a journal, as docs/takes.md describes them, each with its line end.
std::string header_line(const TakeHeader& header);
std::string entry_line(const JournalEntry& entry);
std::string gap_line(const TakeGap& gap);
std::string edit_line(const TakeEdit& edit);
/// Everything that was applied before `take.complete` is above, except what was lost.
std::string complete_line(const Take& take);
/// The last line: the same, and why it ended before its time.
std::string end_line(const Take& take);

/// Errors: BadFile, for a first line that is no header of a take.
Result<TakeHeader> parse_header(const std::string& line);
/// Adds the content of a line. False: it is no line of a journal.
bool parse_line(const std::string& line, Take& take);

}  // namespace tactus
