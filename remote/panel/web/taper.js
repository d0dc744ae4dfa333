// Positions of a slider, 0 to 1, and the values of a control with its taper. A control in dB is linear in dB.

/** True where a logarithmic taper is possible. */
const logarithmic = (control) => control.taper === "logarithmic" && control.low > 0 && control.high > 0;

export function toPosition(control, value) {
  if (control.high === control.low) return 0;
  if (logarithmic(control)) return Math.log(value / control.low) / Math.log(control.high / control.low);
  return (value - control.low) / (control.high - control.low);
}

export function toValue(control, position) {
  if (position <= 0) return control.low;
  if (position >= 1) return control.high;
  if (logarithmic(control)) return control.low * (control.high / control.low) ** position;
  return control.low + position * (control.high - control.low);
}

/** The value moved by a share of the range of positions, with as many digits as a step needs. */
export function step(control, value, share) {
  const exact = toValue(control, toPosition(control, value) + share);
  const size = Math.abs(exact - value);
  if (size === 0 || exact === control.low || exact === control.high) return exact;
  const digits = Math.max(0, 1 - Math.floor(Math.log10(size)));
  return Number(exact.toFixed(Math.min(digits, 12)));
}
