#include "export/targets/memory.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <map>
#include <string>

#include "export/kernel_texts.h"
#include "export/targets/c_text.h"

namespace tactus {
namespace {

constexpr std::array kMachines = {MachineType{"64 bits", 4, 8, 8, 4, 8, 8},
                                  MachineType{"32 bits (Cortex-M)", 4, 4, 4, 4, 8, 8},
                                  MachineType{"AVR", 2, 4, 2, 2, 4, 1}};

struct Size {
  std::size_t bytes = 0, alignment = 1;
};

std::vector<std::string> split(const std::string& text, char at) {
  std::vector<std::string> parts(1);
  for (const char c : text)
    if (c == at)
      parts.emplace_back();
    else
      parts.back() += c;
  return parts;
}

/// Sizes of the types that are declared in a C text of structs, enums and macros with numbers.
class Sizes {
 public:
  Sizes(const MachineType& machine, std::size_t number_bytes) : machine_(machine) {
    for (const auto& [name, bytes] :
         std::initializer_list<std::pair<const char*, std::size_t>>{{"tactus_real", number_bytes},
                                                                    {"char", 1},
                                                                    {"int", machine.of_int},
                                                                    {"long", machine.of_long},
                                                                    {"long long", 8},
                                                                    {"tactus_noise_bits", 8}})
      types_[name] = {bytes, std::min(bytes, machine.most_alignment)};
  }

  void define(const std::string& name, std::size_t value) { numbers_[name] = value; }
  /// A declaration without comments.
  void add(const std::string& code) {
    if (code.starts_with("#define ")) {
      const auto space = code.find(' ', 8);
      std::size_t value = 0;
      const auto text = code.substr(std::min(code.size(), code.find_first_not_of(' ', space)));
      std::from_chars(text.data(), text.data() + text.size(), value);
      return define(code.substr(8, space - 8), value);
    }
    const auto end = code.rfind('}');
    if (!code.starts_with("typedef") || end == std::string::npos) return;
    std::string name;
    for_each_identifier(code.substr(end), [&](std::string_view last) { name = last; });
    if (code.starts_with("typedef enum"))
      types_[name] = {machine_.of_enum, std::min(machine_.of_enum, machine_.most_alignment)};
    else
      types_[name] = struct_size(code.substr(code.find('{') + 1, end - code.find('{') - 1));
  }
  Size size(const std::string& type) const {
    const auto found = types_.find(type);
    return found == types_.end() ? Size{} : found->second;
  }

 private:
  Size struct_size(const std::string& fields) const {
    Size all;
    for (const auto& field : split(fields, ';')) add_field(field, all);
    all.bytes = (all.bytes + all.alignment - 1) / all.alignment * all.alignment;
    return all;
  }

  /// "const tactus_real *x, y[2]"
  void add_field(const std::string& field, Size& all) const {
    std::string type;
    std::size_t at = 0;
    const auto words = split_words(field, at);
    for (const auto& word : words) type += (type.empty() ? "" : " ") + word;
    if (type.empty()) return;
    for (const auto& declarator : split(field.substr(at), ',')) {
      const bool pointer = declarator.find('*') < declarator.find('[');
      const Size one = pointer
                           ? Size{machine_.of_pointer, std::min(machine_.of_pointer, machine_.most_alignment)}
                           : size(type);
      all.bytes =
          (all.bytes + one.alignment - 1) / one.alignment * one.alignment + one.bytes * count(declarator);
      all.alignment = std::max(all.alignment, one.alignment);
    }
  }

  /// The words of the type, without qualifiers; `at`: where the first name begins.
  static std::vector<std::string> split_words(const std::string& field, std::size_t& at) {
    std::vector<std::string> words;
    std::vector<std::size_t> begins;
    const auto end = std::min(field.find_first_of("*,[;"), field.size());
    for (std::size_t i = 0; i < end;) {
      if (!is_identifier_part(field[i])) {
        ++i;
        continue;
      }
      begins.push_back(i);
      std::size_t last = i;
      while (last < field.size() && is_identifier_part(field[last])) ++last;
      words.push_back(field.substr(i, last - i));
      i = last;
    }
    const bool pointer = end < field.size() && field[end] == '*';
    at = end;
    if (!pointer && !words.empty()) {
      at = begins.back();
      words.pop_back();
    }
    std::erase_if(words, [](const std::string& word) {
      return word == "const" || word == "volatile" || word == "unsigned" || word == "signed";
    });
    return words;
  }

  std::size_t count(const std::string& declarator) const {
    std::size_t all = 1;
    for (auto open = declarator.find('['); open != std::string::npos; open = declarator.find('[', open + 1))
      for (const auto& factor :
           split(declarator.substr(open + 1, declarator.find(']', open) - open - 1), '*'))
        all *= number(factor);
    return all;
  }
  std::size_t number(const std::string& text) const {
    std::string word;
    for (const char c : text)
      if (c != ' ') word += c;
    if (const auto found = numbers_.find(word); found != numbers_.end()) return found->second;
    std::size_t value = 1;
    std::from_chars(word.data(), word.data() + word.size(), value);
    return value;
  }

  const MachineType& machine_;
  std::map<std::string, Size> types_;
  std::map<std::string, std::size_t> numbers_;
};

}  // namespace

std::span<const MachineType> machine_types() { return kMachines; }

std::size_t state_bytes(const CProgram& program, const MachineType& machine) {
  Sizes sizes{machine, static_cast<std::size_t>(program.number->bytes)};
  for (const auto& declaration : type_declarations(program)) sizes.add(declaration);
  return sizes.size("tactus").bytes;
}

}  // namespace tactus
