# Writes OUTPUT, a C++ file with the text of FILES (paths below ROOT, separated by "|"): export/kernel_texts.h declares them.
#   cmake -DOUTPUT=… -DROOT=… -DFILES=… -P embed_kernels.cmake
# FUNCTION and HEADER: what returns them, and where it is declared (default: kernel_files, export/kernel_texts.h).
if(NOT FUNCTION)
  set(FUNCTION kernel_files)
  set(HEADER export/kernel_texts.h)
endif()
set(arrays "")
set(table "")
string(REPLACE "|" ";" files "${FILES}")
set(number 0)
foreach(file ${files})
  file(READ ${ROOT}/${file} bytes HEX)
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${bytes}")
  string(REGEX REPLACE "((0x..,)(0x..,)(0x..,)(0x..,)(0x..,)(0x..,)(0x..,)(0x..,))" "\\1\n" bytes "${bytes}")
  string(APPEND arrays "constexpr unsigned char kFile${number}[] = {\n${bytes}0x00};\n")
  string(APPEND table "    {\"${file}\", text(kFile${number})},\n")
  math(EXPR number "${number} + 1")
endforeach()
file(WRITE ${OUTPUT} "// Written by cmake/embed_kernels.cmake.
#include \"${HEADER}\"

namespace tactus {
namespace {

${arrays}
template <std::size_t Size>
std::string_view text(const unsigned char (&bytes)[Size]) {
  return {reinterpret_cast<const char*>(bytes), Size - 1};
}

}  // namespace

std::span<const KernelFile> ${FUNCTION}() {
  static const KernelFile kFiles[] = {
${table}  };
  return kFiles;
}

}  // namespace tactus
")
