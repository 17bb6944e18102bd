# A relocatable folder: `cmake --install BUILD --component bench --prefix FOLDER` (the GPU benchmark alone, a few
# libraries) or `--component server` (everything). Each holds bin/ and lib/ with every library but glibc's; a machine needs
# Linux with glibc 2.36 or newer and, for GPUs, the vendor's Vulkan driver. cpack -G TGZ packs each component.
function(heliograph_bundle component target)
  # The old kind of run path also serves the libraries that libraries need.
  set_target_properties(${target} PROPERTIES INSTALL_RPATH "$ORIGIN/../lib")
  target_link_options(${target} PRIVATE -Wl,--disable-new-dtags)
  install(TARGETS ${target} RUNTIME DESTINATION bin COMPONENT ${component})
  install(CODE "
    file(GET_RUNTIME_DEPENDENCIES EXECUTABLES \"$<TARGET_FILE:${target}>\" ${ARGN}
      RESOLVED_DEPENDENCIES_VAR found UNRESOLVED_DEPENDENCIES_VAR missing
      POST_EXCLUDE_REGEXES \"/(ld-linux.*|lib(c|m|dl|rt|pthread|resolv|util|mvec))\\\\.so[.0-9]*$\")
    if(missing)
      message(FATAL_ERROR \"not found: \${missing}\")
    endif()
    file(INSTALL \${found} DESTINATION \"\${CMAKE_INSTALL_PREFIX}/lib\" FOLLOW_SYMLINK_CHAIN)" COMPONENT ${component})
endfunction()

heliograph_bundle(server heliograph)
install(DIRECTORY ${CMAKE_SOURCE_DIR}/client-web/dist/ DESTINATION share/heliograph/client COMPONENT server OPTIONAL)
install(DIRECTORY ${CMAKE_BINARY_DIR}/spirv/ DESTINATION share/heliograph/spirv COMPONENT server FILES_MATCHING PATTERN "*.spv")
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
set(CPACK_ARCHIVE_COMPONENT_INSTALL ON)
set(CPACK_GENERATOR TGZ)
set(CPACK_COMPONENTS_ALL server bench)
include(CPack)
