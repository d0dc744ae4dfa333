#include <catch2/catch.hpp>

#include "engine/core/journal.h"
#include "engine/core/not_realtime.h"

using namespace tactus;

namespace {

JournalEntry entry(std::int64_t frame, int index) {
  return {frame, JournalEntry::Kind::ControlChange, index, 1.0};
}

struct Tap : JournalTap {
  void applied(const JournalEntry& applied) noexcept override {
    const NotRealtime allocates;
    entries.push_back(applied);
  }
  std::vector<JournalEntry> entries;
};

}  // namespace

TEST_CASE("control inbox: every entry is applied at its frame, and blocks are cut there", "[core]") {
  ControlInbox inbox;
  Tap tap;
  inbox.set_tap(&tap);
  inbox.set_journal({entry(0, 1), entry(5, 2)});
  REQUIRE(inbox.post(entry(3, 3)));
  std::vector<int> applied;
  const auto take = [&](std::int64_t now, std::int64_t frames) {
    return inbox.take_due(now, frames, [&](const JournalEntry& e) { applied.push_back(e.index); });
  };
  CHECK(take(0, 64) == 3);
  CHECK(applied == std::vector<int>{1});
  CHECK(take(3, 61) == 2);
  CHECK(take(5, 59) == 59);
  CHECK(applied == std::vector<int>{1, 3, 2});
  REQUIRE(tap.entries.size() == 3);
  CHECK(tap.entries[1] == entry(3, 3));
}

TEST_CASE("control inbox: after a restart entries for now still count, and those for a frame do not",
          "[core]") {
  ControlInbox inbox;
  Tap tap;
  inbox.set_tap(&tap);
  REQUIRE(inbox.post(entry(100'000, 1)));
  REQUIRE(inbox.post(entry(JournalEntry::kNow, 2)));
  const auto ignore = [](const JournalEntry&) {};
  CHECK(inbox.take_due(10, 64, ignore) == 64);
  CHECK(tap.entries.empty());  // behind one that waits for its frame
  inbox.restart();
  CHECK(inbox.take_due(0, 64, ignore) == 64);
  CHECK(tap.entries == std::vector{entry(0, 2)});
}

TEST_CASE("control inbox: an entry for now carries its true frame, and a restart repeats the journal only",
          "[core]") {
  ControlInbox inbox;
  Tap tap;
  inbox.set_tap(&tap);
  inbox.set_journal({entry(7, 1)});
  REQUIRE(inbox.post(entry(JournalEntry::kNow, 2)));
  const auto ignore = [](const JournalEntry&) {};
  CHECK(inbox.take_due(10, 64, ignore) == 64);
  inbox.restart();
  CHECK(inbox.take_due(0, 64, ignore) == 7);
  CHECK(inbox.take_due(7, 64, ignore) == 64);
  REQUIRE(tap.entries.size() == 3);
  CHECK(tap.entries[0] == entry(10, 1));
  CHECK(tap.entries[1] == entry(10, 2));
}
