# A relocatable folder: `cmake --install BUILD --strip --prefix FOLDER --component NAME`. NAME is `server` (the whole program
# but for Radiance HDR and OpenEXR pictures), `images` (the picture module that reads and writes those, with its 240 libraries:
# installed over the server's folder), `load` (the load test) or `bench` (the GPU benchmark alone). Each holds every library
# but glibc's; a machine needs Linux with glibc 2.36 or newer and, for GPUs, the vendor's Vulkan driver. cmake/packages.cmake
# packs the first three.
set(HELIOGRAPH_SYSTEM_LIBRARIES "/(ld-linux.*|lib(c|m|dl|rt|pthread|resolv|util|mvec))\\\\.so[.0-9]*$")
function(heliograph_bundle component target)
  # The old kind of run path also serves the libraries that libraries need.
  set_target_properties(${target} PROPERTIES INSTALL_RPATH "$ORIGIN/../lib")
  target_link_options(${target} PRIVATE -Wl,--disable-new-dtags)
  install(TARGETS ${target} RUNTIME DESTINATION bin COMPONENT ${component})
  install(CODE "
    file(GET_RUNTIME_DEPENDENCIES EXECUTABLES \"$<TARGET_FILE:${target}>\" ${ARGN}
      RESOLVED_DEPENDENCIES_VAR found UNRESOLVED_DEPENDENCIES_VAR missing
      POST_EXCLUDE_REGEXES \"${HELIOGRAPH_SYSTEM_LIBRARIES}\")
    if(missing)
      message(FATAL_ERROR \"not found: \${missing}\")
    endif()
    file(INSTALL \${found} DESTINATION \"\${CMAKE_INSTALL_PREFIX}/lib\" FOLLOW_SYMLINK_CHAIN)" COMPONENT ${component})
endfunction()

heliograph_bundle(server heliograph)
heliograph_bundle(load heliograph-load)
# The module and what it needs beyond the server's libraries, in a folder of its own.
set_target_properties(heliograph-images PROPERTIES INSTALL_RPATH "$ORIGIN:$ORIGIN/..")
target_link_options(heliograph-images PRIVATE -Wl,--disable-new-dtags)
install(TARGETS heliograph-images LIBRARY DESTINATION lib/heliograph COMPONENT images)
install(CODE "
  file(GET_RUNTIME_DEPENDENCIES EXECUTABLES \"$<TARGET_FILE:heliograph>\" RESOLVED_DEPENDENCIES_VAR there)
  file(GET_RUNTIME_DEPENDENCIES MODULES \"$<TARGET_FILE:heliograph-images>\"
    RESOLVED_DEPENDENCIES_VAR found UNRESOLVED_DEPENDENCIES_VAR missing
    POST_EXCLUDE_REGEXES \"${HELIOGRAPH_SYSTEM_LIBRARIES}\")
  if(missing)
    message(FATAL_ERROR \"not found: \${missing}\")
  endif()
  list(REMOVE_ITEM found \${there})
  file(INSTALL \${found} DESTINATION \"\${CMAKE_INSTALL_PREFIX}/lib/heliograph\" FOLLOW_SYMLINK_CHAIN)" COMPONENT images)
install(DIRECTORY ${CMAKE_SOURCE_DIR}/client-web/dist/ DESTINATION share/heliograph/client COMPONENT server OPTIONAL)
if(TARGET heliograph-bench)
  heliograph_bundle(bench heliograph-bench)
  install(PROGRAMS ${CMAKE_SOURCE_DIR}/tests/bench/gpu_box.sh DESTINATION . COMPONENT bench)
  # The validation layer, so that the driver's side can be checked where nothing is installed.
  find_library(VALIDATION_LAYER NAMES VkLayer_khronos_validation)
  if(VALIDATION_LAYER)
    install(FILES ${VALIDATION_LAYER} DESTINATION lib COMPONENT bench)
    install(FILES /usr/share/vulkan/explicit_layer.d/VkLayer_khronos_validation.json DESTINATION share/vulkan/explicit_layer.d
      COMPONENT bench OPTIONAL)
  endif()
endif()
