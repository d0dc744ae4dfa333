#include "backends/loop/loop.h"
#include "tests/backends/every_backend.h"

namespace tactus::test {

// The backend that needs no hardware.
Subject loop_subject() {
  Subject subject;
  subject.backend = std::make_unique<LoopBackend>(LoopBackend::Pace::AsFastAsPossible);
  subject.request.in_channels = 2;
  subject.request.out_channels = 1;
  return subject;
}

}  // namespace tactus::test
