# Writes a C++ file that holds SPIR-V modules, packed by gzip, all first bytes of the words, then all second ones and so on: a
# quarter of their size.
# cmake -DOUT=file.cpp -DMODULES="name=file.spv;..." -P embed_spirv.cmake
set(text "// Made by cmake/embed_spirv.cmake.\n#include \"server/device/vulkan/core/shader_code.h\"\n\nnamespace heliograph::shaders {\n\n")
foreach(module ${MODULES})
  string(REGEX REPLACE "=.*" "" name "${module}")
  string(REGEX REPLACE "^[^=]*=" "" file "${module}")
  file(SIZE "${file}" bytes)
  execute_process(COMMAND perl -0777 -ne "binmode STDOUT; my @w = unpack('V*', $_); for my $s (0, 8, 16, 24) { print pack('C*', map { $_ >> $s & 255 } @w) }" "${file}"
    COMMAND gzip -9nc OUTPUT_FILE "${file}.gz" COMMAND_ERROR_IS_FATAL ANY)
  file(READ "${file}.gz" hex HEX)
  string(REGEX REPLACE "(..)" "0x\\1," packed "${hex}")
  string(APPEND text "static const unsigned char ${name}Packed[] = {${packed}};\nWords ${name}() {\n    static const std::vector<uint32_t> words = unpacked(${name}Packed, ${bytes});\n    return words;\n}\n\n")
endforeach()
file(WRITE "${OUT}" "${text}}  // namespace heliograph::shaders\n")
