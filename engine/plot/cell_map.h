#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/core/error.h"

namespace tactus {

/// A map of cells over two quantities that were swept: each cell a colour, and a letter for eyes that do not
/// tell colours apart. Row 0 is the lowest.
struct CellMap {
  struct Cell {
    std::string fill;         ///< "#0072b2"
    std::string letter = {};  ///< at most two characters
  };
  struct Key {
    std::string fill, label;
  };
  std::string title;
  std::string x_label, y_label;
  std::vector<std::string> x, y;  ///< how columns and rows are called
  std::vector<Cell> cells;        ///< row by row: cells[row * x.size() + column]
  std::vector<Key> keys;          ///< legend, on the right
};

/// A page of maps, `columns` of them side by side.
struct CellPage {
  std::string title, subtitle;
  std::vector<CellMap> maps;
  int columns = 1;
  int width = 900;  ///< [px]
};

/// [any] 0 to 1 as a colour that grows lighter, the same to colour-blind eyes: cividis of Nunez, Anderton and
/// Renslow, PLoS ONE 13, 2018.
std::string ramp_color(double share);

/// [control] An SVG document on white ground.
std::string to_svg(const CellPage& page);
/// [control] The same into a file. Errors: BadFile.
[[nodiscard]] Status write_svg(const std::filesystem::path& path, const CellPage& page);

}  // namespace tactus
