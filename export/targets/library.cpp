#include <fmt/format.h>

#include "export/targets/target.h"

namespace tactus {

std::vector<ExportedFile> library_files(const CProgram& program) {
  auto files = c_files(program);
  files.push_back({"CMakeLists.txt", fmt::format(R"(cmake_minimum_required(VERSION 3.13)
project({0} LANGUAGES C)

# BUILD_SHARED_LIBS=ON makes it a shared library.
add_library({0} {0}.c)
set_target_properties({0} PROPERTIES C_STANDARD 99 POSITION_INDEPENDENT_CODE ON PUBLIC_HEADER {0}.h)
target_include_directories({0} PUBLIC $<BUILD_INTERFACE:${{CMAKE_CURRENT_SOURCE_DIR}}> $<INSTALL_INTERFACE:include>)
# Products and sums are not fused, so that results are those of the engine.
target_compile_options({0} PRIVATE $<$<C_COMPILER_ID:GNU,Clang,AppleClang>:-ffp-contract=off>)
if(UNIX)
  target_link_libraries({0} PUBLIC m)
endif()
install(TARGETS {0} ARCHIVE DESTINATION lib LIBRARY DESTINATION lib RUNTIME DESTINATION bin PUBLIC_HEADER DESTINATION include)
)",
                                                 program.name)});
  return files;
}

}  // namespace tactus
