#include "tests/backends/every_backend.h"

namespace tactus::test {

std::vector<MakeSubject> every_backend() { return {offline_subject, simulated_subject, loop_subject}; }

}  // namespace tactus::test
