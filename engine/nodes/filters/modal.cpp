#include "engine/dsp/resonators/modal_bank.h"
#include "engine/graph/plan/fingerprint.h"
#include "engine/nodes/declare.h"
#include "engine/nodes/filters/modal_setup.h"
#include "engine/nodes/process.h"

namespace tactus {
namespace {

class ModalNode final : public Node {
  enum Input { kIn, kFrequency, kDecay };

 public:
  /// `modes`: those of the table that may sound; rising.
  ModalNode(Hertz sample_rate, ModeTable table, std::vector<double> gains, std::vector<std::size_t> modes)
      : sample_rate_(sample_rate),
        table_(std::move(table)),
        gains_(std::move(gains)),
        modes_(std::move(modes)),
        bank_(static_cast<int>(modes_.size())) {}

  void process(const NodeBlock& block) noexcept override {
    const Signal in = block.in[kIn];
    std::array<double, kMaxSubBlock> before;
    before[0] = last_in_;
    for (int n = 1; n < block.frames; ++n) before[static_cast<std::size_t>(n)] = in[n - 1];
    last_in_ = in[block.frames - 1];
    run(block, before.data());
  }
  void emit(const NodeBlock& block) noexcept override { run(block, &last_in_); }
  void absorb(const NodeBlock& block) noexcept override { last_in_ = *block.in[kIn].data; }

  void reset() noexcept override {
    bank_.reset();
    steps_.reset();
    last_in_ = 0;
  }
  void copy(const Node& other) noexcept override { assign(*this, other); }

  void adopt(const Node& before) noexcept override {
    if (const auto* other = dynamic_cast<const ModalNode*>(&before)) {
      std::size_t from = 0;
      for (std::size_t to = 0; to < modes_.size(); ++to) {
        while (from < other->modes_.size() && other->modes_[from] < modes_[to]) ++from;
        if (from < other->modes_.size() && other->modes_[from] == modes_[to])
          bank_.adopt(static_cast<int>(to), other->bank_, static_cast<int>(from));
      }
      last_in_ = other->last_in_;
    }
  }

  DelayRange delay(int input, int) const override { return input == kIn ? DelayRange{1, 1} : DelayRange{}; }

  std::optional<std::complex<double>> response(int input, int, std::complex<double> z,
                                               std::span<const double> at) const override {
    if (input != kIn) return std::nullopt;
    const auto delay = 1.0 / z;
    std::complex<double> sum = 0;
    for (const auto k : modes_) sum += mode_response(designed(k, at[kFrequency], at[kDecay]), delay);
    return sum;
  }

  std::vector<LeftOut> left_out() const override {
    const auto all = table_.size(), silent = all - modes_.size();
    if (silent == 0) return {};
    return {{"modes", std::to_string(silent) + " of " + std::to_string(all) +
                          " are silent: of gain 0, or at half the sample rate or above"}};
  }

 private:
  tactus_mode designed(std::size_t mode, double frequency, double decay) const noexcept {
    return tactus_mode_design(table_.frequency_hz(mode, frequency), table_.decay_s(mode, decay), gains_[mode],
                              sample_rate_.value);
  }

  void tune(double frequency, double decay) noexcept {
    if (frequency == frequency_ && decay == decay_) return;
    frequency_ = frequency;
    decay_ = decay;
    for (std::size_t k = 0; k < modes_.size(); ++k)
      bank_.set(static_cast<int>(k), designed(modes_[k], frequency, decay));
  }

  void run(const NodeBlock& block, const double* in_before) noexcept {
    steps_.run(
        block, all_constant(block, kFrequency, 2),
        [&](int n) { tune(block.in[kFrequency][n], block.in[kDecay][n]); },
        [&](int from, int to, int) { bank_.run(in_before + from, block.out[0] + from, to - from); });
  }

  Hertz sample_rate_;
  ModeTable table_;
  std::vector<double> gains_;
  std::vector<std::size_t> modes_;
  ModalBank bank_;
  GroupSteps steps_;
  double frequency_ = -1, decay_ = -1;  ///< what the bank is tuned to; below 0: nothing yet
  double last_in_ = 0;
};

Result<std::unique_ptr<Node>> make_modal(const NodeSetup& setup) {
  auto modal = modal_setup(setup);
  if (!modal) return tl::unexpected(modal.error());
  if (const auto fits = setup.take_memory(8 * modal->table.size()); !fits)
    return tl::unexpected(fits.error());
  Fingerprint print;
  for (const auto k : modal->modes) print.add(std::uint64_t{k});
  if (modal->modes.size() < modal->table.size()) setup.variant = print.value();
  return std::make_unique<ModalNode>(setup.sample_rate, std::move(modal->table), std::move(modal->gains),
                                     std::move(modal->modes));
}

}  // namespace

Result<ModalSetup> modal_setup(const NodeSetup& setup) {
  auto table = ModeTable::make(setup);
  if (!table) return tl::unexpected(table.error());
  auto gains = one_each(setup.setting("gains"), "gains", table->size(), 1);
  if (!gains) return tl::unexpected(gains.error());
  const double slope = setup.setting("gain_slope").number;
  for (std::size_t k = 0; k < gains->size(); ++k) (*gains)[k] *= table->falling(k, slope);
  // Retuning changes no mode that is silent at the lowest frequency that may come.
  const auto frequency = static_cast<std::size_t>(setup.type->input_index("frequency"));
  const double lowest_hz = setup.inputs[frequency].constant.value_or(setup.inputs[frequency].range.low);
  std::vector<std::size_t> modes;
  for (std::size_t k = 0; k < table->size(); ++k)
    if ((*gains)[k] != 0 && table->frequency_hz(k, lowest_hz) < setup.sample_rate.value / 2)
      modes.push_back(k);
  return ModalSetup{std::move(*table), std::move(*gains), std::move(modes)};
}

NodeType modal_type() {
  return {
      .name = "modal",
      .summary = "A bank of resonators in parallel: rings like a body with these modes. It may close a loop.",
      .equation =
          "out = sum of y_k;  an impulse of 1 (one frame) gives y_k = gain_k e^(-6.91 t / decay_k) sin(2 "
          "pi f_k t)\n"
          "y_k[n] = 2 r cos(w) y_k[n-1] - r^2 y_k[n-2] + gain_k r sin(w) in[n-1],  w = 2 pi f_k / fs,  r "
          "= e^(-6.91 / (decay_k fs))\n"
          "A series: f_k = frequency ratio_k,  decay_k = decay (f_1 / f_k)^decay_slope,  gain_k times "
          "(f_1 / f_k)^gain_slope\n"
          "Modes at or above half the sample rate are silent, and left out if they always are. Retuned every "
          "eight frames, at a cost of about "
          "30 ns per mode",
      .source =
          "Rabiner & Gold, Theory and Application of Digital Signal Processing, 1975, section 4.5; "
          "series: Fletcher & Rossing, The Physics of Musical Instruments, 2nd ed. 1998",
      .example =
          "{ type = \"modal\", in = \"strike\", frequency = \"220 Hz\", series = \"bar\", modes = 12, "
          "decay = \"1 s\" }",
      .inputs = {late({"in", "any", "excitation"}), mode_frequency_input(), mode_decay_input()},
      .outputs = {filtered_output("out", "all modes together")},
      .silencers = {{"in"}},
      .settings =
          mode_settings({{"gains", Setting::Kind::Numbers,
                          "gain of each mode: one number for all, or one per mode; default: 1"},
                         within(-4, 4,
                                {"gain_slope",
                                 Setting::Kind::Quantity,
                                 "exponent s in gain_k * (f_1 / f_k)^s; above 0: high modes are softer",
                                 {},
                                 "0"})}),
      .make = make_modal};
}

}  // namespace tactus
