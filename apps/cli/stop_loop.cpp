#include "apps/cli/stop_loop.h"

#include <algorithm>
#include <utility>

#include "apps/cli/console.h"

namespace tactus::app {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kTurn{20};
constexpr int kStalledTurns = 25;          // 0.5 s, as of the dead man's switch
constexpr std::chrono::seconds kGrace{1};  // for what follows the fade: the end of a take, the report

}  // namespace

StopLoop::StopLoop(DeadMansSwitch& dead_man, Settings settings)
    : dead_man_(dead_man), settings_(std::move(settings)), thread_([this] { run(); }) {}

StopLoop::~StopLoop() {
  done_ = true;
  thread_.join();
}

void StopLoop::run() {
  while (!done_) turn();
}

void StopLoop::turn() {
  dead_man_.refresh();
  const auto arrived = inputs_.wait(kTurn);
  const auto now = Clock::now();
  if (ending() != Ending::None) stops_ += arrived.stops;
  if (settings_.each_turn) settings_.each_turn(now);
  if (arrived.stops > 0 || arrived.hung_up) end(Ending::Interrupted);
  input_closed_ |= arrived.input_closed;
  if (input_closed_ && settings_.needs_input && settings_.needs_input()) end(Ending::InputClosed);
  for (const char byte : arrived.bytes)
    handle_key(decoder_.decode(static_cast<unsigned char>(byte), now), now);
  if (std::ranges::any_of(settings_.inputs, [](const auto& input) { return input(); }))
    end(Ending::Interrupted);
  watch_control();
  exit_if_hung(now);
}

void StopLoop::watch_control() {
  const auto waits = control_waits_.load();
  const bool waited = waits != std::exchange(seen_waits_, waits);
  stalled_turns_ = waited || waits == 0 ? 0 : std::min(stalled_turns_ + 1, kStalledTurns + 1);
  if (stalled_turns_ == kStalledTurns && settings_.control_stalled) settings_.control_stalled();
}

void StopLoop::end(Ending ending) {
  if (this->ending() != Ending::None) return;
  dead_man_.stop();
  ended_at_ = Clock::now();
  ending_ = ending;
}

void StopLoop::handle_key(Key key, Clock::time_point now) {
  if (key == 'q') return end(Ending::Quit);
  if (key == kStopKey) return end(Ending::Interrupted);
  pass(settings_.act ? settings_.act(key, now) : key);
}

void StopLoop::pass(Key key) {
  if (key != kNoKey) (void)keys_.push(key);
}

void StopLoop::exit_if_hung(Clock::time_point now) {
  if (stops_ == 0) return;
  const std::chrono::duration<double> fade{settings_.fade.value};
  if (now - ended_at_ > kGrace + fade) inputs_.exit_now(kInterrupted);
}

std::optional<Key> StopLoop::wait_key(milliseconds timeout) {
  const auto deadline = Clock::now() + timeout;
  Key key = kNoKey;
  ++control_waits_;
  while (!keys_.pop(key)) {
    if (ending() != Ending::None || Clock::now() >= deadline) return std::nullopt;
    std::this_thread::sleep_for(milliseconds{2});
  }
  return key;
}

}  // namespace tactus::app
