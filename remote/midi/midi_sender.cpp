#include "remote/midi/midi_sender.h"

#include <algorithm>
#include <utility>

namespace tactus {
namespace {

using namespace std::chrono_literals;
using Clock = MidiOutMap::Clock;

constexpr auto kTurn = 1ms, kLook = 500ms;

}  // namespace

Checked<std::unique_ptr<MidiSender>> MidiSender::start(std::unique_ptr<MidiOutput> output,
                                                       std::vector<RigMidiOut> bindings,
                                                       RemoteTarget& target) {
  std::unique_ptr<MidiSender> sender{new MidiSender{std::move(output), std::move(bindings), target}};
  if (auto errors = sender->map_.check(*target.description()); !errors.empty())
    return tl::unexpected(std::move(errors));
  sender->thread_ = std::thread{[raw = sender.get()] { raw->run(); }};
  return sender;
}

MidiSender::MidiSender(std::unique_ptr<MidiOutput> output, std::vector<RigMidiOut> bindings,
                       RemoteTarget& target)
    : output_(std::move(output)),
      target_(target),
      map_(std::move(bindings), [this](std::span<const std::uint8_t> bytes) {
        output_->send(bytes);
        sent_.fetch_add(1, std::memory_order_relaxed);
      }) {}

MidiSender::~MidiSender() {
  {
    const std::lock_guard lock{mutex_};
    stop_ = true;
  }
  wake_.notify_one();
  if (thread_.joinable()) thread_.join();
}

void MidiSender::run() {
  auto looked = Clock::now();
  std::unique_lock lock{mutex_};
  while (!stop_) {
    lock.unlock();
    const auto now = Clock::now();
    for (RemoteEvent event; target_.take_event(event);) map_.event(event, now);
    map_.tick(*target_.description(), now);
    if (now - looked >= kLook) {
      looked = now;
      if (auto news = output_->look()) target_.report(std::move(*news));
    }
    const auto due = map_.due();
    lock.lock();
    wake_.wait_until(lock, due ? std::min(*due, now + kTurn) : now + kTurn, [this] { return stop_; });
  }
  map_.stop();
}

}  // namespace tactus
