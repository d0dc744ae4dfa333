#include "engine/graph/semantics/expression.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "engine/core/dimension.h"
#include "engine/core/index.h"
#include "engine/core/parse_double.h"
#include "engine/graph/file/error_list.h"
#include "engine/graph/semantics/operators.h"

namespace tactus {
namespace {

// Both bound the depth of the tree, and with it every recursion over it.
constexpr int kExpressionMaxDepth = 64;
constexpr int kMaxValues = 1000;
constexpr int kMaxLanes = 1024;

bool digit(char c) { return c >= '0' && c <= '9'; }
bool letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

/// name { "." name }
bool dotted_name(std::string_view word) {
  const auto dot = word.find('.');
  if (dot == std::string_view::npos) return is_name(word);
  return is_name(word.substr(0, dot)) && dotted_name(word.substr(dot + 1));
}

class Parser {
  using Op = Expression::Op;

 public:
  Parser(std::string_view text, const Source& at) : text_(text), at_(at) {}

  Result<Expression> whole() {
    auto value = comparison();
    if (!value) return value;
    skip_space();
    if (here_ == text_.size()) return value;
    if (peek() == ')') return syntax(here_, "')' has no '(' before it", "remove it");
    if (peek() == ',')
      return syntax(here_, "',' is only allowed between the arguments of a function",
                    "write decimals with a point");
    if (const auto* other = other_operator())
      return syntax(here_, "'" + std::string{other->sign} + "' is not an operator", other->remedy);
    return syntax(here_, found() + " found where an operator was expected", "put + - * or / before it");
  }

 private:
  /// Operators of other languages.
  struct OtherOperator {
    std::string_view sign;
    const char* remedy;
  };
  const OtherOperator* other_operator() const {
    static constexpr std::array<OtherOperator, 8> kOthers{
        {{"^", "write pow(a, b)"},
         {"%", "write mod(a, b)"},
         {"=", "write == to compare"},
         {"&&", "multiply comparisons: (a > 0) * (b > 0)"},
         {"&", "multiply comparisons: (a > 0) * (b > 0)"},
         {"||", "take the larger of two comparisons: max(a > 0, b > 0)"},
         {"|", "take the larger of two comparisons: max(a > 0, b > 0)"},
         {"?", "write select(condition, a, b)"}}};
    const auto* const other = std::ranges::find_if(
        kOthers, [this](const OtherOperator& entry) { return text_.substr(here_).starts_with(entry.sign); });
    return other == kOthers.end() ? nullptr : other;
  }

  /// How a function of other languages is written here; nullptr: no such one.
  static const char* other_function(std::string_view name) {
    static constexpr std::array<OtherOperator, 8> kOthers{
        {{"mtof", "write 440 Hz * pow(2, (note - 69) / 12)"},
         {"midicps", "write 440 Hz * pow(2, (note - 69) / 12)"},
         {"dbamp", "give the level its unit: -6 dB"},
         {"dbtorms", "give the level its unit: -6 dB"},
         {"if", "write select(condition, a, b)"},
         {"fmod", "write mod(a, b)"},
         {"clip", "write clamp(x, low, high)"},
         {"lerp", "write mix(a, b, share)"}}};
    const auto* const other = std::ranges::find(kOthers, name, &OtherOperator::sign);
    return other == kOthers.end() ? nullptr : other->remedy;
  }

  /// sum [ sign sum ]
  Result<Expression> comparison() {
    auto left = sum();
    const auto* sign = left ? comparison_here() : nullptr;
    if (sign == nullptr) return left;
    auto whole = make(sign->op, here_);
    here_ += std::string_view{sign->name}.size();
    auto right = sum();
    if (!right) return right;
    if (const auto* second = comparison_here())
      return syntax(here_, "'" + std::string{second->name} + "' follows another comparison",
                    "compare in brackets, as in (a < b) * (b < c)");
    whole.arguments.push_back(std::move(*left));
    whole.arguments.push_back(std::move(*right));
    return whole;
  }

  /// The longest sign that is here, or nullptr.
  const Operator* comparison_here() {
    skip_space();
    const Operator* longest = nullptr;
    for (auto op = Op::Less; op <= Op::NotEqual; op = static_cast<Op>(static_cast<int>(op) + 1)) {
      const std::string_view sign = operator_of(op).name;
      if (!text_.substr(here_).starts_with(sign)) continue;
      if (longest == nullptr || sign.size() > std::string_view{longest->name}.size())
        longest = &operator_of(op);
    }
    return longest;
  }

  Result<Expression> sum() { return chain('+', Op::Add, '-', Op::Subtract, &Parser::product); }
  Result<Expression> product() { return chain('*', Op::Multiply, '/', Op::Divide, &Parser::factor); }

  /// operand { sign operand }, grouped from the left.
  Result<Expression> chain(char a, Expression::Op op_a, char b, Expression::Op op_b,
                           Result<Expression> (Parser::*operand)()) {
    auto left = (this->*operand)();
    while (left) {
      skip_space();
      if (peek() != a && peek() != b) break;
      auto whole = make(peek() == a ? op_a : op_b, here_);
      ++here_;
      auto right = (this->*operand)();
      if (!right) return right;
      whole.arguments.push_back(std::move(*left));
      whole.arguments.push_back(std::move(*right));
      left = std::move(whole);
    }
    return left;
  }

  Result<Expression> factor() {
    skip_space();
    if (depth_ == kExpressionMaxDepth)
      return syntax(here_, "signs and brackets are nested more than 64 deep", "use nodes");
    ++depth_;
    auto value = unnested_factor();
    --depth_;
    return value;
  }

  Result<Expression> unnested_factor() {
    const char c = peek();
    if (digit(c) || (c == '.' && digit(peek(1)))) return number(here_, 1);
    if (letter(c)) return word();
    if (c == '-') return negative();
    if (c == '(') return bracket();
    if (here_ == text_.size())
      return syntax(here_,
                    text_.find_first_not_of(" \t\r\n") == text_.npos ? "the expression is empty"
                                                                     : "the expression is incomplete",
                    "write a number, a name or '(' here");
    return syntax(here_, found() + " found where a value was expected", "write a number, a name or '(' here");
  }

  Result<Expression> negative() {
    const auto start = here_++;
    skip_space();
    // "-34 dB" is a small gain, not a gain of 34 dB turned upside down.
    if (digit(peek()) || (peek() == '.' && digit(peek(1)))) return number(start, -1);
    auto value = factor();
    if (!value) return value;
    return Expression{.op = Op::Negate, .arguments = {std::move(*value)}, .at = place(start)};
  }

  Result<Expression> bracket() {
    const auto start = here_++;
    auto value = comparison();
    if (value && !take(')')) return unclosed(start);
    return value;
  }

  Result<Expression> number(std::size_t start, double sign) {
    if (++values_ > kMaxValues) return too_long(start);
    double value = 0;
    const auto parsed = parse_double(text_.data() + here_, text_.data() + text_.size(), value);
    const auto digits = text_.substr(here_, index(parsed.ptr - text_.data()) - here_);
    if (parsed.ec != std::errc{})
      return syntax(start, "the number " + std::string{digits} + " is too large or too small",
                    "use a number between 1e-300 and 1e300");
    here_ += digits.size();
    auto whole = make(Op::Number, start);
    whole.bare = true;
    whole.number = without_denormals(sign * value);
    skip_space();
    const auto unit_start = here_;
    const auto unit_text = unit_prefix(text_.substr(here_));
    if (unit_text.empty() && letter(peek())) return not_a_unit(digits);
    if (unit_text.empty()) return whole;
    here_ += unit_text.size();
    const auto unit = parse_unit(unit_text);
    if (!unit)
      return syntax(unit_start, "'" + std::string{unit_text} + "' is not a unit",
                    "units look like ms, mm/s, N/m^1.5 or dB");
    whole.number = without_denormals(unit->to_si(sign * value));
    if (!std::isfinite(whole.number))
      return syntax(start, "the number " + std::string{digits} + " is too large", "use a number below 1e300");
    whole.dimension = unit->dimension;
    whole.bare = false;
    return whole;
  }

  Result<Expression> word() {
    const auto start = here_;
    const auto word = word_here();
    here_ += word.size();
    skip_space();
    if (const auto* type = find_function(word); type != nullptr && (peek() == '(' || is_reserved(word)))
      return function(start, *type);
    if (peek() == '(') {
      const auto* remedy = other_function(word);
      return syntax(start, "there is no function '" + word + "'",
                    remedy != nullptr ? remedy : suggest(word, function_names()));
    }
    if (const auto* constant = find_constant(word)) return number_called(*constant, start);
    if (!dotted_name(word))
      return syntax(start, "'" + word + "' is not a name",
                    "names consist of lower-case letters, digits and _; a port follows a dot");
    if (++values_ > kMaxValues) return too_long(start);
    auto whole = make(Op::Signal, start);
    whole.name = word;
    skip_space();
    return peek() == '[' ? lanes_of(std::move(whole)) : whole;
  }

  /// "[3]", "[0..3]", "[7..4, 0]": lanes of a signal, from 0.
  Result<Expression> lanes_of(Expression signal) {
    const auto open = here_++;
    auto whole = make(Op::Pick, open);
    do {
      const auto start = here_;
      const auto first = lane_number();
      const bool range = take_dots();
      const auto last = range ? lane_number() : first;
      if (!first || !last)
        return syntax(here_, "a lane is a whole number from 0 to " + std::to_string(kMaxLanes - 1),
                      "write " + signal.name + "[2], " + signal.name + "[0..3] or " + signal.name + "[3, 1]");
      const int step = *last < *first ? -1 : 1;
      for (int lane = *first; lane != *last + step; lane += step) whole.lanes.push_back(lane);
      if (std::ssize(whole.lanes) > kMaxLanes)
        return syntax(start, "more than " + std::to_string(kMaxLanes) + " lanes are taken", "take fewer");
    } while (take(','));
    if (!take(']')) return syntax(open, "'[' is not closed", "put ']' behind the lanes");
    whole.arguments.push_back(std::move(signal));
    return whole;
  }

  std::optional<int> lane_number() {
    skip_space();
    int lane = 0;
    const auto start = here_;
    for (; digit(peek()) && lane < kMaxLanes; ++here_) lane = 10 * lane + (peek() - '0');
    return here_ > start && lane < kMaxLanes ? std::optional{lane} : std::nullopt;
  }
  bool take_dots() {
    skip_space();
    if (!text_.substr(here_).starts_with("..")) return false;
    here_ += 2;
    return true;
  }

  Result<Expression> number_called(double value, std::size_t start) {
    if (++values_ > kMaxValues) return too_long(start);
    auto whole = make(Op::Number, start);
    whole.number = value;
    whole.bare = true;
    return whole;
  }

  Result<Expression> function(std::size_t start, const Operator& type) {
    const std::string quoted = "'" + std::string{type.name} + "'";
    auto whole = make(type.op, start);
    const auto open = here_;
    if (!take('(')) return syntax(here_, "'(' is missing after " + quoted, "write " + type.use());
    while (true) {
      auto argument = comparison();
      if (!argument) return argument;
      whole.arguments.push_back(std::move(*argument));
      skip_space();
      if (std::ssize(whole.arguments) == type.operands) break;
      if (peek() == ')') return syntax(here_, "too few values for " + quoted, "write " + type.use());
      if (!take(',')) return unclosed(open);
    }
    if (peek() == ',') return syntax(here_, "too many values for " + quoted, "write " + type.use());
    if (!take(')')) return unclosed(open);
    return whole;
  }

  tl::unexpected<Error> syntax(std::size_t offset, std::string what, std::string remedy) const {
    return fail(Errc::Syntax, place(offset).text(), std::move(what), std::move(remedy));
  }
  tl::unexpected<Error> too_long(std::size_t offset) const {
    return syntax(offset, "the expression has more than 1000 values", "split it into several nodes");
  }
  Result<Expression> unclosed(std::size_t open) const {
    if (here_ == text_.size()) return syntax(open, "'(' is not closed", "put ')' where it ends");
    if (const auto* other = other_operator())
      return syntax(here_, "'" + std::string{other->sign} + "' is not an operator", other->remedy);
    return syntax(here_, found() + " found where an operator or ')' was expected",
                  "put + - * or / before it, or ')'");
  }
  Result<Expression> not_a_unit(std::string_view digits) {
    skip_space();
    const auto word = word_here();
    const auto meant = meant_unit(word);
    return syntax(here_, "'" + word + "' is not a unit",
                  meant.empty() ? "to multiply, write " + std::string{digits} + " * " + word
                                : "did you mean " + meant + "?");
  }

  std::string word_here() const {
    const auto rest = text_.substr(here_);
    const auto end =
        std::find_if_not(rest.begin(), rest.end(), [](char c) { return letter(c) || digit(c) || c == '.'; });
    return {rest.begin(), end};
  }

  /// The word or character at this place, for messages.
  std::string found() const {
    if (const auto word = word_here(); !word.empty()) return "'" + word + "'";
    // Not half of a letter that takes several bytes in UTF-8.
    auto end = here_ + 1;
    for (; end < text_.size() && (static_cast<unsigned char>(text_[end]) & 0xC0u) == 0x80u; ++end) {
    }
    return "'" + std::string{text_.substr(here_, end - here_)} + "'";
  }

  Source place(std::size_t offset) const {
    Source place = at_;
    place.column += static_cast<int>(offset);
    return place;
  }
  Expression make(Op op, std::size_t offset) const { return {.op = op, .at = place(offset)}; }
  char peek(std::size_t ahead = 0) const {
    return here_ + ahead < text_.size() ? text_[here_ + ahead] : '\0';
  }
  void skip_space() {
    while (space(peek())) ++here_;
  }
  bool take(char c) {
    skip_space();
    if (peek() != c) return false;
    ++here_;
    return true;
  }

  std::string_view text_;
  Source at_;
  std::size_t here_ = 0;
  int depth_ = 0;
  int values_ = 0;
};

}  // namespace

bool is_reserved(std::string_view name) {
  return std::ranges::find(reserved_names(), name) != reserved_names().end();
}

bool is_name(std::string_view word) {
  return !word.empty() && word[0] >= 'a' && word[0] <= 'z' &&
         std::ranges::all_of(word, [](char c) { return (c >= 'a' && c <= 'z') || digit(c) || c == '_'; });
}

Result<Expression> parse_expression(std::string_view text, const Source& at) {
  return Parser{text, at}.whole();
}

Source text_start(const Value& value) {
  Source start = value.at;
  if (start.line > 0) ++start.column;
  return start;
}

}  // namespace tactus
