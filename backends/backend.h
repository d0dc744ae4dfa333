#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "backends/health.h"
#include "engine/core/block_io.h"
#include "engine/core/error.h"
#include "engine/core/index.h"
#include "engine/core/units.h"
#include "engine/guard/guarded.h"

namespace tactus {

class MidiInputs;

/// Something with channels that a backend can open.
struct Device {
  std::string id;    ///< stays the same when others come and go: "jack:system", never an index
  std::string name;  ///< for people
  /// Where it is connected or what its driver calls it: "1-2:1.0" for a USB port. Empty: unknown.
  std::string hardware;
  /// The id may mean another device after a reconnection: it is an alias ("default"), or several devices have
  /// the same name and unknown hardware.
  bool ambiguous = false;
  int in_channels = 0;
  int out_channels = 0;
  std::vector<Hertz> sample_rates;  ///< empty: any
  Hertz default_rate;
  std::optional<int> block_frames;  ///< that it runs at now, or prefers
  /// The latency that the driver reports [frames], where it can be queried without opening the device.
  std::optional<double> input_latency_frames, output_latency_frames;
  bool is_default = false;
  std::vector<std::string> in_names, out_names;  ///< of its channels, where they have names

  // Where a library has it that reaches several driver interfaces ("APIs").
  std::string api;           ///< "jack", "alsa"
  std::string library_name;  ///< which two devices may have
  int index = 0;             ///< the library's
};

/// What makes the device of one direction the same one when it returns.
struct DeviceIdentity {
  std::string hardware;            ///< see Device
  int channels = 0;                ///< of the device
  std::vector<std::string> ports;  ///< full name behind each channel; empty: the library names none
  bool ambiguous = false;          ///< see Device

  /// [any] Without known hardware two equal devices that are exchanged look the same.
  bool may_be_another() const { return ambiguous || (channels > 0 && hardware.empty()); }
  bool operator==(const DeviceIdentity&) const = default;
};

/// A second device of a stream: it is read and written at its own rate, beside the blocks of the first.
struct GrantedSecond {
  std::string device;            ///< Device::id
  DeviceIdentity input, output;  ///< empty where there are no channels
  Seconds input_delay;           ///< its inputs are so much later than those of the first
  Seconds output_delay;          ///< its outputs come so long after they are computed
};

/// What was granted. Only this counts: drivers round block sizes and add buffers of their own.
struct StreamGranted {
  std::string device;            ///< Device::id of the outputs, or of the inputs where there are no outputs
  std::string input_device;      ///< where it is another one; otherwise empty
  DeviceIdentity input, output;  ///< empty where there are no channels
  /// What the server calls the connection of its devices: another one after one of them left the server and
  /// came back. Empty: unknown.
  std::string connection;
  int renames = 0;  ///< how often its ports had got other names: a name may now be that of another actuator
  StreamFormat format;
  int block_frames = 0;  ///< 0: changes from block to block
  int periods = 0;       ///< 0: not known
  /// The latency that the driver reports [frames]. It may be wrong: tactus latency measures it.
  std::optional<double> input_latency_frames;
  std::optional<double> output_latency_frames;
  bool xruns_move_delay = false;  ///< a gap may change the delay from then on
  bool writers_unknown = false;   ///< its ports take other programs too, and the library does not name them
  /// Of each input: a number that a device sends, where no sensor at the end of its range is at fault.
  std::vector<bool> digital_inputs;
  std::optional<GrantedSecond> second;
  bool comes_back = true;  ///< when it is Lost, opening it again may work in this process
};

/// What is asked for. Whatever is left out, the backend chooses.
struct StreamRequest {
  std::string device;                ///< Device::id; empty: the default device
  std::string input_device;          ///< for inputs on another device; empty: `device`
  std::optional<Hertz> sample_rate;  ///< a rate that cannot be had is an error, never another rate
  int in_channels = 0;
  int out_channels = 0;
  std::string second_device;  ///< for channels from kSecondDevice on; empty: there are none
  /// Which channels of the device they are, from 0 on; empty: the first ones. As long as there are channels.
  std::vector<int> in_map, out_map;
  std::optional<int> block_frames;  ///< a wish: see StreamGranted
  std::optional<int> periods;       ///< blocks in the driver's buffer; a wish, where a driver has it
  std::string client_name = "tactus";
  /// For a device that returns: what was granted before. The same hardware is preferred to another of the
  /// same name, and channels are connected to the same ports by name; a port that is missing is an error.
  std::optional<StreamGranted> previous;
};

/// [control] The channels that a map of a request means.
inline std::vector<int> channels_of(std::vector<int> map, int channels) {
  if (!map.empty()) return map;
  map.resize(index(channels));
  std::iota(map.begin(), map.end(), 0);
  return map;
}

/// A connection that brings something else to an actuator than its guard lets through: of another client to
/// the port behind an output, which plays the sum of both, or of an output to hardware that was not assigned
/// to it.
struct OtherWriter {
  int output = 0;        ///< channel of the processor
  std::string from, to;  ///< full names of the ports

  bool operator==(const OtherWriter&) const = default;
};

enum class StreamState {
  Stopped,
  Running,
  Stalled,  ///< no block for half a second; it may go on by itself
  Lost,     ///< the device or its server went away; only destroying the stream is left to do
};

/// An open device. Destroying it stops it and closes the device.
///
/// All functions are called from one control thread. While the stream runs, one real-time thread calls
/// `Guarded::process` and `Guarded::finish` and nothing else of the caller's.
class Stream {
 public:
  virtual ~Stream() = default;

  /// [any] What `open` was granted.
  virtual const StreamGranted& granted() const = 0;
  /// [control & stopped] Blocks begin to flow. `ready` is called when the device runs, before the first block
  /// reaches the processor; never when this fails. Errors: Device.
  [[nodiscard]] virtual Status start(const std::function<void()>& ready) = 0;
  /// [control & stopped]
  [[nodiscard]] Status start() {
    return start([] {});
  }
  /// [control] When it returns, no block is in `process` and none will follow. However a stream stops (this,
  /// its end, an error of its own), the last blocks that it outputs come from `Guarded::finish`: to zero.
  /// Stopping twice is fine. Errors: Device, and the stream counts as stopped all the same.
  [[nodiscard]] virtual Status stop() = 0;
  /// [any]
  virtual StreamState state() const = 0;
  /// [any]
  virtual Health health() const = 0;
  /// [any] The block size as it is now: some servers change it under a running stream.
  virtual int block_frames() const { return granted().block_frames; }
  /// [control] Empty: none, or the library does not know.
  virtual std::vector<OtherWriter> other_writers() const { return {}; }
  /// [control] Since the last call another program took an output of this stream away from its device, which
  /// is still there: it may be connected again at any time, at full level.
  virtual bool take_output_cut() { return false; }
  /// [control] The next message about what neither state nor health shows; empty: none.
  virtual std::string take_note() { return {}; }
};

/// A way to reach devices: a sound server, a driver library, a file.
class Backend {
 public:
  virtual ~Backend() = default;

  /// [any] "jack", "rtaudio", "offline": what `--backend` takes and device ids begin with.
  virtual std::string name() const = 0;
  /// [control] Everything that `open` could open now. No device is an empty list; Errors: Device, when the
  /// list is not available, with what to do about it.
  virtual Result<std::vector<Device>> devices() = 0;
  /// [control] Opens a device and calls `processor.prepare` with the granted format. `processor` must outlive
  /// the stream. Errors: UnknownName for the device; Device; BadArgument; those of `prepare`.
  virtual Result<std::unique_ptr<Stream>> open(const StreamRequest& request, GuardedBlocks& processor) = 0;
  /// [control] The MIDI inputs of what the stream of this backend is connected to, while it plays; they are
  /// looked for every `interval`. nullptr: the backend has none.
  virtual std::shared_ptr<MidiInputs> midi_inputs([[maybe_unused]] std::chrono::milliseconds interval) {
    return nullptr;
  }
};

/// A backend that this program was built with. The table is in cmake/TactusDependencies.cmake; the folder
/// backends/NAME defines `make_NAME_backend`.
struct BackendType {
  std::string name;  ///< Backend::name
  std::unique_ptr<Backend> (*make)();
};

/// [control] For sound cards, in the order in which they are asked for a device.
const std::vector<BackendType>& sound_backends();
/// [control] For force-feedback devices.
const std::vector<BackendType>& haptic_backends();
/// [control] All of them, those for sound cards first.
std::vector<BackendType> all_backends();

}  // namespace tactus
