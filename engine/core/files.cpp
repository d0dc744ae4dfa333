#include "engine/core/files.h"

#include <fstream>
#include <random>
#include <system_error>

namespace tactus {

namespace fs = std::filesystem;

namespace {

Status cannot_write(const fs::path& file) {
  return fail(Errc::BadFile, file.generic_string(), "cannot be written",
              "choose an existing, writable folder");
}

}  // namespace

Status write_file(const fs::path& file, const std::string& text) {
  std::ofstream stream{file, std::ios::binary};
  stream << text;
  stream.close();
  return stream ? Status{} : cannot_write(file);
}

Status replace_file(const fs::path& file, const std::string& text) {
  auto temporary = file;
  temporary += ".new" + std::to_string(std::random_device{}());  // no other program takes this name too
  auto status = write_file(temporary, text);
  std::error_code error, ignored;
  if (status) fs::rename(temporary, file, error);
  if (status && !error) return {};
  fs::remove(temporary, ignored);
  return cannot_write(file);
}

Status replace_file_with_backup(const std::filesystem::path& file, const std::string& text) {
  std::error_code ignored;
  auto former = file;
  former += "~";
  std::filesystem::copy_file(file, former, std::filesystem::copy_options::overwrite_existing, ignored);
  return replace_file(file, text);
}

}  // namespace tactus
