#include "engine/nodes/reference.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <vector>

#include "engine/graph/quantity.h"
#include "engine/nodes/network_elements.h"

namespace tactus {
namespace {

std::string unit_text(const std::string& unit) {
  if (unit.empty()) return "plain";
  if (unit.front() == '=') return "that of `" + unit.substr(1) + "`";
  return unit == "any" ? "any" : unit;
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

Row row_of(const Setting& setting) {
  static constexpr const char* kKinds[] = {"choice", "whole number", "true or false", "text",
                                           "file",   "points",       "numbers",       "names"};
  std::string kind = kKinds[static_cast<int>(setting.kind)];
  if (setting.kind == Setting::Kind::Choice) {
    kind.clear();
    for (const auto& choice : setting.choices) kind += (kind.empty() ? "" : ", ") + choice;
  }
  return {setting.name, kind, range_text(setting.low, setting.high),
          !setting.fallback.empty() ? setting.fallback
          : setting.optional        ? "may be left out"
                                    : "required",
          setting.doc};
}

Row row_of(const ElementField& field) {
  return {field.name, unit_text(field.unit), range_text(field.low, field.high),
          field.fallback   ? short_number(*field.fallback)
          : field.optional ? "may be left out"
                           : "required",
          field.doc + (field.signal ? " (signal)" : "")};
}

Row row_of(const ElementQuantity& quantity) {
  return {quantity.name, unit_text(quantity.unit), "", "", quantity.doc};
}

/// Headings, paragraphs and tables, as plain text or as Markdown.
class Page {
 public:
  explicit Page(bool markdown) : markdown_(markdown) {}

  void title(const std::string& text, int level) {
    text_ += markdown_ ? fmt::format("{} {}\n\n", std::string(static_cast<std::size_t>(level), '#'), text)
                       : text + "\n";
  }
  void paragraph(const std::string& text) { text_ += text + (markdown_ ? "\n\n" : "\n"); }
  void code(const std::string& text) {
    text_ += markdown_ ? "```toml\n" + text + "\n```\n\n" : "  " + text + "\n";
  }
  void equation(const std::string& text) {
    text_ += markdown_ ? "```\n" + text + "\n```\n\n" : "  " + text + "\n";
  }

  template <class Items>
  void table(const char* heading, const Items& items) {
    if (items.empty()) return;
    if (markdown_)
      text_ +=
          fmt::format("| {} | unit or kind | range | default | meaning |\n|---|---|---|---|---|\n", heading);
    else
      text_ += std::string{"\n"} + heading + "\n";
    for (const auto& item : items) {
      const Row row = row_of(item);
      if (markdown_)
        text_ += fmt::format("| `{}` | {} | {} | {} | {} |\n", row.name, row.kind, row.range, row.fallback,
                             row.doc);
      else
        text_ += fmt::format("  {:14} {:16} {:18} {:12} {}\n", row.name, row.kind, row.range, row.fallback,
                             row.doc);
    }
    if (markdown_) text_ += "\n";
  }

  std::string take() { return std::move(text_); }

 private:
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
  page.code(type.example);
  page.paragraph("Source: " + type.source + ".");
}

void write_networks(Page& page) {
  page.title("Networks", 2);
  page.paragraph(
      "Elements of `[networks.<name>]`. Up is positive; outputs at a frame are the state at that frame, "
      "inputs act on the "
      "step to the next one. An output is named `network.element.quantity`.");
  for (const auto& element : network_elements()) {
    page.title(element.name, 3);
    page.paragraph(element.doc);
    page.equation(element.equation);
    page.table("field", element.fields);
    page.table("quantity", element.quantities);
    page.code(element.example);
  }
}

std::vector<std::string> groups_of(const NodeTable& table) {
  std::vector<std::string> groups;
  for (const auto* type : table.types)
    if (std::find(groups.begin(), groups.end(), type->group) == groups.end()) groups.push_back(type->group);
  return groups;
}

}  // namespace

std::string reference_overview(const NodeTable& table) {
  std::string text;
  for (const auto& group : groups_of(table)) {
    text += group + "\n";
    for (const auto* type : table.types)
      if (type->group == group) text += fmt::format("  {:14} {}\n", type->name, type->summary);
  }
  text += "networks\n";
  for (const auto& element : network_elements())
    text += fmt::format("  {:14} {}\n", element.name, element.doc);
  return text +
         "\n`tactus nodes NAME` tells all about one type, `tactus nodes network` about the elements of "
         "networks.\n";
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

std::string reference_markdown(const NodeTable& table) {
  Page page{true};
  page.title("Nodes", 1);
  page.paragraph(
      "Made by `tactus nodes --markdown` from the declarations of the node types; a test keeps it up to "
      "date.");
  for (const auto& group : groups_of(table)) {
    std::string heading = group;
    heading[0] = static_cast<char>(std::toupper(heading[0]));
    page.title(heading, 2);
    for (const auto* type : table.types)
      if (type->group == group) write_type(page, *type);
  }
  write_networks(page);
  return page.take();
}

}  // namespace tactus
