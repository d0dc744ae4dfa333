#pragma once
// Thread: [control]

#include <filesystem>
#include <string>

#include "engine/core/error.h"
#include "engine/graph/file/load.h"
#include "engine/scene/file/scene_spec.h"

namespace tactus {

/// What the inputs of an instrument receive that is played without a plant.
struct BenchInputs {
  enum class Kind {
    TestSignal,  ///< strikes where full scale is expected, a slow motion where a quantity is
    Keyboard,    ///< a strike for each key press where full scale is expected, else 0
    Silence,     ///< 0
    File,        ///< channel k of a sound file at the k-th input; further inputs receive 0
  };
  Kind kind = Kind::TestSignal;
  std::filesystem::path file{};  ///< Kind::File
  int channels = 0;              ///< of the file
  bool notes = false;            ///< controls that keyboards set receive a note every half second
};

/// A line for each kind of signal and the inputs that receive it: "2 strikes per second at microphone"; one
/// for the notes of a keyboard. Empty if the instrument takes neither. `by_hand`: see SceneOptions::by_hand.
std::string describe(const BenchInputs& inputs, const GraphSpec& instrument, bool by_hand = false);

/// A scene of an instrument alone: its inputs are connected to a plant of signal generators, its outputs to
/// nothing. A strike is noise with a peak of at most 0.5 that decays with a time constant of 3 ms, over noise
/// of -80 dBFS, as every sensor has; the plant's control `strike` (see SceneOptions::by_hand) starts one at
/// its rise. The errors are those of the instrument.
LoadedScene scene_around(LoadedGraph instrument, const BenchInputs& inputs, Hertz rate, Seconds duration);

}  // namespace tactus
