// Compiled with the flags of a plain -O3 program, see CMakeLists.txt.
#include "tests/benchmarks/peers.h"

namespace tactus::bench {

std::unique_ptr<HandWritten<double>> hand_written_double(const Work& work) {
  return make_hand_written<double>(work);
}
std::unique_ptr<HandWritten<float>> hand_written_float(const Work& work) {
  return make_hand_written<float>(work);
}

}  // namespace tactus::bench
