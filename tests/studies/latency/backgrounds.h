#pragma once

#include <cstdint>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

namespace tactus::study {

/// What sounds beside the probe.
enum class Background { Noise, Music, Speech, Machine };
inline constexpr const char* kBackgroundNames[]{"noise", "music", "speech", "machine"};

/// Recorded sounds: loops and hits of sonic-pi-samples and hydrogen-drumkits, sounds of a desktop, and speech
/// that scripts/study_latency makes. Every second file belongs to the part on which thresholds were chosen,
/// the others to the part that is reported.
class Backgrounds {
 public:
  enum class Part { Chosen, HeldOut };

  /// Reads the files of one part. `speech`: a folder of WAV files.
  Backgrounds(Part part, const std::filesystem::path& speech);

  std::size_t music() const { return long_.size() + hits_.size(); }
  std::size_t speech() const { return speech_.size(); }
  /// `frames` frames with a mean power of 1.
  std::vector<double> samples(Background kind, std::size_t frames, std::mt19937_64& random) const;

 private:
  std::vector<double> raw(Background kind, std::size_t frames, std::mt19937_64& random) const;

  std::vector<std::vector<float>> long_, hits_, speech_;
};

}  // namespace tactus::study
