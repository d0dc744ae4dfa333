#pragma once
// Thread: [control]

#include <filesystem>
#include <string>

namespace tactus::app {

/// A link that was opened in the browser of the desktop, where there is one. The link is a secret: others on
/// this computer see the arguments of a browser, so it is given a file that leads to the link, which only
/// this user may read. The file is removed with this.
class OpenedLink {
 public:
  /// Waits for nothing.
  explicit OpenedLink(const std::string& link);
  ~OpenedLink();
  OpenedLink(const OpenedLink&) = delete;
  OpenedLink& operator=(const OpenedLink&) = delete;

 private:
  std::filesystem::path file_;  ///< or empty
};

}  // namespace tactus::app
