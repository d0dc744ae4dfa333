#include "engine/graph/file/error_list.h"

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <set>
#include <tuple>
#include <unordered_set>
#include <utility>
#include <vector>

namespace tactus {
namespace {

/// File, line and column of "file:line:column".
std::tuple<std::string, int, int> place_of(const std::string& where) {
  const auto column = where.rfind(':'), line = column == where.npos ? column : where.rfind(':', column - 1);
  if (line == where.npos) return {where, 0, 0};
  return {where.substr(0, line), std::atoi(where.c_str() + line + 1), std::atoi(where.c_str() + column + 1)};
}

// A longer name is not a misspelling, and a comparison costs the product of the lengths.
constexpr std::size_t kLongest = 64;

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }
bool same(char a, char b) { return lower(a) == lower(b); }

/// Letters to insert, remove, replace or swap with their neighbour (Damerau, Comm. ACM 7(3), 1964), in the
/// variant that edits no part of a word twice; upper and lower case are the same.
std::size_t distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before, last(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    before = std::exchange(last, row);
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = last[j - 1] + (same(a[i - 1], b[j - 1]) ? 0 : 1);
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, replaced});
      if (i > 1 && j > 1 && same(a[i - 1], b[j - 2]) && same(a[i - 2], b[j - 1]))
        row[j] = std::min(row[j], before[j - 2] + 1);
    }
  }
  return row[b.size()];
}

}  // namespace

void sort_by_place(std::vector<Error>& errors, std::string_view first) {
  std::ranges::stable_sort(errors, {}, [first](const Error& error) {
    const auto at = place_of(error.where);
    return std::pair{std::get<0>(at) != first, at};
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

std::string nearest_name(std::string_view wrong, std::span<const std::string> candidates) {
  if (wrong.size() > kLongest) return {};
  // A third of the letters: "lowpas" is meant as "lowpass", "gain" is not meant as "ramp".
  std::size_t least = (wrong.size() + 1) / 3 + 1;
  std::string nearest;
  for (const auto& candidate : candidates) {
    if (candidate.size() > kLongest) continue;
    const auto letters = distance(wrong, candidate);
    if (letters >= least) continue;
    least = letters;
    nearest = candidate;
  }
  // "freq" is short for "frequency".
  constexpr std::size_t kLeastLetters = 3;
  const auto shortened = [&](const std::string& candidate) { return candidate.starts_with(wrong); };
  if (nearest.empty() && wrong.size() >= kLeastLetters && std::ranges::count_if(candidates, shortened) == 1)
    return *std::ranges::find_if(candidates, shortened);
  return nearest;
}

std::string key_of(std::string_view key, const std::string& owner) {
  return "'" + std::string{key} + "'" + (owner.empty() ? "" : " of " + owner);
}

std::string suggest(std::string_view wrong, std::span<const std::string> known,
                    const std::string& otherwise) {
  const auto near = nearest_name(wrong, known);
  if (!near.empty()) return "did you mean '" + near + "'?";
  return otherwise.empty() ? "there are " + listed(known) : otherwise;
}

void ErrorList::add(Errc code, const Source& at, std::string what, std::string remedy) {
  list_.push_back({code, at.text(), std::move(what), std::move(remedy)});
}

void ErrorList::add(std::vector<Error> errors) {
  list_.insert(list_.end(), std::make_move_iterator(errors.begin()), std::make_move_iterator(errors.end()));
}

void ErrorList::unknown_keys(const Value::Table& table, std::span<const std::string> known,
                             const std::string& owner) {
  const std::unordered_set<std::string_view> names(known.begin(), known.end());  // networks have thousands
  for (const auto& field : table)
    if (!names.contains(field.key))
      add(Errc::UnknownName, field.at,
          (owner.empty() ? "unknown key '" : owner + " has no '") + field.key + "'",
          suggest(field.key, known));
}

std::string ErrorList::text(const Value::Table& table, std::string_view key, const std::string& owner) {
  const auto* value = find(table, key);
  if (value == nullptr) return {};
  if (const auto* text = value->text()) return *text;
  add(Errc::WrongType, value->at, key_of(key, owner) + " must be a string, not " + value->kind(),
      "put it in quotes");
  return {};
}

void ErrorList::warn(Errc code, const Source& at, std::string what, std::string remedy) {
  warnings_.push_back({code, at.text(), std::move(what), std::move(remedy)});
}

/// By place, each once: a file that is read along two ways reports its errors twice.
static std::vector<Error> sorted(std::vector<Error> errors, const std::string& first) {
  sort_by_place(errors, first);
  std::set<std::pair<std::string, std::string>> reported;
  std::erase_if(errors,
                [&](const Error& error) { return !reported.emplace(error.where, error.what).second; });
  return errors;
}

std::vector<Error> ErrorList::take() { return sorted(std::exchange(list_, {}), first_); }
std::vector<Error> ErrorList::take_warnings() { return sorted(std::exchange(warnings_, {}), first_); }

}  // namespace tactus
