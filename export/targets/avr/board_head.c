
   Timer 1 counts frames. At the start of a frame the inputs are sampled one after the other (pins A0, A1, …); then the
   frame is computed. Outputs are pulses of the same timer (OC1A, OC1B), whose width changes at the start of a frame: what
   is sampled at the start of a frame comes out at its end.

   0 V at an input is the low end of its range, 5 V the high end. An output of -1 is a duty of 0 %, 0 is 50 %, 1 is 100 %,
   for a bridge that drives in both directions. */
#include "tactus.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>

#include "board.h"

#ifndef F_CPU
#define F_CPU 16000000UL
#endif

/* Timer cycles in a frame. */
#ifndef FRAME_CYCLES
#define FRAME_CYCLES ((uint16_t)((double)F_CPU / TACTUS_RATE + 0.5))
#endif

/* Clock of the converter: F_CPU / 16 = 1 MHz, 13 cycles a conversion. Full precision is promised up to 200 kHz. */
#define ADC_ON ((1 << ADEN) | (1 << ADIE) | (1 << ADPS2))

#if defined(__AVR_ATmega640__) || defined(__AVR_ATmega1280__) || defined(__AVR_ATmega2560__)
#define PULSE_PINS ((1 << PB5) | (1 << PB6)) /* pins 11 and 12 of an Arduino Mega */
#define SWITCH_PIN (1 << PE4)                /* pin 2 */
#define SWITCH_PULL_UP PORTE
#define SWITCH_INPUT PINE
#else
#define PULSE_PINS ((1 << PB1) | (1 << PB2)) /* pins 9 and 10 of an Arduino Uno */
#define SWITCH_PIN (1 << PD2)                /* pin 2 */
#define SWITCH_PULL_UP PORTD
#define SWITCH_INPUT PIND
#endif
#define PULSE_DIRECTION DDRB

/* A simulator counts cycles between values of this register. */
#ifdef COUNT_CYCLES
#define MARK(value) (GPIOR0 = (value))
#else
#define MARK(value) ((void)0)
#endif

