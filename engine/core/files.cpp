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

/// Writes it beside `file`, calls `before`, and gives it the name of `file`.
template <class Before>
Status replace_after(const fs::path& file, const std::string& text, Before before) {
  auto temporary = file;
  temporary += ".new" + std::to_string(std::random_device{}());  // no other program takes this name too
  auto status = write_file(temporary, text);
  std::error_code error, ignored;
  if (status) before();
  if (status) fs::rename(temporary, file, error);
  if (status && !error) return {};
  fs::remove(temporary, ignored);
  return cannot_write(file);
}

}  // namespace

Status write_file(const fs::path& file, const std::string& text) {
  std::ofstream stream{file, std::ios::binary};
  stream << text;
  stream.close();
  return stream ? Status{} : cannot_write(file);
}

Status replace_file(const fs::path& file, const std::string& text) {
  return replace_after(file, text, [] {});
}

Status replace_file_with_backup(const fs::path& file, const std::string& text) {
  return replace_after(file, text, [&] {
    auto former = file;
    former += "~";
    std::error_code error, ignored;
    if (!fs::exists(file, ignored)) return;
    fs::remove(former, ignored);
    fs::create_hard_link(file, former, error);  // takes no space, and the file is there all the time
    if (error) fs::copy_file(file, former, ignored);
  });
}

}  // namespace tactus
