# Writes OUTPUT, a C++ file with the bytes of FILES (name=path, separated by "|"): remote/panel/pages.h declares them.
#   cmake -DOUTPUT=… -DFILES=… -P embed_pages.cmake
set(types html "text/html\; charset=utf-8" js "text/javascript\; charset=utf-8" css "text/css\; charset=utf-8" svg image/svg+xml)
set(arrays "")
set(table "")
string(REPLACE "|" ";" files "${FILES}")
set(number 0)
foreach(file ${files})
  string(REGEX MATCH "^([^=]+)=(.+)$" parts "${file}")
  set(name ${CMAKE_MATCH_1})
  set(path ${CMAKE_MATCH_2})
  get_filename_component(extension ${name} LAST_EXT)
  string(SUBSTRING "${extension}" 1 -1 extension)
  list(FIND types ${extension} place)
  math(EXPR place "${place} + 1")
  list(GET types ${place} type)
  file(READ ${path} bytes HEX)
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${bytes}")
  string(REGEX REPLACE "((0x..,)(0x..,)(0x..,)(0x..,)(0x..,)(0x..,)(0x..,)(0x..,))" "\\1\n" bytes "${bytes}")
  string(APPEND arrays "constexpr unsigned char kFile${number}[] = {\n${bytes}0x00};\n")
  string(APPEND table "    {\"${name}\", \"${type}\", text(kFile${number})},\n")
  math(EXPR number "${number} + 1")
endforeach()
file(WRITE ${OUTPUT} "// Written by cmake/embed_pages.cmake.
#include \"remote/panel/pages.h\"

namespace tactus {
namespace {

${arrays}
template <std::size_t Size>
std::string_view text(const unsigned char (&bytes)[Size]) {
  return {reinterpret_cast<const char*>(bytes), Size - 1};
}

}  // namespace

std::span<const PanelPage> panel_pages() {
  static const PanelPage kPages[] = {
${table}  };
  return kPages;
}

}  // namespace tactus
")
