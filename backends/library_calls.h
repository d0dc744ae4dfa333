#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>

namespace tactus {

/// [control] Makes a call into a library that may never return, on a thread of its own, and waits for it.
/// False: it did not return within `patience` and is left to itself for good; `call` must own whatever it
/// touches.
bool call_with_timeout(std::function<void()> call,
                       std::chrono::milliseconds patience = std::chrono::milliseconds{2000});

/// [control] The same for a call that returns something. Nothing: it did not return in time.
template <class Call>
auto result_with_timeout(Call call) -> std::optional<decltype(call())> {
  const auto result = std::make_shared<std::optional<decltype(call())>>();
  if (!call_with_timeout([result, call] { *result = call(); })) return std::nullopt;
  return std::move(*result);
}

/// [any] JACK prints what also comes back as an error, and the libraries below RtAudio and PortAudio a line
/// for each device of their configuration that is not there, a hundred on a computer without a card. What
/// matters comes back as an Error; the rest is not printed any more.
void silence_library_logs();

}  // namespace tactus
