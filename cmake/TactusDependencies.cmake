# Every third-party library, found once. Names are those of Debian 12; scripts/setup installs them.
find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(fmt REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(CLI11 REQUIRED)
find_package(tl-expected REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(SNDFILE REQUIRED IMPORTED_TARGET sndfile)

# Libraries that reach sound cards and MIDI keyboards, and where pkg-config finds them. One that is not installed
# is left out, and `tactus devices` says so.
set(TACTUS_CARDS jack rtaudio portaudio rtmidi CACHE STRING "Libraries for sound cards and MIDI")
set(TACTUS_PACKAGE_portaudio portaudio-2.0)
foreach(card jack rtaudio portaudio rtmidi)
  set(TACTUS_HAS_${card} OFF)
  if(NOT card IN_LIST TACTUS_CARDS)
    continue()
  endif()
  if(NOT DEFINED TACTUS_PACKAGE_${card})
    set(TACTUS_PACKAGE_${card} ${card})
  endif()
  pkg_check_modules(${card} QUIET IMPORTED_TARGET ${TACTUS_PACKAGE_${card}})
  set(TACTUS_HAS_${card} ${${card}_FOUND})
endforeach()

find_path(TOMLPLUSPLUS_INCLUDE_DIR toml++/toml.h REQUIRED)

add_library(tactus_tomlplusplus INTERFACE)
target_include_directories(tactus_tomlplusplus SYSTEM INTERFACE ${TOMLPLUSPLUS_INCLUDE_DIR})

if(TACTUS_TESTS)
  find_package(Catch2 2.13 REQUIRED)
endif()
if(TACTUS_BENCHMARKS)
  find_package(benchmark REQUIRED)
endif()
