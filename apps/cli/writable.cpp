#include "apps/cli/writable.h"

#include <fstream>

namespace tactus::app {
namespace {

namespace fs = std::filesystem;

bool opens(const fs::path& file) {
  std::error_code none;
  const auto kind = fs::status(file, none).type();
  if (kind == fs::file_type::directory) return false;
  // A pipe would wait for its reader.
  if (kind != fs::file_type::not_found && kind != fs::file_type::regular) return true;
  const bool opened = std::ofstream{file, std::ios::app}.is_open();
  if (kind == fs::file_type::not_found) fs::remove(file, none);
  return opened;
}

tl::unexpected<Error> not_writable(const fs::path& path, const char* hint) {
  return fail(Errc::BadFile, path.string(), "cannot be written", hint);
}

CLI::Validator asks(Status (*can_write)(const fs::path&)) {
  return {[can_write](const std::string& text) {
            const auto status = text.empty() ? Status{} : can_write(text);
            return status ? std::string{} : to_string(status.error());
          },
          ""};
}

}  // namespace

Status can_write_file(const fs::path& file) {
  if (opens(file)) return {};
  return not_writable(file, "choose a file in an existing, writable folder");
}

Status can_write_into(const fs::path& folder) {
  std::error_code none;
  auto there = fs::absolute(folder, none).lexically_normal();
  while (!fs::exists(there, none) && there.has_relative_path()) there = there.parent_path();
  if (fs::is_directory(there, none) && opens(there / ".tactus_tries_to_write")) return {};
  return not_writable(folder, "choose a writable folder");
}

CLI::Validator writable_file() { return asks(can_write_file); }
CLI::Validator writable_folder() { return asks(can_write_into); }

}  // namespace tactus::app
