#pragma once
// Thread: [control]

#include <chrono>
#include <optional>

namespace tactus::app {

// Arrow keys, as the control characters that readline uses for them.
inline constexpr char kLeftKey = 2, kRightKey = 6, kDownKey = 14, kUpKey = 16;

/// The keys of standard input, each as soon as it is pressed: a terminal is switched to deliver them without
/// Enter and without echo, and back at the end. Anything else is read as it is; after its end no key comes
/// any more.
class Keyboard {
 public:
  Keyboard();
  ~Keyboard();
  Keyboard(const Keyboard&) = delete;
  Keyboard& operator=(const Keyboard&) = delete;

  /// The next key, or nothing if none is pressed within this time.
  std::optional<char> wait(std::chrono::milliseconds timeout);
  bool is_terminal() const { return open_; }

 private:
  std::optional<char> next();

  bool open_ = false, ended_ = false;
};

/// [control, first of all] Where a program is started with standard streams closed, the next file that it
/// opens takes their place, and its bytes would be read as keys: they are opened on /dev/null then.
void open_standard_streams();

/// Columns of the terminal at standard error; 0 if it is none.
int terminal_columns();

}  // namespace tactus::app
