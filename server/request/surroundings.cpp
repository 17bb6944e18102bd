#include "server/request/surroundings.h"

#include "server/base/error.h"

#include <cmath>
#include <numbers>

namespace heliograph {

namespace {

constexpr vec3 GREY{0.8f};             // radiance of even surroundings
constexpr vec3 PLAIN_BACKDROP{0.22f};  // behind a model, so that neither white nor black is lost before it
constexpr float BLUR = 0.4f;           // radians, of a backdrop

constexpr uint64_t OF_SURROUNDINGS = EFFECT_ENVIRONMENT_IMAGE | EFFECT_FILTERED_ENVIRONMENT | EFFECT_ENVIRONMENT_LIGHT;

enum class Chosen : uint32_t { automatic, studio, sky, grey, none };
static_assert(Settings::choice("surroundings", "studio") == 1 && Settings::choice("surroundings", "none") == 4);

enum class Background : uint32_t { automatic, image, plain, blurred };
static_assert(Settings::choice("background", "image") == 1 && Settings::choice("background", "blurred") == 3);

/// Nine coefficients (Environment::ambient) of light that is turned about +Y by `angle`: those of the turned normal, written out.
void turnAmbient(Environment& environment, float angle) {
    const float s = std::sin(angle), c = std::cos(angle);
    vec4* a = environment.ambient;
    const vec4 z = a[2], x = a[3], xy = a[4], yz = a[5], zz = a[6], xz = a[7], xx = a[8];
    a[2] = z * c - x * s;
    a[3] = z * s + x * c;
    a[4] = yz * s + xy * c;
    a[5] = yz * c - xy * s;
    // 3 z^2 - 1, xz and x^2 - y^2 mix; x^2 + y^2 + z^2 = 1 brings what comes out into the same form.
    const vec4 ofXx = zz * (3.0f * s * s) + xz * (s * c) + xx * (c * c);
    const vec4 ofZz = zz * (3.0f * c * c) - xz * (s * c) + xx * (s * s);
    const vec4 rest = (xx - ofXx) * 0.5f;
    a[7] = zz * (6.0f * s * c) + xz * (c * c - s * s) - xx * (2.0f * s * c);
    a[8] = (ofXx + xx) * 0.5f;
    a[6] = (ofZz + rest) / 3.0f;
    a[0] = a[0] - zz - rest + a[6];
}

void paint(Environment& environment, vec3 radiance) {
    environment.image = environment.filtered = NO_INDEX;
    environment.intensity = 1.0f;
    environment.rotation = 0.0f;
    environment.lightColumns = environment.lightRows = 0;
    for (vec4& coefficient : environment.ambient) coefficient = vec4(0.0f);
    environment.ambient[0] = environment.color = vec4(radiance, 0.0f);
}

/// As chosen, before it is turned and scaled. What a scene is offered lacks the tables of its lamps and lights.
Environment chosenFrom(const Scene& scene, const Settings& settings) {
    const auto chosen = static_cast<Chosen>(settings.surroundings);
    Environment environment = scene.environment;
    if (chosen == Chosen::grey || chosen == Chosen::none) paint(environment, chosen == Chosen::grey ? GREY : vec3(0.0f));
    if (chosen != Chosen::studio && chosen != Chosen::sky) return environment;
    if (chosen == Chosen::studio && scene.inStudio) return environment;
    if (scene.offered.empty())
        throw InputError("setting surroundings", "'" + Settings::choiceWord("surroundings", settings.surroundings) + "'",
                         "automatic, grey or none: this scene was opened without others");
    const Environment own = environment;
    environment = scene.offered[chosen == Chosen::studio ? 0 : 1];
    environment.emitterTable = own.emitterTable;
    environment.emitterCount = own.emitterCount;
    environment.lampTree = own.lampTree;
    environment.lampTreeLevels = own.lampTreeLevels;
    environment.lampTrails = own.lampTrails;
    environment.glassTable = own.glassTable;
    environment.lightTree = own.lightTree;
    environment.lightTreeLevels = own.lightTreeLevels;
    environment.listedLights = own.listedLights;
    return environment;
}

Background backgroundOf(const Scene& scene, const Settings& settings) {
    const auto background = static_cast<Background>(settings.background);
    if (background != Background::automatic) return background;
    const auto chosen = static_cast<Chosen>(settings.surroundings);
    const bool studio = scene.fromFile && (chosen == Chosen::studio || (chosen == Chosen::automatic && scene.inStudio));
    return studio ? Background::plain : Background::image;
}

/// What light from a direction calls for where the scene brings none, as far as it called for what lets light through.
uint64_t shadowsFor(EffectSet called) {
    const bool through = called.has(EFFECT_REFRACTIONS | EFFECT_ALPHA_BLEND);
    return EFFECT_SHADOWS | (through ? EFFECT_TRANSPARENT_SHADOWS : 0);
}

}  // namespace

Light sunOf(const Settings& settings) {
    constexpr float DEGREE = std::numbers::pi_v<float> / 180.0f;
    const float azimuth = settings.sunAzimuth * DEGREE, elevation = settings.sunElevation * DEGREE;
    Light sun{};
    sun.type = LIGHT_DIRECTIONAL;
    sun.direction =
        -vec3(std::sin(azimuth) * std::cos(elevation), std::sin(elevation), std::cos(azimuth) * std::cos(elevation));
    sun.intensity = vec3(settings.sunStrength);
    sun.radius = std::tan(0.5f * settings.sunSize * DEGREE);
    return sun;
}

Environment environmentFor(const Scene& scene, const Settings& settings) {
    Environment environment = chosenFrom(scene, settings);
    if (settings.environmentRotation != 0.0f) {
        const float angle = settings.environmentRotation * (std::numbers::pi_v<float> / 180.0f);
        environment.rotation += angle;
        turnAmbient(environment, angle);
    }
    if (settings.environmentStrength != 1.0f) {
        environment.intensity *= settings.environmentStrength;
        environment.color *= settings.environmentStrength;
        for (vec4& coefficient : environment.ambient) coefficient *= settings.environmentStrength;
    }
    const Background background = backgroundOf(scene, settings);
    if (background == Background::plain) environment.backdrop = vec4(PLAIN_BACKDROP, -1.0f);
    if (background == Background::blurred) environment.backdrop.w = BLUR;
    return environment;
}

EffectSet effectsUnder(const Scene& scene, EffectSet called, const Settings& settings) {
    const Environment environment = chosenFrom(scene, settings);
    uint64_t bits = called.bits;
    if (settings.surroundings != static_cast<uint32_t>(Chosen::automatic)) {
        bits &= ~OF_SURROUNDINGS;
        if (environment.image != NO_INDEX) bits |= EFFECT_ENVIRONMENT_IMAGE;
        if (environment.filtered != NO_INDEX) bits |= EFFECT_FILTERED_ENVIRONMENT;
        if (environment.lightColumns > 0) bits |= EFFECT_ENVIRONMENT_LIGHT | shadowsFor(called);
    }
    const EffectSet allowed = allowedEffects(settings);
    if (called.has(EFFECT_SUN) && allowed.has(EFFECT_SUN))
        bits |= shadowsFor(called) | (settings.sunSize > 0.0f ? EFFECT_SOFT_SHADOWS : 0);
    bits &= allowed.bits;
    if (bits & (EFFECT_FOG | EFFECT_MANY_LIGHTS)) bits &= ~EFFECT_GROUND;  // unknown: what air and chosen lights bring there
    return {bits};
}

vec3 backdropOf(const Scene& scene, const Settings& settings) {
    const Environment environment = environmentFor(scene, settings);
    const bool plain = environment.image != NO_INDEX && settings.environment && environment.backdrop.w < 0.0f;
    return vec3(plain ? environment.backdrop : environment.color);
}

std::optional<vec3> plainBackdrop(const Scene& scene, const Settings& settings, EffectSet effects) {
    const bool image = effects.has(EFFECT_ENVIRONMENT_IMAGE) && environmentFor(scene, settings).backdrop.w >= 0.0f;
    if (image || effects.has(EFFECT_FOG)) return std::nullopt;
    return backdropOf(scene, settings);
}

bool exposesViews(const Settings& settings, const Scene& scene) {
    return exposesPictures(settings) ||
           (settings.autoExposure == Settings::choice("autoExposure", "automatic") && scene.litByFile);
}

bool exposesPictures(const Settings& settings) { return settings.autoExposure == Settings::choice("autoExposure", "on"); }

}  // namespace heliograph
