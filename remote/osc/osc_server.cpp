#include "remote/osc/osc_server.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/asio.hpp>
#include <mutex>
#include <thread>

#include "remote/osc/osc_query.h"
#include "remote/stream_clock.h"

namespace tactus {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using asio::ip::udp;
using ErrorCode = boost::system::error_code;

constexpr std::chrono::milliseconds kTick{10};
constexpr std::chrono::seconds kHttpPatience{2};
constexpr std::size_t kHttpBytes = 8192;
constexpr int kMostConnections = 8;

asio::ip::address plain(const asio::ip::address& address) {
  if (!address.is_v6() || !address.to_v6().is_v4_mapped()) return address;
  return asio::ip::make_address_v4(asio::ip::v4_mapped, address.to_v6());
}

OscPeer peer_of(const udp::endpoint& endpoint) {
  const auto address = plain(endpoint.address());
  OscPeer peer;
  peer.address = address.is_v6() ? address.to_v6().to_bytes()
                                 : asio::ip::make_address_v6(asio::ip::v4_mapped, address.to_v4()).to_bytes();
  peer.port = endpoint.port();
  peer.local = address.is_loopback();
  return peer;
}

udp::endpoint endpoint_of(const OscPeer& peer, bool v6) {
  const asio::ip::address_v6 address{peer.address};
  if (!v6 && address.is_v4_mapped())
    return {asio::ip::make_address_v4(asio::ip::v4_mapped, address), peer.port};
  return {address, peer.port};
}

/// One request of a browser or an OSCQuery client; it ends after an answer or two seconds.
class HttpConnection : public std::enable_shared_from_this<HttpConnection> {
 public:
  HttpConnection(tcp::socket socket, const RemoteTarget& target, int port, int& count)
      : socket_(std::move(socket)),
        timer_(socket_.get_executor()),
        target_(target),
        port_(port),
        count_(count) {
    ++count_;
  }
  ~HttpConnection() { --count_; }

  void run() {
    timer_.expires_after(kHttpPatience);
    timer_.async_wait([self = shared_from_this()](ErrorCode error) {
      ErrorCode ignored;
      if (!error) self->socket_.close(ignored);
    });
    asio::async_read_until(socket_, asio::dynamic_buffer(request_, kHttpBytes), "\r\n\r\n",
                           [self = shared_from_this()](ErrorCode error, std::size_t) {
                             if (error) return self->end();
                             self->answer();
                           });
  }

 private:
  void answer() {
    bytes_ = http_bytes(answer_http(target_, request_, port_));
    asio::async_write(socket_, asio::buffer(bytes_),
                      [self = shared_from_this()](ErrorCode, std::size_t) { self->end(); });
  }
  void end() {
    timer_.cancel();
    ErrorCode ignored;
    socket_.shutdown(tcp::socket::shutdown_both, ignored);
    socket_.close(ignored);
  }

  tcp::socket socket_;
  asio::steady_timer timer_;
  const RemoteTarget& target_;
  int port_;
  int& count_;
  std::string request_, bytes_;
};

class Server final : public OscServer {
 public:
  Server(RemoteTarget& target, const ListenOptions& options)
      : target_(target),
        host_(
            target, [this](const OscPeer& peer, std::span<const char> bytes) { send(peer, bytes); },
            options.arm_from_elsewhere) {}

  ~Server() override {
    io_.stop();
    if (thread_.joinable()) thread_.join();
  }

  Status start(const ListenOptions& options) {
    ErrorCode error;
    const auto address = asio::ip::make_address(options.address, error);
    if (error)
      return fail(Errc::Syntax, "--osc", "'" + options.address + "' is no IP address",
                  "give a port, or ADDRESS:PORT such as 0.0.0.0:9000");
    // The system chooses a free port for UDP, which may be in use for TCP.
    for (int attempt = 0; attempt < 20; ++attempt)
      if (error = bind({address, static_cast<unsigned short>(options.port)}); !error || options.port != 0)
        break;
    if (error)
      return fail(
          Errc::Device, "--osc",
          fmt::format("{}:{} cannot be opened: {}", options.address, options.port, error.message()),
          error == asio::error::address_in_use ? "choose another port" : "give an address of this computer");
    v6_ = address.is_v6();
    receive();
    accept();
    tick();
    thread_ = std::thread{[this] { io_.run(); }};
    return {};
  }

  int port() const override { return port_; }
  std::string announcement() const override {
    const auto at = v6_ ? fmt::format("[{}]:{}", address_, port_) : fmt::format("{}:{}", address_, port_);
    return fmt::format("OSC       udp {0}, description http://{0}/", at);
  }
  OscCounts counts() const override {
    const std::lock_guard lock{mutex_};
    return counts_;
  }

 private:
  ErrorCode bind(const udp::endpoint& at) {
    ErrorCode error;
    socket_ = udp::socket{io_};
    acceptor_ = tcp::acceptor{io_};
    socket_.open(at.protocol(), error);
    if (!error) socket_.bind(at, error);
    if (!error) socket_.non_blocking(true, error);
    if (error) return error;
    port_ = socket_.local_endpoint().port();
    address_ = at.address().to_string();
    const tcp::endpoint same{at.address(), static_cast<unsigned short>(port_)};
    acceptor_.open(same.protocol(), error);
    if (!error) acceptor_.set_option(tcp::acceptor::reuse_address{true}, error);
    if (!error) acceptor_.bind(same, error);
    if (!error) acceptor_.listen(kMostConnections, error);
    return error;
  }

  void receive() {
    socket_.async_receive_from(asio::buffer(packet_), from_, [this](ErrorCode error, std::size_t bytes) {
      if (error == asio::error::operation_aborted) return;
      if (!error)
        host_.receive(peer_of(from_), {packet_.data(), bytes}, OscHost::Clock::now(), system_seconds());
      receive();
    });
  }

  void accept() {
    acceptor_.async_accept([this](ErrorCode error, tcp::socket socket) {
      if (error == asio::error::operation_aborted) return;
      // Without a free file descriptor the next attempt would fail at once, over and over.
      if (error) return void(accept_later_ = true);
      if (connections_ < kMostConnections)
        std::make_shared<HttpConnection>(std::move(socket), target_, port_, connections_)->run();
      accept();
    });
  }

  void tick() {
    timer_.expires_after(kTick);
    timer_.async_wait([this](ErrorCode error) {
      if (error) return;
      host_.tick(OscHost::Clock::now(), system_seconds());
      if (std::exchange(accept_later_, false)) accept();
      {
        const std::lock_guard lock{mutex_};
        counts_ = host_.counts();
      }
      tick();
    });
  }

  /// What a receiver or the system has no room for is lost.
  void send(const OscPeer& peer, std::span<const char> bytes) {
    ErrorCode lost;
    socket_.send_to(asio::buffer(bytes.data(), bytes.size()), endpoint_of(peer, v6_), 0, lost);
  }

  RemoteTarget& target_;
  OscHost host_;
  int connections_ = 0;  // outlives the handlers in io_
  asio::io_context io_{1};
  udp::socket socket_{io_};
  tcp::acceptor acceptor_{io_};
  asio::steady_timer timer_{io_};
  udp::endpoint from_;
  alignas(8) std::array<char, 65536> packet_;
  std::string address_;
  int port_ = 0;
  bool v6_ = false, accept_later_ = false;
  mutable std::mutex mutex_;
  OscCounts counts_;  // of `host_`, under `mutex_`
  std::thread thread_;
};

}  // namespace

Result<ListenOptions> parse_osc_address(const std::string& text) {
  return parse_listen_address(text, "--osc",
                              "write --osc 9000, or --osc 0.0.0.0:9000 for clients of other hosts");
}

Result<std::unique_ptr<OscServer>> OscServer::open(const ListenOptions& options, RemoteTarget& target) {
  auto server = std::make_unique<Server>(target, options);
  if (auto started = server->start(options); !started) return tl::unexpected(started.error());
  return server;
}

}  // namespace tactus
