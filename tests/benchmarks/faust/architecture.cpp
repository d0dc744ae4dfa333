// What Faust writes, as one more peer of the benchmarks. TACTUS_WORK and TACTUS_BUILD name it.
#include <math.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "tests/benchmarks/faust_build.h"

#define FAUSTFLOAT float

// Every build has its own class of the same name.
namespace {

struct Meta {
  void declare(const char*, const char*) {}
};
struct UI {
  template <class... Arguments>
  void addHorizontalSlider(const char*, float* zone, float start, Arguments...) {
    *zone = start;
  }
  void openVerticalBox(const char*) {}
  void closeBox() {}
  void declare(...) {}
};
struct dsp {
  virtual ~dsp() = default;
};

<< includeIntrinsic >> << includeclass >>

    class Built : public tactus::bench::FaustBuild {
 public:
  Built() : FaustBuild(TACTUS_WORK, TACTUS_BUILD) { dsp_.init(48000); }
  void clear() override { dsp_.instanceClear(); }
  void compute(int frames, float** in, float** out) override { dsp_.compute(frames, in, out); }

 private:
  mydsp dsp_;
};

Built built;

}  // namespace
