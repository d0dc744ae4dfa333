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
/// An `a` beside other bytes (Alt-a, in pasted text, in what the terminal sends): it disarms, and nothing
/// else.
inline constexpr Key kDisarmKey = 0x105;
/// Ctrl-C as a sequence.
inline constexpr Key kStopKey = 0x106;
/// What the stop loop made of keys, for the control thread (drive_keys.h).
inline constexpr Key kArmKey = 0x110, kPressEnterKey = 0x111, kDisarmedKey = 0x112, kMutedKey = 0x113,
                     kUnmutedKey = 0x114, kNotArmedKey = 0x115;

/// Turns the bytes of a terminal into keys; a capital letter is its small one (Caps Lock). Control sequences
/// (CSI, SS3, Alt with a key) are read to their end however slowly they arrive, and pasted text is no key
/// where the terminal marks it (bracketed paste). An Escape that nothing follows for 50 ms is alone, and a
/// sequence that does not continue for a second is over. So is, a second after it began, what has no length
/// of its own: pasted text, and a string that the terminal sends (DCS, OSC, APC, PM, SOS), which ends with ST
/// or BEL. Keys are also known in the sequences of terminals whose keyboard protocol another program left on
/// (CSI 99;5 u of kitty, CSI 27;5;99 ~ of xterm); there an `a` is kDisarmKey. Whatever an `a` is part of, it
/// is at least kDisarmKey.
class KeyDecoder {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kPatience{1000}, kPatienceAfterEscape{50};

  /// Of every byte: the key that it is or completes, or kNoKey.
  Key decode(unsigned char byte, Clock::time_point now);

 private:
  enum class State {
    Ground,
    Escape,
    Csi,      ///< ESC [ parameters final
    OneMore,  ///< ESC O final; ESC [ [ final
    Mouse,    ///< ESC [ M button column row
    Paste,    ///< ESC [ 200 ~ text ESC [ 201 ~
    String,   ///< ESC P text ESC \; ESC ] text BEL
  };

  bool over(Clock::time_point now) const;
  bool may_be_a(unsigned char byte) const;
  Key key_of(unsigned char byte, Clock::time_point now);
  Key first_byte(unsigned char byte);
  Key after_escape(unsigned char byte, Clock::time_point now);
  Key in_csi(unsigned char byte, Clock::time_point now);
  State after_csi(unsigned char byte) const;
  Key after_protocol(unsigned char final) const;
  Key one_more(unsigned char byte);
  Key in_mouse(unsigned char byte);
  Key in_paste(unsigned char byte);
  Key in_string(unsigned char byte);

  State state_ = State::Ground;
  std::string parameters_;          ///< of a CSI sequence; the last bytes of a paste
  int mouse_bytes_ = 0;             ///< that are still to come
  Clock::time_point last_, began_;  ///< the last byte; what has no length of its own
};

/// Switch the marks around pasted text on and off, where standard error is a terminal. The former also
/// switches off the keyboard protocols of kitty and xterm (modifyOtherKeys), in which Ctrl-C would not be a
/// signal.
inline constexpr const char* kMarkPastedText = "\x1b[?2004h\x1b[=0u\x1b[>4;0m";
inline constexpr const char* kDoNotMarkPastedText = "\x1b[?2004l";

}  // namespace tactus::app
