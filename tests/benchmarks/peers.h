#pragma once

#include <memory>

#include "engine/graph/file/load.h"
#include "engine/graph/plan/compile.h"
#include "engine/guard/guarded.h"
#include "engine/nodes/table.h"
#include "engine/runtime/player.h"
#include "tests/benchmarks/exported_program.h"
#include "tests/benchmarks/faust_build.h"
#include "tests/benchmarks/works.h"

namespace tactus::bench {

inline constexpr int kTapeFrames = 6 * 1024;  ///< a whole number of each block, and more than a stroke

/// The same samples over and over, in blocks: what goes in and what comes out, with the pointers to both.
template <class Number>
class Tape {
 public:
  Tape(const Channels& in, int outputs)
      : out_(static_cast<std::size_t>(outputs), std::vector<Number>(kTapeFrames)) {
    for (const auto& channel : in) in_.emplace_back(channel.begin(), channel.end());
    in_at_.resize(in_.size());
    out_at_.resize(out_.size());
  }
  void seek(int frame) {
    for (std::size_t c = 0; c < in_.size(); ++c) in_at_[c] = in_[c].data() + frame;
    for (std::size_t c = 0; c < out_.size(); ++c) out_at_[c] = out_[c].data() + frame;
  }
  Number** in() { return in_at_.data(); }
  Number** out() { return out_at_.data(); }

 private:
  std::vector<std::vector<Number>> in_, out_;
  std::vector<Number*> in_at_, out_at_;
};

/// Somebody who does a work. `run` takes the frames from `frame` on.
struct Peer {
  virtual ~Peer() = default;
  virtual void run(int frame, int frames) = 0;
};

class ProcessorPeer : public Peer {
 public:
  ProcessorPeer(BlockProcessor& processor, const Channels& in, int outputs)
      : processor_(processor), tape_(in, outputs) {}
  void run(int frame, int frames) override {
    tape_.seek(frame);
    processor_.process({tape_.in(), tape_.out(), frames});
  }

 private:
  BlockProcessor& processor_;
  Tape<double> tape_;
};

inline LoadedGraph loaded(const Work& work) {
  return work.graph.empty() ? parse_graph_leniently(work.text, work.name)
                            : load_graph_leniently(std::string(TACTUS_GRAPHS "/") + work.graph);
}

inline std::unique_ptr<Plan> compiled(const Work& work) {
  CompileOptions options;
  options.sample_rate = Hertz{kRate};
  auto schedule = compile(loaded(work), standard_nodes(), options);
  if (!schedule) throw std::runtime_error(to_string(schedule.error()));
  return std::move(*schedule);
}

class GraphPeer : public Peer {
 public:
  GraphPeer(const Work& work, const Channels& in)
      : engine_(compiled(work)), player_(engine_, in, work.outputs) {
    const auto status = engine_.prepare({Hertz{kRate}, work.inputs, work.outputs, 4096});
    if (!status) throw std::runtime_error(to_string(status.error()));
  }
  void run(int frame, int frames) override { player_.run(frame, frames); }

 private:
  Player engine_;
  ProcessorPeer player_;
};

/// The graph behind the drive guard, as a backend runs it.
class GuardedPeer : public Peer {
 public:
  GuardedPeer(const Work& work, const Channels& in)
      : engine_(compiled(work)),
        guarded_(engine_, std::vector<GuardedChannel>(static_cast<std::size_t>(work.outputs)), true),
        player_(guarded_, in, work.outputs) {
    const auto status = guarded_.prepare({Hertz{kRate}, work.inputs, work.outputs, 4096});
    if (!status) throw std::runtime_error(to_string(status.error()));
  }
  void run(int frame, int frames) override { player_.run(frame, frames); }

 private:
  Player engine_;
  Guarded guarded_;
  ProcessorPeer player_;
};

std::unique_ptr<HandWritten<double>> hand_written_double(const Work& work);
std::unique_ptr<HandWritten<float>> hand_written_float(const Work& work);

template <class Number>
class HandPeer : public Peer {
 public:
  HandPeer(std::unique_ptr<HandWritten<Number>> loop, const Work& work, const Channels& in)
      : loop_(std::move(loop)), tape_(in, work.outputs) {}
  void run(int frame, int frames) override {
    tape_.seek(frame);
    loop_->process(tape_.in(), tape_.out(), frames);
  }

 private:
  std::unique_ptr<HandWritten<Number>> loop_;
  Tape<Number> tape_;
};

class ExportedPeer : public Peer {
 public:
  ExportedPeer(ExportedProgram& program, const Work& work, const Channels& in)
      : program_(program), tape_(in, work.outputs) {
    program_.start();
  }
  void run(int frame, int frames) override {
    tape_.seek(frame);
    program_.process(tape_.in(), tape_.out(), frames);
  }

 private:
  ExportedProgram& program_;
  Tape<double> tape_;
};

class FaustPeer : public Peer {
 public:
  FaustPeer(FaustBuild& build, const Work& work, const Channels& in)
      : build_(build), tape_(in, work.outputs) {
    build_.clear();
  }
  void run(int frame, int frames) override {
    tape_.seek(frame);
    build_.compute(frames, tape_.in(), tape_.out());
  }

 private:
  FaustBuild& build_;
  Tape<float> tape_;
};

}  // namespace tactus::bench
