#include "tests/studies/per_sample/stk_works.h"

#include <cmath>
#include <map>

#if defined(TACTUS_HAS_STK)
#include <BiQuad.h>
#include <BowTable.h>
#include <DelayL.h>
#include <OnePole.h>
#include <OneZero.h>
#include <ReedTable.h>

namespace tactus::bench {
namespace {

/// Two poles, as of a mass on a spring: 9 g, 200 N/m.
struct Spring final : StkWork {
  explicit Spring(double) { filter.setResonance(std::sqrt(200 / 0.009) / 6.2832, 0.9997, true); }
  double tick(double x) override { return filter.tick(x); }
  stk::BiQuad filter;
};

/// A difference below 300 Hz, then a linear table that is limited.
struct Wall final : StkWork {
  explicit Wall(double rate_hz) {
    difference.setCoefficients(rate_hz, -rate_hz);
    smooth.setPole(std::exp(-6.2832 * 300 / rate_hz));
    table.setOffset(0.0);
    table.setSlope(-400 / 6.37);
  }
  double tick(double x) override {
    const double v = smooth.tick(difference.tick(x));
    return x > 0 ? table.tick(x + v / 400) : 0.0;
  }
  stk::OneZero difference;
  stk::OnePole smooth;
  stk::ReedTable table;
};

struct Friction final : StkWork {
  explicit Friction(double rate_hz) {
    difference.setCoefficients(rate_hz, -rate_hz);
    table.setSlope(3.0);
  }
  double tick(double x) override {
    const double v = difference.tick(x);
    return -v * table.tick(v);
  }
  stk::OneZero difference;
  stk::BowTable table;
};

/// A delay with interpolation and a loop filter, as in STK's Plucked, with an input.
struct String final : StkWork {
  explicit String(double rate_hz) : delay(rate_hz / 220 - 0.5, 4095) {}
  double tick(double x) override { return delay.tick(x + filter.tick(0.99 * delay.lastOut())); }
  stk::DelayL delay;
  stk::OneZero filter;
};

}  // namespace

std::unique_ptr<StkWork> make_stk_work(const std::string& name, double rate_hz) {
  stk::Stk::setSampleRate(rate_hz);
  if (name == "spring on a mass") return std::make_unique<Spring>(rate_hz);
  if (name == "wall") return std::make_unique<Wall>(rate_hz);
  if (name == "friction") return std::make_unique<Friction>(rate_hz);
  return std::make_unique<String>(rate_hz);
}

std::string stk_classes(const std::string& name) {
  static const std::map<std::string, std::string> classes{{"spring on a mass", "BiQuad"},
                                                          {"wall", "OneZero, OnePole, ReedTable"},
                                                          {"friction", "OneZero, BowTable"},
                                                          {"string", "DelayL, OneZero"}};
  return classes.at(name);
}

}  // namespace tactus::bench
#else
namespace tactus::bench {

struct Nothing final : StkWork {
  double tick(double) override { return 0.0; }
};
std::unique_ptr<StkWork> make_stk_work(const std::string&, double) { return std::make_unique<Nothing>(); }
std::string stk_classes(const std::string&) { return "not installed"; }

}  // namespace tactus::bench
#endif
