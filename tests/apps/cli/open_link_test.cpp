#include "apps/cli/open_link.h"

#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <optional>

#include "tests/support/temporary_folder.h"
#include "tests/support/wait_until.h"

using namespace tactus;

namespace {

/// Environment variables of this process, as they were before at its end.
class Environment {
 public:
  void set(const char* name, const std::string& value) {
    const char* before = std::getenv(name);
    before_.emplace_back(name, before != nullptr ? std::optional<std::string>{before} : std::nullopt);
    ::setenv(name, value.c_str(), 1);
  }
  void unset(const char* name) {
    set(name, "");
    ::unsetenv(name);
  }
  ~Environment() {
    for (auto one = before_.rbegin(); one != before_.rend(); ++one)
      one->second ? ::setenv(one->first, one->second->c_str(), 1) : ::unsetenv(one->first);
  }

 private:
  std::vector<std::pair<const char*, std::optional<std::string>>> before_;
};

std::string text_of(const std::filesystem::path& file) {
  std::ifstream in{file};
  return {std::istreambuf_iterator<char>{in}, {}};
}

}  // namespace

TEST_CASE("open link: the browser is given a file that only this user may read, and that leads to the link") {
  const test::TemporaryFolder folder;
  const auto opener = folder.write("xdg-open",
                                   "#!/bin/sh\necho \"$#\" \"$1\" > \"$TACTUS_OPENED.new\"\nmv "
                                   "\"$TACTUS_OPENED.new\" \"$TACTUS_OPENED\"\n");
  std::filesystem::permissions(opener, std::filesystem::perms::owner_all);
  const auto opened = folder.path() / "opened";
  Environment environment;
  environment.set("PATH", folder.path().string() + ":" + std::getenv("PATH"));
  environment.set("TMPDIR", folder.path().string());
  environment.set("TACTUS_OPENED", opened.string());
  environment.set("DISPLAY", ":7");
  std::filesystem::path page;
  {
    const app::OpenedLink link{"http://127.0.0.1:8080/#secret"};
    REQUIRE(test::wait_until([&] { return std::filesystem::exists(opened); }));
    auto words = text_of(opened);
    CHECK(words.starts_with("1 "));
    page = words.substr(2, words.find('\n') - 2);
    CHECK(words.find("secret") == std::string::npos);
    CHECK(text_of(page).find("url=http://127.0.0.1:8080/#secret\"") != std::string::npos);
    struct stat state {};
    REQUIRE(::stat(page.c_str(), &state) == 0);
    CHECK((state.st_mode & 0777U) == 0600U);
  }
  CHECK_FALSE(std::filesystem::exists(page));

  std::filesystem::remove(opened);
  environment.unset("DISPLAY");
  environment.unset("WAYLAND_DISPLAY");
  const app::OpenedLink no_desktop{"http://127.0.0.1:8080/#secret"};
  for (const auto& entry : std::filesystem::directory_iterator{folder.path()})
    CHECK(entry.path().extension() != ".html");
}
