#include "remote/osc/osc_messages.h"

#include <oscpack/osc/OscOutboundPacketStream.h>
#include <oscpack/osc/OscReceivedElements.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <limits>

namespace tactus {
namespace {

constexpr double kNtpTo1970_s = 2'208'988'800.0;
constexpr double kNtpTicks = 4'294'967'296.0;  // of a second
constexpr std::uint64_t kImmediately = 1;
constexpr std::size_t kPacketBytes = 1400;

/// Too much of something: thrown and caught here, as oscpack's exceptions are.
struct TooLarge : std::exception {
  const char* what() const noexcept override { return "too many messages, arguments or levels"; }
};
struct BadText : std::exception {
  const char* what() const noexcept override { return "an address or a text is too long or not printable"; }
};

struct Blob : std::exception {
  const char* what() const noexcept override { return "blobs are not accepted"; }
};

/// oscpack 1.1.0 does not check the length of a blob (it makes an exception and does not throw it), and reads
/// behind the packet. A blob has no use here: a message with one never reaches oscpack.
void refuse_blobs(std::string_view message) {
  const auto address_end = message.find('\0');
  if (address_end == std::string_view::npos) return;
  const auto tags = message.substr(std::min(message.size(), (address_end / 4 + 1) * 4));
  if (tags.starts_with(',') && tags.substr(0, tags.find('\0')).find('b') != std::string_view::npos)
    throw Blob{};
}

std::uint64_t ntp_of(double time_s) {
  const double seconds = std::floor(time_s);
  const auto whole = static_cast<std::uint64_t>(static_cast<std::int64_t>(seconds + kNtpTo1970_s));
  return (whole << 32) + static_cast<std::uint64_t>((time_s - seconds) * kNtpTicks);
}

/// Tags repeat every 136 years; of those times the one next to `now_s` is meant.
double time_of(std::uint64_t tag, double now_s) {
  if (tag == kImmediately) return OscBundle::kNow;
  return now_s + static_cast<double>(static_cast<std::int64_t>(tag - ntp_of(now_s))) / kNtpTicks;
}

std::string checked(const char* text) {
  const std::string_view all{text};
  if (all.size() > kLongestOscText || std::ranges::any_of(all, [](unsigned char c) { return c < 0x20; }))
    throw BadText{};
  return std::string{all};
}

OscValue value_of(const osc::ReceivedMessageArgument& argument) {
  using namespace osc;
  switch (argument.TypeTag()) {
    case FLOAT_TYPE_TAG:
      return static_cast<double>(argument.AsFloatUnchecked());
    case DOUBLE_TYPE_TAG:
      return argument.AsDoubleUnchecked();
    case INT32_TYPE_TAG:
      return std::int64_t{argument.AsInt32Unchecked()};
    case INT64_TYPE_TAG:
      return static_cast<std::int64_t>(argument.AsInt64Unchecked());
    case TRUE_TYPE_TAG:
      return std::int64_t{1};
    case FALSE_TYPE_TAG:
      return std::int64_t{0};
    case STRING_TYPE_TAG:
      return checked(argument.AsStringUnchecked());
    case SYMBOL_TYPE_TAG:
      return checked(argument.AsSymbolUnchecked());
    default:
      return std::monostate{};
  }
}

/// `from`: a packet, or an element of a bundle.
template <class From>
OscMessage message_of(const From& from) {
  refuse_blobs({from.Contents(), static_cast<std::size_t>(from.Size())});
  const osc::ReceivedMessage received{from};
  OscMessage message{checked(received.AddressPattern())};
  for (auto at = received.ArgumentsBegin(); at != received.ArgumentsEnd(); ++at) {
    if (std::ssize(message.values) == kMostOscValues) throw TooLarge{};
    message.values.push_back(value_of(*at));
  }
  return message;
}

struct PacketReader {
  double now_s;
  std::vector<OscBundle> bundles = {};
  int messages = 0;

  void count(int depth) {
    if (++messages > kMostOscMessages || depth > kMostOscDepth) throw TooLarge{};
  }
  void read(const osc::ReceivedBundle& bundle, int depth) {
    count(depth);
    const auto place = bundles.size();
    bundles.push_back({time_of(bundle.TimeTag(), now_s)});
    for (auto at = bundle.ElementsBegin(); at != bundle.ElementsEnd(); ++at) {
      if (at->IsBundle()) {
        read(osc::ReceivedBundle{*at}, depth + 1);
      } else {
        count(depth);
        bundles[place].messages.push_back(message_of(*at));
      }
    }
  }
};

struct Appender {
  osc::OutboundPacketStream& stream;
  void operator()(std::monostate) const { stream << osc::OscNil; }
  void operator()(double value) const { stream << static_cast<float>(value); }
  void operator()(const std::string& text) const { stream << text.c_str(); }
  void operator()(std::int64_t value) const {
    if (std::abs(value) <= std::numeric_limits<std::int32_t>::max())
      stream << static_cast<osc::int32>(value);
    else
      stream << static_cast<osc::int64>(value);
  }
};

void append(osc::OutboundPacketStream& stream, const OscMessage& message) {
  stream << osc::BeginMessage(message.address.c_str());
  for (const auto& value : message.values) std::visit(Appender{stream}, value);
  stream << osc::EndMessage;
}

/// At most, in a bundle.
std::size_t bytes_of(const OscMessage& message) {
  const auto padded = [](std::size_t bytes) { return (bytes + 4) / 4 * 4; };
  auto bytes = 4 + padded(message.address.size()) + padded(1 + message.values.size());
  for (const auto& value : message.values) {
    const auto* text = std::get_if<std::string>(&value);
    bytes += text != nullptr ? padded(text->size()) : 8;
  }
  return bytes;
}

/// The part of `text` up to the first slash.
std::string_view first_part(std::string_view text) { return text.substr(0, text.find('/')); }

/// A limit on the work that a pattern of many stars makes.
class PartMatcher {
 public:
  bool matches(std::string_view pattern, std::string_view text) {
    if (++steps_ > kMostSteps) return false;
    if (pattern.empty()) return text.empty();
    if (pattern.front() == '*') return star(pattern.substr(1), text);
    if (pattern.front() == '{') return choice(pattern, text);
    if (text.empty()) return false;
    if (pattern.front() == '[') return set(pattern, text);
    if (pattern.front() != '?' && pattern.front() != text.front()) return false;
    return matches(pattern.substr(1), text.substr(1));
  }

 private:
  static constexpr int kMostSteps = 2000;

  bool star(std::string_view pattern, std::string_view text) {
    for (std::size_t skipped = 0; skipped <= text.size(); ++skipped)
      if (matches(pattern, text.substr(skipped))) return true;
    return false;
  }
  bool choice(std::string_view pattern, std::string_view text) {
    const auto end = pattern.find('}');
    if (end == std::string_view::npos) return false;
    auto choices = pattern.substr(1, end - 1);
    while (true) {
      const auto comma = choices.find(',');
      const auto one = choices.substr(0, comma);
      if (text.starts_with(one) && matches(pattern.substr(end + 1), text.substr(one.size()))) return true;
      if (comma == std::string_view::npos) return false;
      choices.remove_prefix(comma + 1);
    }
  }
  bool set(std::string_view pattern, std::string_view text) {
    const auto end = pattern.find(']', 1);
    if (end == std::string_view::npos) return false;
    auto members = pattern.substr(1, end - 1);
    const bool others = members.starts_with('!');
    if (others) members.remove_prefix(1);
    bool found = false;
    for (std::size_t m = 0; m < members.size(); ++m) {
      const bool range = m + 2 < members.size() && members[m + 1] == '-';
      found = found || (range ? members[m] <= text.front() && text.front() <= members[m + 2]
                              : members[m] == text.front());
      if (range) m += 2;
    }
    return found != others && matches(pattern.substr(end + 1), text.substr(1));
  }

  int steps_ = 0;
};

/// Part by part; `beginning`: what the pattern does not reach may follow.
bool matches_parts(std::string_view pattern, std::string_view address, bool beginning) {
  while (true) {
    if (pattern.empty()) return address.empty() || (beginning && address.front() == '/');
    if (pattern.front() != '/' || !address.starts_with('/')) return false;
    pattern.remove_prefix(1);
    address.remove_prefix(1);
    const auto wanted = first_part(pattern), part = first_part(address);
    if (!PartMatcher{}.matches(wanted, part)) return false;
    pattern.remove_prefix(wanted.size());
    address.remove_prefix(part.size());
  }
}

}  // namespace

Result<std::vector<OscBundle>> parse_osc(std::span<const char> packet, double now_s) {
  try {
    const osc::ReceivedPacket received{packet.data(), packet.size()};
    PacketReader reader{now_s};
    if (received.IsBundle())
      reader.read(osc::ReceivedBundle{received}, 0);
    else
      reader.bundles.push_back({OscBundle::kNow, {message_of(received)}});
    return std::move(reader.bundles);
  } catch (const std::exception& error) {
    return fail(Errc::Syntax, "", std::string{"the packet is no valid OSC: "} + error.what());
  }
}

bool contains_text(std::span<const char> packet, std::string_view text) {
  constexpr std::size_t kStep = 4;
  const std::string_view all{packet.data(), packet.size()};
  for (std::size_t at = 0; at + text.size() < all.size(); at += kStep)
    if (all.substr(at).starts_with(text) && all[at + text.size()] == 0) return true;
  return false;
}

std::vector<std::string> build_osc(std::span<const OscMessage> messages, double time_s) {
  constexpr std::size_t kHeader = 16;
  std::vector<std::string> packets;
  std::array<char, kPacketBytes> buffer;
  const bool alone = messages.size() == 1 && time_s == OscBundle::kNow;
  for (std::size_t m = 0; m < messages.size();) {
    if (kHeader + bytes_of(messages[m]) > buffer.size()) {
      ++m;
      continue;
    }
    osc::OutboundPacketStream stream{buffer.data(), buffer.size()};
    if (!alone) stream << osc::BeginBundle(time_s == OscBundle::kNow ? kImmediately : ntp_of(time_s));
    for (auto bytes = kHeader; m < messages.size(); ++m) {
      bytes += bytes_of(messages[m]);
      if (bytes > buffer.size()) break;
      append(stream, messages[m]);
    }
    if (!alone) stream << osc::EndBundle;
    packets.emplace_back(stream.Data(), stream.Size());
  }
  return packets;
}

bool matches_osc(std::string_view pattern, std::string_view address) {
  return matches_parts(pattern, address, false);
}

bool covers_osc(std::string_view pattern, std::string_view address) {
  while (pattern.ends_with('/')) pattern.remove_suffix(1);
  return matches_parts(pattern, address, true);
}

bool is_osc_pattern(std::string_view address) {
  return address.find_first_of("?*[]{}") != std::string_view::npos;
}

}  // namespace tactus
