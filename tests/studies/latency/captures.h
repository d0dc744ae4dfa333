#pragma once

#include <string>

namespace tactus::study {

/// Recordings of the probe beside recorded and synthetic backgrounds, each with what may happen to one: two
/// clocks, lost frames, distortion, a second path. Prints tables in Markdown; what is wrong goes to stderr.
/// `speech`: a folder of WAV files; `held_out`: with the sounds that no threshold was chosen by. Of `count`
/// captures from the number `first` on. Exit code 1: a gross error, or a lost frame without a word.
int captures(int first, int count, bool held_out, const std::string& speech);

}  // namespace tactus::study
