// Compiled with the flags of everything else, which decide what the program needs.
#include "apps/processor/feature.h"

// 1 if `macro` is defined as 1, as compilers define those of instruction sets; otherwise 0.
#define TACTUS_SECOND(first, second, ...) second
#define TACTUS_IS_1_1 0, 1
#define TACTUS_SECOND_OF(...) TACTUS_SECOND(__VA_ARGS__, 0, 0)
#define TACTUS_JOINED(value) TACTUS_SECOND_OF(TACTUS_IS_1_##value)
#define TACTUS_DEFINED(macro) TACTUS_JOINED(macro)

namespace tactus::app {
namespace {

enum Word { kEax, kEbx, kEcx, kEdx };
constexpr unsigned kExtended = 0x80000001;
constexpr unsigned kYmm = 0x6;
#if defined(__APPLE__)
constexpr unsigned kZmm = kYmm;  // the system saves the rest from their first use on
#else
constexpr unsigned kZmm = 0xe6;
#endif

}  // namespace

constinit const ProcessorFeature kProcessorFeatures[] = {
    {"SSE3", 1, 0, kEcx, 0, 0, TACTUS_DEFINED(__SSE3__)},
    {"SSSE3", 1, 0, kEcx, 9, 0, TACTUS_DEFINED(__SSSE3__)},
    {"CX16", 1, 0, kEcx, 13, 0, TACTUS_DEFINED(__GCC_HAVE_SYNC_COMPARE_AND_SWAP_16)},
    {"SSE4.1", 1, 0, kEcx, 19, 0, TACTUS_DEFINED(__SSE4_1__)},
    {"SSE4.2", 1, 0, kEcx, 20, 0, TACTUS_DEFINED(__SSE4_2__)},
    {"MOVBE", 1, 0, kEcx, 22, 0, TACTUS_DEFINED(__MOVBE__)},
    {"POPCNT", 1, 0, kEcx, 23, 0, TACTUS_DEFINED(__POPCNT__)},
    {"AVX", 1, 0, kEcx, 28, kYmm, TACTUS_DEFINED(__AVX__)},
    {"F16C", 1, 0, kEcx, 29, kYmm, TACTUS_DEFINED(__F16C__)},
    {"FMA", 1, 0, kEcx, 12, kYmm, TACTUS_DEFINED(__FMA__)},
    {"BMI", 7, 0, kEbx, 3, 0, TACTUS_DEFINED(__BMI__)},
    {"BMI2", 7, 0, kEbx, 8, 0, TACTUS_DEFINED(__BMI2__)},
    {"AVX2", 7, 0, kEbx, 5, kYmm, TACTUS_DEFINED(__AVX2__)},
    {"AVX512F", 7, 0, kEbx, 16, kZmm, TACTUS_DEFINED(__AVX512F__)},
    {"AVX512DQ", 7, 0, kEbx, 17, kZmm, TACTUS_DEFINED(__AVX512DQ__)},
    {"AVX512IFMA", 7, 0, kEbx, 21, kZmm, TACTUS_DEFINED(__AVX512IFMA__)},
    {"AVX512CD", 7, 0, kEbx, 28, kZmm, TACTUS_DEFINED(__AVX512CD__)},
    {"AVX512BW", 7, 0, kEbx, 30, kZmm, TACTUS_DEFINED(__AVX512BW__)},
    {"AVX512VL", 7, 0, kEbx, 31, kZmm, TACTUS_DEFINED(__AVX512VL__)},
    {"AVX512VBMI", 7, 0, kEcx, 1, kZmm, TACTUS_DEFINED(__AVX512VBMI__)},
    {"AVX512VBMI2", 7, 0, kEcx, 6, kZmm, TACTUS_DEFINED(__AVX512VBMI2__)},
    {"GFNI", 7, 0, kEcx, 8, 0, TACTUS_DEFINED(__GFNI__)},
    {"AVX512VNNI", 7, 0, kEcx, 11, kZmm, TACTUS_DEFINED(__AVX512VNNI__)},
    {"AVX512BITALG", 7, 0, kEcx, 12, kZmm, TACTUS_DEFINED(__AVX512BITALG__)},
    {"AVX512VPOPCNTDQ", 7, 0, kEcx, 14, kZmm, TACTUS_DEFINED(__AVX512VPOPCNTDQ__)},
    {"AVX512FP16", 7, 0, kEdx, 23, kZmm, TACTUS_DEFINED(__AVX512FP16__)},
    {"AVXVNNI", 7, 1, kEax, 4, kYmm, TACTUS_DEFINED(__AVXVNNI__)},
    {"AVX512BF16", 7, 1, kEax, 5, kZmm, TACTUS_DEFINED(__AVX512BF16__)},
    {"LAHF", kExtended, 0, kEcx, 0, 0, TACTUS_DEFINED(__LAHF_SAHF__)},
    {"LZCNT", kExtended, 0, kEcx, 5, 0, TACTUS_DEFINED(__LZCNT__)},
    {"SSE4A", kExtended, 0, kEcx, 6, 0, TACTUS_DEFINED(__SSE4A__)},
    {"XOP", kExtended, 0, kEcx, 11, kYmm, TACTUS_DEFINED(__XOP__)},
    {"FMA4", kExtended, 0, kEcx, 16, kYmm, TACTUS_DEFINED(__FMA4__)},
    {"TBM", kExtended, 0, kEcx, 21, 0, TACTUS_DEFINED(__TBM__)},
    {}};

}  // namespace tactus::app
