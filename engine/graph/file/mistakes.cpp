#include "engine/graph/file/mistakes.h"

#include <algorithm>
#include <charconv>
#include <iterator>
#include <set>
#include <tuple>
#include <utility>

#include "engine/graph/file/nearest.h"

namespace tactus {
namespace {

struct Place {
  std::string_view file;
  int line = 0;
  int column = 0;

  auto key() const { return std::tie(file, line, column); }
};

/// Takes ":12" off the end of `text`; 0 if there is none.
int take_number(std::string_view& text) {
  const auto colon = text.rfind(':');
  if (colon == text.npos) return 0;
  int number = 0;
  const auto* const end = text.data() + text.size();
  const auto parsed = std::from_chars(text.data() + colon + 1, end, number);
  if (parsed.ec != std::errc{} || parsed.ptr != end) return 0;
  text = text.substr(0, colon);
  return number;
}

Place place_of(std::string_view where) {
  const int last = take_number(where);
  const int before = take_number(where);
  return {where, before, last};
}

}  // namespace

void sort_by_place(std::vector<Error>& errors, std::string_view first) {
  std::stable_sort(errors.begin(), errors.end(), [first](const Error& a, const Error& b) {
    const auto at = place_of(a.where), bt = place_of(b.where);
    if ((at.file == first) != (bt.file == first)) return at.file == first;
    return at.key() < bt.key();
  });
}

std::string listed(std::span<const std::string> names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) text += i + 1 == names.size() ? " and " : ", ";
    text += "'" + names[i] + "'";
  }
  return text;
}

std::string suggest(std::string_view wrong, std::span<const std::string> known,
                    const std::string& otherwise) {
  const auto near = nearest_name(wrong, known);
  if (!near.empty()) return "did you mean '" + near + "'?";
  return otherwise.empty() ? "there are " + listed(known) : otherwise;
}

void Mistakes::add(Errc code, const Source& at, std::string what, std::string remedy) {
  list_.push_back({code, at.text(), std::move(what), std::move(remedy)});
}

void Mistakes::add(std::vector<Error> errors) {
  list_.insert(list_.end(), std::make_move_iterator(errors.begin()), std::make_move_iterator(errors.end()));
}

void Mistakes::unknown_keys(const Value::Table& table, std::span<const std::string> known) {
  for (const auto& field : table) {
    if (std::find(known.begin(), known.end(), field.key) != known.end()) continue;
    add(Errc::UnknownName, field.at, "unknown key '" + field.key + "'", suggest(field.key, known));
  }
}

std::string Mistakes::text(const Value::Table& table, std::string_view key) {
  const auto* value = find(table, key);
  if (value == nullptr) return {};
  if (const auto* text = value->text()) return *text;
  add(Errc::WrongType, value->at, "'" + std::string{key} + "' must be a string, not " + value->kind(),
      "put it in quotes");
  return {};
}

std::vector<Error> Mistakes::take() {
  sort_by_place(list_, first_);
  // A file that is read along two ways reports its mistakes twice.
  std::set<std::pair<std::string, std::string>> told;
  std::erase_if(list_, [&](const Error& error) { return !told.emplace(error.where, error.what).second; });
  return std::exchange(list_, {});
}

}  // namespace tactus
