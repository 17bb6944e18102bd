# Packages: `ninja packages` in the build folder makes build/packages/*.deb (they use Debian's libraries) and *.tar.gz (folders
# that bring their own, cmake/bundle.cmake). What stands in them beside programs comes from packaging/.
set(words ${CMAKE_BINARY_DIR}/words)
file(GLOB words_from CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/packaging/*)
add_custom_command(OUTPUT ${words}/heliograph.toml
  COMMAND ${CMAKE_SOURCE_DIR}/packaging/words.sh $<TARGET_FILE:heliograph> $<TARGET_FILE:heliograph-load> ${words}
  DEPENDS heliograph heliograph-load ${words_from} VERBATIM)
add_custom_target(words DEPENDS ${words}/heliograph.toml)

# Debian's: from the root of the file system. deb_program(COMPONENT TARGET KIND FOLDER FILE): without a run path.
function(deb_program component target kind folder file)
  install(TARGETS ${target} ${kind} DESTINATION ${folder} COMPONENT ${component} EXCLUDE_FROM_ALL)
  install(CODE "file(RPATH_REMOVE FILE \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${folder}/${file}\")"
    COMPONENT ${component} EXCLUDE_FROM_ALL)
endfunction()
deb_program(deb_server heliograph RUNTIME usr/bin heliograph)
deb_program(deb_images heliograph-images LIBRARY usr/lib/heliograph heliograph-images.so)
deb_program(deb_load heliograph-load RUNTIME usr/bin heliograph-load)
function(deb_files component folder)
  install(FILES ${ARGN} DESTINATION ${folder} COMPONENT ${component} EXCLUDE_FROM_ALL)
endfunction()
install(DIRECTORY ${CMAKE_SOURCE_DIR}/client-web/dist/ DESTINATION usr/share/heliograph/client COMPONENT deb_server EXCLUDE_FROM_ALL)
install(DIRECTORY ${words}/man1 DESTINATION usr/share/man COMPONENT deb_server EXCLUDE_FROM_ALL PATTERN heliograph-load* EXCLUDE)
deb_files(deb_load usr/share/man/man1 ${words}/man1/heliograph-load.1.gz)
deb_files(deb_server usr/share/bash-completion/completions ${words}/completions/heliograph)
deb_files(deb_load usr/share/bash-completion/completions ${words}/completions/heliograph-load)
deb_files(deb_server etc/heliograph ${words}/heliograph.toml)
deb_files(deb_server lib/systemd/system ${CMAKE_SOURCE_DIR}/packaging/heliograph.service ${CMAKE_SOURCE_DIR}/packaging/heliograph.socket)
install(FILES ${CMAKE_SOURCE_DIR}/packaging/sysusers.conf DESTINATION usr/lib/sysusers.d RENAME heliograph.conf
  COMPONENT deb_server EXCLUDE_FROM_ALL)
deb_files(deb_server usr/share/doc/heliograph ${CMAKE_SOURCE_DIR}/packaging/debian/copyright)
deb_files(deb_images usr/share/doc/heliograph-images ${CMAKE_SOURCE_DIR}/packaging/debian/copyright)
deb_files(deb_load usr/share/doc/heliograph-load ${CMAKE_SOURCE_DIR}/packaging/debian/copyright)

# The same words in the folders that bring their own libraries, where they were made.
install(DIRECTORY ${words}/man1 DESTINATION share/man COMPONENT server OPTIONAL)
install(DIRECTORY ${words}/completions DESTINATION share/bash-completion COMPONENT server OPTIONAL)

set(CPACK_PACKAGE_VENDOR "the Heliograph authors")
set(CPACK_PACKAGE_CONTACT "Heliograph <heliograph@example.org>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Ray tracing on a machine far away, watched in a browser")
set(CPACK_PACKAGE_DIRECTORY ${CMAKE_BINARY_DIR}/packages)
set(CPACK_ARCHIVE_COMPONENT_INSTALL ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_GENERATOR DEB TGZ)
set(CPACK_STRIP_FILES ON)
# One folder for all archives: what is unpacked later joins what was unpacked first.
set(CPACK_COMPONENT_INCLUDE_TOPLEVEL_DIRECTORY ON)
set(CPACK_PACKAGE_FILE_NAME heliograph-${PROJECT_VERSION}-linux-amd64)
set(CPACK_ARCHIVE_SERVER_FILE_NAME heliograph-${PROJECT_VERSION}-linux-amd64)
set(CPACK_ARCHIVE_IMAGES_FILE_NAME heliograph-images-${PROJECT_VERSION}-linux-amd64)
set(CPACK_ARCHIVE_LOAD_FILE_NAME heliograph-load-${PROJECT_VERSION}-linux-amd64)
set(CPACK_ARCHIVE_BENCH_FILE_NAME heliograph-bench-${PROJECT_VERSION}-linux-amd64)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_DEB_SERVER_PACKAGE_NAME heliograph)
set(CPACK_DEBIAN_DEB_SERVER_PACKAGE_SUGGESTS "heliograph-images, libnats3.4, mesa-vulkan-drivers")
set(CPACK_DEBIAN_DEB_SERVER_PACKAGE_CONTROL_EXTRA
  "${CMAKE_SOURCE_DIR}/packaging/debian/postinst;${CMAKE_SOURCE_DIR}/packaging/debian/prerm;${CMAKE_SOURCE_DIR}/packaging/debian/postrm;${CMAKE_SOURCE_DIR}/packaging/debian/conffiles")
set(CPACK_DEBIAN_DEB_IMAGES_PACKAGE_NAME heliograph-images)
set(CPACK_DEBIAN_DEB_IMAGES_PACKAGE_DEPENDS "heliograph (= ${PROJECT_VERSION}-1)")
set(CPACK_DEBIAN_DEB_LOAD_PACKAGE_NAME heliograph-load)
set(CPACK_COMPONENT_DEB_SERVER_DESCRIPTION "Ray traces a scene on this machine and shows it in a browser elsewhere:
server, page and commands, with a systemd service.")
set(CPACK_COMPONENT_DEB_IMAGES_DESCRIPTION "Reads Radiance HDR and OpenEXR pictures and writes OpenEXR for heliograph.")
set(CPACK_COMPONENT_DEB_LOAD_DESCRIPTION "Lets many viewers look at a Heliograph server at once and says what they saw.")
# Which components, and from which root: by the kind of package.
set(CPACK_COMPONENTS_ALL server images load)
set(CPACK_PROJECT_CONFIG_FILE ${CMAKE_SOURCE_DIR}/cmake/package_kinds.cmake)
include(CPack)
find_program(CPACK cpack REQUIRED)
add_custom_target(packages COMMAND ${CPACK} DEPENDS words heliograph heliograph-images heliograph-load
  WORKING_DIRECTORY ${CMAKE_BINARY_DIR} USES_TERMINAL VERBATIM)
