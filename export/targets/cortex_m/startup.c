/* Start of a Cortex-M4F without an operating system: vector table, memory, floating-point unit. */
#include <stdint.h>

extern uint32_t data_source, data_begin, data_end, bss_begin, bss_end, stack_top;
int main(void);

static void halt(void) {
  for (;;) {}
}

void start(void) {
  const uint32_t* from = &data_source;
  uint32_t* to;
  *(volatile uint32_t*)0xE000ED88u |= 0xFu << 20; /* CPACR: access to coprocessors 10 and 11, the FPU */
  __asm__ volatile("dsb\n isb");
  for (to = &data_begin; to < &data_end;) *to++ = *from++;
  for (to = &bss_begin; to < &bss_end;) *to++ = 0;
  main();
  halt();
}

/* Faults go to `halt`; interrupts of a board come behind the first sixteen. */
__attribute__((section(".vectors"), used)) static const void* const vectors[16] = {
    &stack_top, start, halt, halt, halt, halt, halt, 0, 0, 0, 0, halt, halt, 0, halt, halt};
