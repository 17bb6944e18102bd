// Many glowing triangles: instead of by power alone they are chosen from a tree (many_lights.glsl) by power over the square of the
// distance. Both sides of a triangle shine, and what a path of its own finds has to know with what chance it would have been
// chosen from where the path came: of that place no normal is known, so none takes part in the choice.

// A place from which lamps are looked at.
LightWay lookAround(vec3 point) {
    LightWay way;
    way.origin = point;
    way.direction = vec3(0.0f, 0.0f, 0.0f);
    way.reach = 0.0f;
    return way;
}

// The glowing triangle that `number` in [0, 1) chooses; its words are those of its entry in the table.
ChosenLight chosenLamp(vec3 point, float number) {
    return chosenFrom(ENVIRONMENT.lampTree, ENVIRONMENT.lampTreeLevels, lookAround(point), 0u, number);
}

// Entry of a placed triangle in the table, which is in the order of instances and primitives; emitterCount where it is no lamp.
uint lampEntry(uint instance, uint primitive) {
    UNIFORM_UINT step = 1u;
    for (UNIFORM_UINT i = 0u; i < 32u; i++) {
        if (step * 2u <= ENVIRONMENT.emitterCount) step = step * 2u;
    }
    uint entry = uint(0u);
    for (UNIFORM_UINT half_ = step; half_ > 0u; half_ = half_ / 2u) {
        uint later = entry + half_;
        bool there = later < uint(ENVIRONMENT.emitterCount);
        uint at = ENVIRONMENT.emitterTable + SELECT(there, later, uint(0u)) * EMITTER_TABLE_WORDS;
        uint itsInstance = TEXEL(at + 2u);
        bool before = itsInstance < instance || (itsInstance == instance && TEXEL(at + 3u) <= primitive);
        entry = SELECT(there && before, later, entry);
    }
    uint found = ENVIRONMENT.emitterTable + entry * EMITTER_TABLE_WORDS;
    return SELECT(TEXEL(found + 2u) == instance && TEXEL(found + 3u) == primitive, entry, uint(ENVIRONMENT.emitterCount));
}

// Chance with which chosenLamp finds that triangle from `point`; 0 if it is no lamp.
float lampChance(vec3 point, uint instance, uint primitive) {
    uint entry = lampEntry(instance, primitive);
    bool lamp = entry < uint(ENVIRONMENT.emitterCount);
    uint trail = TEXEL(ENVIRONMENT.lampTrails + SELECT(lamp, entry, uint(0u)));
    LightWay way = lookAround(point);
    float chance = SELECT(lamp, 1.0f, 0.0f);
    uint node = uint(ENVIRONMENT.lampTree);
    for (UNIFORM_UINT level = 0u; level < ENVIRONMENT.lampTreeLevels; level++) {
        bool open = (node & LIGHT_TREE_LEAF) == 0u;
        if (ANY(open && lamp)) {
            LightParts parts = lightPartsAt(SELECT(open, node, uint(ENVIRONMENT.lampTree)), way, 0u);
            uint part = (trail >> (level * LAMP_TRAIL_BITS)) & (LIGHT_TREE_WIDTH - 1u);
            float own = 0.0f;
            uint next = node;
            for (UNIFORM_UINT i = 0u; i < LIGHT_TREE_WIDTH; i++) {
                own = SELECT(part == i, parts.weight[i], own);
                next = SELECT(part == i, parts.next[i], next);
            }
            float both = chance * (own / SELECT(parts.sum > 0.0f, parts.sum, 1.0f));
            chance = SELECT(open, both, chance);
            node = SELECT(open, next, node);
        }
    }
    return chance;
}
