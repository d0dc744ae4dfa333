# Which instructions the compiler may use; on a processor without them the program ends with a message (apps/processor).
set(TACTUS_MARCH "")
if(TACTUS_ARCH)
  set(TACTUS_MARCH -march=${TACTUS_ARCH})
elseif(TACTUS_NATIVE)
  include(CheckCXXCompilerFlag)
  check_cxx_compiler_flag(-march=native TACTUS_MARCH_NATIVE)  # not every clang has it for every processor
  if(TACTUS_MARCH_NATIVE)
    set(TACTUS_MARCH -march=native)
  endif()
endif()

# The flags that every target of the project shares.
add_library(tactus_flags INTERFACE)
target_compile_features(tactus_flags INTERFACE cxx_std_20)
target_include_directories(tactus_flags INTERFACE ${PROJECT_SOURCE_DIR})
# -ffp-contract=off: a result must not depend on which multiplications the compiler chose to fuse.
target_compile_options(tactus_flags INTERFACE
  $<$<CXX_COMPILER_ID:GNU,Clang,AppleClang>:-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
    -Wnon-virtual-dtor -Woverloaded-virtual -Wdouble-promotion -ffp-contract=off -fno-math-errno>
  # g++ 12 takes every short string assigned from a literal for an overlap (GCC bug 105651).
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>
  # Files compiled as one look to g++ like headers that use another file's anonymous namespace.
  $<$<AND:$<BOOL:${TACTUS_UNITY}>,$<CXX_COMPILER_ID:GNU>>:-Wno-subobject-linkage>
  # clang 20 and newer blame the caller of std::stable_sort for a function that libstdc++ 12 uses inside, and the user
  # of Catch2 for its __COUNTER__.
  $<$<AND:$<CXX_COMPILER_ID:Clang>,$<VERSION_GREATER_EQUAL:$<CXX_COMPILER_VERSION>,20>>:-Wno-deprecated-declarations
    -Wno-c2y-extensions>
  $<$<CXX_COMPILER_ID:GNU,Clang,AppleClang>:$<IF:$<BOOL:${TACTUS_WERROR}>,-Werror,-w>>
  ${TACTUS_MARCH})
# g++ 12 loses the zeros of a constant that it copies: with AVX2 or AVX-512 tuning {1, 1, 0, 0} becomes
# {1, 1, 1, 1}. Where it may not move general registers to vector registers it does not try.
# tests/compiler_test.cpp watches it.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13
   AND CMAKE_CXX_COMPILER_VERSION VERSION_GREATER_EQUAL 12 AND CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  target_compile_options(tactus_flags INTERFACE -mtune-ctrl=^inter_unit_moves_to_vec)
endif()
if(TACTUS_SANITIZE)
  target_compile_options(tactus_flags INTERFACE -fsanitize=${TACTUS_SANITIZE} -fno-omit-frame-pointer -g)
  target_link_options(tactus_flags INTERFACE -fsanitize=${TACTUS_SANITIZE})
  if(TACTUS_SANITIZE MATCHES "thread")  # its operator new is beside that of tests/support/allocation_count_test.cpp
    target_link_options(tactus_flags INTERFACE -Wl,--allow-multiple-definition)
  endif()
  # g++ 12 takes what the address sanitizer adds to <regex> for uninitialised.
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND TACTUS_SANITIZE MATCHES "address")
    target_compile_options(tactus_flags INTERFACE -Wno-maybe-uninitialized)
  endif()
endif()

# The program and the Python module contain the same objects, so that their results are the same. Names stay hidden: g++
# then compiles position-independent code as it compiles that of a program.
function(tactus_position_independent target)
  set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON CXX_VISIBILITY_PRESET hidden
                                             VISIBILITY_INLINES_HIDDEN ON)
endfunction()

# Headers of the standard library and of {fmt}, read once for all modules.
if(TACTUS_SHORT_BUILD AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/precompiled.cpp CONTENT "")
  add_library(tactus_precompiled OBJECT ${PROJECT_BINARY_DIR}/precompiled.cpp)
  tactus_position_independent(tactus_precompiled)
  target_link_libraries(tactus_precompiled PRIVATE tactus_flags fmt::fmt)
  target_precompile_headers(tactus_precompiled PRIVATE <algorithm> <array> <atomic> <charconv> <chrono> <cmath> <complex>
    <filesystem> <fmt/format.h> <fstream> <functional> <map> <memory> <numeric> <optional> <span> <string> <string_view>
    <thread> <vector>)
  target_compile_options(tactus_flags INTERFACE $<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess>)  # for ccache
endif()

# Several source files of a target are compiled as one.
function(tactus_unity target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${TACTUS_UNITY} UNITY_BUILD_BATCH_SIZE ${TACTUS_UNITY_BATCH})
endfunction()

# tactus_optimise(app 1): -O1 for code whose compile time counts more than its speed; never for the real-time path.
# Never more than the build's own level: g++ 12 crashes on a precompiled header of a lower level.
function(tactus_optimise target level)
  if(TACTUS_SHORT_BUILD AND NOT CMAKE_CXX_FLAGS MATCHES "-O[01]")
    target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU,Clang,AppleClang>:-O${level}>)
  endif()
endfunction()

# tactus_module(core engine/core DEPENDS ...): one target for one folder, from every .cpp in and below it,
# so that a new file is built without naming it anywhere. FLAT: subfolders have targets of their own.
# OPTIMISE 2: compiled with -O2, because none of it runs on the real-time path; CONTROL REGEX...: that holds only for
# the files below the folder that match.
function(tactus_module name)
  cmake_parse_arguments(ARG "FLAT" "OPTIMISE" "DEPENDS;PRIVATE;CONTROL" ${ARGN})
  if(ARG_FLAT)
    file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  else()
    file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  endif()
  if(NOT sources)
    add_library(tactus_${name} INTERFACE)
    target_link_libraries(tactus_${name} INTERFACE tactus_flags ${ARG_DEPENDS})
    add_library(tactus::${name} ALIAS tactus_${name})
    return()
  endif()
  set(targets tactus_${name})
  set(control tactus_${name})
  if(ARG_CONTROL AND TACTUS_SHORT_BUILD)
    set(control tactus_${name}_control)
    list(JOIN ARG_CONTROL "|" pattern)
    set(selected ${sources})
    list(FILTER selected INCLUDE REGEX "^${CMAKE_CURRENT_SOURCE_DIR}/(${pattern})")
    list(REMOVE_ITEM sources ${selected})
    add_library(${control} OBJECT ${selected})
    list(APPEND targets ${control})
    list(APPEND sources $<TARGET_OBJECTS:${control}>)
  endif()
  add_library(tactus_${name} STATIC ${sources})
  add_library(tactus::${name} ALIAS tactus_${name})
  foreach(target IN LISTS targets)
    target_link_libraries(${target} PUBLIC tactus_flags ${ARG_DEPENDS} PRIVATE ${ARG_PRIVATE})
    tactus_unity(${target})
    tactus_position_independent(${target})
    # Sound libraries bring macros (_REENTRANT) with which a shared precompiled header is not valid.
    if(TARGET tactus_precompiled AND NOT "${ARG_PRIVATE}" MATCHES "PkgConfig::[a-z]")
      target_link_libraries(${target} PRIVATE fmt::fmt)
      target_precompile_headers(${target} REUSE_FROM tactus_precompiled)
    endif()
    # g++ 12 takes the AVX-512 intrinsics that Eigen uses for uninitialised (GCC bug 105593); which of the two
    # warnings it gives depends on the machine.
    if("Eigen3::Eigen" IN_LIST ARG_DEPENDS)
      target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-uninitialized -Wno-maybe-uninitialized>)
    endif()
  endforeach()
  if(ARG_OPTIMISE)
    tactus_optimise(${control} ${ARG_OPTIMISE})
  endif()
endfunction()

# tactus_embed_files(target FUNCTION HEADER name=path...): makes the files a part of the program, which an installed one
# could not find. FUNCTION, which HEADER declares, returns them: see engine/core/embedded_file.h.
function(tactus_embed_files target function header)
  set(embedded ${CMAKE_CURRENT_BINARY_DIR}/${function}.cpp)
  string(REPLACE ";" "|" files "${ARGN}")
  set(paths ${ARGN})
  list(TRANSFORM paths REPLACE "^[^=]+=" "")
  add_custom_command(
    OUTPUT ${embedded}
    COMMAND ${CMAKE_COMMAND} -DOUTPUT=${embedded} -DFUNCTION=${function} -DHEADER=${header} "-DFILES=${files}"
            -P ${PROJECT_SOURCE_DIR}/cmake/embed_files.cmake
    DEPENDS ${paths} ${PROJECT_SOURCE_DIR}/cmake/embed_files.cmake
    COMMENT "Embedding ${function}" VERBATIM)
  target_sources(${target} PRIVATE ${embedded})
  # Each names its arrays alike.
  set_source_files_properties(${embedded} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()
