#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

// Every public function says from which thread it may be called: [control], [realtime] or [any] in its
// comment, in that of its class, or for a whole header in the line below `#pragma once`:  // Thread:
// [control]

namespace {

namespace fs = std::filesystem;

bool has_tag(const std::string& comment) {
  for (const auto* tag : {"[control", "[realtime", "[any"})
    if (comment.find(tag) != std::string::npos) return true;
  return false;
}

/// Finds functions by the formatter's layout: declarations of a namespace begin in column 0, those of a class
/// in column 2; a comment is for the lines below it up to an empty line.
class HeaderReader {
 public:
  std::vector<std::string> untagged(std::istream& header) {
    std::vector<std::string> found;
    for (std::string line; std::getline(header, line);) {
      if (line.starts_with("// Thread: ") && has_tag(line)) return {};
      if (read(line)) found.push_back(line);
    }
    return found;
  }

 private:
  /// True for a public function without a tag.
  bool read(const std::string& line) {
    static const std::regex begins_class{R"(^(class|struct) (\w+)( final)?( :.*)?\s*\{$)"};
    static const std::regex function{R"(^(  )?[A-Za-z_~\[][\w:<>,&*\s\[\]~]*[\w=<>+*/\]-]\()"};
    static const std::regex no_function{
        R"(^\s*(return|if|for|while|switch|using|friend|static_assert|case|else|template|TACTUS|public|private)\b)"};
    if (line.empty() || line.starts_with("#")) return comment_.clear(), false;
    const auto first = line.find_first_not_of(' ');
    if (line.compare(first, 2, "//") == 0) {
      if (!in_comment_) comment_.clear();
      in_comment_ = true;
      comment_ += line;
      return false;
    }
    in_comment_ = false;
    if (std::regex_search(line, begins_class)) {
      class_is_tagged_ = has_tag(comment_);
      public_ = line.starts_with("struct");
      in_class_ = true;
      comment_.clear();
      return false;
    }
    if (line == "};") return in_class_ = false, comment_.clear(), false;
    if (line == " public:") return public_ = true, false;
    if (line == " private:" || line == " protected:") return public_ = false, false;
    if (first != (in_class_ ? 2U : 0U) || (in_class_ && (!public_ || class_is_tagged_))) return false;
    if (line.find("= default") != std::string::npos || line.find("= delete") != std::string::npos)
      return false;
    if (line.find(" override") != std::string::npos || line.find("  ~") == 0) return false;
    if (!std::regex_search(line, function) || std::regex_search(line, no_function)) return false;
    return !has_tag(comment_);
  }

  std::string comment_;
  bool in_comment_ = false, in_class_ = false, class_is_tagged_ = false, public_ = false;
};

std::vector<std::string> untagged(const std::string& text) {
  std::istringstream stream{text};
  return HeaderReader{}.untagged(stream);
}

/// "file: declaration" of every public function without a tag below a folder.
std::vector<std::string> untagged_in(const std::string& folder) {
  const fs::path root = TACTUS_SOURCE_DIR;
  std::vector<std::string> found;
  for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
    if (entry.path().extension() != ".h") continue;
    std::ifstream header{entry.path()};
    for (const auto& line : HeaderReader{}.untagged(header))
      found.push_back(fs::relative(entry.path(), root).generic_string() + ":" + line);
  }
  std::sort(found.begin(), found.end());
  return found;
}

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const auto& line : lines) text += line + "\n";
  return text;
}

}  // namespace

TEST_CASE("thread tags: every public function has one", "[layers]") {
  const std::string folder = GENERATE("engine", "backends", "latency", "remote", "apps", "python");
  CHECK(joined(untagged_in(folder)) == "");
}

TEST_CASE("thread tags: a function without one is found, one with a tag is not", "[layers]") {
  CHECK(untagged("int f(int x);\n").size() == 1);
  CHECK(untagged("/// [any] Twice.\nint f(int x);\nint g();\n").empty());
  CHECK(untagged("/// [any] Twice.\nint f(int x);\n\nint g();\n").size() == 1);
  CHECK(untagged("#pragma once\n// Thread: [control]\nint f(int x);\n").empty());
  CHECK(untagged("class A {\n public:\n  int f() const;\n private:\n  int g();\n};\n").size() == 1);
  CHECK(untagged("/// [realtime]\nclass A {\n public:\n  int f() const;\n};\n").empty());
  CHECK(untagged("struct A {\n  int x = 0;\n  std::vector<int> y;\n};\n").empty());
}
