#pragma once
// Thread: [any]

#include <chrono>
#include <string>

namespace tactus::app {

/// A key: its character in ASCII, or one of these.
using Key = int;
inline constexpr Key kUpKey = 0x100, kDownKey = 0x101, kRightKey = 0x102, kLeftKey = 0x103;
/// A byte that is no key of its own.
inline constexpr Key kNoKey = 0x104;
/// What the stop loop made of keys, for the control thread (drive_keys.h).
inline constexpr Key kArmKey = 0x110, kFirstArmKey = 0x111, kDisarmedKey = 0x112, kMutedKey = 0x113,
                     kUnmutedKey = 0x114, kNotArmedKey = 0x115;

/// Turns the bytes of a terminal into keys. Control sequences (CSI, SS3, Alt with a key) are read to their
/// end however slowly they arrive, and pasted text is no key where the terminal marks it (bracketed paste). A
/// sequence that does not continue for a second is over. A string that the terminal sends (DCS, OSC, APC, PM,
/// SOS) ends with ST or BEL, or a second after it began: Alt with its first letter takes no key away for
/// longer.
class KeyDecoder {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::seconds kPatience{1};

  /// Of every byte: the key that it is or completes, or kNoKey.
  Key decode(unsigned char byte, Clock::time_point now);

 private:
  enum class State {
    Ground,
    Escape,
    Csi,      ///< ESC [ parameters final
    OneMore,  ///< ESC O final; ESC [ [ final
    Paste,    ///< ESC [ 200 ~ text ESC [ 201 ~
    String,   ///< ESC P text ESC \; ESC ] text BEL
  };

  Key first_byte(unsigned char byte);
  Key after_escape(unsigned char byte, Clock::time_point now);
  Key in_csi(unsigned char byte);
  Key one_more(unsigned char byte);
  Key in_paste(unsigned char byte);
  Key in_string(unsigned char byte, Clock::time_point now);

  State state_ = State::Ground;
  std::string parameters_;  ///< of a CSI sequence; the last bytes of a paste
  Clock::time_point last_, string_began_;
};

/// Switch the marks around pasted text on and off, where standard error is a terminal.
inline constexpr const char* kMarkPastedText = "\x1b[?2004h";
inline constexpr const char* kDoNotMarkPastedText = "\x1b[?2004l";

}  // namespace tactus::app
