static tactus program;
static tactus_real in[TACTUS_INPUTS > 0 ? TACTUS_INPUTS : 1], out[TACTUS_OUTPUTS > 0 ? TACTUS_OUTPUTS : 1];
static uint8_t channel;
static volatile uint16_t late; /* frames that took longer than a frame */

static void start_conversion(void) {
  ADMUX = (1 << REFS0) | channel;
  ADCSRA = ADC_ON | (1 << ADSC);
}

static void compute_frame(void) {
  MARK(1);
  tactus_step(&program, in, out);
  MARK(2);
#if TACTUS_PULSES > 0
  OCR1A = tactus_pulse_width(0, out[0], FRAME_CYCLES);
#endif
#if TACTUS_PULSES > 1
  OCR1B = tactus_pulse_width(1, out[1], FRAME_CYCLES);
#endif
  if (TIFR1 & (1 << TOV1)) ++late;
  MARK(3);
}

/* The start of a frame. */
ISR(TIMER1_OVF_vect) {
  channel = 0;
#if TACTUS_CONVERSIONS > 0
  start_conversion();
#else
  compute_frame();
#endif
}

#if TACTUS_CONVERSIONS > 0
ISR(ADC_vect) {
  in[channel] = tactus_of_converter(channel, ADC);
#if TACTUS_CONVERSIONS > 1
  if (++channel < TACTUS_CONVERSIONS) {
    start_conversion();
    return;
  }
#endif
  compute_frame();
}
#endif

static void start_board(void) {
  tactus_init(&program);
  PULSE_DIRECTION |= PULSE_PINS;
  SWITCH_PULL_UP |= SWITCH_PIN;
  ICR1 = FRAME_CYCLES - 1;
  OCR1A = OCR1B = FRAME_CYCLES / 2;
  TCCR1A = (1 << COM1A1) | (TACTUS_PULSES > 1 ? 1 << COM1B1 : 0) | (1 << WGM11);
  TCCR1B = (1 << WGM13) | (1 << WGM12) | (1 << CS10);
  TIMSK1 = 1 << TOIE1;
}

/* Dead man's switch: the outputs are on while the contact is closed. */
static void watch_switch(void) {
  if (!(SWITCH_INPUT & SWITCH_PIN)) tactus_alive(&program);
}
