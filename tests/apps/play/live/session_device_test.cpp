#include <catch2/catch.hpp>

#include "apps/play/live/session.h"
#include "engine/core/channels.h"
#include "tests/support/error_summary.h"
#include "tests/support/fake_backend.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/wait_until.h"

// A session on a device that fails on request; the test brings the blocks.

using namespace tactus;
using namespace tactus::app;

namespace {

std::string tone(const std::string& level, const std::string& frequency = "100 Hz") {
  return R"(format = 1
name = "tone"
[controls]
level = { value = )" +
         level + R"(, range = [0, 1] }
[nodes]
wave = { type = "sine", frequency = ")" +
         frequency + R"(" }
[outputs]
shaker = { from = "level * wave" }
)";
}

/// Beside a tone, a loop of 5 ms that grows by half each time.
constexpr const char* kToneAndFeedback = R"(format = 1
name = "tone and feedback"
[nodes]
wave = { type = "sine", level = 0.4, frequency = "100 Hz" }
kick = { type = "sine", level = 0.01, frequency = "100 Hz" }
x = "kick + 1.5 * echo"
echo = { type = "delay", in = "x", time = "5 ms" }
[outputs]
shaker = { from = "wave" }
woofer = { from = "x" }
)";

bool has(const std::vector<std::string>& messages, const std::string& text) {
  return std::ranges::any_of(messages,
                             [&](const auto& line) { return line.find(text) != std::string::npos; });
}

struct Fixture {
  explicit Fixture(bool armed = true, const std::string& graph = tone("0.4"), int outputs_ = 1)
      : outputs(outputs_) {
    const auto file = folder.write("tone.toml", graph);
    performer = make_instrument({resolve_target(file.string())});
    StreamRequest request;
    request.out_channels = outputs;
    session = std::make_unique<Session>(*performer, backend, request, armed);
  }
  ~Fixture() { world.state = StreamState::Stopped; }  // nothing fades: no block comes any more
  void start() {
    REQUIRE(session->open({}));
    session->set_delay(delay);
    REQUIRE(session->start());
  }
  /// The highest sample of the last 0.1 s of a second: the soft start, or a fade, is over by then.
  double level(int output = 0) {
    ChannelBuffers out{outputs, 64};
    double highest = 0;
    for (int frame = 0; frame < 48000; frame += 64) {
      backend.guarded->process({nullptr, out.data(), 64});
      if (frame > 43200)
        for (int n = 0; n < 64; ++n) highest = std::max(highest, std::abs(out[output][n]));
    }
    return highest;
  }
  /// The file is edited, and taken over while blocks are processed.
  void edit(const std::string& graph) {
    folder.write("tone.toml", graph);
    REQUIRE(test::wait_until([&] {
      level();
      return has(tick(), "edit applied");
    }));
  }
  /// As when a was pressed twice.
  Status arm() {
    session->switches().order_arm();
    return session->arm(true);
  }
  std::vector<std::string> tick() {
    session->tick();
    return session->take_messages();
  }
  /// The device is lost, and back as soon as it is tried again.
  std::vector<std::string> lose(const std::function<void()>& change = [] {}) {
    world.state = StreamState::Lost;
    auto messages = tick();
    change();
    for (auto& message : tick()) messages.push_back(std::move(message));
    REQUIRE(session->view().state == StreamState::Running);
    return messages;
  }
  int takes() const {
    int count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
      count += entry.path().extension() == ".wav";
    return count;
  }

  int outputs;
  test::TemporaryFolder folder;
  test::FakeWorld world;
  test::FakeBackend backend{world};
  std::optional<DelaySettings> delay;
  std::unique_ptr<Performer> performer;
  std::unique_ptr<Session> session;
};

}  // namespace

TEST_CASE("session: the same device comes back armed, with the controls where the user left them", "[live]") {
  Fixture f;
  f.start();
  CHECK(f.level() == Approx(0.4).epsilon(1e-3));
  REQUIRE(f.session->controls().turn("level", 0.05));
  f.tick();
  CHECK(f.level() == Approx(0.05).epsilon(1e-3));
  f.lose();
  CHECK(f.session->armed());
  CHECK(f.session->controls().text(0) == "level = 0.05");
  CHECK(f.level() == Approx(0.05).epsilon(1e-3));
}

TEST_CASE("session: an edit moves a control only where its value changed, in the engine and on the screen",
          "[live]") {
  Fixture f;
  f.start();
  REQUIRE(f.session->controls().turn("level", 0.05));
  f.tick();
  CHECK(f.level() == Approx(0.05).epsilon(1e-3));
  f.edit(tone("0.2"));
  CHECK(f.session->controls().text(0) == "level = 0.2");
  CHECK(f.level() == Approx(0.2).epsilon(1e-3));
  REQUIRE(f.session->controls().turn("level", 0.1));
  f.tick();
  f.edit(tone("0.2", "120 Hz"));
  CHECK(f.session->controls().text(0) == "level = 0.1");
  CHECK(f.level() == Approx(0.1).epsilon(1e-3));
}

TEST_CASE("session: feedback of one drive disarms the others too", "[live]") {
  Fixture f{true, kToneAndFeedback, 2};
  f.start();
  CHECK(f.level(1) == 0.0);  // faded within the second
  CHECK(has(f.tick(), "woofer: feedback at"));
  CHECK_FALSE(f.session->armed());
  f.tick();
  CHECK(f.level(0) == 0.0);
}

TEST_CASE("session: a device that comes back otherwise is disarmed, and says why", "[live]") {
  Fixture f;
  f.world.output = {"1-2:1.0", 2, {}, false};
  f.start();
  CHECK(f.level() > 0.3);
  const auto messages = f.lose([&] { f.world.output.hardware = "1-3:1.0"; });
  CHECK(has(messages, "'1-3:1.0' instead of '1-2:1.0'"));
  CHECK(messages.back().starts_with("drives disarmed"));
  CHECK_FALSE(f.session->armed());
  CHECK(f.level() == 0.0);
  CHECK(f.arm());
  CHECK(f.level() > 0.3);
}

TEST_CASE("session: another block size disarms, and makes a measured delay unknown", "[live]") {
  Fixture f;
  f.delay = DelaySettings{64, {}, false};
  f.start();
  const bool running = GENERATE(true, false);
  if (running) f.world.block_now = 128;
  const auto messages = running ? f.tick() : f.lose([&] { f.world.block = 128; });
  CHECK_FALSE(f.session->armed());
  CHECK(has(messages, "measured with 64 frames per block, but the block size is 128"));
  CHECK(f.level() == 0.0);
  CHECK(f.arm());
}

TEST_CASE("session: a drive whose padding is unknown for the new block size cannot be armed", "[live]") {
  Fixture f;
  f.delay = DelaySettings{64, {}, true};
  f.start();
  f.lose([&] { f.world.block = 128; });
  const auto refused = f.arm();
  REQUIRE_FALSE(refused);
  CHECK(test::summary(refused) == "BadArgument 64 128");
  f.lose([&] { f.world.block = 64; });
  CHECK(f.arm());
}

TEST_CASE("session: no drive is armed at a port that another program writes to", "[live]") {
  Fixture f;
  f.world.writers = {{0, "player:out_1", "card:playback_1"}};
  f.start();
  CHECK(f.level() == 0.0);
  CHECK_FALSE(f.session->armed());
  CHECK(has(f.tick(), "'player:out_1' also writes to 'card:playback_1'"));
  const auto refused = f.arm();
  REQUIRE_FALSE(refused);
  CHECK(test::summary(refused) == "Device 'player:out_1' 'card:playback_1' --shared-port");
  f.world.writers.clear();
  f.tick();
  CHECK(f.arm());
  CHECK(f.level() > 0.3);
}

TEST_CASE("session: a program that connects to an armed drive's port disarms it, unless ports are shared",
          "[live]") {
  const bool shared = GENERATE(false, true);
  Fixture f;
  f.session->share_ports(shared);
  f.start();
  f.world.writers = {{0, "player:out_1", "card:playback_1"}};
  const auto messages = f.tick();
  CHECK(has(messages, "'player:out_1' also writes to 'card:playback_1'"));
  CHECK(f.tick().empty());  // said once
  CHECK(f.session->armed() == shared);
  CHECK((f.level() > 0.3) == shared);
}

TEST_CASE("session: starts that fail leave no take behind", "[live]") {
  Fixture f;
  f.world.starts = false;
  REQUIRE(f.session->open(f.folder.path() / "take.wav"));
  CHECK_FALSE(f.session->start());
  CHECK(f.takes() == 0);
  f.world.starts = true;
  REQUIRE(f.session->start());
  CHECK(f.takes() == 1);
  f.level();
  f.world.starts = false;
  f.world.state = StreamState::Lost;
  CHECK(test::wait_until([&] {
    f.tick();
    return f.world.tried >= 4;
  }));
  CHECK(f.takes() == 1);
  f.world.starts = true;
  CHECK(test::wait_until([&] {
    f.tick();
    return f.session->view().state == StreamState::Running;
  }));
  CHECK(f.takes() == 2);
  CHECK(f.session->takes().size() == 2);
}

TEST_CASE("session: a take that cannot be written stops the start, and nothing sounds", "[live]") {
  Fixture f;
  f.folder.write("take.jsonl", "");
  REQUIRE(f.session->open(f.folder.path() / "take.wav"));
  const auto started = f.session->start();
  REQUIRE_FALSE(started);
  CHECK(started.error().code == Errc::BadFile);
  CHECK(f.world.state == StreamState::Stopped);
  CHECK(f.level() == 0.0);
}
