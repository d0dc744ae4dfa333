# Every third-party library, found once. Names are those of Debian 12; scripts/setup installs them.
find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(fmt REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(CLI11 REQUIRED)
find_package(tl-expected REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(SNDFILE REQUIRED IMPORTED_TARGET sndfile)

option(TACTUS_ODE "Worlds of rigid bodies, where the Open Dynamics Engine is installed" ON)
if(TACTUS_ODE)
  pkg_check_modules(ode QUIET IMPORTED_TARGET ode>=0.16)
endif()

# Libraries for sound cards, force-feedback devices, data acquisition cards and MIDI, each with the name of its package in pkg-config and the versions that can be
# used. A line here registers the backend in the folder of that name, in the order in which they are asked for a device;
# one that is not installed, or only in another version, is left out.
set(sound_libraries
  jack jack
  rtaudio rtaudio<6  # 6.0 replaced the numbers of devices and the exceptions
  portaudio portaudio-2.0)
set(haptic_libraries  # of force-feedback devices
  sdl sdl2)
set(acquisition_libraries  # of data acquisition cards
  comedi comedilib)
set(midi_libraries
  rtmidi rtmidi)

set(TACTUS_CARDS "" CACHE STRING "Libraries for sound cards, force-feedback devices, data acquisition cards and MIDI to use; empty: all that are installed")
set(TACTUS_SOUND_LIBRARIES "")  # those found
set(TACTUS_HAPTIC_LIBRARIES "")
set(TACTUS_ACQUISITION_LIBRARIES "")
set(TACTUS_MIDI_LIBRARIES "")
foreach(kind sound haptic acquisition midi)
  string(TOUPPER ${kind} KIND)
  while(${kind}_libraries)
    list(POP_FRONT ${kind}_libraries library package)
    if(TACTUS_CARDS AND NOT library IN_LIST TACTUS_CARDS)
      continue()
    endif()
    pkg_check_modules(${library} QUIET IMPORTED_TARGET ${package})
    if(${library}_FOUND)
      list(APPEND TACTUS_${KIND}_LIBRARIES ${library})
      set(TACTUS_HAS_${library} ON)
    elseif(package MATCHES "^([^<>=]+)[<>=]")
      pkg_check_modules(${library}_any QUIET ${CMAKE_MATCH_1})
      if(${library}_any_FOUND)
        message(WARNING "${library} ${${library}_any_VERSION} cannot be used, and its backend is left out; install ${package}")
      endif()
    endif()
  endwhile()
endforeach()

# Remote control: by OSC, by sensors at serial ports, by joysticks, and by the panel in a browser. What is not installed is left out.
option(TACTUS_OSC "Remote control by OSC, where oscpack and Boost are installed" ON)
option(TACTUS_SERIAL "Sensors at serial ports, where Boost is installed" ON)
option(TACTUS_PANEL "The panel in a browser, where Boost is installed and uPlot can be had" ON)
if((TACTUS_OSC OR TACTUS_SERIAL OR TACTUS_PANEL) AND NOT WIN32)
  find_path(BOOST_ASIO_INCLUDE_DIR boost/beast.hpp)
  if(BOOST_ASIO_INCLUDE_DIR)
    add_library(tactus_boost INTERFACE)
    target_include_directories(tactus_boost SYSTEM INTERFACE ${BOOST_ASIO_INCLUDE_DIR})
  endif()
endif()
if(TACTUS_OSC AND TARGET tactus_boost)
  find_path(OSCPACK_INCLUDE_DIR oscpack/osc/OscReceivedElements.h)  # it has no package file
  find_library(OSCPACK_LIBRARY oscpack)
  if(OSCPACK_INCLUDE_DIR AND OSCPACK_LIBRARY)
    set(TACTUS_HAS_osc ON)
    add_library(tactus_oscpack INTERFACE)
    target_include_directories(tactus_oscpack SYSTEM INTERFACE ${OSCPACK_INCLUDE_DIR})
    target_link_libraries(tactus_oscpack INTERFACE tactus_boost ${OSCPACK_LIBRARY})
  endif()
endif()
option(TACTUS_HID "Joysticks, gamepads and pedals move controls, where SDL 2 is installed" ON)
if(TACTUS_HID)
  pkg_check_modules(sdl2 QUIET IMPORTED_TARGET sdl2)
  if(sdl2_FOUND)
    set(TACTUS_HAS_hid ON)
  endif()
endif()
if(TACTUS_SERIAL AND TARGET tactus_boost)
  set(TACTUS_HAS_serial ON)
endif()
if(TACTUS_PANEL AND TARGET tactus_boost)
  include(TactusUplot)
endif()

find_path(TOMLPLUSPLUS_INCLUDE_DIR toml++/toml.h REQUIRED)

add_library(tactus_tomlplusplus INTERFACE)
target_include_directories(tactus_tomlplusplus SYSTEM INTERFACE ${TOMLPLUSPLUS_INCLUDE_DIR})

if(TACTUS_TESTS)
  find_package(Catch2 3 QUIET)
  if(NOT Catch2_FOUND)
    find_package(Catch2 2.13 REQUIRED)
  endif()
endif()
if(TACTUS_BENCHMARKS)
  find_package(benchmark REQUIRED)
endif()
