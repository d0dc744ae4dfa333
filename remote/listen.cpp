#include "remote/listen.h"

#include <charconv>

namespace tactus {

Result<ListenOptions> parse_listen_address(const std::string& text, const std::string& option,
                                           const std::string& remedy) {
  ListenOptions options;
  const auto colon = text.rfind(':');
  const auto port = colon == std::string::npos ? text : text.substr(colon + 1);
  if (colon != std::string::npos) options.address = text.substr(0, colon);
  if (options.address == "localhost") options.address = "127.0.0.1";
  if (options.address.starts_with('[') && options.address.ends_with(']'))
    options.address = options.address.substr(1, options.address.size() - 2);
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), options.port);
  const bool number = error == std::errc{} && end == port.data() + port.size();
  if (number && options.port >= 0 && options.port <= 65535) return options;
  return fail(Errc::Syntax, option, "'" + text + "' is no port and no ADDRESS:PORT", remedy);
}

}  // namespace tactus
