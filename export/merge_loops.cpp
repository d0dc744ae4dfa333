#include "export/merge_loops.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <regex>
#include <set>
#include <string_view>
#include <vector>

#include "export/number.h"

namespace tactus {
namespace {

constexpr std::string_view kIndex = "[lane]";

/// The name of the array that a statement declares and does no more: "tactus_real x[8];".
std::optional<std::string> declared_array(const Statement& statement) {
  static const std::regex form{R"(tactus_real (\w+)\[\d+\];)"};
  std::smatch match;
  return statement.lanes == 0 && std::regex_match(statement.text, match, form) ? std::optional{match[1].str()}
                                                                               : std::nullopt;
}
bool is_declaration(const Statement& statement) {
  static const std::regex fault{R"(int \w+ = 0;)"};
  return declared_array(statement) || (statement.lanes == 0 && std::regex_match(statement.text, fault));
}

/// How a loop mentions what may outlive its lane: arrays, the state of nodes, inputs and outputs, and what is
/// handed on by its address.
struct Mentions {
  std::set<std::string> by_lane, otherwise;

  bool contains(const std::string& name) const { return by_lane.contains(name) || otherwise.contains(name); }
};

/// Calls `with` with each word of a text, the place where it begins, and whether it is a field of a struct.
template <class With>
void for_each_word(const std::string& text, With with) {
  for_each_identifier(text, [&](std::string_view word) {
    const auto begin = static_cast<std::size_t>(word.data() - text.data());
    with(std::string{word}, begin, begin > 0 && (text[begin - 1] == '.' || text[begin - 1] == '>'));
  });
}

bool has(const std::string& text, std::size_t at, std::string_view what) {
  return text.compare(at, what.size(), what) == 0;
}

Mentions mentions_of(const std::string& text) {
  Mentions found;
  for_each_word(text, [&](const std::string& word, std::size_t begin, bool field) {
    const auto end = begin + word.size();
    const bool of_state = begin >= 3 && has(text, begin - 3, "s->");
    const bool by_address = begin > 0 && text[begin - 1] == '&';
    if (!of_state && (field || !(by_address || has(text, end, "[")) || word.starts_with("tactus_data_")))
      return;
    const bool port = !of_state && (word == "in" || word == "out");
    auto& names = has(text, end, kIndex) ? found.by_lane : found.otherwise;
    names.insert(of_state ? "s->" + word : port ? "in or out" : word);
  });
  return found;
}

/// No lane of either loop mentions what another lane of the other one does.
bool are_independent(const Statement& first, const Statement& second) {
  const auto one = mentions_of(first.text), other = mentions_of(second.text);
  return std::ranges::none_of(one.otherwise, [&](const auto& name) { return other.contains(name); }) &&
         std::ranges::none_of(other.otherwise, [&](const auto& name) { return one.contains(name); });
}

void merge(std::vector<Statement>& frame) {
  const auto place = [&](std::size_t at) { return frame.begin() + static_cast<std::ptrdiff_t>(at); };
  for (std::size_t i = 0; i < frame.size();) {
    std::size_t j = i + 1;
    while (j < frame.size() && is_declaration(frame[j])) ++j;
    if (frame[i].lanes == 0 || j == frame.size() || frame[j].lanes != frame[i].lanes ||
        !are_independent(frame[i], frame[j])) {
      ++i;
      continue;
    }
    frame[i].text += "\n" + frame[j].text;
    frame.erase(place(j));
    std::rotate(place(i), place(i + 1), place(j));  // declarations come before
    i = j - 1;
  }
}

std::size_t count_mentions(const std::string& text, const std::string& name) {
  std::size_t count = 0;
  for_each_word(text,
                [&](const std::string& word, std::size_t, bool field) { count += !field && word == name; });
  return count;
}

/// Text in which each element `name[lane]` is `name`.
std::string without_index(std::string text, const std::string& name) {
  std::vector<std::size_t> places;
  for_each_word(text, [&](const std::string& word, std::size_t begin, bool field) {
    if (!field && word == name) places.push_back(begin + word.size());
  });
  for (auto at = places.rbegin(); at != places.rend(); ++at) text.erase(*at, kIndex.size());
  return text;
}

/// An array that a single loop mentions, lane by lane, is a number of that lane.
void drop_arrays(CProgram& program) {
  auto& frame = program.frame;
  for (auto& declaration : frame) {
    const auto name = declared_array(declaration);
    if (!name) continue;
    std::size_t elsewhere = 0;
    Statement* loop = nullptr;
    for (auto& statement : frame) {
      if (&statement == &declaration || count_mentions(statement.text, *name) == 0) continue;
      if (loop != nullptr || statement.lanes == 0) ++elsewhere;
      loop = &statement;
    }
    for (const auto& value : program.checked) elsewhere += count_mentions(value, *name);
    if (loop == nullptr || elsewhere > 0 || mentions_of(loop->text).otherwise.contains(*name)) continue;
    const auto definition = *name + std::string{kIndex} + " = ";
    auto at = loop->text.find(definition);
    while (at != std::string::npos && at > 0 && loop->text[at - 1] != '\n')
      at = loop->text.find(definition, at + 1);
    if (at == std::string::npos) continue;
    loop->text.insert(at, "const tactus_real ");
    loop->text = without_index(loop->text, *name);
    declaration.text.clear();
  }
  std::erase_if(frame, [](const Statement& statement) { return statement.text.empty(); });
}

/// Of several values that a lane checks, the sum is: x - x is 0 while x is finite.
void join_checks(CProgram& program) {
  static const std::regex form{R"(\n(\w+) \|= (\w+(?:\[lane\])?) - \2 != 0;)"};
  std::set<std::string> joined;
  for (auto& loop : program.frame) {
    if (loop.lanes == 0) continue;
    std::string fault, sum;
    bool several = false;
    for (std::sregex_iterator match{loop.text.begin(), loop.text.end(), form}, end; match != end; ++match) {
      const auto name = (*match)[1].str(), value = (*match)[2].str();
      sum += fmt::format("{}({} - {})", sum.empty() ? "" : " + ", value, value);
      several = !fault.empty();
      if (several)
        joined.insert(name);
      else
        fault = name;
    }
    if (several)
      loop.text = std::regex_replace(loop.text, form, "") + fmt::format("\n{} |= {} != 0;", fault, sum);
  }
  std::erase_if(program.faults, [&](const std::string& fault) { return joined.contains(fault); });
  std::erase_if(program.frame, [&](const Statement& statement) {
    return std::ranges::any_of(joined,
                               [&](const auto& fault) { return statement.text == "int " + fault + " = 0;"; });
  });
}

}  // namespace

void merge_loops(CProgram& program) {
  merge(program.frame);
  drop_arrays(program);
  join_checks(program);
}

}  // namespace tactus
