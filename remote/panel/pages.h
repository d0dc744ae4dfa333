#pragma once
// Thread: [any]

#include <span>
#include <string_view>

namespace tactus {

/// A file of remote/panel/web, or of uPlot, as it was when the program was built.
struct PanelPage {
  std::string_view name;  ///< "main.js"
  std::string_view type;  ///< "text/javascript"
  std::string_view bytes;
};

/// Made by cmake/embed_pages.cmake.
std::span<const PanelPage> panel_pages();

}  // namespace tactus
