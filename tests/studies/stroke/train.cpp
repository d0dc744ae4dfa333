#include "tests/studies/stroke/train.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <string>

#include "tests/studies/onset/random.h"

namespace tactus::study {
namespace {

constexpr int kBands = TACTUS_STROKE_BANDS, kFeatures = TACTUS_STROKE_FEATURES, kAges = TACTUS_STROKE_AGES,
              kHidden = TACTUS_STROKE_HIDDEN, kJoint = TACTUS_STROKE_JOINT / 8;

/// Eight numbers: of the bands, or of units of the joint layer.
#pragma GCC diagnostic ignored "-Wpsabi"  // no other file calls a function with an Eight
typedef float Eight __attribute__((vector_size(32)));
static_assert(kBands == 8 && TACTUS_STROKE_JOINT % 8 == 0);

Eight load(const float* in) {
  Eight out;
  __builtin_memcpy(&out, in, sizeof out);
  return out;
}

float sum(Eight x) { return ((x[0] + x[4]) + (x[1] + x[5])) + ((x[2] + x[6]) + (x[3] + x[7])); }

Eight bent(Eight x) { return x > 0 ? x : 0.05f * x; }
Eight slope(Eight bent) { return bent > 0 ? Eight{} + 1.0f : Eight{} + 0.05f; }

/// The weights of tactus_stroke_net; or their gradient.
struct Net {
  Eight band_bias[kHidden]{}, joint[kBands * kHidden][kJoint]{}, age[kAges][kJoint]{};
  Eight joint_bias[kJoint]{}, last[kJoint]{}, last_bias{};
  Eight band[kFeatures * kHidden]{};  ///< the same number eight times; in a gradient: of each band
};
constexpr int kVectors = sizeof(Net) / sizeof(Eight);

/// The weights of the joint layer, by unit: each vector of the eight bands.
struct ByUnit {
  Eight weights[kJoint * 8][kHidden];

  explicit ByUnit(const Net& net) {
    for (int unit = 0; unit < kJoint * 8; ++unit)
      for (int j = 0; j < kHidden; ++j)
        for (int b = 0; b < kBands; ++b) weights[unit][j][b] = net.joint[b * kHidden + j][unit / 8][unit % 8];
  }
};

struct Pass {
  Eight hidden[kHidden], joint[kJoint];
  float log_odds;
};

Pass forward(const Net& net, const Example& example) {
  Pass pass;
  for (int j = 0; j < kHidden; ++j) pass.hidden[j] = net.band_bias[j];
  for (int i = 0; i < kFeatures; ++i) {
    const Eight x = load(example.levels[i]);
    for (int j = 0; j < kHidden; ++j) pass.hidden[j] += x * net.band[i * kHidden + j];
  }
  for (Eight& hidden : pass.hidden) hidden = bent(hidden);
  Eight joint[2][kJoint]{}, last{};
  for (int b = 0; b < kBands; ++b)
    for (int j = 0; j < kHidden; ++j)
      for (int m = 0; m < kJoint; ++m) joint[b % 2][m] += pass.hidden[j][b] * net.joint[b * kHidden + j][m];
  for (int m = 0; m < kJoint; ++m) {
    for (int i = 0; i < kAges; ++i) joint[0][m] += example.after[i] * net.age[i][m];
    pass.joint[m] = bent(joint[0][m] + joint[1][m] + net.joint_bias[m]);
    last += pass.joint[m] * net.last[m];
  }
  pass.log_odds = sum(last) + net.last_bias[0];
  return pass;
}

void add_gradient(const Net& net, const ByUnit& by_unit, const Example& example, Net& to) {
  const Pass pass = forward(net, example);
  const float error = example.weight * (1 / (1 + std::exp(-pass.log_odds)) - example.stroke);
  to.last_bias[0] += error;
  Eight joint[kJoint], hidden[kHidden]{};
  for (int m = 0; m < kJoint; ++m) {
    to.last[m] += error * pass.joint[m];
    joint[m] = error * net.last[m] * slope(pass.joint[m]);
    to.joint_bias[m] += joint[m];
    for (int i = 0; i < kAges; ++i) to.age[i][m] += example.after[i] * joint[m];
  }
  for (int b = 0; b < kBands; ++b)
    for (int j = 0; j < kHidden; ++j)
      for (int m = 0; m < kJoint; ++m) to.joint[b * kHidden + j][m] += pass.hidden[j][b] * joint[m];
  for (int unit = 0; unit < kJoint * 8; ++unit)
    for (int j = 0; j < kHidden; ++j) hidden[j] += joint[unit / 8][unit % 8] * by_unit.weights[unit][j];
  for (int j = 0; j < kHidden; ++j) {
    hidden[j] *= slope(pass.hidden[j]);
    to.band_bias[j] += hidden[j];
  }
  for (int i = 0; i < kFeatures; ++i) {
    const Eight x = load(example.levels[i]);
    for (int j = 0; j < kHidden; ++j) to.band[i * kHidden + j] += x * hidden[j];
  }
}

/// Numbers of a net of the engine to or from those of a Net, both in its order.
template <class Numbers, class Copy>
void each_number(Numbers& net, const Copy& copy) {
  for (int j = 0; j < kHidden; ++j) copy(net.band_bias[j], kBands);
  for (auto& weights : net.joint) copy(weights, kJoint * 8);
  for (auto& weights : net.age) copy(weights, kJoint * 8);
  copy(net.joint_bias, kJoint * 8);
  copy(net.last, kJoint * 8);
}

Net of_engine(const tactus_stroke_net& from) {
  Net net;
  auto* to = reinterpret_cast<float*>(&net);
  each_number(from, [&](const double* numbers, int count) {
    for (int i = 0; i < count; ++i) *to++ = static_cast<float>(numbers[i]);
  });
  net.last_bias[0] = static_cast<float>(from.last_bias);
  for (int i = 0; i < kFeatures; ++i)
    for (int j = 0; j < kHidden; ++j)
      net.band[i * kHidden + j] = Eight{} + static_cast<float>(from.band[i][j]);
  return net;
}

tactus_stroke_net for_engine(const Net& net, const tactus_stroke_net& like) {
  tactus_stroke_net out = like;
  const auto* from = reinterpret_cast<const float*>(&net);
  each_number(out, [&](double* numbers, int count) {
    for (int i = 0; i < count; ++i) numbers[i] = static_cast<double>(*from++);
  });
  out.last_bias = static_cast<double>(net.last_bias[0]);
  for (int i = 0; i < kFeatures; ++i)
    for (int j = 0; j < kHidden; ++j) out.band[i][j] = static_cast<double>(net.band[i * kHidden + j][0]);
  return out;
}

/// The mean gradient of a batch of the examples that `order` names.
Net gradient_of(const Net& net, const std::vector<Example>& examples, const std::uint32_t* order, int batch) {
  const ByUnit by_unit(net);
  Net gradient;
  for (int n = 0; n < batch; ++n) add_gradient(net, by_unit, examples[order[n]], gradient);
  for (Eight& weight : gradient.band) weight = Eight{} + sum(weight);
  auto* numbers = reinterpret_cast<Eight*>(&gradient);
  for (int k = 0; k < kVectors; ++k) numbers[k] /= static_cast<float>(batch);
  return gradient;
}

/// Adam (Kingma & Ba, 2015).
struct Adam {
  Net mean, square;
  double steps = 0;

  void step(Net& net, const Net& gradient, double rate) {
    steps += 1;
    rate *= std::sqrt(1 - std::pow(0.999, steps)) / (1 - std::pow(0.9, steps));
    auto* to = reinterpret_cast<Eight*>(&net);
    const auto* now = reinterpret_cast<const Eight*>(&gradient);
    auto *first = reinterpret_cast<Eight*>(&mean), *second = reinterpret_cast<Eight*>(&square);
    for (int k = 0; k < kVectors; ++k) {
      first[k] += 0.1f * (now[k] - first[k]);
      second[k] += 0.001f * (now[k] * now[k] - second[k]);
      for (int m = 0; m < 8; ++m)
        to[k][m] -= static_cast<float>(rate) * first[k][m] / (std::sqrt(second[k][m]) + 1e-8f);
    }
  }
};

}  // namespace

tactus_stroke_net first_net(int lookahead, int seed) {
  Random random("first net " + std::to_string(seed));
  const auto draw = [&](double* weights, std::size_t count, int inputs) {
    for (std::size_t i = 0; i < count; ++i) weights[i] = std::sqrt(2.0 / inputs) * random.normal();
  };
  tactus_stroke_net net{};
  net.lookahead = lookahead;
  draw(net.band[0], sizeof net.band / sizeof(double), kFeatures);
  draw(net.joint[0], sizeof net.joint / sizeof(double), kBands * kHidden);
  draw(net.last, TACTUS_STROKE_JOINT, TACTUS_STROKE_JOINT);
  net.last_bias = -2;
  return net;
}

tactus_stroke_net train(const tactus_stroke_net& from, const std::vector<Example>& examples, int epochs,
                        double rate) {
  constexpr int batch = 2048;
  Random random("order");
  Net net = of_engine(from);
  Adam adam;
  std::vector<std::uint32_t> order(examples.size());
  std::iota(order.begin(), order.end(), 0u);
  const int batches = static_cast<int>(examples.size()) / batch;
  for (int epoch = 0; epoch < epochs; ++epoch) {
    for (std::size_t n = order.size(); n > 1; --n) std::swap(order[n - 1], order[random.below(n)]);
    for (int k = 0; k < batches; ++k) {
      const double done = (epoch * batches + k + 1.0) / (epochs * batches);
      adam.step(net, gradient_of(net, examples, &order[static_cast<std::size_t>(k * batch)], batch),
                rate * (1 + std::cos(std::numbers::pi * done)) / 2);
    }
  }
  return for_engine(net, from);
}

}  // namespace tactus::study
