/* Runs a program of main.c for an AVR in simavr, cycle by cycle, and drives its converter.

     simulate MCU PROGRAM.elf CHANNELS IN_ADDRESS IN_BYTES OUT_ADDRESS OUT_BYTES < millivolts > frames

     simulate MCU PROGRAM.elf CHANNELS

   Without addresses the inputs go up and down over their range, and only the counters are printed.

   millivolts: CHANNELS unsigned 16-bit numbers a frame. frames: for each frame the inputs and the outputs as they are in
   data memory, then the pulse widths OCR1A and OCR1B, 16 bits each.

   The program, compiled with COUNT_CYCLES, writes to GPIOR0: 1 before the step of a frame, 2 behind it, 3 when the outputs
   are set. Prints the least, the mean and the largest number of cycles from 1 to 2 (the step), from the sampling of the
   first input to 3 (the frame), and from one sampling to the next (the period). */
#include <inttypes.h>
#include <stdarg.h>
#include <simavr/avr_adc.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_elf.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
  const char* name;
  uint64_t least, most, total, runs;
} counter;

enum { MAX_CHANNELS = 8 };
enum { GPIOR0 = 0x3e, OCR1A = 0x88, OCR1B = 0x8a }; /* of both processors */
static counter step = {.name = "step", .least = UINT64_MAX}, frame = {.name = "frame", .least = UINT64_MAX},
               period = {.name = "period", .least = UINT64_MAX};
static avr_cycle_count_t sampled, began;
static uint16_t millivolts[MAX_CHANNELS];
static int channels, converted, ended, triggers;
static unsigned in_address, in_bytes, out_address, out_bytes;
static avr_irq_t* pins;

static void count(counter* c, uint64_t cycles) {
  if (cycles < c->least) c->least = cycles;
  if (cycles > c->most) c->most = cycles;
  c->total += cycles;
  ++c->runs;
}
static void print(const counter* c) {
  fprintf(stderr, "%s: least %" PRIu64 ", mean %.3f, most %" PRIu64 ", frames %" PRIu64 "\n", c->name,
          c->runs > 0 ? c->least : 0, c->runs > 0 ? (double)c->total / (double)c->runs : 0.0, c->most, c->runs);
}

static void read_millivolts(void) {
  const unsigned way = (unsigned)triggers % 2000;
  if (out_bytes > 0) {
    if (fread(millivolts, sizeof *millivolts, (size_t)channels, stdin) != (size_t)channels) ended = 1;
    return;
  }
  for (int i = 0; i < channels; ++i) millivolts[i] = (uint16_t)(5 * (way < 1000 ? way : 2000 - way) - (way == 1000));
  if (triggers >= 4000) ended = 1;
}

/* The first conversions of a converter take longer. */
static int settled(void) { return triggers > 8; }

/* A conversion starts. */
static void on_trigger(avr_irq_t* irq, uint32_t value, void* data) {
  avr_t* const avr = data;
  (void)irq;
  (void)value;
  if (converted == 0) {
    if (settled()) count(&period, avr->cycle - sampled);
    ++triggers;
    sampled = avr->cycle;
    read_millivolts();
  }
  for (int i = 0; i < channels; ++i) avr_raise_irq(pins + ADC_IRQ_ADC0 + i, millivolts[i]);
  converted = (converted + 1) % channels;
}

static void on_mark(avr_t* avr, avr_io_addr_t address, uint8_t value, void* data) {
  (void)data;
  avr->data[address] = value;
  if (value == 1) began = avr->cycle;
  if (value == 2 && settled()) count(&step, avr->cycle - began - 1); /* without the cycle of the mark itself */
  if (value != 3 || ended) return;
  if (settled()) count(&frame, avr->cycle - sampled);
  if (out_bytes == 0) return;
  fwrite(avr->data + in_address, 1, in_bytes, stdout);
  fwrite(avr->data + out_address, 1, out_bytes, stdout);
  fwrite(avr->data + OCR1A, 1, 2, stdout);
  fwrite(avr->data + OCR1B, 1, 2, stdout);
}

/* Messages of the simulator would be among the frames. */
static void log_errors(avr_t* avr, const int level, const char* format, va_list arguments) {
  (void)avr;
  if (level <= LOG_ERROR) vfprintf(stderr, format, arguments);
}

int main(int arguments, char** argument) {
  elf_firmware_t program;
  avr_t* avr;
  int state = cpu_Running;
  if (arguments != 4 && arguments != 8)
    return fprintf(stderr, "simulate MCU PROGRAM.elf CHANNELS [IN_ADDRESS IN_BYTES OUT_ADDRESS OUT_BYTES]\n"), 2;
  avr_global_logger_set(log_errors);
  memset(&program, 0, sizeof program);
  avr = avr_make_mcu_by_name(argument[1]);
  if (avr == NULL || elf_read_firmware(argument[2], &program) != 0) return fprintf(stderr, "cannot load\n"), 1;
  channels = atoi(argument[3]);
  if (arguments == 8) {
    in_address = (unsigned)strtoul(argument[4], NULL, 0);
    in_bytes = (unsigned)strtoul(argument[5], NULL, 0);
    out_address = (unsigned)strtoul(argument[6], NULL, 0);
    out_bytes = (unsigned)strtoul(argument[7], NULL, 0);
  }
  avr_init(avr);
  program.frequency = 16000000;
  avr_load_firmware(avr, &program);
  avr->frequency = 16000000;
  avr->vcc = avr->avcc = avr->aref = 5000;
  avr->log = LOG_ERROR;
  pins = avr_io_getirq(avr, AVR_IOCTL_ADC_GETIRQ, 0);
  avr_irq_register_notify(pins + ADC_IRQ_OUT_TRIGGER, on_trigger, avr);
  avr_register_io_write(avr, GPIOR0, on_mark, NULL);
  while (!ended && state != cpu_Done && state != cpu_Crashed) state = avr_run(avr);
  print(&step);
  print(&frame);
  print(&period);
  return state == cpu_Crashed;
}
