#pragma once
// Thread: [any]

namespace tactus::app {

/// An extension of the instruction set of x86-64 that compilers use on their own.
struct ProcessorFeature {
  const char* name;
  unsigned leaf, subleaf;  ///< of the instruction CPUID
  int word;                ///< of its result: EAX, EBX, ECX, EDX are 0 to 3
  int bit;
  unsigned saved_state;  ///< bits of XCR0: registers that the operating system has to save
  bool needed;           ///< this program was compiled to use it
};

/// The last one has no name.
extern const ProcessorFeature kProcessorFeatures[];

}  // namespace tactus::app
