// The layers of the material model against closed forms and in furnaces, with the interactive integrator, with glossy reflections
// and along paths.

#include "server/request/effect_rules.h"
#include "tests/image/picture.h"

#include <gtest/gtest.h>

#include <array>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

/// The three ways of tracing, with samples that bring their noise well below a bound of 0.3 %.
struct Way {
    const char* name;
    Settings settings;
    uint32_t samples;
};

std::vector<Way> ways() {
    Settings interactive;
    interactive.contributionThreshold = 0.0f;
    Settings glossy = interactive, path = interactive;
    glossy.glossyReflections = true;
    path.integrator = Settings::choice("integrator", "path");
    return {{"interactive", interactive, 3}, {"glossy", glossy, 192}, {"path", path, 384}};
}

/// A material with these layers and how it is made on top of the default.
using Make = std::function<void(Material&, MaterialLayers&)>;

Picture layered(const Make& make, vec3 sky, const Settings& settings, uint32_t samples, float fieldOfView = 25.0f) {
    SceneBuilder builder = darkness(sky);
    Material m = SceneBuilder::defaultMaterial();
    MaterialLayers layers;
    make(m, layers);
    m.layers = builder.addLayers(layers);
    place(builder, icosphere(5, builder.addMaterial(m, "layered")));
    return render(builder.finish(), lookAt(vec3(0, 0, 4), vec3(0.0f), fieldOfView), settings, samples, uvec2(33, 33));
}

vec3 meanOf(const Picture& picture) {
    dvec3 sum(0.0);
    for (vec4 p : picture.pixels) sum += dvec3(p);
    return vec3(sum / double(picture.pixels.size()));
}

/// Reflects nothing but by its layers.
void blacken(Material& m) {
    m.baseColor = vec4(0.0f, 0.0f, 0.0f, 1.0f);
    m.specular.w = 1.0f;
}

void expectNoGain(const char* what, const Make& make, double least) {
    for (const Way& way : ways()) {
        const vec3 mean = meanOf(layered(make, vec3(1.0f), way.settings, way.samples));
        for (int c = 0; c < 3; c++) {
            EXPECT_LE(mean[c], 1.001f) << what << ' ' << way.name;
            EXPECT_GE(mean[c], least) << what << ' ' << way.name;
        }
    }
}

TEST(Layers, ACoatOverWhiteIsInvisibleInAFurnace) {
    for (float roughness : {0.0f, 0.3f, 0.8f})
        expectNoGain(
            "coat", [&](Material&, MaterialLayers& l) { l.coat = 1.0f, l.coatRoughness = roughness; }, 0.997);
}

TEST(Layers, ACoatOverMetalNeverGains) {
    const auto make = [](Material& m, MaterialLayers& l) {
        m.metallic = 1.0f, m.roughness = 0.4f;
        l.coat = 1.0f, l.coatRoughness = 0.1f;
    };
    expectNoGain("coated metal", make, 0.99);
}

/// Straight on, 4 % of what is there; half a coat half of it.
TEST(Layers, ACoatOverBlackReflectsAsGlassDoes) {
    for (const Way& way : ways()) {
        for (float coat : {1.0f, 0.5f}) {
            const auto make = [&](Material& m, MaterialLayers& l) { blacken(m), l.coat = coat; };
            const Picture picture = layered(make, vec3(1.0f), way.settings, way.samples, 2.0f);
            EXPECT_NEAR(picture.centre().x / (0.04 * coat), 1.0, 0.03) << way.name << ' ' << coat;
        }
    }
}

/// The whole sphere in even light, over its disc: the integral of Schlick's curve, 0.04 + 0.96 / 21.
TEST(Layers, ACoatedBlackBallReflectsSchlicksMean) {
    const auto make = [](Material& m, MaterialLayers& l) { blacken(m), l.coat = 1.0f; };
    Settings settings;
    settings.contributionThreshold = 0.0f;
    SceneBuilder builder = darkness(vec3(1.0f));
    Material m = SceneBuilder::defaultMaterial();
    MaterialLayers layers;
    make(m, layers);
    m.layers = builder.addLayers(layers);
    place(builder, icosphere(6, builder.addMaterial(m, "coated")));
    const Picture picture =
        render(builder.finish(), lookAt(vec3(0, 0, 400), vec3(0.0f), 0.2865f), settings, 16, uvec2(129, 129));
    // The picture is 2.0 m high: the disc fills it, and beside it is white.
    double sum = 0.0, count = 0.0;
    for (uint32_t y = 0; y < 129; y++) {
        for (uint32_t x = 0; x < 129; x++) {
            const double r = std::hypot(x - 64.0, y - 64.0) / 64.5;
            if (r > 0.9) continue;
            sum += picture.at(x, y).x;
            count++;
        }
    }
    // Over discs up to r = 0.9: cosines from sqrt(1 - 0.81) to 1, weight 2 c dc.
    const double least = std::sqrt(1.0 - 0.81);
    double expected = 0.0, weights = 0.0;
    for (int i = 0; i < 4000; i++) {
        const double c = least + (1.0 - least) * (i + 0.5) / 4000.0;
        expected += (0.04 + 0.96 * std::pow(1.0 - c, 5.0)) * c, weights += c;
    }
    EXPECT_NEAR(sum / count / (expected / weights), 1.0, 0.03);
}

/// A coat keeps its own normal: over a metal of roughness 1 a lamp is mirrored sharply.
TEST(Layers, ACoatsHighlightHasItsOwnWidth) {
    const auto peak = [&](float coatRoughness) {
        SceneBuilder builder("highlight");
        builder.setEnvironmentColor(vec3(0.0f));
        builder.addLight(sun(vec3(0, 0, -1), vec3(1.0f)));
        Material m = SceneBuilder::defaultMaterial();
        blacken(m);
        MaterialLayers layers;
        layers.coat = 1.0f, layers.coatRoughness = coatRoughness;
        m.layers = builder.addLayers(layers);
        place(builder, icosphere(5, builder.addMaterial(m, "coated")));
        return double(render(builder.finish(), lookAt(vec3(0, 0, 4), vec3(0.0f), 0.01f), {}, 1, uvec2(3, 3)).centre().x);
    };
    // D(1) V F cos = 1 / (pi a^2) / 4 * 0.04
    for (double roughness : {0.2, 0.5, 1.0}) {
        const double a = roughness * roughness;
        EXPECT_NEAR(peak(float(roughness)) / (0.04 / (4.0 * EXACT_PI * a * a)), 1.0, 0.01) << roughness;
    }
}

TEST(Layers, SheenNeverGains) {
    for (float roughness : {0.1f, 0.3f, 0.6f, 1.0f}) {
        expectNoGain(
            "sheen",
            [&](Material&, MaterialLayers& l) {
                l.sheenRed = l.sheenGreen = l.sheenBlue = 1.0f;
                l.sheenRoughness = roughness;
            },
            0.97);
    }
}

/// Directional albedo of the sheen over black by our own integral, in double, along wi: Estevez & Kulla (2017), equations 2 and 3.
double sheenIntegral(double roughness, double cosine) {
    const double a = roughness * roughness, t = (1.0 - a) * (1.0 - a);
    const auto mixed = [&](double rough, double smooth) { return rough + (smooth - rough) * t; };
    const auto fit = [&](double x) {
        return mixed(21.5473, 25.3245) / (1.0 + mixed(3.82987, 3.32435) * std::pow(x, mixed(0.19823, 0.16801))) +
               mixed(-1.97760, -1.27393) * x + mixed(-4.32054, -4.85967);
    };
    const auto lambda = [&](double c) { return std::exp(c < 0.5 ? fit(c) : 2.0 * fit(0.5) - fit(1.0 - c)); };
    const dvec3 wo(std::sqrt(1.0 - cosine * cosine), 0.0, cosine);
    const int rings = 400, sectors = 400;
    double sum = 0.0;
    for (int i = 0; i < rings; i++) {
        const double z = (i + 0.5) / rings, s = std::sqrt(1.0 - z * z);
        for (int j = 0; j < sectors; j++) {
            const double turn = 2.0 * EXACT_PI * (j + 0.5) / sectors;
            const dvec3 wi(s * std::cos(turn), s * std::sin(turn), z), h = glm::normalize(wi + wo);
            const double sine2 = 1.0 - h.z * h.z;
            const double d = (2.0 + 1.0 / a) * std::pow(sine2, 0.5 / a) / (2.0 * EXACT_PI);
            sum += d / ((1.0 + lambda(cosine) + lambda(z)) * 4.0 * cosine);
        }
    }
    return sum * 2.0 * EXACT_PI / (rings * sectors);
}

TEST(Layers, SheenOverBlackReflectsItsIntegral) {
    for (float roughness : {0.3f, 0.6f, 1.0f}) {
        for (const Way& way : ways()) {
            for (double sine : {0.0, 0.5, 0.8}) {
                SceneBuilder builder = darkness(vec3(1.0f));
                Material m = SceneBuilder::defaultMaterial();
                blacken(m);
                MaterialLayers layers;
                layers.sheenRed = layers.sheenGreen = layers.sheenBlue = 1.0f;
                layers.sheenRoughness = roughness;
                m.layers = builder.addLayers(layers);
                place(builder, ground(100.0f, builder.addMaterial(m, "cloth")));
                const double cosine = std::sqrt(1.0 - sine * sine);
                const Camera camera = lookAt(vec3(float(sine), float(cosine), 0), vec3(0.0f), 1.0f);
                const double seen = meanOf(render(builder.finish(), camera, way.settings, way.samples, uvec2(9, 9))).x;
                EXPECT_NEAR(seen / sheenIntegral(roughness, cosine), 1.0, 0.03) << way.name << ' ' << roughness << ' ' << sine;
            }
        }
    }
}

TEST(Layers, AnisotropicMetalNeverGains) {
    for (float roughness : {0.0f, 0.2f, 0.5f}) {
        for (float strength : {0.5f, 1.0f}) {
            expectNoGain(
                "brushed",
                [&](Material& m, MaterialLayers& l) {
                    m.metallic = 1.0f, m.roughness = roughness;
                    l.anisotropy = strength;
                },
                roughness > 0.0f ? 0.86 : 0.85);
        }
    }
}

/// Distribution times visibility wherever it is seen from under one angle; what bounces between facets is given back by a factor
/// that is the same for all of them.
TEST(Layers, AnisotropicHighlightsHaveBothWidths) {
    const double roughness = 0.4, strength = 0.7, across = roughness * roughness;
    const double along = across + (1.0 - across) * strength * strength;
    double given = 0.0;
    for (double turn : {0.0, 30.0, 90.0}) {
        SceneBuilder builder("brushed");
        builder.setEnvironmentColor(vec3(0.0f));
        builder.addLight(sun(vec3(0, -1, 0), vec3(1.0f)));
        Material m = SceneBuilder::defaultMaterial();
        m.metallic = 1.0f, m.roughness = float(roughness);
        MaterialLayers layers;
        layers.anisotropy = float(strength);
        layers.anisotropyCosine = float(std::cos(turn * EXACT_PI / 180.0));
        layers.anisotropySine = float(std::sin(turn * EXACT_PI / 180.0));
        m.layers = builder.addLayers(layers);
        MeshData plate = ground(100.0f, builder.addMaterial(m, "plate"));
        plate.tangents.assign(plate.positions.size(), vec4(1, 0, 0, 1));
        place(builder, plate);
        const auto scene = builder.finish();
        ASSERT_TRUE(std::ranges::any_of(explainEffects(*scene),
                                        [](const EffectReason& r) { return r.name == "anisotropy" && r.calledFor; }));
        for (double azimuth : {0.0, 45.0, 90.0}) {
            const double lean = 20.0 * EXACT_PI / 180.0, phi = azimuth * EXACT_PI / 180.0;
            // In the tangent frame x, bitangent cross(up, x) = -z.
            const dvec3 wo(std::sin(lean) * std::cos(phi), std::cos(lean), -std::sin(lean) * std::sin(phi)), wi(0, 1, 0);
            const dvec3 h = glm::normalize(wo + wi);
            const double c = std::cos(turn * EXACT_PI / 180.0), s = std::sin(turn * EXACT_PI / 180.0);
            const dvec3 t(c, 0, -s), b(-s, 0, -c);
            const auto scaled = [&](dvec3 d) {
                return std::sqrt(std::pow(glm::dot(d, t) * along, 2) + std::pow(glm::dot(d, b) * across, 2) + d.y * d.y);
            };
            const double x = glm::dot(h, t) / along, y = glm::dot(h, b) / across, z = h.y;
            const double d = 1.0 / (EXACT_PI * along * across * std::pow(x * x + y * y + z * z, 2));
            const double v = 0.5 / (wi.y * scaled(wo) + wo.y * scaled(wi));
            Settings settings;
            settings.reflections = settings.shadows = false;
            const Camera camera = lookAt(vec3(wo), vec3(0.0f), 0.01f);
            const double seen = render(scene, camera, settings, 1, uvec2(3, 3)).centre().x;
            if (given == 0.0) given = seen / (d * v);
            EXPECT_NEAR(seen / (d * v) / given, 1.0, 1e-3) << turn << ' ' << azimuth;
        }
    }
}

// ---- thin films ----

/// Colour matching by sums of Gaussians: Wyman, Sloan & Shirley, "Simple Analytic Approximations to the CIE XYZ Color Matching
/// Functions", JCGT 2(2) 2013.
dvec3 matching(double nm) {
    const auto lobe = [&](double peak, double below, double above) {
        const double t = (nm - peak) / (nm < peak ? below : above);
        return std::exp(-0.5 * t * t);
    };
    return {1.056 * lobe(599.8, 37.9, 31.0) + 0.362 * lobe(442.0, 16.0, 26.7) - 0.065 * lobe(501.1, 20.4, 26.2),
            0.821 * lobe(568.8, 46.9, 40.5) + 0.286 * lobe(530.9, 16.3, 31.1),
            1.217 * lobe(437.0, 11.8, 36.0) + 0.681 * lobe(459.0, 26.0, 13.8)};
}

/// Exact reflectance of a film straight on: Airy's sum over all orders, in light of equal energy, as luminance.
double airyLuminance(double film, double base, double nanometres) {
    double sum = 0.0, white = 0.0;
    for (double nm = 380.0; nm <= 780.0; nm += 1.0) {
        const double r1 = (1.0 - film) / (1.0 + film), r2 = (film - base) / (film + base);
        const double phase = 4.0 * EXACT_PI * film * nanometres / nm;
        const double r =
            (r1 * r1 + r2 * r2 + 2.0 * r1 * r2 * std::cos(phase)) / (1.0 + r1 * r1 * r2 * r2 + 2.0 * r1 * r2 * std::cos(phase));
        const double y = matching(nm).y;
        sum += r * y, white += y;
    }
    return sum / white;
}

TEST(Layers, AFilmOverGlassReflectsAirysSum) {
    // Of all light: 3 % of the reflectance of the body without a film; thick films 11 %, since the eye's sensitivities are single
    // Gaussians of the wave number there.
    for (const auto& [nanometres, off] :
         {std::pair(150.0, 0.0034), std::pair(250.0, 0.0034), std::pair(400.0, 0.0034), std::pair(550.0, 0.012)}) {
        const auto thickness = static_cast<float>(nanometres);
        const auto make = [thickness](Material& m, MaterialLayers& l) {
            m.baseColor = vec4(0.0f, 0.0f, 0.0f, 1.0f);
            m.roughness = 0.0f;
            m.ior = 2.0f;
            l.iridescence = 1.0f, l.filmIor = 1.4f;
            l.filmThickest = thickness;
        };
        Settings settings;
        settings.contributionThreshold = 0.0f;
        const vec3 seen = layered(make, vec3(1.0f), settings, 1, 0.5f).centre();
        const double luminance = 0.2126 * seen.x + 0.7152 * seen.y + 0.0722 * seen.z;
        EXPECT_NEAR(luminance, airyLuminance(1.4, 2.0, nanometres), off) << nanometres;
    }
}

TEST(Layers, AFilmNeverGainsAndNoFilmChangesNothing) {
    for (float metallic : {0.0f, 1.0f}) {
        for (float nanometres : {200.0f, 450.0f}) {
            expectNoGain(
                "film",
                [&](Material& m, MaterialLayers& l) {
                    m.metallic = metallic, m.roughness = 0.2f;
                    l.iridescence = 1.0f, l.filmThickest = nanometres;
                },
                0.0);
        }
    }
    const auto plain = [](Material& m, MaterialLayers&) { m.roughness = 0.2f, m.metallic = 1.0f; };
    const auto off = [&](Material& m, MaterialLayers& l) { plain(m, l), l.iridescence = 0.0f; };
    EXPECT_EQ(meanOf(layered(plain, vec3(1.0f), {}, 1)), meanOf(layered(off, vec3(1.0f), {}, 1)));
}

// ---- dispersion ----

Material dispersive(SceneBuilder& builder, float strength) {
    Material m = glass(1.5f);
    MaterialLayers layers;
    layers.dispersion = strength;
    m.layers = builder.addLayers(layers);
    return m;
}

TEST(Layers, DispersionLosesNothingOfAnyColour) {
    for (const Way& way : ways()) {
        SceneBuilder builder = darkness(vec3(1.0f));
        place(builder, icosphere(5, builder.addMaterial(dispersive(builder, 1.0f), "gem")));
        const auto scene = builder.finish();
        const vec3 mean =
            meanOf(render(scene, lookAt(vec3(0, 0, 4), vec3(0.0f), 20.0f), way.settings, way.samples, uvec2(33, 33)));
        for (int c = 0; c < 3; c++) EXPECT_NEAR(mean[c], 1.0, 0.02) << way.name << " channel " << c;
    }
}

/// A prism turns what is behind it by Snell's law, each channel by an index of its own.
TEST(Layers, APrismTurnsEachColourByItsIndex) {
    const double wedge = 10.0 * EXACT_PI / 180.0, strength = 4.0;
    for (int channel = 0; channel < 3; channel++) {
        const double ior = 1.5 + (channel - 1) * 0.5 * 0.025 * strength;
        // Straight into the first face, out of the second, which leans by the wedge.
        const double turned = std::asin(ior * std::sin(wedge)) - wedge;
        for (double off : {-0.002, 0.002}) {
            SceneBuilder builder = darkness();
            const uint32_t prism = builder.addMaterial(dispersive(builder, float(strength)), "prism");
            MeshData front = panel(vec3(-1, -1, 0), vec3(2, 0, 0), vec3(0, 2, 0), prism);
            place(builder, front);
            // The far face looks away, its thick side below.
            const float slope = float(std::tan(wedge));
            place(builder, panel(vec3(1, -1, -0.5f - slope), vec3(-2, 0, 0), vec3(0, 2, 2 * slope), prism));
            // A lamp above a level that the ray of this channel just misses or just meets, 100 m behind.
            const double level = -100.0 * std::tan(turned + off);
            place(builder, panel(vec3(-500, float(level), -100.5f), vec3(1000, 0, 0), vec3(0, 1000, 0),
                                 builder.addMaterial(glow(vec3(1.0f)), "lamp")));
            Settings settings;
            settings.contributionThreshold = 0.0f;
            const Camera camera = lookAt(vec3(0, 0, 5), vec3(0.0f), 0.01f);
            const vec3 seen = render(builder.finish(), camera, settings, 3, uvec2(1, 1)).centre();
            EXPECT_NEAR(seen[channel], off > 0.0 ? 0.92f : 0.0f, 0.02f) << "channel " << channel << " off " << off;
        }
    }
}

// ---- light through thin things ----

Material leaf(SceneBuilder& builder, float share, vec3 color) {
    Material m = SceneBuilder::defaultMaterial();
    m.baseColor = vec4(0.8f, 0.8f, 0.8f, 1.0f);
    m.specular.w = 1.0f;  // no reflection
    MaterialLayers layers;
    layers.diffuseTransmission = share;
    layers.diffuseRed = color.x, layers.diffuseGreen = color.y, layers.diffuseBlue = color.z;
    m.layers = builder.addLayers(layers);
    return m;
}

TEST(Layers, ALeafLitFromBehindGlowsInItsColour) {
    const vec3 color(0.2f, 0.6f, 0.1f);
    for (bool behind : {false, true}) {
        SceneBuilder builder("leaf");
        builder.setEnvironmentColor(vec3(0.0f));
        builder.addLight(sun(vec3(0, 0, behind ? 1.0f : -1.0f), vec3(2.0f)));
        const Material m = leaf(builder, 0.4f, color);
        place(builder, panel(vec3(-1, -1, 0), vec3(2, 0, 0), vec3(0, 2, 0), builder.addMaterial(m, "leaf")));
        const auto scene = builder.finish();
        for (const Way& way : ways()) {
            const vec3 seen = render(scene, lookAt(vec3(0.3f, 0, 3), vec3(0.0f), 1.0f), way.settings, 4, uvec2(5, 5)).centre();
            for (int c = 0; c < 3; c++) {
                const double expected = 2.0 / EXACT_PI * (behind ? 0.4 * double(color[c]) : 0.6 * 0.8);
                EXPECT_NEAR(seen[c] / expected, 1.0, 1e-3) << way.name << (behind ? " behind" : " before");
            }
        }
    }
}

/// Even light from both sides: what is reflected and what comes through add up.
TEST(Layers, ALeafInAFurnaceShowsBothAlbedos) {
    for (const Way& way : ways()) {
        SceneBuilder builder = darkness(vec3(1.0f));
        const Material m = leaf(builder, 0.4f, vec3(0.5f, 1.0f, 0.2f));
        place(builder, panel(vec3(-1, -1, 0), vec3(2, 0, 0), vec3(0, 2, 0), builder.addMaterial(m, "leaf")));
        const vec3 seen =
            meanOf(render(builder.finish(), lookAt(vec3(0, 0, 3), vec3(0.0f), 5.0f), way.settings, way.samples, uvec2(17, 17)));
        for (int c = 0; c < 3; c++)
            EXPECT_NEAR(seen[c], 0.6 * 0.8 + 0.4 * double(vec3(0.5f, 1.0f, 0.2f)[c]), 0.006) << way.name;
    }
}

/// Rays to a glowing surface and rays of its own share the light of what stands behind, by paths.
TEST(Layers, ALeafBeforeALampIsTheSameWithAndWithoutRaysToIt) {
    const auto mean = [&](bool toLamps) {
        SceneBuilder builder = darkness();
        const Material m = leaf(builder, 0.5f, vec3(1.0f));
        place(builder, panel(vec3(-1, -1, 0), vec3(2, 0, 0), vec3(0, 2, 0), builder.addMaterial(m, "leaf")));
        place(builder, panel(vec3(1, -1, -1), vec3(-2, 0, 0), vec3(0, 2, 0), builder.addMaterial(glow(vec3(1.0f)), "lamp")));
        Settings settings = ways().back().settings;
        settings.surfaceLights = toLamps;
        return meanOf(render(builder.finish(), lookAt(vec3(0, 0, 3), vec3(0.0f), 5.0f), settings, 1024, uvec2(17, 17))).x;
    };
    const double with = mean(true), without = mean(false);
    EXPECT_GT(with, 0.05);
    EXPECT_NEAR(with / without, 1.0, 0.01);
}

// ---- by need ----

TEST(Layers, AreSimulatedWhereAMaterialCallsForThemAlone) {
    const char* const names[] = {"clearcoat", "sheen", "anisotropy", "iridescence", "dispersion", "diffuseTransmission"};
    const auto called = [&](const Make& make) {
        SceneBuilder builder = darkness(vec3(1.0f));
        Material m = SceneBuilder::defaultMaterial();
        MaterialLayers layers;
        make(m, layers);
        m.layers = builder.addLayers(layers);
        place(builder, icosphere(2, builder.addMaterial(m, "it")));
        std::vector<std::string> result;
        for (const EffectReason& reason : explainEffects(*builder.finish()))
            if (reason.calledFor && std::ranges::count(names, reason.name) > 0) result.push_back(reason.name);
        return result;
    };
    const std::array<Make, 6> makers = {
        [](Material&, MaterialLayers& l) { l.coat = 1.0f; },
        [](Material&, MaterialLayers& l) { l.sheenGreen = 0.5f; },
        [](Material&, MaterialLayers& l) { l.anisotropy = 0.1f; },
        [](Material&, MaterialLayers& l) { l.iridescence = 0.1f; },
        [](Material& m, MaterialLayers& l) { m.flags = MATERIAL_VOLUME, m.transmission = 1.0f, l.dispersion = 0.1f; },
        [](Material&, MaterialLayers& l) { l.diffuseTransmission = 0.1f; },
    };
    EXPECT_TRUE(called([](Material&, MaterialLayers&) {}).empty());
    for (size_t i = 0; i < makers.size(); i++) EXPECT_EQ(called(makers[i]), std::vector<std::string>{names[i]});
}

}  // namespace
}  // namespace heliograph::TEST_FILE
