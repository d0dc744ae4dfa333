#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace tactus {

/// How long a call into a library may take.
inline constexpr std::chrono::milliseconds kPatience{2000};
/// [control] How long it may take to list devices: ALSA opens each device of its configuration, some for
/// seconds. It may be changed before any call.
std::chrono::milliseconds& listing_patience();

/// [control] Makes a call into a library that may never return, on a thread of its own, and waits for it.
/// False: it did not return within `patience` and is left to itself for good; `call` must own whatever it
/// touches. `slow`: a message that is reported after two seconds; empty: none.
bool call_with_timeout(std::function<void()> call, std::chrono::milliseconds patience = kPatience,
                       const std::string& slow = {});

/// [control] The same for a call that returns something. Nothing: it did not return in time.
template <class Call>
auto result_with_timeout(Call call, std::chrono::milliseconds patience = kPatience,
                         const std::string& slow = {}) -> std::optional<decltype(call())> {
  const auto result = std::make_shared<std::optional<decltype(call())>>();
  if (!call_with_timeout([result, call] { *result = call(); }, patience, slow)) return std::nullopt;
  return std::move(*result);
}

/// [control, before any call] Who reports the messages of slow calls to the user; without one nobody does.
void on_slow_call(std::function<void(const std::string&)> report);

/// [any] After how long without a block a stream over this API ("alsa", "core") counts as lost; nothing: it
/// may go on at any time, because a sound server answers for it. ALSA's plugins wait for ever when their
/// server is gone, and CoreAudio and WASAPI report no error when a card is unplugged.
std::optional<std::chrono::milliseconds> silence_until_lost(const std::string& api);

/// [any] JACK prints what also comes back as an error, and the libraries below RtAudio and PortAudio a line
/// for each device of their configuration that is not there, a hundred on a computer without a card. What
/// matters comes back as an Error; the rest is not printed any more.
void silence_library_logs();

}  // namespace tactus
