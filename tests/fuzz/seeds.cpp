#include "tests/fuzz/seeds.h"

#include "server/encode/jpeg_encoder.h"
#include "server/encode/png_encoder.h"
#include "server/net/protocol.h"
#include "server/pool/wire/tile_bytes.h"
#include "server/request/settings.h"
#include "tests/support/compressed_files.h"

#include <webp/encode.h>

namespace heliograph::fuzz {

namespace {

std::string text(const std::vector<uint8_t>& bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

std::vector<Seed> messages() {
    std::vector<Seed> seeds;
    const char* const all[] = {
        R"({"type":"camera","inputId":7,"position":[0,1,5],"forward":[0,0,-1],"up":[0,1,0],"fieldOfView":60,"moving":true})",
        R"({"type":"settings","inputId":8,"values":{"shadows":false,"aoSamples":4}})",
        R"({"type":"resolution","inputId":9,"width":320,"height":180})",
        R"({"type":"scene","name":"cornell"})",
        R"({"type":"ack","frameId":3,"presentedMs":12.5,"shownMs":4})",
        R"({"type":"client","visible":false,"exact":true,"vp9":true,"h264":true})",
        R"({"type":"picture","format":"png"})",
        R"({"type":"path","playing":true})",
        R"({"type":"ping","time":1.5})",
        R"({"type":"effectCosts"})",
        R"({"type":"accuracy","seconds":30})",
        R"({"type":"focus","inputId":10,"x":0.5,"y":0.5})",
        R"({"type":"watch","inputId":11,"view":"0123456789abcdef0123456789abcdef"})",
        R"({"type":"watch","inputId":12})",
        R"({"type":"drive","inputId":13,"viewer":2,"refuse":true})",
        R"({"type":"token","token":"secret"})",
    };
    for (const char* message : all) seeds.push_back({std::to_string(seeds.size()), message});
    return seeds;
}

std::vector<Seed> settings() {
    const nlohmann::json all = Settings().toJson();
    std::vector<Seed> seeds{{"all", all.dump()}};
    for (const auto& [name, value] : all.items())
        seeds.push_back({name, name + "=" + (value.is_string() ? value.get<std::string>() : value.dump())});
    return seeds;
}

std::vector<Seed> headers() {
    FrameHeader header;
    header.size = {320, 180};
    header.fullSize = {640, 360};
    header.samples = 4;
    header.payloadBytes = 3;
    std::vector<uint8_t> bytes(FRAME_HEADER_BYTES + 3, 1);
    writeFrameHeader(header, std::span<uint8_t, FRAME_HEADER_BYTES>(bytes.data(), FRAME_HEADER_BYTES));
    return {{"frame", text(bytes)}};
}

std::vector<Seed> uploads() {
    return {{"model", R"({"scene":"a/m.gltf","files":[{"path":"a/m.gltf","bytes":12},{"path":"a/m.bin","bytes":900}]})"},
            {"sky", R"({"scene":"sky.hdr","files":[{"path":"sky.hdr","bytes":4096}]})"},
            {"outside", R"({"scene":"a/../../m.obj","files":[{"path":"a/../../m.obj","bytes":1}]})"},
            {"twice", R"({"scene":"M.glb","files":[{"path":"M.glb","bytes":1},{"path":"m.GLB","bytes":1}]})"},
            {"folder", R"({"scene":"m.obj","files":[{"path":"m.obj","bytes":1},{"path":"m.obj/m.png","bytes":1}]})"}};
}

std::vector<Seed> poolMessages() {
    BatchOrder batch{.head = 1, .id = 2, .scene = {}, .request = {}, .tiles = {}};
    batch.request.resolution = {64, 32};
    Tile tile;
    tile.size = {16, 8};
    tile.sampleCount = 1;
    batch.tiles = {tile, tile};
    TilesWriter tiles(2);
    TileResult result;
    result.tile = tile;
    result.radianceSum.assign(128, vec4(0.5f));
    tiles.add(0, result);
    return {{"nodeBeat", text(bytesOf(NodeBeat{.id = 1, .build = {}, .name = "a", .hardware = "b"}))},
            {"headBeat", text(bytesOf(HeadBeat{.id = 1, .build = {}}))},
            {"refusal", text(bytesOf(Refusal{.head = 1, .why = "another build"}))},
            {"load", text(bytesOf(LoadOrder{.head = 1, .scene = {}, .settings = {}}))},
            {"loadState", text(bytesOf(LoadState{.node = 1, .scene = {}, .share = 0.5f, .text = "geometry"}))},
            {"chunkAsk", text(bytesOf(ChunkAsk{.node = 1, .scene = {}, .index = 3}))},
            {"chunk", text(bytesOf(Chunk{.scene = {}, .index = 3, .bytes = {1, 2, 3}}))},
            {"batch", text(bytesOf(batch))},
            {"cancel", text(bytesOf(Cancel{.head = 1, .id = 2}))},
            {"batchEnd", text(bytesOf(BatchEnd{.id = 2, .why = "no"}))},
            {"tiles", text(tiles.take())}};
}

std::vector<Seed> images() {
    std::vector<Seed> seeds;
    DisplayImage image{8, 8, std::vector<uint8_t>(256)};
    for (size_t i = 0; i < image.rgba.size(); i++) image.rgba[i] = static_cast<uint8_t>(i);
    std::vector<uint8_t> bytes;
    makePngEncoder()->encode(image, 90, bytes);
    seeds.push_back({"png", text(bytes)});
    makeJpegEncoder()->encode(image, 90, bytes);
    seeds.push_back({"jpeg", text(bytes)});
    std::string hdr = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 4\n";
    for (int i = 0; i < 64; i++) hdr += static_cast<char>(i % 4 == 3 ? 129 : 16 * i);
    seeds.push_back({"hdr", hdr});
    std::string turned = "#?RADIANCE\nEXPOSURE=2\nFORMAT=32-bit_rle_xyze\n\n+X 4 +Y 4\n";
    for (int i = 0; i < 64; i++) turned += static_cast<char>(i % 16 < 12 ? 1 + i % 4 / 3 : 129);
    seeds.push_back({"hdr_turned", turned});
    uint8_t* webp = nullptr;
    const size_t size = WebPEncodeLosslessRGBA(image.rgba.data(), 8, 8, 32, &webp);
    seeds.push_back({"webp", {reinterpret_cast<const char*>(webp), size}});
    WebPFree(webp);
    return seeds;
}

const char* const TRIANGLE = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";  // (0,0,0) (1,0,0) (0,1,0)
const char* const TRIANGLE_SCENE =
    R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],
"bufferViews":[{"buffer":0,"byteLength":36}],"materials":[{"alphaMode":"MASK","pbrMetallicRoughness":{"baseColorFactor":[1,0.5,0.2,1],"roughnessFactor":0.3}}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],"cameras":[{"type":"perspective","perspective":{"yfov":1,"znear":0.1}}],
"nodes":[{"mesh":0,"scale":[1,2,1]},{"camera":0,"translation":[0,0,4]}],"scenes":[{"nodes":[0,1]}],"scene":0})";

std::vector<Seed> gltf() {
    return {
        {"triangle", R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,)" +
                         std::string(TRIANGLE) + R"("}],)" + TRIANGLE_SCENE}};
}

std::vector<Seed> glb() {
    std::string json = R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":36}],)" + std::string(TRIANGLE_SCENE);
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    std::string bytes = "glTF";
    const auto word = [&](uint32_t value) { bytes.append(reinterpret_cast<const char*>(&value), 4); };
    word(2);
    word(static_cast<uint32_t>(12 + 8 + json.size() + 8 + 36));
    word(static_cast<uint32_t>(json.size()));
    word(0x4E4F534A);
    bytes += json;
    word(36);
    word(0x004E4942);
    bytes.append(reinterpret_cast<const char*>(corners), 36);
    const testing_files::WavyGrid grid(4);
    return {{"triangle", bytes},
            {"draco", testing_files::dracoGlb(grid)},
            {"draco_sequential", testing_files::dracoGlb(grid, testing_files::dracoBytes(grid, true), grid.vertices())},
            {"meshopt", testing_files::meshoptGlb(grid, testing_files::MeshoptKind::filtered, true)},
            {"meshopt_indices", testing_files::meshoptGlb(grid, testing_files::MeshoptKind::exact, false)}};
}

/// The material file stands behind a NUL.
std::vector<Seed> obj() {
    const std::string text =
        "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nusemtl red\nf 1/1/1 2/1/1 3/1/1 4/1/1\n"
        "f -1 -2 -3\n";
    return {{"quad", text + '\0' + "newmtl red\nKd 1 0 0\nNs 20\nd 0.5\nmap_Kd picture.png\n"}};
}

}  // namespace

std::map<std::string, std::vector<Seed>> seeds() {
    return {{"message", messages()}, {"settings", settings()}, {"header", headers()},
            {"upload", uploads()},   {"image", images()},      {"gltf", gltf()},
            {"glb", glb()},          {"obj", obj()},           {"pool", poolMessages()}};
}

}  // namespace heliograph::fuzz
