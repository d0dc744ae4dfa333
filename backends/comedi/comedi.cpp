#include <comedilib.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <map>
#include <utility>

#include "backends/acquisition_backends.h"
#include "backends/comedi/comedi_settings.h"
#include "backends/comedi/converter_range.h"
#include "backends/described_devices.h"
#include "backends/find_device.h"
#include "backends/paced/output_watchdog.h"

namespace tactus {
namespace {

const std::string kPrefix = "comedi:";
const std::string kFolder = "/dev";
constexpr Hertz kUsualRate{10'000};

/// Why the file of a device cannot be opened.
Error cannot_open(const std::string& file, int why) {
  const auto what = fmt::format("'{}' cannot be opened: {}", file, std::strerror(why));
  if (why == EACCES || why == EPERM)
    return {Errc::Device, "", what, "sudo usermod -aG iocard $USER   # then log in again"};
  if (why == ENOENT)
    return {Errc::Device, "", what,
            "load the kernel module of the card, as in: sudo modprobe ni_pcimio   # tactus devices --backend "
            "comedi lists the cards"};
  if (why == ENXIO || why == ENODEV)
    return {
        Errc::Device, "", what,
        fmt::format("no driver is attached; a card that is not found by itself needs: sudo comedi_config {} "
                    "DRIVER ADDRESS",
                    file)};
  if (why == EBUSY) return {Errc::Device, "", what, "end the program that uses it"};
  return {Errc::Device, "", what, "sudo dmesg | tail   # shows what the driver reports"};
}

/// A converter of a card: the inputs or the outputs.
struct Converter {
  int subdevice = -1;  ///< -1: there is none
  // Of each channel.
  std::vector<std::string> names;
  std::vector<ConverterRange> ranges;
  std::vector<unsigned> specs;  ///< number of channel and range
  int channels() const { return static_cast<int>(names.size()); }
  /// By which the same channels are known when the card returns: "output 0 (-5 to 5 V) in 4096 steps".
  std::vector<std::string> ports(const std::vector<int>& chosen) const {
    std::vector<std::string> known;
    for (const int c : chosen)
      known.push_back(
          fmt::format("{} in {} steps", names[index(c)], std::int64_t{ranges[index(c)].most} + 1));
    return known;
  }
};

/// The open file of a card.
class Card {
 public:
  static Result<std::shared_ptr<Card>> open(const std::string& file) {
    errno = 0;
    // The library reports only that it failed.
    const int tried = ::open(file.c_str(), O_RDWR | O_CLOEXEC);
    if (tried < 0) return tl::unexpected(cannot_open(file, errno));
    ::close(tried);
    auto* opened = comedi_open(file.c_str());
    if (opened == nullptr) return tl::unexpected(cannot_open(file, errno == 0 ? ENODEV : errno));
    (void)fcntl(comedi_fileno(opened), F_SETFD, FD_CLOEXEC);
    return std::make_shared<Card>(opened, file);
  }
  Card(comedi_t* opened, std::string path) : card_(opened), file_(std::move(path)) {}
  Card(const Card&) = delete;
  Card& operator=(const Card&) = delete;
  ~Card() { comedi_close(card_); }

  comedi_t* get() const { return card_; }
  int file() const { return comedi_fileno(card_); }
  std::string board() const { return text_of(comedi_get_board_name(card_)); }
  std::string driver() const { return text_of(comedi_get_driver_name(card_)); }

  /// `range`: its number; without, the widest of each channel. Errors: OutOfRange.
  Result<Converter> converter(bool inputs, const std::optional<int>& range) const {
    Converter found;
    found.subdevice = comedi_find_subdevice_by_type(card_, inputs ? COMEDI_SUBD_AI : COMEDI_SUBD_AO, 0);
    if (found.subdevice < 0) return found;
    const auto subdevice = static_cast<unsigned>(found.subdevice);
    for (int c = 0; c < comedi_get_n_channels(card_, subdevice); ++c) {
      const auto channel = static_cast<unsigned>(c);
      const int ranges = comedi_get_n_ranges(card_, subdevice, channel);
      if (range && *range >= ranges)
        return fail(
            Errc::OutOfRange, "",
            fmt::format("{} {} of '{}' has no range {}", inputs ? "input" : "output", c + 1, file_, *range),
            fmt::format("choose 0 to {}: {}", ranges - 1, listed(subdevice, channel, ranges)));
      const auto number = static_cast<unsigned>(range ? *range : widest(subdevice, channel, ranges));
      const auto* limits = comedi_get_range(card_, subdevice, channel, number);
      const auto most = comedi_get_maxdata(card_, subdevice, channel);
      if (limits == nullptr || most == 0 || !(limits->min < limits->max)) continue;
      found.names.push_back(
          fmt::format("{} {} ({:g} to {:g} V)", inputs ? "input" : "output", c, limits->min, limits->max));
      found.ranges.push_back({limits->min, limits->max, most});
      found.specs.push_back(CR_PACK(channel, number, 0u));
    }
    return found;
  }

 private:
  static std::string text_of(const char* text) { return text == nullptr ? "unnamed" : text; }
  int widest(unsigned subdevice, unsigned channel, int ranges) const {
    int best = 0;
    double width = 0.0;
    for (int r = 0; r < ranges; ++r)
      if (const auto* limits = comedi_get_range(card_, subdevice, channel, static_cast<unsigned>(r));
          limits != nullptr && limits->unit == UNIT_volt && limits->max - limits->min > width) {
        width = limits->max - limits->min;
        best = r;
      }
    return best;
  }
  std::string listed(unsigned subdevice, unsigned channel, int ranges) const {
    std::string text;
    for (int r = 0; r < ranges; ++r)
      if (const auto* limits = comedi_get_range(card_, subdevice, channel, static_cast<unsigned>(r)))
        text += fmt::format("{}{} is {:g} to {:g} V", text.empty() ? "" : ", ", r, limits->min, limits->max);
    return text;
  }

  comedi_t* card_;
  std::string file_;
};

constexpr unsigned reference_of(ComediSettings::Reference reference) {
  using Reference = ComediSettings::Reference;
  return reference == Reference::Ground   ? AREF_GROUND
         : reference == Reference::Common ? AREF_COMMON
         : reference == Reference::Other  ? AREF_OTHER
                                          : AREF_DIFF;
}

/// Single conversions of chosen channels, all in one system call.
class Conversions {
 public:
  Conversions(const Converter& converter, const std::vector<int>& channels, unsigned kind, unsigned reference)
      : raw_(channels.size()), instructions_(channels.size()) {
    for (std::size_t c = 0; c < channels.size(); ++c) {
      const auto channel = index(channels[c]);
      ranges_.push_back(converter.ranges[channel]);
      auto& instruction = instructions_[c];
      instruction.insn = kind;
      instruction.n = 1;
      instruction.data = &raw_[c];
      instruction.subdev = static_cast<unsigned>(converter.subdevice);
      instruction.chanspec = converter.specs[channel] | CR_PACK(0u, 0u, reference);
    }
    list_.n_insns = static_cast<unsigned>(channels.size());
    list_.insns = instructions_.data();
  }
  Conversions(const Conversions&) = delete;
  Conversions& operator=(const Conversions&) = delete;

  int channels() const { return static_cast<int>(raw_.size()); }
  /// [realtime]
  bool run(int file) noexcept {
    return raw_.empty() || ioctl(file, COMEDI_INSNLIST, &list_) == static_cast<int>(raw_.size());
  }
  double share(std::size_t channel) const noexcept { return ranges_[channel].share(raw_[channel]); }
  void set_share(std::size_t channel, double share) noexcept { raw_[channel] = ranges_[channel].raw(share); }

 private:
  std::vector<ConverterRange> ranges_;
  std::vector<lsampl_t> raw_;
  std::vector<comedi_insn> instructions_;
  comedi_insnlist list_{};
};

/// The chosen channels of a card, and the process that brings its outputs to zero.
class ComediFrames final : public FrameDevice {
 public:
  ComediFrames(std::shared_ptr<Card> card, const std::pair<Converter, Converter>& converters,
               const std::vector<int>& inputs, const std::vector<int>& outputs, unsigned reference)
      : card_(std::move(card)),
        file_(card_->file()),
        in_(converters.first, inputs, INSN_READ, reference),
        out_(converters.second, outputs, INSN_WRITE, AREF_GROUND),
        zero_(converters.second, outputs, INSN_WRITE, AREF_GROUND) {
    for (std::size_t c = 0; c < outputs.size(); ++c) zero_.set_share(c, 0.0);
  }
  ~ComediFrames() override {
    watchdog_.reset();
    if (locked_ >= 0) comedi_unlock(card_->get(), static_cast<unsigned>(locked_));
  }

  /// No other program writes to the outputs; they are at zero. Errors: Device.
  Status take_outputs(int subdevice, const std::string& file) {
    if (out_channels() == 0) return {};
    if (comedi_lock(card_->get(), static_cast<unsigned>(subdevice)) != 0)
      return fail(Errc::Device, "", fmt::format("the outputs of '{}' are in use by another program", file),
                  "end that program");
    locked_ = subdevice;
    if (!zero_.run(file_))
      return fail(Errc::Device, "",
                  fmt::format("the outputs of '{}' cannot be written: {}", file, std::strerror(errno)),
                  "sudo dmesg | tail   # shows what the driver reports");
    auto watchdog =
        OutputWatchdog::start([](void* self) { static_cast<ComediFrames*>(self)->to_zero(); }, this, {file_});
    if (!watchdog) return tl::unexpected(watchdog.error());
    watchdog_ = std::move(*watchdog);
    return {};
  }

  int in_channels() const override { return in_.channels(); }
  int out_channels() const override { return out_.channels(); }
  bool read(std::int64_t, float* in) noexcept override {
    if (!in_.run(file_)) return false;
    for (int c = 0; c < in_.channels(); ++c) in[c] = static_cast<float>(in_.share(index(c)));
    return true;
  }
  bool write(std::int64_t, const float* out) noexcept override {
    for (int c = 0; c < out_.channels(); ++c) out_.set_share(index(c), static_cast<double>(out[c]));
    if (watchdog_) watchdog_->frame();
    return out_.run(file_);
  }
  void to_zero() noexcept override { (void)zero_.run(file_); }
  void expect_frames(bool on) noexcept override {
    if (watchdog_) watchdog_->expect_frames(on);
  }
  bool lost() const override { return watchdog_ && !watchdog_->alive(); }

 private:
  std::shared_ptr<Card> card_;
  int file_;
  Conversions in_, out_, zero_;
  int locked_ = -1;
  std::unique_ptr<OutputWatchdog> watchdog_;
};

struct FoundCard {
  std::shared_ptr<Card> card;
  Converter inputs, outputs;
};

Result<FoundCard> open_card(const ComediSettings& settings) {
  auto card = Card::open(settings.file);
  if (!card) return tl::unexpected(card.error());
  auto inputs = (*card)->converter(true, settings.in_range);
  if (!inputs) return tl::unexpected(inputs.error());
  auto outputs = (*card)->converter(false, settings.out_range);
  if (!outputs) return tl::unexpected(outputs.error());
  return FoundCard{std::move(*card), std::move(*inputs), std::move(*outputs)};
}

/// The port or the bus address of the card, its driver and its board. Empty: the system does not say where it
/// is.
std::string hardware_of(const std::string& file, const Card& card) {
  std::error_code missing;
  const auto node = std::filesystem::path{file}.filename();
  const auto device = std::filesystem::canonical("/sys/class/comedi" / node / "device", missing);
  return missing ? "" : fmt::format("{} {} {}", device.filename().string(), card.driver(), card.board());
}

Device described(const std::string& id, const ComediSettings& settings, const FoundCard& found) {
  Device device;
  device.id = id;
  const auto short_name = "comedi:" + settings.file.substr(settings.file.find_last_not_of("0123456789") + 1);
  device.name = fmt::format("{} ({}, driver {})", found.card->board(), short_name, found.card->driver());
  device.hardware = hardware_of(settings.file, *found.card);
  device.api = "comedi";
  device.library_name = settings.file;
  device.default_rate = kUsualRate;
  device.sample_rates = paced_rates();
  device.block_frames = 1;
  device.in_channels = found.inputs.channels();
  device.out_channels = found.outputs.channels();
  device.in_names = found.inputs.names;
  device.out_names = found.outputs.names;
  return device;
}

/// "/dev/comedi0", "/dev/comedi1", …, in the order of their numbers.
std::vector<std::string> card_files() {
  std::map<int, std::string> files;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator{kFolder, error}) {
    const auto name = entry.path().filename().string();
    int number = 0, used = 0;
    if (std::sscanf(name.c_str(), "comedi%d%n", &number, &used) == 1 && used == static_cast<int>(name.size()))
      files[number] = entry.path().string();
  }
  std::vector<std::string> sorted;
  for (const auto& [number, file] : files) sorted.push_back(file);
  return sorted;
}

/// Data acquisition cards through Comedi, one frame a block. A device is "comedi:/dev/comedi0", with settings
/// after it: see ComediSettings. Full scale of a channel is the larger end of its range.
class ComediBackend final : public Backend, public DescribedDevices {
 public:
  std::string name() const override { return "comedi"; }

  Status add(const std::string& id) override {
    if (!id.starts_with(kPrefix + "/"))
      return fail(Errc::UnknownName, "", "'" + id + "' is no file of a card", "see tactus devices");
    auto settings = comedi_settings(id.substr(kPrefix.size()));
    if (!settings) return tl::unexpected(settings.error());
    auto found = open_card(*settings);
    if (!found) return tl::unexpected(found.error());
    added_[id] = std::move(*settings);
    return {};
  }

  Result<std::vector<Device>> devices() override {
    std::vector<Device> devices;
    std::optional<Error> first;
    std::map<std::string, ComediSettings> all = added_;
    const auto files = card_files();
    for (const auto& file : files) {
      auto& settings = all[kPrefix + file];
      settings.file = file;
    }
    for (const auto& [id, settings] : all) {
      const auto found = open_card(settings);
      if (found)
        devices.push_back(described(id, settings, *found));
      else if (!first)
        first = found.error();
    }
    if (!devices.empty()) return devices;
    if (first) return tl::unexpected(*first);
    return fail(
        Errc::Device, "", "there is no data acquisition card: no file /dev/comedi0",
        "load the kernel module of the card, as in: sudo modprobe ni_pcimio   # or comedi_test, which "
        "simulates one");
  }

  Result<std::unique_ptr<Stream>> open(const StreamRequest& request, GuardedBlocks& processor) override {
    const auto listed = devices();
    if (!listed) return tl::unexpected(listed.error());
    auto choice = choose(*listed, request);
    if (!choice) return tl::unexpected(choice.error());
    if (choice->input.id != choice->output.id)
      return fail(Errc::BadArgument, "", "inputs and outputs are of two cards", "name one");
    const auto settings = comedi_settings(choice->output.id.substr(kPrefix.size()));
    if (!settings) return tl::unexpected(settings.error());
    auto found = open_card(*settings);
    if (!found) return tl::unexpected(found.error());
    const auto inputs = channels_of(request.in_map, request.in_channels),
               outputs = channels_of(request.out_map, request.out_channels);
    choice->granted.input.ports = found->inputs.ports(inputs);
    choice->granted.output.ports = found->outputs.ports(outputs);
    auto frames = std::make_unique<ComediFrames>(found->card, std::pair{found->inputs, found->outputs},
                                                 inputs, outputs, reference_of(settings->reference));
    if (auto status = frames->take_outputs(found->outputs.subdevice, settings->file); !status)
      return tl::unexpected(status.error());
    return PacedStream::open(std::move(frames), choice->granted, settings->pace, processor);
  }

 private:
  std::map<std::string, ComediSettings> added_;  ///< by id
};

}  // namespace

std::unique_ptr<Backend> make_comedi_backend() { return std::make_unique<ComediBackend>(); }

}  // namespace tactus
