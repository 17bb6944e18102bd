#include "server/base/error.h"
#include "server/scene/load/scene_source.h"
#include "tests/unit/scene/scene_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace heliograph {
namespace {

using namespace testing_files;
using ::testing::Contains;
using ::testing::HasSubstr;

const std::string SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";

TEST(ObjLoader, ReadsPolygonsAndTurnsTextureCoordinates) {
    const ScratchFolder folder;
    const auto scene = openScene(folder.write("a.obj", SQUARE + "f 1/1 2/2 3/3 4/4\nf -4/-4 -3/-3 -2/-2\n"));
    EXPECT_EQ(scene->triangleCount(), 3u);
    EXPECT_EQ(scene->positions.size(), 5u);  // shared corners, one of padding
    for (size_t i = 0; i < 4; i++) EXPECT_EQ(scene->attributes[i].v0, 1.0f - scene->positions[i].y);
    for (size_t i = 0; i < 4; i++) EXPECT_EQ(scene->attributes[i].normal, vec3(0, 0, 1));
}

TEST(ObjLoader, SmoothsUnderTheCreaseAngleOnly) {
    const ScratchFolder folder;
    // Two quads that meet at 90 degrees stay sharp, at 30 degrees they are smooth.
    const auto normals = [&](const std::string& z, const std::string& extra) {
        const auto scene =
            openScene(folder.write("a.obj", extra + "v 0 0 0\nv 0 1 0\nv 1 1 0\nv 1 0 0\nv 0 1 1\nv 0 0 1\nv -0.866 1 " + z +
                                                "\nv -0.866 0 " + z + "\nf 4 3 2 1\nf 1 2 7 8\n"));
        return scene->attributes.size();
    };
    EXPECT_EQ(normals("-0.5", ""), 6u);
    EXPECT_EQ(normals("-5", ""), 8u);
    EXPECT_EQ(normals("-5", "s 1\n"), 6u);
    EXPECT_GE(normals("-0.5", "s off\n"), 8u);
}

TEST(ObjLoader, ReadsMaterials) {
    const ScratchFolder folder;
    folder.write("m.mtl",
                 "newmtl glass\nKd 0 0 0\nKs 1 1 1\nNs 96\nNi 1.5\nd 0.1\nIr 0.1\nTf 0.9 0.8 0.7\n"
                 "newmtl veil\nKd 1 1 1\nd 0.25\n"
                 "newmtl mirror\nKd 0.1 0.1 0.1\nKs 0.6 0.8 0.7\nillum 3\n"
                 "newmtl lamp\nKd 1 1 1\nKe 5 4 3\nmap_Kd missing.png\n"
                 "newmtl unused\nmap_Kd also-missing.png\n"
                 "newmtl metal\nKd 1 0.5 0\nPr 0.25\nPm 1\n");
    const auto scene =
        openScene(folder.write("a.obj", "mtllib m.mtl\n" + SQUARE +
                                            "usemtl glass\nf 1 2 3\nusemtl veil\nf 1 2 3\nusemtl mirror\nf 1 2 3\nusemtl "
                                            "lamp\nf 1 2 3\nusemtl metal\nf 1 2 3\nusemtl nothing\nf 1 2 3\n"));
    ASSERT_EQ(scene->materials.size(), 6u);
    const Material &glass = scene->materials[1], &veil = scene->materials[2], &mirror = scene->materials[3],
                   &lamp = scene->materials[4], &metal = scene->materials[5];
    EXPECT_EQ(glass.flags, MATERIAL_PHONG | MATERIAL_VOLUME);
    EXPECT_FLOAT_EQ(glass.transmission, 0.9f);
    EXPECT_FLOAT_EQ(glass.mirror, 0.1f);
    EXPECT_EQ(vec3(glass.transmissionTint), vec3(0.9f, 0.8f, 0.7f));
    EXPECT_EQ(glass.specular, vec4(1, 1, 1, 96));
    EXPECT_EQ(veil.flags, MATERIAL_PHONG | MATERIAL_ALPHA_BLEND);
    EXPECT_FLOAT_EQ(veil.baseColor.w, 0.25f);
    EXPECT_FLOAT_EQ(mirror.mirror, 0.8f);
    EXPECT_EQ(vec3(lamp.emission), vec3(5, 4, 3));
    EXPECT_EQ(metal.flags, 0u);
    EXPECT_FLOAT_EQ(metal.roughness, 0.25f);
    EXPECT_THAT(scene->warnings, Contains(HasSubstr("missing.png")));
    EXPECT_THAT(scene->warnings, ::testing::Not(Contains(HasSubstr("also-missing"))));
    EXPECT_EQ(scene->meshes.size(), 2u);  // solid and see-through
}

TEST(ObjLoader, WarnsOfAMissingMaterialFile) {
    const ScratchFolder folder;
    const auto scene = openScene(folder.write("a.obj", "mtllib none.mtl\n" + SQUARE + "usemtl x\nf 1 2 3\n"));
    EXPECT_EQ(scene->triangleCount(), 1u);
    EXPECT_THAT(scene->warnings, Contains(HasSubstr("none.mtl")));
}

TEST(ObjLoader, NeverLeavesItsFolder) {
    const ScratchFolder folder;
    folder.write("out.mtl", "newmtl x\nKd 1 0 0\n");
    folder.write("in/up.mtl", "newmtl x\nmap_Kd ../out.png\n");
    EXPECT_THROW(openScene(folder.write("in/a.obj", "mtllib ../out.mtl\n" + SQUARE + "f 1 2 3\n")), InputError);
    EXPECT_THROW(openScene(folder.write("in/a.obj", "mtllib /etc/hostname\n" + SQUARE + "f 1 2 3\n")), InputError);
    EXPECT_THROW(openScene(folder.write("in/a.obj", "mtllib up.mtl\n" + SQUARE + "usemtl x\nf 1 2 3\n")), InputError);
}

TEST(ObjLoader, SurvivesHostileLines) {
    const ScratchFolder folder;
    const auto open = [&](const std::string& text) { return openScene(folder.write("a.obj", text)); };
    EXPECT_EQ(open(SQUARE + "f 1 2 3\nt crease 2000000000/0/0\n")->triangleCount(), 1u);
    EXPECT_EQ(open(SQUARE + "f 1 2 3\nf 1 2 99\nf 1/9/9 2 3\nf 1 2\n")->triangleCount(), 1u);
    EXPECT_EQ(open(SQUARE + "v nan inf 1e999\nf 1 2 5\nf 1 2 3\n")->bounds.high.z, 0.0f);
    EXPECT_EQ(open(SQUARE + "l 1 2\np 1\nvp 1 2 3\nf 1 2 3\n")->triangleCount(), 1u);
    std::string polygon = "f";
    for (int i = 0; i < 300; i++) polygon += " 1";
    EXPECT_THROW(open(SQUARE + polygon), InputError);
    EXPECT_THROW(open(SQUARE + "f 0 0 0\n"), InputError);
    EXPECT_THROW(open(""), InputError);
    EXPECT_THROW(open(std::string(1000, '\0')), InputError);
    EXPECT_THROW(open("v " + std::string(200000, '1')), InputError);
}

// The parser adds up an exponent's digits in an int, without looking (seen by the sanitizer).
TEST(ObjLoader, RefusesExponentsThatTheParserCannotCount) {
    const ScratchFolder folder;
    const auto open = [&](const std::string& text) { return openScene(folder.write("a.obj", text)); };
    for (const char* number : {"1e2147483648", "-.5E-9999999999", "1e+2147483647x"}) {
        EXPECT_THAT([&] { open(SQUARE + "v 0 0 " + number + "\nf 1 2 3\n"); },
                    ::testing::ThrowsMessage<InputError>(HasSubstr("line 9: an exponent of 10 digits")))
            << number;
        folder.write("m.mtl", "newmtl a\nKd 1 " + std::string(number) + " 1\n");
        EXPECT_THAT([&] { open("mtllib m.mtl\n" + SQUARE + "usemtl a\nf 1 2 3\n"); },
                    ::testing::ThrowsMessage<InputError>(HasSubstr("m.mtl: line 2: an exponent of 10 digits")))
            << number;
    }
    EXPECT_EQ(open(SQUARE + "v 1e-000002 1E+1 0\nf 1 2 3\n")->triangleCount(), 1u);
}

}  // namespace
}  // namespace heliograph
