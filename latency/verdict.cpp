#include "latency/verdict.h"

namespace tactus {

const char* code(Verdict verdict) {
  switch (verdict) {
    case Verdict::Ok:
      return "ok";
    case Verdict::NoSignal:
      return "NO_SIGNAL";
    case Verdict::WrongChannel:
      return "WRONG_CHANNEL";
    case Verdict::Feedback:
      return "HOWL";
    case Verdict::Clipping:
      return "CLIPPING";
    case Verdict::LostFrames:
      return "LOST_FRAMES";
    case Verdict::ApiMismatch:
      return "API_MISMATCH";
    case Verdict::EchoCancel:
      return "ECHO_CANCEL";
    case Verdict::Agc:
      return "AGC";
    case Verdict::ClocksDiffer:
      return "CLOCKS_DIFFER";
    case Verdict::DirectMonitoring:
      return "DIRECT_MONITORING";
    case Verdict::NotFlat:
      return "NOT_FLAT";
    case Verdict::LowSnr:
      return "LOW_SNR";
    case Verdict::UnstableStart:
      return "UNSTABLE_START";
  }
  return "";
}

}  // namespace tactus
