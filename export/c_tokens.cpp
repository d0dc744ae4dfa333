#include "export/c_tokens.h"

#include <cctype>

#include "export/number.h"

namespace tactus {

CTokens tokens_of(std::string_view text) {
  CTokens tokens;
  for (std::size_t at = 0; at < text.size();) {
    std::size_t end = at + 1;
    auto kind = CToken::Kind::Other;
    if (std::isdigit(static_cast<unsigned char>(text[at])) != 0) {
      kind = CToken::Kind::Number;
      while (end < text.size() && (is_identifier_part(text[end]) || text[end] == '.' ||
                                   ((text[end] == '-' || text[end] == '+') && text[end - 1] == 'e')))
        ++end;
    } else if (is_identifier_part(text[at])) {
      kind = CToken::Kind::Name;
      while (end < text.size() && is_identifier_part(text[end])) ++end;
    }
    tokens.push_back({kind, std::string{text.substr(at, end - at)}});
    at = end;
  }
  return tokens;
}

std::string text_of(const CTokens& tokens) {
  std::string text;
  for (const auto& token : tokens) text += token.text;
  return text;
}

bool is_field(const CTokens& tokens, std::size_t token) {
  return token > 0 && (tokens[token - 1].text == "." ||
                       (token > 1 && tokens[token - 1].text == ">" && tokens[token - 2].text == "-"));
}

bool is_member(const CTokens& tokens, std::size_t token) {
  return token > 2 && is_field(tokens, token) && tokens[token - 3].text == "s";
}

bool mentions_variable(const CTokens& tokens, const std::string& name) {
  for (std::size_t t = 0; t < tokens.size(); ++t)
    if (tokens[t].kind == CToken::Kind::Name && tokens[t].text == name && !is_field(tokens, t)) return true;
  return false;
}

}  // namespace tactus
