# Writes OUTPUT, a C++ file with the bytes of FILES (name=path, separated by "|"), which FUNCTION returns; HEADER declares it:
# see tactus_embed_files.
#   cmake -DOUTPUT=… -DFUNCTION=… -DHEADER=… -DFILES=… -P embed_files.cmake
set(arrays "")
set(table "")
string(REPLACE "|" ";" files "${FILES}")
set(number 0)
foreach(file ${files})
  string(REGEX MATCH "^([^=]+)=(.+)$" parts "${file}")
  set(name ${CMAKE_MATCH_1})
  file(READ ${CMAKE_MATCH_2} bytes HEX)
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${bytes}")
  string(REGEX REPLACE "((0x..,)(0x..,)(0x..,)(0x..,)(0x..,)(0x..,)(0x..,)(0x..,))" "\\1\n" bytes "${bytes}")
  string(APPEND arrays "constexpr unsigned char kFile${number}[] = {\n${bytes}0x00};\n")
  string(APPEND table "    {\"${name}\", text(kFile${number})},\n")
  math(EXPR number "${number} + 1")
endforeach()
file(WRITE ${OUTPUT} "// Written by cmake/embed_files.cmake.
#include \"${HEADER}\"

namespace tactus {
namespace {

${arrays}
template <std::size_t Size>
std::string_view text(const unsigned char (&bytes)[Size]) {
  return {reinterpret_cast<const char*>(bytes), Size - 1};
}

}  // namespace

std::span<const EmbeddedFile> ${FUNCTION}() {
  static const EmbeddedFile kFiles[] = {
${table}  };
  return kFiles;
}

}  // namespace tactus
")
