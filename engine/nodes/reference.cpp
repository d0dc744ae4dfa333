#include "engine/nodes/reference.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <vector>

#include "engine/graph/file/quantity.h"
#include "engine/nodes/networks/network_elements.h"
#include "engine/nodes/world/world_elements.h"

namespace tactus {
namespace {

std::string unit_text(const std::string& unit) {
  if (unit.empty()) return "plain";
  return unit.front() == '=' ? "as " + unit.substr(1) : unit;
}

std::string range_text(double low, double high) {
  if (std::isinf(low) && std::isinf(high)) return "";
  if (std::isinf(high)) return "at least " + short_number(low);
  if (std::isinf(low)) return "at most " + short_number(high);
  return short_number(low) + " to " + short_number(high);
}

/// What the columns of one port or setting say, for text and Markdown alike.
struct Row {
  std::string name, kind, range, fallback, doc;
};

Row row_of(const InputPort& port) {
  return {port.name, unit_text(port.unit), range_text(port.low, port.high),
          port.fallback ? short_number(*port.fallback) : "required",
          port.doc + (port.fixed ? " (constant)" : "") + (port.late ? " (may close a loop)" : "")};
}

Row row_of(const OutputPort& port) {
  return {port.name, port.kind == OutputKind::Trigger ? "trigger" : unit_text(port.unit), "", "", port.doc};
}

/// "points, of s and as unit": the text in brackets.
std::string units_text(const std::vector<std::string>& units) {
  std::string text;
  for (const auto& unit : units) text += (text.empty() ? " of " : " and ") + unit_text(unit);
  return text;
}

Row row_of(const Setting& setting) {
  using Kind = Setting::Kind;
  std::string kind = setting_kind_name(setting.kind);
  std::string doc = setting.doc;
  if (setting.kind == Kind::Choice) doc = fmt::format("{}: {}", fmt::join(setting.choices, ", "), doc);
  if (setting.kind != Kind::Choice) kind += units_text(setting.choices);
  return {setting.name, kind, range_text(setting.low, setting.high),
          setting.required           ? "required"
          : setting.fallback.empty() ? "optional"
                                     : setting.fallback,
          doc};
}

/// What every field is limited to is said once.
std::string range_text(const ElementField& field) {
  return range_text(field.low == -kLargestField ? -kUnlimited : field.low,
                    field.high == kLargestField ? kUnlimited : field.high);
}

Row row_of(const ElementField& field) {
  return {field.name, unit_text(field.unit), range_text(field),
          field.fallback   ? short_number(*field.fallback)
          : field.optional ? "optional"
                           : "required",
          field.doc + (field.late ? " (signal)" : "")};
}

Row row_of(const ElementQuantity& quantity) {
  return {quantity.name, unit_text(quantity.unit), "", "", quantity.doc};
}

Row row_of(const WorldQuantity& quantity) {
  const bool trigger = quantity.reading == WorldReading::Trigger;
  return {quantity.name, trigger ? "trigger" : unit_text(quantity.unit), "", "", quantity.doc};
}

constexpr std::size_t kWidth = 100;

/// Characters as a person counts them: UTF-8 goes on with 10xxxxxx.
std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

std::string padded(const std::string& text, std::size_t width) {
  return text + std::string(width - std::min(width, width_of(text)), ' ');
}

/// `text` broken at spaces to lines of kWidth, the first one behind `start`, the others behind as much space.
/// Line breaks of its own stay.
std::string wrapped(const std::string& start, const std::string& text) {
  std::string result, line = start;
  const std::string indent(width_of(start), ' ');
  bool fresh = true;
  const auto end_line = [&] {
    line.erase(line.find_last_not_of(' ') + 1);
    result += line + "\n";
    line = indent;
    fresh = true;
  };
  for (std::size_t at = 0; at <= text.size();) {
    const auto end = std::min(text.find_first_of(" \n", at), text.size());
    const auto word = text.substr(at, end - at);
    if (!fresh && width_of(line) + 1 + width_of(word) > kWidth) end_line();
    line += (fresh ? "" : " ") + word;
    fresh = false;
    if (end < text.size() && text[end] == '\n') end_line();
    at = end + 1;
  }
  end_line();
  return result;
}

/// In Markdown a bar would end the cell.
std::string cell(const std::string& text) {
  std::string safe;
  for (const char c : text) safe += c == '|' ? std::string{"\\|"} : std::string{c};
  return safe;
}

/// Headings, paragraphs and tables, as plain text or as Markdown.
class Page {
 public:
  explicit Page(bool markdown) : markdown_(markdown) {}

  void title(const std::string& text, int level) {
    if (markdown_)
      text_ += fmt::format("{} {}\n\n", std::string(static_cast<std::size_t>(level), '#'), text);
    else
      text_ += (text_.empty() || text_.ends_with("\n\n") ? "" : "\n") + text + "\n";
  }
  void paragraph(const std::string& text) {
    text_ += markdown_ ? text + "\n\n" : wrapped(kIndent, text) + "\n";
  }
  void equation(const std::string& text) {
    text_ += markdown_ ? "```\n" + text + "\n```\n\n" : wrapped("    ", text) + "\n";
  }
  /// One line whatever its length: it is there to be copied.
  void example(const std::string& text) {
    text_ += markdown_ ? "```toml\n" + text + "\n```\n\n" : "    " + text + "\n\n";
  }

  template <class Items>
  void table(const char* heading, const Items& items) {
    std::vector<Row> rows;
    for (const auto& item : items) rows.push_back(row_of(item));
    if (!rows.empty()) markdown_ ? markdown_table(heading, rows) : text_table(heading, rows);
  }

  std::string take() { return std::move(text_); }

 private:
  static constexpr const char* kIndent = "  ";

  /// Columns that say nothing in any row are left out.
  static std::vector<std::string Row::*> columns_of(const std::vector<Row>& rows) {
    std::vector<std::string Row::*> columns;
    for (const auto column : {&Row::name, &Row::kind, &Row::range, &Row::fallback})
      if (std::any_of(rows.begin(), rows.end(), [&](const Row& row) { return !(row.*column).empty(); }))
        columns.push_back(column);
    return columns;
  }

  void markdown_table(const std::string& heading, const std::vector<Row>& rows) {
    const Row head{heading, heading == "setting" ? "kind" : "unit", "range", "default", "meaning"};
    std::string line;
    for (const auto column : columns_of(rows)) {
      text_ += "| " + head.*column + " ";
      line += "|---";
    }
    text_ += "| " + head.doc + " |\n" + line + "|---|\n";
    for (const auto& row : rows) {
      for (const auto column : columns_of(rows))
        text_ += column == &Row::name ? "| `" + row.name + "` " : "| " + cell(row.*column) + " ";
      text_ += "| " + cell(row.doc) + " |\n";
    }
    text_ += "\n";
  }

  void text_table(const std::string& heading, const std::vector<Row>& rows) {
    text_ += kIndent + heading + "s\n";
    const auto columns = columns_of(rows);
    std::vector<std::size_t> widths;
    for (const auto column : columns) {
      widths.push_back(0);
      for (const auto& row : rows) widths.back() = std::max(widths.back(), width_of(row.*column));
    }
    for (const auto& row : rows) {
      std::string start = std::string{kIndent} + kIndent;
      for (std::size_t c = 0; c < columns.size(); ++c) start += padded(row.*columns[c], widths[c] + 2);
      text_ += wrapped(start, row.doc);
    }
    text_ += "\n";
  }

  bool markdown_;
  std::string text_;
};

void write_type(Page& page, const NodeType& type) {
  page.title(type.name, 3);
  page.paragraph(type.summary);
  page.equation(type.equation);
  page.table("input", type.inputs);
  page.table("output", type.outputs);
  page.table("setting", type.settings);
  page.example(type.example);
  page.paragraph("Source: " + type.source + ".");
}

/// The fields that name other elements, by ElementType::Ends.
const char* ends_text(ElementType::Ends ends) {
  static constexpr const char* kTexts[] = {"", " `on` gives the mass.",
                                           " `on` gives the point that it acts on.",
                                           " `between` gives its two points, the lower one first."};
  return kTexts[static_cast<int>(ends)];
}

/// The elements of networks or of worlds.
template <class Elements, class EndsText>
void write_elements(Page& page, const Elements& elements, EndsText ends) {
  for (const auto& element : elements) {
    page.title(element.name, 3);
    page.paragraph(element.doc + ends(element.ends));
    page.equation(element.equation);
    page.table("setting", element.settings);
    page.table("field", element.fields);
    page.table("output", element.quantities);
    page.example(element.example);
  }
}

void write_networks(Page& page) {
  page.title("Networks", 2);
  page.paragraph(
      "Elements of `[networks.<name>]`. Up is positive. The outputs of a frame are the state at that frame; "
      "the inputs act on the step to the next frame. An output is written `network.element.output`; "
      "`network.element` alone is the first output. Where a range has no end, it ends at " +
      short_number(kLargestField) + ", except for signals.");
  write_elements(page, network_elements(), ends_text);
}

/// The same for worlds.
const char* body_ends_text(ElementType::Ends ends) {
  return ends == ElementType::Ends::None ? ""
         : ends == ElementType::Ends::On ? " `on` gives the body."
                                         : " `on` gives the body, `against` another one.";
}

void write_worlds(Page& page) {
  page.title("Worlds", 2);
  page.paragraph(
      "Elements of `[worlds.<name>]`: rigid bodies in space, in builds with the Open Dynamics Engine. z "
      "points up. A world is stepped at its own rate; in the frames of a step positions move on a line to "
      "the next state, and all else is held. Without an element of type gravity nothing falls. Also "
      "`world.energy`, "
      "`world.depth` and `world.refused` can be read.");
  page.table("setting", world_options().fields);
  page.table("output", world_quantities());
  write_elements(page, world_elements(), body_ends_text);
}

std::vector<std::string> groups_of(const NodeTable& table) {
  std::vector<std::string> groups;
  for (const auto* type : table.types)
    if (std::find(groups.begin(), groups.end(), type->group) == groups.end()) groups.push_back(type->group);
  return groups;
}

}  // namespace

const char* setting_kind_name(Setting::Kind kind) {
  static constexpr const char* kNames[] = {"choice", "whole number", "quantity", "true or false", "text",
                                           "file",   "points",       "numbers",  "names",         "text"};
  return kNames[static_cast<int>(kind)];
}

std::string reference_overview(const NodeTable& table) {
  constexpr std::size_t kNameWidth = 14;
  std::string text;
  for (const auto& group : groups_of(table)) {
    text += group + "\n";
    for (const auto* type : table.types)
      if (type->group == group) text += wrapped("  " + padded(type->name, kNameWidth), type->summary);
  }
  text += "networks\n";
  for (const auto& element : network_elements())
    text += wrapped("  " + padded(element.name, kNameWidth), element.doc);
  text += "worlds\n";
  for (const auto& element : world_elements())
    text += wrapped("  " + padded(element.name, kNameWidth), element.doc);
  return text + "\n" +
         wrapped("",
                 "`tactus nodes NAME` describes one type in full, `tactus nodes network` the elements of "
                 "networks, `tactus nodes world` those of worlds.");
}

std::string reference_text(const NodeType& type) {
  Page page{false};
  write_type(page, type);
  return page.take();
}

std::string network_reference() {
  Page page{false};
  write_networks(page);
  return page.take();
}

std::string world_reference() {
  Page page{false};
  write_worlds(page);
  return page.take();
}

std::string reference_markdown(const NodeTable& table) {
  Page page{true};
  page.title("Nodes", 1);
  page.paragraph(
      "All values of `type` in graph files. Generated from the declarations in `engine/nodes` by "
      "`scripts/renew_docs`; a test checks that it is up to date. Numbers are in SI units unless a unit is "
      "given; the format of graph files is described in [graph_files.md](graph_files.md).");
  for (const auto& group : groups_of(table)) {
    std::string heading = group;
    heading[0] = static_cast<char>(std::toupper(heading[0]));
    page.title(heading, 2);
    for (const auto* type : table.types)
      if (type->group == group) write_type(page, *type);
  }
  write_networks(page);
  write_worlds(page);
  auto text = page.take();
  text.pop_back();  // one line break at the end, not two
  return text;
}

}  // namespace tactus
