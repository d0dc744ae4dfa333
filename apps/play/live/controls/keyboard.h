#pragma once
// Thread: [control]

#include <chrono>
#include <memory>
#include <optional>

namespace tactus::app {

/// A key that was pressed.
struct Key {
  enum class Kind { Character, Up, Down, Left, Right, Enter, Escape };
  Kind kind = Kind::Character;
  char character = 0;

  bool operator==(const Key&) const = default;
};

/// The keys of standard input, each as soon as it is pressed: a terminal is switched to bring them without
/// Enter and without showing them, and back at the end. Anything else is read as it is; where it ends, no key
/// comes any more.
class Keyboard {
 public:
  Keyboard();
  ~Keyboard();
  Keyboard(const Keyboard&) = delete;
  Keyboard& operator=(const Keyboard&) = delete;

  /// [control] The next key, or nothing if none is pressed for so long.
  std::optional<Key> wait(std::chrono::milliseconds patience);
  /// A person may be sitting there.
  bool is_terminal() const;

 private:
  struct Terminal;
  std::unique_ptr<Terminal> terminal_;
};

/// [control, first of all] Where a program is started with standard streams closed, the next file that it
/// opens takes their place, and its bytes would be read as keys: they lead nowhere then.
void open_standard_streams();

/// Columns of the terminal at standard error; 0 if it is none.
int terminal_columns();

}  // namespace tactus::app
