#include "server/kernel/kernel.h"
#include "tests/image/picture.h"

#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

/// Lets 1 - alpha straight through.
Material blend(vec3 color, float alpha) {
    Material m = paint(color);
    m.flags |= MATERIAL_ALPHA_BLEND;
    m.baseColor.w = alpha;
    return m;
}

/// A thin sheet of coloured glass without reflection.
Material tinted(vec3 color) {
    Material m = SceneBuilder::defaultMaterial();
    m.transmission = 1.0f;
    m.ior = 1.0f;
    m.roughness = 0.0f;
    m.baseColor = vec4(color, 1.0f);
    return m;
}

MeshData sheet(float height, uint32_t material, float half = 2.0f) { return ground(half, material, height); }

/// Light under the sheets, as seen from the side below them: white ground, sun from above.
vec3 lightUnder(const std::vector<Material>& sheets) {
    SceneBuilder builder = darkness();
    place(builder, ground(50.0f, builder.addMaterial(paint(vec3(1.0f)), "white")));
    for (size_t i = 0; i < sheets.size(); i++) place(builder, sheet(2.0f + float(i), builder.addMaterial(sheets[i], "sheet")));
    builder.addLight(sun(vec3(0, -1, 0), vec3(float(EXACT_PI))));
    return render(builder.finish(), lookAt(vec3(0, 1, 5), vec3(0.0f), 5.0f)).centre();
}

TEST(TransparentShadow, BlendedSheetsPassOneMinusAlphaEach) {
    EXPECT_NEAR(lightUnder({}).x, 1.0f, 1e-5f);
    EXPECT_NEAR(lightUnder({blend(vec3(1, 0, 0), 0.25f)}).x, 0.75f, 1e-5f);
    EXPECT_NEAR(lightUnder({blend(vec3(1, 0, 0), 0.25f), blend(vec3(1, 0, 0), 0.5f)}).y, 0.375f, 1e-5f);
    EXPECT_NEAR(lightUnder({blend(vec3(1, 0, 0), 1.0f), blend(vec3(1, 0, 0), 0.5f)}).y, 0.0f, 1e-5f);
}

TEST(TransparentShadow, TintedPanesMultiplyTheirColours) {
    const vec3 a(0.9f, 0.5f, 0.1f), b(0.4f, 0.8f, 1.0f);
    const vec3 one = lightUnder({tinted(a)}), two = lightUnder({tinted(a), tinted(b)});
    for (int c = 0; c < 3; c++) {
        EXPECT_NEAR(one[c], a[c], 1e-5f);
        EXPECT_NEAR(two[c], a[c] * b[c], 1e-5f) << "each pane once, no double count";
    }
}

TEST(TransparentShadow, WithoutTheEffectEverySurfaceCastsAFullShadow) {
    SceneBuilder builder = darkness();
    place(builder, ground(50.0f, builder.addMaterial(paint(vec3(1.0f)), "white")));
    place(builder, sheet(2.0f, builder.addMaterial(blend(vec3(1, 0, 0), 0.25f), "sheet")));
    builder.addLight(sun(vec3(0, -1, 0), vec3(float(EXACT_PI))));
    const auto scene = builder.finish();
    cpu().load(scene, {}, {});
    FrameRequest request = frameRequest(*scene, lookAt(vec3(0, 1, 5), vec3(0.0f), 5.0f), {}, uvec2(9, 9), 1);
    ASSERT_TRUE(request.effects.has(EFFECT_TRANSPARENT_SHADOWS));
    request.effects.bits &= ~EFFECT_TRANSPARENT_SHADOWS;
    Film film;
    std::vector<vec4> pixels;
    renderFrame(cpu(), request, 1, film);
    film.develop(pixels);
    EXPECT_EQ(vec3(pixels[40]), vec3(0.0f));
}

TEST(TransparentShadow, ManyPanesAreAllCounted) {
    const std::vector<Material> panes(12, tinted(vec3(0.9f, 0.5f, 1.0f)));
    const vec3 light = lightUnder(panes);
    EXPECT_NEAR(light.x, std::pow(0.9, 12.0), 1e-5);
    EXPECT_NEAR(light.y, std::pow(0.5, 12.0), 1e-6);
    EXPECT_NEAR(light.z, 1.0, 1e-5);
}

TEST(TransparentShadow, SurfacesBeyondTheLimitAreOpaque) {
    constexpr uint32_t MOST = scalar_kernel::Kernel<0>::MAX_SHADOW_SURFACES;
    EXPECT_NEAR(lightUnder(std::vector<Material>(MOST, tinted(vec3(0.99f)))).x, std::pow(0.99, MOST), 1e-5);
    EXPECT_EQ(lightUnder(std::vector<Material>(MOST + 1, tinted(vec3(0.99f)))), vec3(0.0f));
}

TEST(TransparentShadow, AnOpaqueSheetAmongThemBlocksAll) {
    EXPECT_EQ(lightUnder({tinted(vec3(0.9f)), paint(vec3(1.0f)), tinted(vec3(0.5f))}), vec3(0.0f));
}

TEST(TransparentShadow, GlassBodiesAbsorbOnTheWay) {
    Material amber = glass(1.0f);
    amber.absorption = vec4(0.2f, 1.0f, 3.0f, 0.0f);
    SceneBuilder builder = darkness();
    place(builder, ground(50.0f, builder.addMaterial(paint(vec3(1.0f)), "white")));
    place(builder, box(vec3(-2, 2, -2), vec3(2, 2.7f, 2), builder.addMaterial(amber, "amber")));
    builder.addLight(sun(vec3(0, -1, 0), vec3(float(EXACT_PI))));
    const vec3 light = render(builder.finish(), lookAt(vec3(0, 1, 5), vec3(0.0f), 5.0f)).centre();
    const double sigma[] = {0.2, 1.0, 3.0};
    for (int c = 0; c < 3; c++) EXPECT_NEAR(light[c], std::exp(-0.7 * sigma[c]), 2e-4) << c;
}

TEST(TransparentShadow, PanesBehindTheLightDoNotCount) {
    SceneBuilder builder = darkness();
    place(builder, ground(50.0f, builder.addMaterial(paint(vec3(1.0f)), "white")));
    place(builder, sheet(2.0f, builder.addMaterial(tinted(vec3(0.1f)), "above the lamp"), 20.0f));
    builder.addLight(pointLight(vec3(0, 1.5f, 0), vec3(float(EXACT_PI) * 2.25f)));
    EXPECT_NEAR(render(builder.finish(), lookAt(vec3(0, 1, 5), vec3(0.0f), 5.0f)).centre().x, 1.0f, 1e-4f);
}

// ---- what the camera sees ----

TEST(AlphaBlend, LayersCompositeInOrder) {
    SceneBuilder builder = darkness(vec3(0.2f, 0.3f, 0.4f));
    const vec3 colours[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const float alphas[] = {0.5f, 0.25f, 0.7f};
    vec3 expected(0.2f, 0.3f, 0.4f);
    for (int i = 0; i < 3; i++) {
        Material m = blend(vec3(0.0f), alphas[i]);
        m.emission = vec4(colours[i], 0.0f);
        place(builder, sheet(float(i), builder.addMaterial(m, "layer")));
        expected = expected * (1.0f - alphas[i]) + colours[i] * alphas[i];
    }
    Settings settings;
    settings.contributionThreshold = 0.0f;
    const Picture picture = render(builder.finish(), lookAt(vec3(0, 6, 0), vec3(0.0f), 10.0f), settings);
    for (int c = 0; c < 3; c++) EXPECT_NEAR(picture.centre()[c], expected[c], 1e-5f) << c;
}

// 40 layers in front of a lamp: 16 are followed, what is left of the light is estimated from the sky.
TEST(AlphaBlend, LayersBeyondTheLimitAreEstimated) {
    SceneBuilder builder = darkness(vec3(1.0f));
    const uint32_t layer = builder.addMaterial(blend(vec3(0.0f), 0.05f), "layer");
    for (int i = 0; i < 40; i++) place(builder, sheet(0.1f * float(i), layer));
    place(builder, sheet(-1.0f, builder.addMaterial(glow(vec3(0.0f)), "black")));
    Settings settings;
    settings.contributionThreshold = 0.0f;
    const Picture picture = render(builder.finish(), lookAt(vec3(0, 9, 0), vec3(0.0f), 10.0f), settings);
    EXPECT_NEAR(picture.centre().x, std::pow(0.95, 17.0), 1e-4);
}

TEST(AlphaBlend, VertexAlphaCounts) {
    SceneBuilder builder = darkness(vec3(1.0f));
    MeshData mesh = sheet(0.0f, builder.addMaterial(blend(vec3(0.0f), 1.0f), "veil"));
    mesh.colors.assign(4, vec4(1.0f, 1.0f, 1.0f, 0.4f));
    place(builder, mesh);
    EXPECT_NEAR(render(builder.finish(), lookAt(vec3(0, 4, 0), vec3(0.0f), 10.0f)).centre().x, 0.6f, 0.002f);
}

/// A sheet with a chequered alpha of 8 x 8 squares of 0.5 m, holes where x + y is odd.
std::shared_ptr<const Scene> fence(bool placed) {
    SceneBuilder builder = darkness(vec3(0.5f));
    ImageData image;
    image.width = image.height = 8;
    for (uint32_t i = 0; i < 64; i++)
        image.rgba8.insert(image.rgba8.end(), {255, 255, 255, uint8_t((i + i / 8) % 2 ? 0 : 255)});
    TextureSlot slot = SceneBuilder::defaultTexture(builder.addImage(image));
    slot.nearest = 1;
    Material m = glow(vec3(2.0f));
    m.flags |= MATERIAL_ALPHA_MASK;
    m.baseTexture = builder.addTexture(slot);
    MeshData body = sheet(3.0f, builder.addMaterial(m, "fence"));
    if (placed) {
        // Modelled elsewhere, standing in two places: stays in object space.
        for (vec3& p : body.positions) p = vec3(p.z, p.x, p.y) * 2.0f + vec3(7, 0, 0);
        for (vec3& n : body.normals) n = vec3(1, 0, 0);
        mat4 back(0.0f);
        back[0] = vec4(0, 0, 0.5f, 0);
        back[1] = vec4(0.5f, 0, 0, 0);
        back[2] = vec4(0, 0.5f, 0, 0);
        back[3] = vec4(0, 0, -3.5f, 1);
        const uint32_t mesh = builder.addMesh(body);
        builder.addInstance(mesh, back);
        back[3].x = 100.0f;
        builder.addInstance(mesh, back);
    } else {
        place(builder, body);
    }
    place(builder, ground(50.0f, builder.addMaterial(paint(vec3(1.0f)), "white")));
    builder.addLight(sun(vec3(0, -1, 0), vec3(float(EXACT_PI))));
    return builder.finish();
}

/// Whether the fence of `fence()` has a hole at (x, z); 0 near a border.
int holeAt(double x, double z) {
    const double u = (x + 2.0) / 0.5, v = (2.0 - z) / 0.5;
    if (u < 0.0 || u >= 8.0 || v < 0.0 || v >= 8.0) return 1;
    if (std::abs(u - std::round(u)) < 1e-3 || std::abs(v - std::round(v)) < 1e-3) return 0;
    return (int(u) + int(v)) % 2 ? 1 : -1;
}

TEST(AlphaMask, HolesAreSeenThrough) {
    for (bool placed : {false, true}) {
        const Camera camera = lookAt(vec3(0, 10, 0), vec3(0.0f), 25.0f);
        const Picture picture = render(fence(placed), camera);
        int holes = 0;
        for (uint32_t y = 0; y < picture.size.y; y++) {
            for (uint32_t x = 0; x < picture.size.x; x++) {
                const dvec3 p = onPlane(camera, picture.size, x, y, dvec3(0, 3, 0), dvec3(0, 1, 0));
                const int hole = holeAt(p.x, p.z);
                if (hole == 0) continue;
                ASSERT_EQ(picture.at(x, y).x == 2.0f, hole < 0) << x << ' ' << y;
                holes += hole > 0;
            }
        }
        EXPECT_GT(holes, 1000);
    }
}

TEST(AlphaMask, HolesLetTheSunThrough) {
    for (bool placed : {false, true}) {
        const Camera camera = lookAt(vec3(0, 2.8f, 3), vec3(0, 0, 0), 50.0f);
        const Picture picture = render(fence(placed), camera);
        int spots = 0;
        for (uint32_t y = 20; y < picture.size.y; y++) {
            for (uint32_t x = 0; x < picture.size.x; x++) {
                const dvec3 p = onPlane(camera, picture.size, x, y, dvec3(0.0), dvec3(0, 1, 0));
                const int hole = holeAt(p.x, p.z);
                if (hole == 0 || std::abs(p.x) > 1.99 || std::abs(p.z) > 1.99) continue;
                ASSERT_NEAR(picture.at(x, y).x, hole > 0 ? 1.5f : 0.5f, 1e-5f) << x << ' ' << y;
                spots += hole > 0;
            }
        }
        EXPECT_GT(spots, 200);
    }
}

// Cut-outs read the finest texels however far they are: a sample sees all or nothing, and only the mean of many is their coverage.
TEST(AlphaMask, FineHolesAreTheirCoverageInTheMeanAlone) {
    SceneBuilder builder = darkness();
    ImageData image;
    image.width = image.height = 128;
    for (uint32_t i = 0; i < 128 * 128; i++)
        image.rgba8.insert(image.rgba8.end(), {255, 255, 255, uint8_t((i + i / 128) % 2 ? 0 : 255)});
    TextureSlot slot = SceneBuilder::defaultTexture(builder.addImage(image));
    slot.nearest = 1;
    Material m = glow(vec3(2.0f));
    m.flags |= MATERIAL_ALPHA_MASK;
    m.baseTexture = builder.addTexture(slot);
    place(builder, sheet(3.0f, builder.addMaterial(m, "fence")));
    const auto scene = builder.finish();
    const Camera camera = lookAt(vec3(0, 10, 0), vec3(0.0f), 40.0f);  // 41 pixels across the sheet, three texels each
    const auto worst = [&](uint32_t samples) {
        const Picture picture = render(scene, camera, {}, samples, uvec2(51, 51));
        double sum = 0.0;
        for (uint32_t y = 10; y < 41; y++)
            for (uint32_t x = 10; x < 41; x++) sum += std::pow(double(picture.at(x, y).x) / 2.0 - 0.5, 2.0);
        return std::sqrt(sum / (31 * 31));
    };
    EXPECT_NEAR(worst(1), 0.5, 0.01) << "sqrt(c (1 - c)) of a coverage c of a half";
    EXPECT_LT(worst(256), 0.05);
}

// Shadow rays go straight through glass: what a ball gathers into a spot is spread over its shadow.
TEST(TransparentShadow, ABallsCausticIsSpreadOverItsShadow) {
    SceneBuilder builder = darkness();
    place(builder, ground(50.0f, builder.addMaterial(paint(vec3(0.8f)), "floor")));
    MeshData body = icosphere(5, builder.addMaterial(glass(1.5f), "ball"));
    for (vec3& p : body.positions) p = p * 0.5f + vec3(0, 0.8f, 0);
    place(builder, body);
    place(builder, panel(vec3(-0.5f, 5, -0.5f), vec3(1, 0, 0), vec3(0, 0, 1), builder.addMaterial(glow(vec3(40.0f)), "lamp")));
    const auto scene = builder.finish();
    const Camera camera = lookAt(vec3(3, 1.2f, 0), vec3(0.0f), 14.0f);
    Settings settings;
    settings.maxRefractions = 8;
    const auto spotOf = [&](const char* integrator, uint32_t samples) {
        settings.integrator = Settings::choice("integrator", "path") * (std::string_view(integrator) == "path");
        return double(render(scene, camera, settings, samples, uvec2(33, 33)).centre().x);
    };
    const double shown = spotOf("interactive", 64), exact = spotOf("path", 4096);
    EXPECT_NEAR(exact / shown, 21.0, 3.0) << exact << " for " << shown;
}

}  // namespace
}  // namespace heliograph::TEST_FILE
