#include "tests/backends/every_backend.h"

namespace tactus::test {

std::vector<MakeSubject> every_backend() { return {loop_subject}; }

}  // namespace tactus::test
