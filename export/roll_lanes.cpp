#include "export/roll_lanes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <map>
#include <optional>
#include <set>
#include <string_view>

#include "engine/core/index.h"
#include "export/c_names.h"
#include "export/c_tokens.h"
#include "export/kernel_texts.h"
#include "export/number.h"

namespace tactus {
namespace {

// Fewer lanes fill no vector of numbers and are faster one by one: compilers keep them in registers, while a
// loop leaves its results in memory for the next one. A lane of more statements than this is no pattern.
constexpr std::size_t kFewestLanes = 8, kLongestLane = 24;

using Token = CToken;
using Tokens = CTokens;

/// What two statements have to have in common to be the same for two lanes.
std::string shape_of(const Tokens& tokens) {
  std::string shape;
  for (const auto& token : tokens)
    shape += token.kind == Token::Kind::Other ? token.text : token.kind == Token::Kind::Name ? "@" : "#";
  return shape;
}

std::optional<long> whole_number(const std::string& text) {
  long value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size() ? std::optional{value} : std::nullopt;
}

/// What names of all lanes have in common: "u" of u_0, u_1; "d_samples" of d_0_samples, d_1_samples.
std::string common_name(const std::vector<std::string>& names) {
  const auto parts = [](const std::string& name) {
    std::vector<std::string> found{{}};
    for (const char c : name) c == '_' ? found.emplace_back() : (found.back() += c, found.back());
    return found;
  };
  const auto first = parts(names.front());
  std::string common;
  for (std::size_t i = 0; i < first.size(); ++i) {
    const bool alike = std::ranges::all_of(names, [&](const std::string& name) {
      const auto other = parts(name);
      return other.size() == first.size() && other[i] == first[i];
    });
    if (alike) common += (common.empty() ? "" : "_") + first[i];
  }
  return common.empty() || !std::isalpha(static_cast<unsigned char>(common.front())) ? "lane_value" : common;
}

/// `type name[count]`, with what is behind the name, as of a member or a table.
struct Declaration {
  std::string type, name, count, rest;

  static std::optional<Declaration> read(const std::string& text) {
    const auto end = std::min(text.find_first_of("[=;"), text.size());
    auto head = text.substr(0, end);
    while (!head.empty() && head.back() == ' ') head.pop_back();
    const auto space = head.find_last_of(" *");
    if (space == std::string::npos) return std::nullopt;
    Declaration found{head.substr(0, space), head.substr(space + 1), {}, {}};
    auto at = end;
    if (at < text.size() && text[at] == '[') {
      const auto close = text.find(']', at);
      found.count = text.substr(at, close + 1 - at);
      at = close + 1;
    }
    found.rest = text.substr(at);
    return found;
  }
};

class LaneRoller {
 public:
  explicit LaneRoller(CProgram& program) : program_(program) {
    for (std::size_t i = 0; i < program_.members.size(); ++i)
      if (const auto declared = Declaration::read(program_.members[i].declaration)) {
        members_[declared->name] = i;
        taken_members_.insert(declared->name);
      }
    for (std::size_t i = 0; i < program_.tables.size(); ++i)
      if (const auto declared = Declaration::read(program_.tables[i])) {
        tables_[declared->name] = i;
        taken_.insert(declared->name);
      }
    for (const auto* list : {&program_.variables, &program_.start, &program_.follow, &program_.designs})
      for (const auto& text : *list) taken_.merge(identifiers_of(text));
    for (const auto& statement : program_.frame) taken_.merge(identifiers_of(statement.text));
    for (auto* names : {&taken_, &taken_members_}) names->insert(program_.name);
  }

  void run() {
    take_variables();
    std::vector<Statement> frame = std::move(program_.frame);
    roll(frame);
    program_.frame = std::move(frame);
    for (auto* list : {&program_.start, &program_.follow, &program_.designs}) {
      std::vector<Statement> statements;
      for (auto& text : *list) statements.push_back({std::move(text)});
      list->clear();
      roll(statements);
      for (const auto& statement : statements) list->push_back(statement.with_loop());
    }
    drop_gaps();
  }

 private:
  /// A place in a lane at which the lanes differ, and what each has there.
  struct Slot {
    std::size_t statement, token;
    std::vector<std::string> texts;
  };
  /// Statements `first`, ... of a list, `period` in each of `lanes` lanes.
  struct Pattern {
    std::size_t first, period, lanes;
    std::vector<Slot> slots;

    std::size_t end() const { return first + period * lanes; }
    std::size_t saved() const { return (lanes - 1) * period; }
  };
  using Names = std::vector<std::string>;

  // The text to work on.

  void tokenise(const std::vector<Statement>& statements) {
    list_.clear();
    shapes_.clear();
    for (const auto& statement : statements) {
      list_.push_back(tokens_of(statement.text));
      shapes_.push_back(fmt::format("{} {} {}", statement.divisor, statement.lanes, shape_of(list_.back())));
    }
  }

  void roll(std::vector<Statement>& statements) {
    tokenise(statements);
    for (std::size_t at = 0; at < list_.size();) {
      const auto pattern = best_pattern(statements, at);
      if (!pattern || !locals_stay_in_their_lanes(*pattern)) {
        ++at;
        continue;
      }
      const auto rolled = roll_one(*pattern);
      const auto begin = statements.begin() + static_cast<std::ptrdiff_t>(pattern->first);
      statements.erase(begin, begin + static_cast<std::ptrdiff_t>(pattern->period * pattern->lanes));
      statements.insert(statements.begin() + static_cast<std::ptrdiff_t>(pattern->first), rolled.begin(),
                        rolled.end());
      for (auto& statement : statements) statement.text = renamed(statement.text);
      at = pattern->first + rolled.size();
      tokenise(statements);
    }
  }

  /// The one that leaves the fewest statements, of those that begin here.
  std::optional<Pattern> best_pattern(const std::vector<Statement>& statements, std::size_t at) const {
    std::optional<Pattern> best;
    for (std::size_t period = 1; period <= kLongestLane && at + period * kFewestLanes <= list_.size();
         ++period) {
      std::size_t lanes = 1;
      while (at + (lanes + 1) * period <= list_.size() && alike(at, at + lanes * period, period)) ++lanes;
      if (lanes < kFewestLanes || !run_once_a_frame(statements, at, period)) continue;
      auto found = with_slots({at, period, lanes, {}});
      if (found && (!best || found->saved() > best->saved())) best = std::move(found);
    }
    return best;
  }
  static bool run_once_a_frame(const std::vector<Statement>& statements, std::size_t at, std::size_t count) {
    const auto first = statements.begin() + static_cast<std::ptrdiff_t>(at);
    return std::all_of(first, first + static_cast<std::ptrdiff_t>(count),
                       [](const Statement& each) { return each.divisor == 1 && each.lanes == 0; });
  }
  bool alike(std::size_t one, std::size_t other, std::size_t period) const {
    return std::equal(shapes_.begin() + static_cast<std::ptrdiff_t>(one),
                      shapes_.begin() + static_cast<std::ptrdiff_t>(one + period),
                      shapes_.begin() + static_cast<std::ptrdiff_t>(other));
  }

  /// As many lanes of it as can be rolled.
  std::optional<Pattern> with_slots(Pattern pattern) const {
    for (; pattern.lanes >= kFewestLanes; --pattern.lanes) {
      find_slots(pattern);
      const auto lanes = lanes_that_fit(pattern);
      if (lanes == pattern.lanes) return pattern.slots.empty() ? std::nullopt : std::optional{pattern};
      if (lanes < kFewestLanes) return std::nullopt;
      pattern.lanes = lanes + 1;  // is lowered
    }
    return std::nullopt;
  }
  void find_slots(Pattern& pattern) const {
    pattern.slots.clear();
    for (std::size_t s = 0; s < pattern.period; ++s)
      for (std::size_t t = 0; t < list_[pattern.first + s].size(); ++t) {
        std::vector<std::string> texts;
        for (std::size_t lane = 0; lane < pattern.lanes; ++lane)
          texts.push_back(list_[pattern.first + lane * pattern.period + s][t].text);
        if (std::ranges::any_of(texts, [&](const auto& text) { return text != texts.front(); }))
          pattern.slots.push_back({s, t, std::move(texts)});
      }
  }

  enum class Role { Number, Member, Table, Local, Variable, None };

  Role role_of(const Pattern& pattern, const Slot& slot) const {
    const auto& tokens = list_[pattern.first + slot.statement];
    if (tokens[slot.token].kind == Token::Kind::Number) return Role::Number;
    if (is_member(tokens, slot.token)) return Role::Member;
    if (is_field(tokens, slot.token)) return Role::None;
    const auto& name = slot.texts.front();
    if (tables_.contains(name)) return Role::Table;
    if (variables_.contains(name)) return Role::Variable;
    for (const auto& other : pattern.slots)
      if (other.texts == slot.texts && defines(list_[pattern.first + other.statement], other.token))
        return Role::Local;
    return Role::None;
  }
  /// "const tactus_real x = ..."
  static bool defines(const Tokens& tokens, std::size_t token) {
    return token == 4 && tokens[0].text == "const" && tokens.size() > 6 && tokens[6].text == "=";
  }

  /// How many of the lanes, from the first one, have the same kinds of names and numbers in all places.
  std::size_t lanes_that_fit(const Pattern& pattern) const {
    std::size_t lanes = pattern.lanes;
    for (const auto& slot : pattern.slots) lanes = std::min(lanes, lanes_that_fit(pattern, slot));
    return lanes;
  }
  std::size_t lanes_that_fit(const Pattern& pattern, const Slot& slot) const {
    // What some lanes share does not differ among them.
    std::size_t fit = 1;
    const bool name = list_[pattern.first + slot.statement][slot.token].kind == Token::Kind::Name;
    while (name && fit < slot.texts.size() && slot.texts[fit] == slot.texts.front()) ++fit;
    if (fit > 1) return fit;
    const auto role = role_of(pattern, slot);
    if (role == Role::None) return 0;
    for (; fit < slot.texts.size(); ++fit) {
      const auto &first = slot.texts.front(), &text = slot.texts[fit];
      if (role == Role::Number) {
        if (whole_number(first).has_value() != whole_number(text).has_value()) break;
        continue;
      }
      const auto begin = slot.texts.begin();
      if (std::find(begin, begin + static_cast<std::ptrdiff_t>(fit), text) !=
          begin + static_cast<std::ptrdiff_t>(fit))
        break;  // twice: no array of one a lane
      if (role == Role::Member && !same_member(first, text)) break;
      if (role == Role::Table && !same_table(first, text)) break;
      if (role == Role::Variable && !same_variable(pattern, first, text)) break;
    }
    return fit;
  }
  bool same_member(const std::string& one, const std::string& other) const {
    const auto a = members_.find(one), b = members_.find(other);
    if (a == members_.end() || b == members_.end()) return false;
    const auto first = *Declaration::read(program_.members[a->second].declaration),
               second = *Declaration::read(program_.members[b->second].declaration);
    return first.type == second.type && first.count == second.count;
  }
  bool same_table(const std::string& one, const std::string& other) const {
    const auto b = tables_.find(other);
    if (b == tables_.end()) return false;
    const auto first = *Declaration::read(program_.tables[tables_.at(one)]),
               second = *Declaration::read(program_.tables[b->second]);
    return first.type == second.type && first.count.empty() && second.count.empty();
  }

  // Variables of a frame: those that only one lane uses are declared in its loop.

  void take_variables() {
    for (const auto& text : program_.variables) {
      const auto declared = Declaration::read(text);
      if (declared && declared->count.empty()) variables_[declared->name] = text;
    }
  }
  bool same_variable(const Pattern& pattern, const std::string& one, const std::string& other) const {
    const auto a = variables_.find(one), b = variables_.find(other);
    if (a == variables_.end() || b == variables_.end()) return false;
    const auto mine = tokens_of(a->second), others = tokens_of(b->second);
    if (shape_of(mine) != shape_of(others)) return false;
    for (std::size_t t = 0; t < mine.size(); ++t)
      if (mine[t] != others[t] && is_member(mine, t) && !same_member(mine[t].text, others[t].text))
        return false;
    return can_move(pattern, one, mine) && can_move(pattern, other, others);
  }
  /// Only the pattern uses it, and nothing before has changed the members that it begins with.
  bool can_move(const Pattern& pattern, const std::string& name, const Tokens& declaration) const {
    if (!only_within(pattern, name) || is_checked(name)) return false;
    for (std::size_t t = 0; t < declaration.size(); ++t)
      if (is_member(declaration, t))
        for (std::size_t s = 0; s < pattern.first; ++s)
          if (mentions_member(list_[s], declaration[t].text)) return false;
    return true;
  }
  bool only_within(const Pattern& pattern, const std::string& name) const {
    for (std::size_t s = 0; s < list_.size(); ++s)
      if ((s < pattern.first || s >= pattern.end()) && mentions_variable(list_[s], name)) return false;
    return true;
  }
  static bool mentions_member(const Tokens& tokens, const std::string& name) {
    for (std::size_t t = 0; t < tokens.size(); ++t)
      if (tokens[t].text == name && is_member(tokens, t)) return true;
    return false;
  }
  bool is_checked(const std::string& name) const {
    return std::ranges::find(program_.checked, name) != program_.checked.end();
  }

  // Rolling.

  /// Its lanes come in falling order, and in the order of all other loops they may join one of these. That is
  /// their choice as long as they have no state in common.
  bool is_to_be_reversed(const Pattern& pattern) const {
    if (has_common_state(pattern)) return false;
    const auto number = [](const std::string& name) {
      const auto digits = name.find_last_not_of("0123456789") + 1;
      return whole_number(name.substr(digits));
    };
    for (const auto& slot : pattern.slots) {
      const auto first = number(slot.texts[0]), second = number(slot.texts[1]);
      if (is_identifier_start(slot.texts[0][0]) && first && second) return *first > *second;
    }
    return false;
  }
  bool has_common_state(const Pattern& pattern) const {
    for (std::size_t s = 0; s < pattern.period; ++s) {
      const auto& tokens = list_[pattern.first + s];
      for (std::size_t t = 0; t < tokens.size(); ++t)
        if (is_member(tokens, t) && std::ranges::none_of(pattern.slots, [&](const Slot& slot) {
              return slot.statement == s && slot.token == t;
            }))
          return true;
    }
    return false;
  }

  struct Loop {
    std::vector<std::string> before, body, after;
  };
  /// What stands for the names of all lanes.
  using Replaced = std::map<std::pair<Role, Names>, std::string>;

  std::vector<Statement> roll_one(Pattern pattern) {
    const std::size_t variables = add_variables(pattern);
    find_slots(pattern);
    if (is_to_be_reversed(pattern))
      for (auto& slot : pattern.slots) std::ranges::reverse(slot.texts);
    Loop loop;
    Replaced replaced;
    std::vector<Tokens> lane(list_.begin() + static_cast<std::ptrdiff_t>(pattern.first),
                             list_.begin() + static_cast<std::ptrdiff_t>(pattern.first + pattern.period));
    for (const auto& slot : pattern.slots) {
      auto& token = lane[slot.statement][slot.token].text;
      const auto role = role_of(pattern, slot);
      switch (role) {
        case Role::Number:
          token = number_of_lane(slot.texts);
          break;
        case Role::Member:
          token = replacement(replaced, role, slot.texts, [&] { return make_member(slot.texts); });
          break;
        case Role::Table:
          token = replacement(replaced, role, slot.texts, [&] { return make_table(slot.texts); });
          break;
        case Role::Local: {
          const bool definition = defines(list_[pattern.first + slot.statement], slot.token);
          token = replacement(replaced, role, slot.texts,
                              [&] { return make_local(pattern, slot.texts, lane[slot.statement], loop); });
          // An element of an array has its type already.
          if (definition && token.ends_with("[lane]"))
            for (std::size_t t = 0; t < 4; ++t) lane[slot.statement][t].text.clear();
          break;
        }
        case Role::Variable:  // by now a local
        case Role::None:      // in no pattern
          break;
      }
    }
    for (std::size_t s = 0; s < lane.size(); ++s)
      loop.body.push_back(text_of({lane[s].begin() + (s < variables ? 2 : 0), lane[s].end()}));
    std::ranges::move(loop.after, std::back_inserter(loop.body));
    return written(loop, pattern.lanes);
  }

  static std::vector<Statement> written(const Loop& loop, std::size_t lanes) {
    std::vector<Statement> statements;
    for (const auto& text : loop.before) statements.push_back({text});
    std::string text;
    for (const auto& line : loop.body) text += (text.empty() ? "" : "\n") + line;
    statements.push_back({text, 1, static_cast<int>(lanes)});
    return statements;
  }

  template <class Make>
  static std::string replacement(Replaced& replaced, Role role, const Names& names, Make make) {
    const auto found = replaced.find({role, names});
    return found != replaced.end() ? found->second : replaced[{role, names}] = make();
  }

  /// Declares the variables of a lane at its start, as statements of their own; returns how many.
  std::size_t add_variables(Pattern& pattern) {
    std::vector<Names> all;
    for (const auto& slot : pattern.slots)
      if (role_of(pattern, slot) == Role::Variable && std::ranges::find(all, slot.texts) == all.end())
        all.push_back(slot.texts);
    if (all.empty()) return 0;
    std::vector<Tokens> list;
    for (std::size_t lane = 0; lane < pattern.lanes; ++lane) {
      for (const auto& names : all) list.push_back(tokens_of("const " + variables_.at(names[lane])));
      const auto from = list_.begin() + static_cast<std::ptrdiff_t>(pattern.first + lane * pattern.period);
      list.insert(list.end(), from, from + static_cast<std::ptrdiff_t>(pattern.period));
    }
    for (const auto& names : all)
      for (const auto& name : names) {
        std::erase(program_.variables, variables_.at(name));
        variables_.erase(name);
      }
    list_.erase(list_.begin() + static_cast<std::ptrdiff_t>(pattern.first),
                list_.begin() + static_cast<std::ptrdiff_t>(pattern.end()));
    list_.insert(list_.begin() + static_cast<std::ptrdiff_t>(pattern.first), list.begin(), list.end());
    pattern.period += all.size();
    return all.size();
  }

  /// A name that a lane defines is read in the same lane, or behind all of them.
  bool locals_stay_in_their_lanes(const Pattern& pattern) const {
    std::map<std::string, const Names*> defined;
    for (const auto& slot : pattern.slots)
      if (role_of(pattern, slot) == Role::Local)
        for (const auto& name : slot.texts) {
          const auto [at, added] = defined.emplace(name, &slot.texts);
          if (!added && *at->second != slot.texts) return false;
        }
    for (std::size_t s = pattern.first; s < pattern.end(); ++s)
      for (std::size_t t = 0; t < list_[s].size(); ++t) {
        const auto at = defined.find(list_[s][t].text);
        if (at == defined.end() || is_field(list_[s], t)) continue;
        if ((*at->second)[(s - pattern.first) / pattern.period] != list_[s][t].text) return false;
      }
    return true;
  }

  /// A number that counts with the lanes, or a table.
  std::string number_of_lane(const Names& texts) {
    std::vector<long> whole;
    for (const auto& text : texts)
      if (const auto value = whole_number(text)) whole.push_back(*value);
    if (whole.size() == texts.size()) {
      const long step = whole[1] - whole[0];
      bool even = step == 1 || step == -1;
      for (std::size_t i = 1; i < whole.size(); ++i) even = even && whole[i] - whole[i - 1] == step;
      if (even && step == 1) return whole[0] == 0 ? "lane" : fmt::format("{} + lane", whole[0]);
      if (even) return fmt::format("{} - lane", whole[0]);
    }
    const bool real = whole.empty();
    const auto known = number_tables_.find(texts);
    if (known != number_tables_.end()) return known->second + "[lane]";
    const auto name = unique_name(real ? "tactus_data_lanes" : "tactus_data_places", taken_);
    program_.tables.push_back(
        fmt::format("static const {} {}[] = {};", real ? "tactus_real" : "int", name, c_list(texts, 6)));
    program_.table_bytes += (real ? 8 : 4) * texts.size();
    number_tables_[texts] = name;
    return name + "[lane]";
  }

  std::string make_member(const Names& names) {
    const auto place = members_.at(names.front());
    const auto declared = *Declaration::read(program_.members[place].declaration);
    const auto name = unique_name(common_name(names), taken_members_);
    auto& first = program_.members[place];
    for (std::size_t i = 1; i < names.size(); ++i) {
      auto& other = program_.members[members_.at(names[i])];
      first.bytes += other.bytes;
      other.declaration.clear();
    }
    first.declaration = fmt::format("{} {}[{}]{}", declared.type, name, names.size(), declared.count);
    first.about += fmt::format(", and {} alike", names.size() - 1);
    become(names, name, member_renames_);
    for (const auto& each : names) members_.erase(each);
    members_[name] = place;
    return name + "[lane]";
  }

  std::string make_table(const Names& names) {
    const auto place = tables_.at(names.front());
    const auto declared = *Declaration::read(program_.tables[place]);
    const auto name = unique_name(common_name(names), taken_);
    std::string table = fmt::format("{} {}[{}] = {{", declared.type, name, names.size());
    for (std::size_t i = 0; i < names.size(); ++i) {
      auto& text = program_.tables[tables_.at(names[i])];
      auto value = Declaration::read(text)->rest;
      value = value.substr(value.find('{'));
      table += (i == 0 ? "\n    " : ",\n    ") + value.substr(0, value.rfind(';'));
      text.clear();
    }
    program_.tables[place] = table + "};";
    become(names, name, renames_);
    for (const auto& each : names) tables_.erase(each);
    tables_[name] = place;
    return name + "[lane]";
  }

  /// An array if something behind the loop reads it. Where all lanes are checked, the loop does it.
  std::string make_local(const Pattern& pattern, const Names& names, const Tokens& definition, Loop& loop) {
    const auto name = unique_name(common_name(names), taken_);
    const auto checked = std::ranges::count_if(names, [&](const auto& each) { return is_checked(each); });
    const bool all = checked == std::ssize(names);
    const bool outside = (checked > 0 && !all) || std::ranges::any_of(names, [&](const std::string& each) {
                           return !only_within(pattern, each);
                         });
    const auto value = outside ? name + "[lane]" : name;
    if (all) {
      const auto fault = unique_name(name + "_fault", taken_);
      loop.before.push_back(fmt::format("int {} = 0;", fault));
      loop.after.push_back(fmt::format("{0} |= {1} - {1} != 0;", fault, value));
      program_.faults.push_back(fault);
      std::erase_if(program_.checked,
                    [&](const std::string& each) { return std::ranges::find(names, each) != names.end(); });
    }
    if (outside) {
      loop.before.push_back(fmt::format("{} {}[{}];", definition[2].text, name, names.size()));
      become(names, name, renames_);
    }
    return value;
  }

  /// From now on each name is an element of an array, wherever else it is mentioned.
  void become(const Names& names, const std::string& array, std::map<std::string, std::string>& renames) {
    for (std::size_t i = 0; i < names.size(); ++i) renames[names[i]] = fmt::format("{}[{}]", array, i);
    for (auto* list : {&program_.variables, &program_.start, &program_.follow, &program_.designs,
                       &program_.checked, &program_.tables})
      for (auto& text : *list) text = renamed(text);
    for (auto& [name, text] : variables_) text = renamed(text);
    for (auto& statement : program_.frame) statement.text = renamed(statement.text);
  }
  std::string renamed(const std::string& text) const {
    if (renames_.empty() && member_renames_.empty()) return text;
    const auto tokens = tokens_of(text);
    std::string result;
    for (std::size_t t = 0; t < tokens.size(); ++t) {
      const auto& renames = is_member(tokens, t) ? member_renames_ : renames_;
      const bool other = is_field(tokens, t) && !is_member(tokens, t);
      const auto found = other ? renames.end() : renames.find(tokens[t].text);
      result += found == renames.end() ? tokens[t].text : found->second;
    }
    return result;
  }

  void drop_gaps() {
    std::erase_if(program_.members, [](const ProgramMember& member) { return member.declaration.empty(); });
    std::erase_if(program_.tables, [](const std::string& table) { return table.empty(); });
  }

  CProgram& program_;
  std::map<std::string, std::size_t> members_, tables_;  ///< by name
  std::map<std::string, std::string> variables_;         ///< their declarations
  std::set<std::string> taken_, taken_members_;
  std::vector<Tokens> list_;
  std::vector<std::string> shapes_;
  std::map<std::string, std::string> renames_, member_renames_;
  std::map<Names, std::string> number_tables_;
};

}  // namespace

void roll_lanes(CProgram& program) { LaneRoller{program}.run(); }

}  // namespace tactus
