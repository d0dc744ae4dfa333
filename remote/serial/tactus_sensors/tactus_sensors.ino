// Sensors for Tactus: a ribbon at A0, a force-sensitive resistor at A1 (10 kohm to ground), a rotary encoder at pins 2 and 3.
// It sends 250 lines a second, such as "@1234567 ribbon 0.512 force 0.031 turns 2.25 *4F": the time in microseconds, then names of
// controls and their values in the unit of the control, then the exclusive or of all bytes before the asterisk.
//
//   tactus play my_instrument --rig desk.toml --serial /dev/ttyACM0
//
// with, in my_instrument/instrument.toml:
//
//   [controls]
//   ribbon = { value = 0, range = [0, 1], smooth = "4 ms" }
//   force  = { value = 0, range = [0, 1], smooth = "4 ms" }
//   turns  = { value = 0, range = [-100, 100], smooth = "4 ms" }

const unsigned long kInterval_us = 4000;
const float kStepsPerTurn = 80.0;  // of an encoder with 20 periods a turn

volatile long steps = 0;

void encoder_moved() {
  static byte before = 0;
  const byte now = digitalRead(2) << 1 | digitalRead(3);
  // Which way, for each pair of states: 0 for none, and for one that was missed.
  static const signed char kSteps[16] = {0, -1, 1, 0, 1, 0, 0, -1, -1, 0, 0, 1, 0, 1, -1, 0};
  steps += kSteps[before << 2 | now];
  before = now;
}

void setup() {
  Serial.begin(115200);
  pinMode(2, INPUT_PULLUP);
  pinMode(3, INPUT_PULLUP);
  attachInterrupt(digitalPinToInterrupt(2), encoder_moved, CHANGE);
  attachInterrupt(digitalPinToInterrupt(3), encoder_moved, CHANGE);
}

void send(const String& line) {
  byte sum = 0;
  for (unsigned i = 0; i < line.length(); ++i) sum ^= line[i];
  Serial.print(line);
  Serial.print('*');
  Serial.println(sum, HEX);
}

void loop() {
  static unsigned long next = micros();
  if ((long)(micros() - next) < 0) return;
  next += kInterval_us;
  const unsigned long now = micros();
  const float ribbon = analogRead(A0) / 1023.0, force = analogRead(A1) / 1023.0;
  noInterrupts();
  const long turned = steps;
  interrupts();
  send("@" + String(now) + " ribbon " + String(ribbon, 4) + " force " + String(force, 4) + " turns " +
       String(turned / kStepsPerTurn, 4) + " ");
}
