#include "server/base/error.h"
#include "server/scene/load/obj_text.h"
#include "server/scene/load/scene_source.h"
#include "tests/unit/scene/scene_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
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

TEST(ObjLoader, NeverLeavesItsFolderAndDrawsTheRest) {
    const ScratchFolder folder;
    folder.write("out.mtl", "newmtl x\nKd 1 0 0\n");
    folder.write("in/up.mtl", "newmtl x\nKd 0 1 0\nmap_Kd ../out.png\n");
    for (const char* name : {"../out.mtl", "/etc/hostname", "C:\\out.mtl", "..\\out.mtl"}) {
        const auto scene =
            openScene(folder.write("in/a.obj", "mtllib " + std::string(name) + "\n" + SQUARE + "usemtl x\nf 1 2 3\n"));
        EXPECT_EQ(scene->triangleCount(), 1u) << name;
        EXPECT_EQ(scene->materials.size(), 1u) << name;
        EXPECT_THAT(scene->warnings, Contains(HasSubstr(name))) << name;
    }
    for (const char* name : {"../out.png", "/etc/out.png", "C:\\out.png", "https://example.org/out.png"}) {
        folder.write("in/up.mtl", "newmtl x\nKd 0 1 0\nmap_Kd " + std::string(name) + "\n");
        const auto scene = openScene(folder.write("in/a.obj", "mtllib up.mtl\n" + SQUARE + "usemtl x\nf 1 2 3\n"));
        EXPECT_EQ(vec3(scene->materials.at(1).baseColor), vec3(0, 1, 0)) << name;
        EXPECT_THAT(scene->warnings, Contains(::testing::AllOf(HasSubstr(name), HasSubstr("not drawn")))) << name;
    }
}

TEST(ObjLoader, SurvivesHostileLines) {
    const ScratchFolder folder;
    const auto open = [&](const std::string& text) { return openScene(folder.write("a.obj", text)); };
    EXPECT_EQ(open(SQUARE + "f 1 2 3\nt crease 2000000000/0/0\n")->triangleCount(), 1u);
    EXPECT_EQ(open(SQUARE + "f 1 2 3\nf 1 2 99\nf 1/9/9 2 3\nf 1 2\nf 1/1/1/1 2 3\nf a b c\n")->triangleCount(), 1u);
    EXPECT_EQ(open(SQUARE + "v nan inf 1e999\nf 1 2 5\nf 1 2 3\n")->bounds.high.z, 0.0f);
    EXPECT_EQ(open(SQUARE + "v 1e2147483648 -.5E-9999999999 1e+2147483647x\nf 1 2 5\nf 1 2 3\n")->triangleCount(), 1u);
    std::string polygon = "f";
    for (int i = 0; i < 300; i++) polygon += " 1";
    EXPECT_NO_THROW(open(SQUARE + polygon)) << "triangles without area";
    EXPECT_THROW(open(SQUARE + "f 0 0 0\n"), InputError);
    EXPECT_THROW(open(""), InputError);
    EXPECT_THROW(open(std::string(1000, '\0')), InputError);
    EXPECT_THROW(open("\xff\xfev\x01"), InputError);
    EXPECT_THROW(open("v " + std::string(20'000'000, '1')), InputError);
}

TEST(ObjLoader, TellsWhatIsNotDrawnByItsKind) {
    const ScratchFolder folder;
    const auto scene = openScene(
        folder.write("a.obj", SQUARE + "l 1 2\nl 2 3\np 1\nvp 1 2 3\nv 0 0 0*/\nf 1 2 3\nf 1 2\nusemtl gone\nf 1 2 3\n"));
    EXPECT_THAT(scene->warnings, Contains(HasSubstr("2 lines 'l' are not drawn (the first in line 9)")));
    EXPECT_THAT(scene->warnings, Contains(HasSubstr("1 lines 'p'")));
    EXPECT_THAT(scene->warnings, Contains(HasSubstr("something behind a number (the first in line 13)")));
    EXPECT_THAT(scene->warnings, Contains(HasSubstr("1 faces were dropped")));
    EXPECT_THAT(scene->warnings, Contains(HasSubstr("'gone'")));
}

// Files of other programs: each with the same square of the same material, written otherwise.
TEST(ObjLoader, ReadsWhatOthersWrite) {
    const ScratchFolder folder;
    const std::string mtl = "newmtl deep red\nKd 1 0 0\n", mark = "\xef\xbb\xbf";
    for (const char* name : {"m.mtl", "two words.mtl", "sub/m.mtl"}) folder.write(name, mtl);
    folder.write("marked.mtl", mark + mtl);
    folder.write("dos.mtl", "newmtl \t deep red \r\nKd 1 0 0\r\n");
    const std::string face = SQUARE + "usemtl deep red\nf 1 2 3 4\n";
    std::string dos = "mtllib dos.mtl\n" + face;
    for (size_t at = 0; (at = dos.find('\n', at)) != std::string::npos; at += 2) dos.replace(at, 1, "\r\n");
    const std::vector<std::string> texts = {
        "mtllib m.mtl\n" + face,
        mark + "mtllib m.mtl\n" + face,
        "# made by\n" + mark + "mtllib m.mtl\n" + face,
        "mtllib marked.mtl\n" + face,
        "mtllib two words.mtl\n" + face,
        "mtllib gone.mtl two words.mtl\n" + face,
        "mtllib two words.mtl m.mtl\n" + face,
        "mtllib sub\\m.mtl\n" + face,
        dos,
        "mtllib m.mtl\n" + SQUARE + "usemtl \t deep red \nf 1 \\\n2 3 \\\r\n 4\n",
        "mtllib m.mtl\nv 0 \\\n0 0\nv 1 0 0 # corner\nv +1 1 0 1.0\nv 0 1 0\nusemtl deep red\nf 1 2 3 4 # all\n"};
    for (const std::string& text : texts) {
        const auto scene = openScene(folder.write("a.obj", text));
        EXPECT_EQ(scene->triangleCount(), 2u) << text;
        ASSERT_EQ(scene->materials.size(), 2u) << text;
        EXPECT_EQ(vec3(scene->materials[1].baseColor), vec3(1, 0, 0)) << text;
        EXPECT_THAT(scene->warnings, ::testing::Not(Contains(HasSubstr("not drawn")))) << text;
    }
    EXPECT_EQ(openScene(folder.write("a.obj", "mtllib m.mtl\n" + SQUARE + "usemtl deep red\nf 1 2 3\nusemtl\nf 1 3 4\n"))
                  ->materials.size(),
              2u)
        << "usemtl alone: the default";
}

TEST(ObjLoader, AMaterialHasNothingOfTheOneBefore) {
    const ScratchFolder folder;
    folder.write("white.png", "no picture, but a name");
    folder.write("m.mtl",
                 "newmtl a\nKd 1 0 0\nd 0.5\nnewmtl map\nmap_Kd white.png\nnewmtl grey\nKd 0.5\nd -halo 1.0\n"
                 "newmtl clear\nTr 0.75\nd 1\nillum 2\n");
    const auto scene = openScene(folder.write("a.obj", "mtllib m.mtl\n" + SQUARE +
                                                           "usemtl a\nf 1 2 3\nusemtl map\nf 1 2 3\nusemtl "
                                                           "grey\nf 1 2 3\nusemtl clear\nf 1 2 3\n"));
    EXPECT_EQ(scene->materials.at(2).baseColor, vec4(0.6f, 0.6f, 0.6f, 1.0f)) << "the format's default under a map";
    EXPECT_EQ(scene->materials.at(3).baseColor, vec4(0.5f, 0.5f, 0.5f, 1.0f));
    EXPECT_EQ(scene->materials.at(4).baseColor.w, 1.0f) << "d before Tr";
    EXPECT_THAT(scene->warnings, Contains(HasSubstr("d -halo")));
}

TEST(ObjLoader, KeepsTheShapeOfWhatIsFarFromTheOrigin) {
    const ScratchFolder folder;
    const auto at = [&](const std::string& x, const std::string& z) {
        return openScene(folder.write("a.obj", "v " + x + ".125 102 " + z + ".5\nv " + x + ".375 102.0625 " + z + ".5\nv " + x +
                                                   ".25 102.25 " + z + ".75\nf 1 2 3\n"));
    };
    const auto near = at("0", "0"), far = at("512345", "5403210");
    EXPECT_THAT(far->warnings, Contains(HasSubstr("far from 0: moved by (-512345.25, -102.25, -5403210.75)")));
    for (const auto& [a, b] : {std::pair(0, 1), std::pair(1, 2)})
        EXPECT_EQ(far->positions[b] - far->positions[a], near->positions[b] - near->positions[a]);
    EXPECT_THAT(at("7", "3")->warnings, ::testing::Not(Contains(HasSubstr("moved"))));
}

/// The units of ASCII text as UTF-16, with a mark before it.
std::string utf16(const std::string& text, bool little) {
    std::string bytes = little ? "\xff\xfe" : "\xfe\xff";
    for (const char c : text) bytes += little ? std::string{c, '\0'} : std::string{'\0', c};
    return bytes;
}

TEST(ObjLoader, ReadsUtf16) {
    const ScratchFolder folder;
    for (const bool little : {true, false}) {
        folder.write("m.mtl", utf16("newmtl m\nKd 1 0 0\n", little));
        const auto scene = openScene(folder.write("a.obj", utf16("mtllib m.mtl\n" + SQUARE + "usemtl m\nf 1 2 3\n", little)));
        EXPECT_EQ(scene->triangleCount(), 1u);
        EXPECT_EQ(scene->materials[scene->triangles[0].w].baseColor.y, 0.0f);
    }
    // A pair of units is one letter, half a pair is none, half a unit is left out.
    const std::string name("\xff\xfe\x3d\xd8\x0a\xde=\xd8x", 9);
    ObjLines lines(std::span(reinterpret_cast<const uint8_t*>(name.data()), name.size()), "a");
    EXPECT_EQ(lines.next(), "\xf0\x9f\x98\x8a\xef\xbf\xbd");
}

TEST(ObjLoader, ACommentBehindANameIsNoneWhereTheNameIsThere) {
    const ScratchFolder folder;
    folder.write("m.mtl", "newmtl Material #25\nKd 1 0 0\nnewmtl red # so\nKd 0.5 0 0\nnewmtl red\nKd 0 0 0\n");
    const auto red = [&](const std::string& use) {
        const auto scene = openScene(folder.write("a.obj", "mtllib m.mtl\n" + SQUARE + "usemtl " + use + "\nf 1 2 3\n"));
        EXPECT_THAT(scene->warnings, Contains(HasSubstr("1 materials stand twice, the first of each is drawn: 'red'")));
        return scene->materials[scene->triangles[0].w].baseColor.x;
    };
    EXPECT_EQ(red("Material #25"), 1.0f);
    EXPECT_EQ(red("Material #25 # the first"), 1.0f);
    EXPECT_EQ(red("red"), 0.5f);
    EXPECT_EQ(red("red # so"), 0.5f);
}

TEST(ObjLoader, FindsFilesWhateverTheCaseOfTheirNames) {
    const ScratchFolder folder;
    folder.write("Lib/Red.MTL", "newmtl m\nKd 1 0 0\n");
    folder.write("lib.mtl", "newmtl m\nKd 0.25 0 0\n");
    folder.write("LIB.mtl", "newmtl m\nKd 0.5 0 0\n");
    const auto red = [&](const std::string& library) {
        const auto scene = openScene(folder.write("a.obj", "mtllib " + library + "\n" + SQUARE + "usemtl m\nf 1 2 3\n"));
        return scene->materials[scene->triangles[0].w].baseColor.x;
    };
    EXPECT_EQ(red("lib/red.mtl"), 1.0f);
    EXPECT_EQ(red("\"LIB\\RED.mtl\""), 1.0f);
    EXPECT_EQ(red("lib.mtl"), 0.25f) << "the same name comes first";
    EXPECT_EQ(red("Lib.Mtl"), 0.5f) << "then the first in their order";
}

}  // namespace
}  // namespace heliograph::TEST_FILE
