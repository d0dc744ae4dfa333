#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <thread>
#include <vector>

namespace tactus::test {

using Bytes = std::vector<std::uint8_t>;

/// What the user-space side of a HID device does. All three are called from threads of the gadget.
struct HidFunctions {
  Bytes report_descriptor;
  /// A report of the host, its identifier first: of the output endpoint, or of the control pipe.
  std::function<void(const Bytes&)> take;
  /// The feature report that the host asks for; empty: there is none, and the request is stalled.
  std::function<Bytes(std::uint8_t identifier)> give;
};

/// A full-speed USB device of the HID class: this program answers its requests through FunctionFS, and the
/// kernel's dummy_hcd connects it to this machine. It exchanges one report a millisecond in each direction.
class HidGadget {
 public:
  /// Skips the test case where the kernel lacks what it needs, and says what. The name is that of its maker
  /// and product.
  HidGadget(const std::string& maker, const std::string& product, HidFunctions functions);
  ~HidGadget();
  HidGadget(const HidGadget&) = delete;
  HidGadget& operator=(const HidGadget&) = delete;

  void plug();
  void unplug();
  /// Returns when the host has fetched the input report, which it does while a program has the device open.
  void send(const Bytes& report) const;

 private:
  void make(const std::string& maker, const std::string& product) const;
  void describe() const;
  void answer_requests() const;
  void take_output_reports() const;

  HidFunctions functions_;
  int control_ = -1, in_ = -1, out_ = -1;
  std::atomic<bool> stop_{false};
  std::thread requests_, outputs_;
};

}  // namespace tactus::test
