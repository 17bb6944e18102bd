# Writes a C++ file that holds SPIR-V modules as arrays of words.
# cmake -DOUT=file.cpp -DMODULES="name=file.spv;..." -P embed_spirv.cmake
set(text "// Made by cmake/embed_spirv.cmake.\n#include \"server/device/vulkan/core/shader_code.h\"\n\nnamespace heliograph::shaders {\n\n")
foreach(module ${MODULES})
  string(REGEX REPLACE "=.*" "" name "${module}")
  string(REGEX REPLACE "^[^=]*=" "" file "${module}")
  file(READ "${file}" hex HEX)
  string(REGEX REPLACE "(..)(..)(..)(..)" "0x\\4\\3\\2\\1," words "${hex}")
  string(APPEND text "static const uint32_t ${name}Words[] = {${words}};\nextern const std::span<const uint32_t> ${name};\nconst std::span<const uint32_t> ${name}(${name}Words);\n\n")
endforeach()
file(WRITE "${OUT}" "${text}}  // namespace heliograph::shaders\n")
