// Words of what a material has beyond its base, in the scene's texels from Material.layers on: LAYER_NUMBER(word, name, default)
// a float, LAYER_WORD(word, name) the index of a TextureSlot or another number of 32 bits. The including file defines both;
// the table undefines them. Names and meaning are those of the Khronos extensions of glTF 2.0.
// KHR_materials_clearcoat
LAYER_NUMBER(0, coat, 0.0f)
LAYER_NUMBER(1, coatRoughness, 0.0f)
LAYER_NUMBER(2, coatNormalScale, 1.0f)
LAYER_WORD(3, coatTexture)           // red
LAYER_WORD(4, coatRoughnessTexture)  // green
LAYER_WORD(5, coatNormalTexture)
// KHR_materials_sheen
LAYER_NUMBER(6, sheenRed, 0.0f)
LAYER_NUMBER(7, sheenGreen, 0.0f)
LAYER_NUMBER(8, sheenBlue, 0.0f)
LAYER_NUMBER(9, sheenRoughness, 0.0f)
LAYER_WORD(10, sheenColorTexture)
LAYER_WORD(11, sheenRoughnessTexture)  // alpha
LAYER_WORD(12, sheenTable)             // first texel of the table of sheenAlbedo
// KHR_materials_anisotropy
LAYER_NUMBER(13, anisotropy, 0.0f)
LAYER_NUMBER(14, anisotropyCosine, 1.0f)  // of the angle from the tangent to the direction along which highlights are long
LAYER_NUMBER(15, anisotropySine, 0.0f)
LAYER_WORD(16, anisotropyTexture)  // red and green: direction, blue: strength
// KHR_materials_iridescence
LAYER_NUMBER(17, iridescence, 0.0f)
LAYER_NUMBER(18, filmIor, 1.3f)
LAYER_NUMBER(19, filmThinnest, 100.0f)  // nanometres
LAYER_NUMBER(20, filmThickest, 400.0f)
LAYER_WORD(21, iridescenceTexture)    // red
LAYER_WORD(22, filmThicknessTexture)  // green, from the thinnest to the thickest
// KHR_materials_dispersion
LAYER_NUMBER(23, dispersion, 0.0f)  // 20 over the Abbe number
// KHR_materials_diffuse_transmission
LAYER_NUMBER(24, diffuseTransmission, 0.0f)
LAYER_NUMBER(25, diffuseRed, 1.0f)
LAYER_NUMBER(26, diffuseGreen, 1.0f)
LAYER_NUMBER(27, diffuseBlue, 1.0f)
LAYER_WORD(28, diffuseTransmissionTexture)  // alpha
LAYER_WORD(29, diffuseColorTexture)
#undef LAYER_NUMBER
#undef LAYER_WORD
