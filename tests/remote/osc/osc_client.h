#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <chrono>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "remote/osc/osc_messages.h"
#include "tests/support/wait_until.h"

namespace tactus::test {

inline sockaddr_in loopback(int port) {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<std::uint16_t>(port));
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return to;
}

inline double system_now_s() {
  return std::chrono::duration<double>{std::chrono::system_clock::now().time_since_epoch()}.count();
}

/// A client with a socket of its own, on this computer.
class OscClient {
 public:
  explicit OscClient(int port) : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    const auto to = loopback(port);
    REQUIRE(::connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0);
  }
  ~OscClient() { ::close(socket_); }
  OscClient(const OscClient&) = delete;
  OscClient& operator=(const OscClient&) = delete;

  void send(const OscMessage& message) const { send({message}, OscBundle::kNow); }
  void send(const std::vector<OscMessage>& messages, double time_s) const {
    for (const auto& packet : build_osc(messages, time_s)) send_bytes(packet);
  }
  void send_bytes(const std::string& bytes) const { (void)::send(socket_, bytes.data(), bytes.size(), 0); }

  /// The next message with this address; those before it are dropped.
  std::optional<OscMessage> wait_for(const std::string& address,
                                     std::chrono::milliseconds patience = std::chrono::seconds{30}) {
    std::optional<OscMessage> found;
    (void)wait_until(
        [&] {
          read();
          while (!found && !unread_.empty()) {
            if (unread_.front().address == address) found = unread_.front();
            unread_.pop_front();
          }
          return found.has_value();
        },
        patience);
    return found;
  }
  /// Asks for a number and arms with it. The drives then need `/alive`.
  void arm() {
    send({"/arm/request"});
    const auto number = wait_for("/arm/number");
    REQUIRE(number);
    send({"/arm", number->values});
  }

 private:
  void read() {
    std::array<char, 2048> bytes;
    for (auto count = ::recv(socket_, bytes.data(), bytes.size(), MSG_DONTWAIT); count > 0;
         count = ::recv(socket_, bytes.data(), bytes.size(), MSG_DONTWAIT)) {
      const auto read = parse_osc({bytes.data(), static_cast<std::size_t>(count)}, system_now_s());
      REQUIRE(read);
      for (const auto& bundle : *read)
        for (const auto& message : bundle.messages) unread_.push_back(message);
    }
  }

  int socket_;
  std::deque<OscMessage> unread_;
};

/// The whole answer to an HTTP request, sent as it is; "": the connection was closed without one.
inline std::string http(int port, const std::string& request) {
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const auto to = loopback(port);
  REQUIRE(::connect(socket, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0);
  (void)::send(socket, request.data(), request.size(), MSG_NOSIGNAL);
  std::string answer;
  std::array<char, 4096> bytes;
  for (auto count = ::recv(socket, bytes.data(), bytes.size(), 0); count > 0;
       count = ::recv(socket, bytes.data(), bytes.size(), 0))
    answer.append(bytes.data(), static_cast<std::size_t>(count));
  ::close(socket);
  return answer;
}

}  // namespace tactus::test
