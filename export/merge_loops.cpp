#include "export/merge_loops.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <regex>
#include <set>
#include <vector>

#include "export/c_tokens.h"

namespace tactus {
namespace {

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

bool is_followed_by_lane(const CTokens& tokens, std::size_t token) {
  return token + 3 < tokens.size() && tokens[token + 1].text == "[" && tokens[token + 2].text == "lane" &&
         tokens[token + 3].text == "]";
}

Mentions mentions_of(const std::string& text) {
  Mentions found;
  const auto tokens = tokens_of(text);
  for (std::size_t t = 0; t < tokens.size(); ++t) {
    if (tokens[t].kind != CToken::Kind::Name) continue;
    const auto& word = tokens[t].text;
    const bool of_state = is_member(tokens, t), of_struct = !of_state && is_field(tokens, t);
    const bool is_array = t + 1 < tokens.size() && tokens[t + 1].text == "[",
               by_address = t > 0 && tokens[t - 1].text == "&";
    if (of_struct || !(of_state || is_array || by_address) || word.starts_with("tactus_data_")) continue;
    const bool is_port = !of_state && (word == "in" || word == "out");
    auto& names = is_followed_by_lane(tokens, t) ? found.by_lane : found.otherwise;
    names.insert(of_state ? "s->" + word : is_port ? "in or out" : word);
  }
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

/// Text in which each element `name[lane]` of an array is `name`.
std::string without_index(const std::string& text, const std::string& name) {
  auto tokens = tokens_of(text);
  for (std::size_t t = 0; t < tokens.size(); ++t)
    if (tokens[t].text == name && !is_field(tokens, t) && is_followed_by_lane(tokens, t))
      tokens.erase(tokens.begin() + static_cast<std::ptrdiff_t>(t + 1),
                   tokens.begin() + static_cast<std::ptrdiff_t>(t + 4));
  return text_of(tokens);
}

/// The loop that alone mentions an array, lane by lane; nullptr: there is none.
Statement* only_loop_with(const std::string& name, const Statement& declaration, CProgram& program) {
  Statement* loop = nullptr;
  for (auto& statement : program.frame) {
    if (&statement == &declaration || !mentions_variable(tokens_of(statement.text), name)) continue;
    if (loop != nullptr || statement.lanes == 0) return nullptr;
    loop = &statement;
  }
  const bool checked = std::ranges::any_of(
      program.checked, [&](const std::string& value) { return mentions_variable(tokens_of(value), name); });
  const bool alone = loop != nullptr && !checked && !mentions_of(loop->text).otherwise.contains(name);
  return alone ? loop : nullptr;
}

/// An array that a single loop mentions, lane by lane, is a number of that lane.
void drop_arrays(CProgram& program) {
  for (auto& declaration : program.frame) {
    const auto name = declared_array(declaration);
    auto* const loop = name ? only_loop_with(*name, declaration, program) : nullptr;
    if (loop == nullptr) continue;
    const auto definition = "\n" + *name + "[lane] = ";
    const auto at = ("\n" + loop->text).find(definition);  // at the start of a line
    if (at == std::string::npos) continue;
    loop->text.insert(at, "const tactus_real ");
    loop->text = without_index(loop->text, *name);
    declaration.text.clear();
  }
  std::erase_if(program.frame, [](const Statement& statement) { return statement.text.empty(); });
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
