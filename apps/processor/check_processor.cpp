// Compiled for every processor of its kind, unlike everything else, and runs before everything else: a
// program that was compiled for another processor ends with a message, not with an illegal instruction.
// Includes nothing with inline functions: the linker would take the one of another file, with instructions of
// that file.
#include "apps/processor/feature.h"

#if defined(__x86_64__)
#include <cpuid.h>
#if defined(_WIN32)
#include <io.h>
#else
#include <unistd.h>
#endif

#include <cstdlib>
#include <cstring>

namespace tactus::app {
namespace {

constexpr int kCannotRun = 126;  // as a shell ends for a program that cannot be executed
constexpr unsigned kOsSavesState = 1u << 27;

/// The registers that the operating system saves; 0: only those that every processor has.
unsigned saved_state() {
  unsigned words[4] = {};
  if (__get_cpuid(1, &words[0], &words[1], &words[2], &words[3]) == 0) return 0;
  if ((words[2] & kOsSavesState) == 0) return 0;
  unsigned low = 0, high = 0;
  __asm__("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
  return low;
}

bool has(const ProcessorFeature& feature, unsigned saved) {
  unsigned words[4] = {};
  if (__get_cpuid_count(feature.leaf, feature.subleaf, &words[0], &words[1], &words[2], &words[3]) == 0)
    return false;
  return (words[feature.word] >> feature.bit & 1) != 0 &&
         (saved & feature.saved_state) == feature.saved_state;
}

void print(const char* text) {
#if defined(_WIN32)
  static_cast<void>(_write(2, text, static_cast<unsigned>(std::strlen(text))));
#else
  if (write(STDERR_FILENO, text, std::strlen(text)) < 0) return;
#endif
}

[[gnu::constructor(101)]] void check_processor() {
  const unsigned saved = saved_state();
  bool can_run = true;
  for (const auto* feature = kProcessorFeatures; feature->name != nullptr; ++feature) {
    if (!feature->needed || has(*feature, saved)) continue;
    print(can_run ? "this processor lacks instructions that this program was compiled for: " : ", ");
    print(feature->name);
    can_run = false;
  }
  if (can_run) return;
  print("; compile it on this machine, or with -DTACTUS_ARCH=x86-64 for every processor\n");
  std::_Exit(kCannotRun);
}

}  // namespace
}  // namespace tactus::app
#endif
