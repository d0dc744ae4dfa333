/* Runs the program in a simulator: reads frames from input.raw and writes frames to output.raw, by semihosting. On a board,
   a timer interrupt calls tactus_step in its place, with what the converters give, and the main loop tactus_alive. */
#include "tactus.h"

enum { SYS_OPEN = 1, SYS_CLOSE = 2, SYS_WRITE = 5, SYS_READ = 6, SYS_EXIT = 0x18 };
enum { READ_BINARY = 1, WRITE_BINARY = 5, EXIT_NORMAL = 0x20026, EXIT_FAILED = 0x20024 };
enum { FRAMES = 64 }; /* read at once */

static int host(int operation, const void* arguments) {
  register int r0 __asm__("r0") = operation;
  register const void* r1 __asm__("r1") = arguments;
  __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
  return r0;
}
static int open_file(const char* name, int length, int mode) {
  const int arguments[] = {(int)name, mode, length};
  return host(SYS_OPEN, arguments);
}
/* Bytes that were left over. */
static int transfer(int operation, int file, void* bytes, int count) {
  const int arguments[] = {file, (int)bytes, count};
  return host(operation, arguments);
}

/* What is counted lies between the two: see count_instructions.c. */
__attribute__((noinline)) void count_begin(void) { __asm__ volatile(""); }
__attribute__((noinline)) void count_end(void) { __asm__ volatile(""); }

static tactus program;
static tactus_real in[FRAMES][TACTUS_INPUTS], out[FRAMES][TACTUS_OUTPUTS];

int main(void) {
  const int input = open_file("input.raw", 9, READ_BINARY), output = open_file("output.raw", 10, WRITE_BINARY);
  int frames, n;
  if (input < 0 || output < 0) host(SYS_EXIT, (const void*)EXIT_FAILED);
  tactus_init(&program);
  do {
    frames = (int)((sizeof in - (unsigned)transfer(SYS_READ, input, in, sizeof in)) / sizeof in[0]);
    for (n = 0; n < frames; ++n) {
      tactus_alive(&program);
      count_begin();
      tactus_step(&program, in[n], out[n]);
      count_end();
    }
    transfer(SYS_WRITE, output, out, frames * (int)sizeof out[0]);
  } while (frames == FRAMES);
  host(SYS_EXIT, (const void*)EXIT_NORMAL);
  return 0;
}
