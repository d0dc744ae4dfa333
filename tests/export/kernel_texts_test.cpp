#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

// In floats, exported programs call floorf instead of floor, and avr-libc makes macros of such names. So no
// variable of a kernel has the name of a function of math.h; and kernels call no function that avr-libc
// lacks.
TEST_CASE("export: kernels name no variable like a function, and call what every C library has") {
  const std::regex comment{"//[^\n]*"}, string{"\"[^\"\n]*\""};
  const std::regex variable{
      "\\b(acos|asin|atan|atan2|ceil|cos|exp|fabs|floor|fmod|log|log10|log1p|log2|pow|rint|round|sin|sinh|"
      "sqrt|tan|"
      "tanh|trunc|cosh|expm1|hypot)\\b(?!\\s*\\()"};
  int kernels = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(TACTUS_SOURCE_DIR "/engine")) {
    if (!entry.path().string().ends_with("_kernel.h")) continue;
    ++kernels;
    std::stringstream text;
    text << std::ifstream{entry.path()}.rdbuf();
    const auto code = std::regex_replace(std::regex_replace(text.str(), comment, ""), string, "");
    INFO(entry.path());
    std::smatch found;
    std::regex_search(code, found, variable);
    CHECK(found.str() == "");
    CHECK(code.find("llround") == std::string::npos);
  }
  CHECK(kernels > 40);
}
