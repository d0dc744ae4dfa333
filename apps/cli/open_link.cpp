#include "apps/cli/open_link.h"

#include <cstdlib>
#include <fstream>
#ifdef _WIN32
#include <windows.h>
// Its types come first.
#include <shellapi.h>
#else
#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <thread>

extern char** environ;
#endif

namespace tactus::app {

#ifdef _WIN32
OpenedLink::OpenedLink(const std::string& link) {
  ShellExecuteA(nullptr, "open", link.c_str(), nullptr, nullptr, SW_SHOWNORMAL);
}
#else
namespace {

[[maybe_unused]] bool set(const char* variable) {
  const char* value = std::getenv(variable);
  return value != nullptr && *value != '\0';
}

/// nullptr: there is no desktop.
const char* opener() {
#ifdef __APPLE__
  return "open";
#else
  return set("DISPLAY") || set("WAYLAND_DISPLAY") ? "xdg-open" : nullptr;
#endif
}

/// A page that leads to the link, for this user alone; empty where it cannot be written.
std::filesystem::path write_page(const std::string& link) {
  std::error_code error;
  auto name = (std::filesystem::temp_directory_path(error) / "tactus-panel-XXXXXX.html").string();
  const int file = error ? -1 : ::mkstemps(name.data(), 5);  // only its owner may read it
  if (file < 0) return {};
  ::close(file);
  std::ofstream{name} << "<!doctype html><meta http-equiv=\"refresh\" content=\"0; url=" << link << "\">\n";
  return name;
}

/// What it prints would disturb the status line.
void run_silently(const char* program, const std::string& argument) {
  posix_spawn_file_actions_t silent;
  posix_spawn_file_actions_init(&silent);
  posix_spawn_file_actions_addopen(&silent, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&silent, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_adddup2(&silent, STDOUT_FILENO, STDERR_FILENO);
  std::string name = program, given = argument;
  char* arguments[] = {name.data(), given.data(), nullptr};
  pid_t process = 0;
  const bool began = posix_spawnp(&process, program, &silent, nullptr, arguments, environ) == 0;
  posix_spawn_file_actions_destroy(&silent);
  if (began) std::thread{[process] { waitpid(process, nullptr, 0); }}.detach();
}

}  // namespace

OpenedLink::OpenedLink(const std::string& link) {
  const char* program = opener();
  if (program == nullptr) return;
  file_ = write_page(link);
  if (!file_.empty()) run_silently(program, file_.string());
}
#endif

OpenedLink::~OpenedLink() {
  std::error_code ignored;
  if (!file_.empty()) std::filesystem::remove(file_, ignored);
}

}  // namespace tactus::app
