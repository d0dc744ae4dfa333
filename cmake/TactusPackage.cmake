# What `cmake --install` copies, and the Debian package made of it by CPack (scripts/package).
include(GNUInstallDirs)

install(TARGETS tactus)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/instruments DESTINATION ${CMAKE_INSTALL_DATADIR}/tactus)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/README.md ${PROJECT_SOURCE_DIR}/CHANGELOG.md
        DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs/ DESTINATION ${CMAKE_INSTALL_DOCDIR} FILES_MATCHING PATTERN "*.md" PATTERN "*.svg")

# The manual page and the completion for bash, generated from the commands.
set(manual ${PROJECT_BINARY_DIR}/manual)
add_custom_command(
  OUTPUT ${manual}/tactus.1 ${manual}/tactus
  COMMAND ${CMAKE_COMMAND} -E make_directory ${manual}
  COMMAND tactus --man > ${manual}/tactus.1
  COMMAND tactus --bash-completion > ${manual}/tactus
  DEPENDS tactus
  COMMENT "Generating the manual page and the completion for bash")
add_custom_target(manual ALL DEPENDS ${manual}/tactus.1 ${manual}/tactus)
install(FILES ${manual}/tactus.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES ${manual}/tactus DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)

# The program contains these libraries, which consist of headers; the others are packages that it depends on.
foreach(library libboost-dev libcli11-dev libeigen3-dev libexpected-dev libtomlplusplus-dev nlohmann-json3-dev)
  install(FILES /usr/share/doc/${library}/copyright DESTINATION ${CMAKE_INSTALL_DOCDIR}/third_party RENAME ${library}
          OPTIONAL)
endforeach()

if(TACTUS_HAS_panel)
  install(FILES ${TACTUS_UPLOT_DIR}/../LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR}/third_party RENAME uplot OPTIONAL)
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME tactus)
set(CPACK_PACKAGE_VENDOR "The Tactus authors")
set(CPACK_PACKAGE_CONTACT "The Tactus authors <tactus@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "haptic instruments on ordinary sound cards")
set(CPACK_PACKAGE_DESCRIPTION "Reads sensors and drives actuators through an audio interface, as text files say.
It simulates instruments without hardware, checks their stability, limits what reaches an actuator, and measures
the round-trip latency of the interface.")
set(CPACK_DEBIAN_PACKAGE_SECTION sound)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS jackd2)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
include(CPack)
