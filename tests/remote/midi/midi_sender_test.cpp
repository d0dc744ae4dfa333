#include "remote/midi/midi_sender.h"

#include <catch2/catch.hpp>
#include <mutex>

#include "tests/remote/fake_remote_target.h"
#include "tests/support/wait_until.h"

using namespace tactus;

namespace {

struct Cable {
  std::mutex mutex;
  std::vector<std::vector<std::uint8_t>> sent;
  std::vector<std::string> reports;
  std::size_t count() {
    const std::lock_guard lock{mutex};
    return sent.size();
  }
};

class Output final : public MidiOutput {
 public:
  explicit Output(Cable& cable) : cable_(cable) {}
  const std::string& name() const override { return name_; }
  void send(std::span<const std::uint8_t> bytes) override {
    const std::lock_guard lock{cable_.mutex};
    cable_.sent.emplace_back(bytes.begin(), bytes.end());
  }
  std::optional<std::string> look() override { return "looked"; }

 private:
  Cable& cable_;
  std::string name_ = "fake";
};

/// Events come on another thread.
class Target final : public test::FakeRemoteTarget {
 public:
  explicit Target(Cable& cable) : cable_(cable) {
    RemoteEvent event{.kind = RemoteEvent::Kind::Trigger, .level = 1.0};
    std::string{"hit"}.copy(event.text, sizeof event.text - 1);
    events.push_back(event);
  }
  void report(std::string text) override {
    const std::lock_guard lock{cable_.mutex};
    cable_.reports.push_back(std::move(text));
  }

 private:
  Cable& cable_;
};

}  // namespace

TEST_CASE("midi sender: sends what happens, and ends its notes when it ends", "[remote]") {
  Cable cable;
  Target target{cable};
  target.describe({{"strength", ""}}, {"hit"});
  {
    const auto sender = MidiSender::start(std::make_unique<Output>(cable),
                                          {{.name = "hit", .at = {}, .number = 38, .length = 10_s}}, target);
    REQUIRE(sender);
    REQUIRE(test::wait_until([&] { return cable.count() == 1; }));
    REQUIRE(test::wait_until([&] {
      const std::lock_guard lock{cable.mutex};
      return !cable.reports.empty();
    }));
    CHECK((*sender)->sent() == 1);
  }
  REQUIRE(cable.sent.size() == 2);
  CHECK(cable.sent[0] == std::vector<std::uint8_t>{0x90, 38, 127});
  CHECK(cable.sent[1] == std::vector<std::uint8_t>{0x80, 38, 0});
}

TEST_CASE("midi sender: a message of something that does not exist is an error", "[remote]") {
  Cable cable;
  Target target{cable};
  const auto sender = MidiSender::start(std::make_unique<Output>(cable), {{.name = "hat", .at = {}}}, target);
  REQUIRE_FALSE(sender);
  CHECK(sender.error().front().code == Errc::UnknownName);
}
