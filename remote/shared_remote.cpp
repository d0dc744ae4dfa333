#include "remote/shared_remote.h"

#include <algorithm>
#include <utility>

namespace tactus {
namespace {

void raise(const std::vector<double>& before, std::vector<double>& now) {
  for (std::size_t i = 0; i < std::min(before.size(), now.size()); ++i) now[i] = std::max(now[i], before[i]);
}

}  // namespace

class SharedRemote::Share final : public RemoteTarget {
 public:
  explicit Share(SharedRemote& all) : all_(all) {
    const std::lock_guard lock{all_.mutex_};
    all_.shares_.push_back(this);
  }
  ~Share() override {
    const std::lock_guard lock{all_.mutex_};
    std::erase(all_.shares_, this);
    all_.watch_bodies();
  }

  std::shared_ptr<const RemoteDescription> description() const override { return all_.target_.description(); }
  bool post(std::span<const RemoteOrder> bundle) override {
    const std::lock_guard lock{all_.mutex_};
    return all_.target_.post(bundle);
  }
  void report(std::string text) override { all_.target_.report(std::move(text)); }
  bool learn_address(const std::string& address) override {
    const std::lock_guard lock{all_.mutex_};
    return all_.target_.learn_address(address);
  }
  bool learn_hid(const RigHid& source) override {
    const std::lock_guard lock{all_.mutex_};
    return all_.target_.learn_hid(source);
  }
  bool request(RemoteRequest request) override {
    const std::lock_guard lock{all_.mutex_};
    return all_.target_.request(std::move(request));
  }
  void disarm() noexcept override { all_.target_.disarm(); }
  void mute(bool on) noexcept override { all_.target_.mute(on); }
  bool armed() const noexcept override { return all_.target_.armed(); }
  bool muted() const noexcept override { return all_.target_.muted(); }
  int disarms() const noexcept override { return all_.target_.disarms(); }
  Result<int> order_arm() override {
    const std::lock_guard lock{all_.mutex_};
    return all_.target_.order_arm();
  }
  void keep_alive(int arming) noexcept override { all_.target_.keep_alive(arming); }

  RemoteMeters take_meters() override {
    const std::lock_guard lock{all_.mutex_};
    all_.collect_meters();
    return std::exchange(meters_, {});
  }
  bool take_event(RemoteEvent& event) override {
    const std::lock_guard lock{all_.mutex_};
    all_.collect_events();
    if (events_.empty()) return false;
    event = events_.front();
    events_.pop_front();
    return true;
  }
  std::int64_t late() const noexcept override { return all_.target_.late(); }

  std::shared_ptr<const RemoteState> state() const override { return all_.target_.state(); }
  std::shared_ptr<const RemoteEdit> edit() const override { return all_.target_.edit(); }
  std::shared_ptr<const RemoteScope> scope() const override { return all_.target_.scope(); }
  std::shared_ptr<const RemoteVerdict> verdict() const override { return all_.target_.verdict(); }
  void order_verdict(double delay_s) override { all_.target_.order_verdict(delay_s); }
  void order_scope(std::uint32_t id, int bin, std::vector<std::string> signals) override {
    const std::lock_guard lock{all_.mutex_};
    all_.target_.order_scope(id, bin, std::move(signals));
  }
  void order_levels(bool on) override { all_.target_.order_levels(on); }
  bool take_scope(ScopeChunk& chunk) override {
    const std::lock_guard lock{all_.mutex_};
    return all_.target_.take_scope(chunk);
  }

  void watch_bodies(RemoteWatch watch) override {
    const std::lock_guard lock{all_.mutex_};
    watch_ = watch;
    all_.watch_bodies();
  }
  std::shared_ptr<const RemoteBodies> bodies() const override { return all_.target_.bodies(); }
  RemoteWatch watch() const { return watch_; }

  void add(const RemoteEvent& event) {
    if (event.kind == RemoteEvent::Kind::Impact && !watch_.impacts) return;

    if (events_.size() >= kMostEvents) events_.pop_front();
    events_.push_back(event);
  }
  /// The levels are the highest since it took them last; everything else is as it is now.
  void add(const RemoteMeters& meters) {
    auto before = std::exchange(meters_, meters);
    raise(before.inputs, meters_.inputs);
    raise(before.outputs, meters_.outputs);
  }

 private:
  SharedRemote& all_;
  // Under its mutex.
  std::deque<RemoteEvent> events_;
  RemoteMeters meters_;
  RemoteWatch watch_;
};

std::unique_ptr<RemoteTarget> SharedRemote::share() { return std::make_unique<Share>(*this); }

void SharedRemote::collect_events() {
  for (RemoteEvent event; target_.take_event(event);)
    for (auto* share : shares_) share->add(event);
}

/// What any of them wants.
void SharedRemote::watch_bodies() {
  RemoteWatch all;
  for (const auto* share : shares_) {
    all.poses |= share->watch().poses;
    all.impacts |= share->watch().impacts;
  }
  target_.watch_bodies(all);
}

void SharedRemote::collect_meters() {
  const auto meters = target_.take_meters();
  for (auto* share : shares_) share->add(meters);
}

}  // namespace tactus
