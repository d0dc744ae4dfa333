#pragma once
// Thread: [any, the network thread]

#include <chrono>
#include <cstdint>
#include <optional>
#include <utility>

#include "engine/core/error.h"
#include "remote/remote.h"

namespace tactus {

/// The number that a client asks for and sends back to arm the drives, so that no single message arms. It is
/// good for one try within 3 s, and void once anybody has disarmed the drives: who disarms wins over who is
/// about to arm.
class ArmRequest {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::seconds kPatience{3};
  static constexpr int kMostNumber = 1 << 23;  ///< exact as float32 too, which is all that Pd has

  /// `random`: any number.
  std::int64_t begin(const RemoteTarget& target, std::uint64_t random, Clock::time_point now) noexcept {
    request_ =
        Request{1 + static_cast<std::int64_t>(random % kMostNumber), now + kPatience, target.disarms()};
    return request_->number;
  }
  /// RemoteTarget::order_arm with the number that the client gives. A wrong one voids the request, so that
  /// numbers cannot be tried in turn. Errors: BadArgument: it is void, or order_arm's.
  Result<int> arm(RemoteTarget& target, std::optional<double> given, Clock::time_point now) {
    const auto request = std::exchange(request_, std::nullopt);
    if (!request) return refuse("no number was requested");
    if (now > request->until) return refuse("the request is older than 3 s");
    if (!given || *given != static_cast<double>(request->number)) return refuse("the number is wrong");
    if (target.disarms() != request->disarms) return refuse("the drives were disarmed after the request");
    return target.order_arm();
  }

 private:
  struct Request {
    std::int64_t number;
    Clock::time_point until;
    int disarms;
  };
  static Result<int> refuse(const char* why) {
    return fail(Errc::BadArgument, "", why, "request a number and send it back within 3 s");
  }

  std::optional<Request> request_;
};

}  // namespace tactus
