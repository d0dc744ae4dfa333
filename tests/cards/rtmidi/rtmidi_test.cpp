#include <catch2/catch.hpp>
#include <filesystem>

#include "backends/midi.h"
#include "tests/support/skip.h"
#include "tests/support/wait_until.h"

// What RtMidi reports where there is no MIDI; with ports: tests/cards/alsa/alsa_midi_test.cpp.

using namespace tactus;

namespace {

std::string first_news(const std::string& api) {
  const auto inputs = make_rtmidi(api);
  std::vector<std::string> news;
  REQUIRE(test::wait_until([&] {
    for (auto& text : inputs->news()) news.push_back(text);
    return !news.empty();
  }));
  return news.front();
}

}  // namespace

TEST_CASE("rtmidi: an API that is not there is reported, and JACK's is left to the stream", "[cards]") {
  CHECK(first_news("telegraph") == "no MIDI: this program was built without the MIDI backend 'telegraph'");
  CHECK(first_news("jack") == "no MIDI: this program was built without the MIDI backend 'jack'");
}

TEST_CASE("rtmidi: where the kernel has no sequencer, the command that loads it is printed", "[cards]") {
  if (std::filesystem::exists("/dev/snd/seq")) test::skip("the sequencer is loaded on this machine");
  CHECK(first_news("alsa") ==
        "no MIDI: the kernel's MIDI sequencer is not loaded; load it with: sudo modprobe snd-seq");
}
