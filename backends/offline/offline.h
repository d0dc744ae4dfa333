#pragma once
// Thread: [control]

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "backends/backend.h"
#include "backends/wav_file.h"

namespace tactus {

/// Where frames come from: `read` fills channels[0 … this->channels)[0 … frames), for any number of frames.
struct FrameSource {
  int channels = 0;
  std::function<Status(double* const* channels, int frames)> read;
};
/// Where they go.
struct FrameSink {
  int channels = 0;
  std::function<Status(const double* const* channels, int frames)> write;
  /// The block of zeros that ends every run, whole or broken off. A file that is as long as its input leaves
  /// it out.
  std::function<Status(const double* const* channels, int frames)> finish = {};
};

/// [control] The samples, then silence. `samples` must outlive the source.
FrameSource source_of(const Samples& samples);
/// [control] The rest of the file, then silence. `reader` must outlive the source.
FrameSource source_of(WavReader& reader);
/// [control] Appends to `samples`, which must have its channels and outlive the sink.
FrameSink sink_into(Samples& samples);
/// [control] `writer` must outlive the sink.
FrameSink sink_into(WavWriter& writer);

/// A run without hardware and without a clock, as fast as the machine goes.
struct OfflineJob {
  Hertz sample_rate = 48_kHz;
  int in_channels = 0;
  int out_channels = 0;
  std::int64_t frames = 0;
  /// Block sizes, used in turn and over again; the last block is as long as what is left.
  std::vector<int> block_frames = {256};
  FrameSource source = {};  ///< without `read`: silence
  FrameSink sink = {};      ///< without `write`: the output is dropped
};

/// [control] Prepares `processor` and runs the job. Errors: BadArgument for the job; those of `prepare`, the
/// source and the sink.
[[nodiscard]] Result<Health> run_offline(Guarded& processor, const OfflineJob& job);

/// [control] `run_offline` from memory to memory: the input's rate, channels and length, `out_channels`
/// outputs.
[[nodiscard]] Result<Samples> render(Guarded& processor, const Samples& input, int out_channels,
                                     std::vector<int> block_frames = {256});

/// The offline run behind the seam of all backends: one device, "offline:files", of any rate and any
/// channels. `start` runs to the end before it returns and leaves the stream Finished.
class OfflineBackend final : public Backend {
 public:
  /// `job` says all but rate and channels, which the request does.
  explicit OfflineBackend(OfflineJob job) : job_(std::move(job)) {}

  std::string name() const override { return "offline"; }
  Result<std::vector<Device>> devices() override;
  Result<std::unique_ptr<Stream>> open(const StreamRequest& request, Guarded& processor) override;

 private:
  OfflineJob job_;
};

}  // namespace tactus
