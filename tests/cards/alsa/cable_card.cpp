#include "tests/cards/alsa/cable_card.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cstdlib>

#include "tests/support/skip.h"

namespace tactus::test {
namespace {

void run_card(const std::string& what, int number) {
  const auto command = fmt::format("{}/scripts/vm/card {} {}", TACTUS_SOURCE_DIR, what, number);
  CAPTURE(command);
  REQUIRE(std::system(command.c_str()) == 0);
}

}  // namespace

CableCard::CableCard(int number) : number_(number), name_(number == 1 ? "CableA" : "CableB") {
  if (std::getenv("TACTUS_VM") == nullptr)
    skip("real ALSA cards need the virtual machine: scripts/test_cards");
  plug();
}

CableCard::~CableCard() {
  const auto command = fmt::format("{}/scripts/vm/card plug {}", TACTUS_SOURCE_DIR, number_);
  static_cast<void>(std::system(command.c_str()));
}

void CableCard::plug() const { run_card("plug", number_); }
void CableCard::pull() const { run_card("pull", number_); }

std::optional<Device> CableCard::side(Backend& backend, int device) const {
  const auto devices = backend.devices();
  REQUIRE(devices);
  const auto place = fmt::format("hw:{},{}", name_, device);
  for (const auto& one : *devices)
    if (one.id.find(place) != std::string::npos) return one;
  return std::nullopt;
}

StreamRequest CableCard::request(Backend& backend, double rate, int block, int channels) const {
  const auto output = output_of(backend), input = input_of(backend);
  REQUIRE(output);
  REQUIRE(input);
  StreamRequest request;
  request.device = output->id;
  request.input_device = input->id;
  request.sample_rate = Hertz{rate};
  request.block_frames = block;
  request.in_channels = request.out_channels = channels;
  return request;
}

std::vector<Way> alsa_ways() {
  std::vector<Way> ways;
  for (const auto& backend : sound_backends())
    if (backend.name != "jack") ways.push_back({backend.name + ":alsa", backend.make, true});
  return ways;
}

}  // namespace tactus::test
