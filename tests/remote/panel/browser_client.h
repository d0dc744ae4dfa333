#pragma once

#include <boost/asio.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace tactus::test {

using Json = nlohmann::json;
namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using asio::ip::tcp;

/// Of a link "http://127.0.0.1:8080/#TOKEN".
inline std::string token_of(const std::string& link) { return link.substr(link.find('#') + 1); }
inline std::string address_of(const std::string& link) { return link.substr(7, link.find("/#") - 7); }
inline int port_of(const std::string& link) {
  return std::stoi(address_of(link).substr(address_of(link).rfind(':') + 1));
}

/// A WebSocket client in place of a browser.
class BrowserClient {
 public:
  struct Request {
    std::string host, origin, token;
  };

  explicit BrowserClient(int port) {
    socket_.next_layer().connect({asio::ip::address_v4::loopback(), static_cast<unsigned short>(port)});
  }
  /// False: refused.
  bool open(const Request& request) {
    socket_.set_option(websocket::stream_base::decorator([&](websocket::request_type& head) {
      if (!request.origin.empty()) head.set(beast::http::field::origin, request.origin);
    }));
    boost::system::error_code error;
    socket_.handshake(request.host, "/session?token=" + request.token, error);
    return !error;
  }
  bool open(const std::string& link) {
    return open({address_of(link), "http://" + address_of(link), token_of(link)});
  }
  void send(const std::string& text) { socket_.write(asio::buffer(text)); }
  /// The next message of a kind.
  Json wait_for(const std::string& kind) {
    while (true) {
      beast::flat_buffer buffer;
      socket_.read(buffer);
      if (!socket_.got_text()) continue;
      auto message = Json::parse(beast::buffers_to_string(buffer.data()));
      if (message["kind"] == kind) return message;
    }
  }
  struct Scope {
    double frame = 0.0;
    std::vector<std::vector<double>> traces;
  };
  /// The next scope frames, of bins of one frame.
  Scope wait_for_scope() {
    while (true) {
      beast::flat_buffer buffer;
      socket_.read(buffer);
      if (socket_.got_text()) continue;
      const auto bytes = beast::buffers_to_string(buffer.data());
      Scope scope;
      std::uint32_t count = 0;
      std::memcpy(&count, bytes.data() + 12, sizeof count);
      std::memcpy(&scope.frame, bytes.data() + 16, sizeof scope.frame);
      for (std::size_t t = 0; t < static_cast<std::uint8_t>(bytes[1]); ++t) {
        scope.traces.emplace_back();
        for (std::size_t n = 0; n < count; ++n) {
          float value = 0;
          std::memcpy(&value, bytes.data() + 24 + sizeof value * (t * count + n), sizeof value);
          scope.traces.back().push_back(double(value));
        }
      }
      return scope;
    }
  }
  tcp::socket& socket() { return socket_.next_layer(); }

 private:
  asio::io_context io_;
  websocket::stream<tcp::socket> socket_{io_};
};

}  // namespace tactus::test
