#pragma once

#include <memory>
#include <string>

#include "tests/support/error_summary.h"
#include "tests/support/graphs/graph_runner.h"
#include "tests/support/temporary_folder.h"

namespace tactus::test {

/// Graphs in a folder with parts. `format = 1` stands before every text.
class PartGraphs {
 public:
  explicit PartGraphs(const std::string& part) { write("part.toml", part); }

  void write(const std::string& name, const std::string& text) const {
    folder_.write(name, "format = 1\n" + text);
  }
  Checked<std::unique_ptr<Plan>> schedule(const std::string& text, const NodeTable& table,
                                          const CompileOptions& options = {}) const {
    const auto file = (folder_.path() / "test.toml").string();
    return compile(parse_graph_leniently("format = 1\n" + text, file), table, options);
  }
  /// Throws what is wrong with the texts.
  std::unique_ptr<Plan> right(const std::string& text, const NodeTable& table = standard_nodes(),
                              const CompileOptions& options = {}) const {
    auto made = schedule(text, table, options);
    if (!made) throw std::runtime_error(to_string(made.error()));
    return std::move(*made);
  }
  std::unique_ptr<Player> engine(const std::string& text, const NodeTable& table = standard_nodes(),
                                 const CompileOptions& options = {}) const {
    return std::make_unique<Player>(right(text, table, options));
  }
  /// "" if there is none.
  std::string errors_of(const std::string& text, const CompileOptions& options = {}) const {
    const auto made = schedule(text, standard_nodes(), options);
    return folder_.strip(summary(made));
  }

 private:
  TemporaryFolder folder_;
};

}  // namespace tactus::test
