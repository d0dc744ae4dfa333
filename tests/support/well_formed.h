#pragma once

#include <string>
#include <vector>

namespace tactus::test {

/// Every opened tag is closed in turn, and no bare & or < is left: what an XML parser asks first.
inline bool well_formed(const std::string& text) {
  std::vector<std::string> open;
  for (std::size_t at = 0; (at = text.find_first_of("<&", at)) != std::string::npos; ++at) {
    if (text[at] == '&') {
      const auto end = text.find(';', at);
      if (end == std::string::npos || end - at > 5) return false;
      continue;
    }
    const auto end = text.find('>', at);
    if (end == std::string::npos) return false;
    const auto tag = text.substr(at + 1, end - at - 1);
    const auto name = tag.substr(0, tag.find(' '));
    if (tag.back() == '/') continue;
    if (tag.front() != '/') {
      open.push_back(name);
    } else {
      if (open.empty() || "/" + open.back() != name) return false;
      open.pop_back();
    }
  }
  return open.empty();
}

}  // namespace tactus::test
