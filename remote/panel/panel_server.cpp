#include "remote/panel/panel_server.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/asio.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <deque>
#include <mutex>
#include <random>
#include <thread>
#include <utility>

#include "remote/panel/pages.h"

namespace tactus {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using ErrorCode = boost::system::error_code;
using Request = http::request<http::empty_body>;
using Response = http::response<http::string_body>;

constexpr std::chrono::milliseconds kTick{10};
constexpr std::chrono::seconds kHttpPatience{10};
constexpr int kMostConnections = 32, kMostBrowsers = 8;
constexpr std::uint32_t kLongestHead = 8192;
// What waits for a browser: beyond the first it gets no scope frames, beyond the second it is disconnected.
constexpr std::size_t kMuchBytes = 256 << 10, kMostBytes = 8 << 20;

/// 128 random bits.
std::string make_token() {
  std::random_device random;
  std::string token;
  for (int i = 0; i < 4; ++i) token += fmt::format("{:08x}", random());
  return token;
}

/// Takes as long for every wrong text of the same length.
bool same_secret(std::string_view given, std::string_view wanted) {
  if (given.size() != wanted.size()) return false;
  unsigned char difference = 0;
  for (std::size_t i = 0; i < given.size(); ++i)
    difference |= static_cast<unsigned char>(given[i] ^ wanted[i]);
  return difference == 0;
}

std::string_view view(beast::string_view text) { return {text.data(), text.size()}; }

/// "[::1]:80" and "127.0.0.1:80" without the port.
std::string_view without_port(std::string_view host) {
  const auto colon = host.rfind(':');
  return colon == host.npos || host.ends_with(']') ? host : host.substr(0, colon);
}

class Browser;

/// What the connections of a server share. It outlives them.
struct Common {
  PanelHost* panel = nullptr;
  std::string token, address;
  int port = 0;
  int connections = 0;
  int last_browser = 0;
  std::map<int, std::weak_ptr<Browser>> browsers;

  /// A page of another site that had its name point here would still name itself. An address is no name:
  /// behind 0.0.0.0 a browser may have reached any of this computer's.
  bool knows_host(std::string_view host) const {
    const auto name = std::string{without_port(host)};
    if (name == "localhost") return true;
    ErrorCode no_address;
    const bool bracketed = name.starts_with('[') && name.ends_with(']');
    (void)asio::ip::make_address(bracketed ? name.substr(1, name.size() - 2) : name, no_address);
    return !no_address;
  }
  /// Browsers name where a page came from.
  bool knows_origin(std::string_view origin, std::string_view host) const {
    return origin == "http://" + std::string{host};
  }
};

Response answer_with(const Request& request, http::status status, std::string_view type,
                     std::string_view body) {
  Response response{status, request.version()};
  response.set(http::field::content_type, beast::string_view{type.data(), type.size()});
  response.set(http::field::cache_control, "no-store");
  response.set("X-Content-Type-Options", "nosniff");
  response.set("Referrer-Policy", "no-referrer");
  response.set("Content-Security-Policy",
               "default-src 'self'; connect-src 'self' ws:; frame-ancestors 'none'; base-uri 'none'; "
               "form-action 'none'");
  response.keep_alive(request.keep_alive());
  response.body() = body;
  response.prepare_payload();
  return response;
}

/// What browsers call the content of a page.
std::string_view media_type(std::string_view name) {
  constexpr std::pair<std::string_view, std::string_view> kTypes[] = {
      {".html", "text/html; charset=utf-8"},
      {".js", "text/javascript; charset=utf-8"},
      {".css", "text/css; charset=utf-8"},
      {".svg", "image/svg+xml"}};
  for (const auto& [ending, type] : kTypes)
    if (name.ends_with(ending)) return type;
  return "application/octet-stream";
}

Response page_for(const Request& request) {
  auto name = view(request.target());
  name = name.substr(0, name.find('?'));
  if (name == "/") name = "/index.html";
  for (const auto& page : panel_pages())
    if (name.substr(1) == page.name)
      return answer_with(request, http::status::ok, media_type(page.name), page.bytes);
  return answer_with(request, http::status::not_found, "text/plain", "there is no such page");
}

/// The value of `key` in the query of a target: "/session?token=…".
std::string_view query_value(std::string_view target, std::string_view key) {
  auto query = target.substr(std::min(target.find('?'), target.size()));
  while (!query.empty()) {
    query.remove_prefix(1);
    const auto one = query.substr(0, query.find('&'));
    if (one.starts_with(key) && one.substr(key.size()).starts_with('=')) return one.substr(key.size() + 1);
    query.remove_prefix(one.size());
  }
  return {};
}

/// The WebSocket of a browser.
class Browser : public std::enable_shared_from_this<Browser> {
 public:
  Browser(beast::tcp_stream stream, Common& common)
      : socket_(std::move(stream)), common_(common), number_(++common.last_browser) {}
  ~Browser() { common_.browsers.erase(number_); }

  void run(Request request, bool local) {
    common_.browsers[number_] = weak_from_this();
    beast::get_lowest_layer(socket_).expires_never();
    auto timeouts = websocket::stream_base::timeout::suggested(beast::role_type::server);
    timeouts.idle_timeout = std::chrono::seconds{10};
    timeouts.keep_alive_pings = true;
    socket_.set_option(timeouts);
    socket_.read_message_max(PanelHost::kLongestMessage);
    socket_.async_accept(request, [self = shared_from_this(), local](ErrorCode error) {
      if (error) return;
      self->open_ = true;
      self->common_.panel->connected(self->number_, local);
      self->read();
    });
  }

  void send_text(std::string text) {
    if (!open_) return;
    if (waiting_bytes_ + text.size() > kMostBytes) return close();
    send({std::move(text), false});
  }
  void send_scope(std::string bytes) {
    if (open_ && waiting_bytes_ < kMuchBytes) send({std::move(bytes), true});
  }

 private:
  struct Frame {
    std::string bytes;
    bool binary;
  };

  void read() {
    socket_.async_read(buffer_, [self = shared_from_this()](ErrorCode error, std::size_t) {
      if (error) return self->close();
      const auto text = beast::buffers_to_string(self->buffer_.data());
      self->buffer_.consume(self->buffer_.size());
      if (self->open_ && self->socket_.got_text())
        self->common_.panel->received(self->number_, text, PanelHost::Clock::now());
      self->read();
    });
  }

  void send(Frame frame) {
    waiting_bytes_ += frame.bytes.size();
    frames_.push_back(std::move(frame));
    if (frames_.size() == 1) write();
  }

  void write() {
    socket_.binary(frames_.front().binary);
    socket_.async_write(asio::buffer(frames_.front().bytes),
                        [self = shared_from_this()](ErrorCode error, std::size_t) {
                          self->waiting_bytes_ -= self->frames_.front().bytes.size();
                          self->frames_.pop_front();
                          if (error) return self->close();
                          if (!self->frames_.empty()) self->write();
                        });
  }

  void close() {
    if (!std::exchange(open_, false)) return;
    common_.panel->disconnected(number_);
    beast::get_lowest_layer(socket_).close();
  }

  websocket::stream<beast::tcp_stream> socket_;
  Common& common_;
  int number_;
  bool open_ = false;
  beast::flat_buffer buffer_;
  std::deque<Frame> frames_;
  std::size_t waiting_bytes_ = 0;
};

/// A connection that asks for pages, until it becomes a WebSocket.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(tcp::socket socket, Common& common) : stream_(std::move(socket)), common_(common) {
    ++common_.connections;
    ErrorCode unknown;
    local_ = stream_.socket().remote_endpoint(unknown).address().is_loopback() && !unknown;
  }
  ~Connection() { --common_.connections; }

  void read() {
    parser_.emplace();
    parser_->header_limit(kLongestHead);
    stream_.expires_after(kHttpPatience);
    http::async_read(stream_, buffer_, *parser_, [self = shared_from_this()](ErrorCode error, std::size_t) {
      if (!error) self->answer(self->parser_->release());
    });
  }

 private:
  void answer(Request request) {
    const auto host = view(request[http::field::host]);
    const bool session = view(request.target()).starts_with("/session?");
    if (!common_.knows_host(host)) return refuse(request, "this is not the address of the panel");
    if (!session) {
      if (request.method() != http::verb::get && request.method() != http::verb::head)
        return write(answer_with(request, http::status::method_not_allowed, "text/plain", "only GET"));
      return write(page_for(request));
    }
    if (!websocket::is_upgrade(request) || !common_.knows_origin(view(request[http::field::origin]), host) ||
        !same_secret(query_value(view(request.target()), "token"), common_.token))
      return refuse(request, "open the link that the program prints");
    if (std::ssize(common_.browsers) >= kMostBrowsers)
      return write(
          answer_with(request, http::status::service_unavailable, "text/plain", "too many panels are open"));
    std::make_shared<Browser>(std::move(stream_), common_)->run(std::move(request), local_);
  }

  void refuse(const Request& request, std::string_view why) {
    write(answer_with(request, http::status::forbidden, "text/plain", why));
  }

  void write(Response response) {
    response_ = std::move(response);
    if (parser_->get().method() == http::verb::head) response_.body().clear();
    http::async_write(stream_, response_, [self = shared_from_this()](ErrorCode error, std::size_t) {
      if (error || self->response_.need_eof()) {
        ErrorCode ignored;
        self->stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
        return;
      }
      self->read();
    });
  }

  beast::tcp_stream stream_;
  Common& common_;
  bool local_ = false;
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::empty_body>> parser_;
  Response response_;
};

class Server final : public PanelServer {
 public:
  Server(RemoteTarget& target, const ListenOptions& options)
      : host_(target,
              {[this](int client, std::string text) {
                 if (const auto browser = find(client)) browser->send_text(std::move(text));
               },
               [this](int client, std::string bytes) {
                 if (const auto browser = find(client)) browser->send_scope(std::move(bytes));
               }},
              options.arm_from_elsewhere) {
    common_.panel = &host_;
    common_.token = make_token();
  }

  ~Server() override {
    io_.stop();
    if (thread_.joinable()) thread_.join();
  }

  Status start(const ListenOptions& options) {
    ErrorCode error;
    const auto address = asio::ip::make_address(options.address, error);
    if (error)
      return fail(Errc::Syntax, "--panel", "'" + options.address + "' is no IP address",
                  "give a port, or ADDRESS:PORT such as 0.0.0.0:8080");
    if (error = listen({address, static_cast<unsigned short>(options.port)}); error)
      return fail(
          Errc::Device, "--panel",
          fmt::format("{}:{} cannot be opened: {}", options.address, options.port, error.message()),
          error == asio::error::address_in_use ? "choose another port" : "give an address of this computer");
    common_.port = acceptor_.local_endpoint().port();
    common_.address = address.is_v6() ? "[" + address.to_string() + "]" : address.to_string();
    accept();
    tick();
    thread_ = std::thread{[this] { io_.run(); }};
    return {};
  }

  int port() const override { return common_.port; }
  std::string link() const override {
    const bool any = common_.address == "0.0.0.0" || common_.address == "[::]";
    return fmt::format("http://{}:{}/#{}", any ? "127.0.0.1" : common_.address, common_.port, common_.token);
  }
  PanelCounts counts() const override {
    const std::lock_guard lock{mutex_};
    return counts_;
  }

 private:
  ErrorCode listen(const tcp::endpoint& at) {
    ErrorCode error;
    acceptor_.open(at.protocol(), error);
    if (!error) acceptor_.set_option(tcp::acceptor::reuse_address{true}, error);
    if (!error) acceptor_.bind(at, error);
    if (!error) acceptor_.listen(kMostConnections, error);
    return error;
  }

  void accept() {
    acceptor_.async_accept([this](ErrorCode error, tcp::socket socket) {
      if (error == asio::error::operation_aborted) return;
      // Without a free file descriptor the next attempt would fail at once, over and over.
      if (error) return void(accept_later_ = true);
      if (common_.connections < kMostConnections)
        std::make_shared<Connection>(std::move(socket), common_)->read();
      accept();
    });
  }

  void tick() {
    timer_.expires_after(kTick);
    timer_.async_wait([this](ErrorCode error) {
      if (error) return;
      host_.tick(PanelHost::Clock::now());
      if (std::exchange(accept_later_, false)) accept();
      {
        const std::lock_guard lock{mutex_};
        counts_ = host_.counts();
      }
      tick();
    });
  }

  std::shared_ptr<Browser> find(int client) const {
    const auto found = common_.browsers.find(client);
    return found == common_.browsers.end() ? nullptr : found->second.lock();
  }

  PanelHost host_;
  Common common_;  // outlives the handlers in io_
  asio::io_context io_{1};
  tcp::acceptor acceptor_{io_};
  asio::steady_timer timer_{io_};
  bool accept_later_ = false;
  mutable std::mutex mutex_;
  PanelCounts counts_;  // of `host_`, under `mutex_`
  std::thread thread_;
};

}  // namespace

Result<ListenOptions> parse_panel_address(const std::string& text) {
  if (text.empty()) return ListenOptions{};
  return parse_listen_address(text, "--panel",
                              "write --panel, --panel 8080, or --panel 0.0.0.0:8080 for other hosts");
}

Result<std::unique_ptr<PanelServer>> PanelServer::open(const ListenOptions& options, RemoteTarget& target) {
  auto server = std::make_unique<Server>(target, options);
  if (auto started = server->start(options); !started) return tl::unexpected(started.error());
  return server;
}

}  // namespace tactus
