#pragma once

#include <memory>
#include <string>

namespace tactus::bench {

/// A law of one input and one output, of the classes of the Synthesis Toolkit that come closest.
struct StkWork {
  virtual ~StkWork() = default;
  virtual double tick(double x) = 0;
};

/// By the name of the law.
std::unique_ptr<StkWork> make_stk_work(const std::string& name, double rate_hz);
/// Names of these classes; "not installed" without the library.
std::string stk_classes(const std::string& name);

}  // namespace tactus::bench
