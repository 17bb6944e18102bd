#include "server/device/vulkan/trace/batch.h"

#include "server/base/clock.h"

#include <algorithm>
#include <cstring>

namespace heliograph {

namespace {

constexpr VkBufferUsageFlags STORAGE = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;

uint64_t groupsOf(const Tile& tile) { return uint64_t((tile.size.x + 7) / 8) * ((tile.size.y + 7) / 8); }
uint64_t pixelsOf(const Tile& tile) { return uint64_t(tile.size.x) * tile.size.y; }

}  // namespace

void BatchSize::learn(double seconds, uint64_t samples) {
    if (samples == 0 || !(seconds > 0.0)) return;
    double measured = seconds / static_cast<double>(samples);
    secondsPerSample = secondsPerSample > 0.0 ? 0.7 * secondsPerSample + 0.3 * measured : measured;
}

uint64_t BatchSize::samples() const {
    if (!(secondsPerSample > 0.0)) return std::min(4 * least, most);
    double wanted = targetSeconds / secondsPerSample;
    return static_cast<uint64_t>(std::clamp(wanted, static_cast<double>(least), static_cast<double>(most)));
}

Batch::Batch(Gpu& gpu, TracePipelines& pipelines, const GpuScene& scene)
    : gpu_(gpu), pipelines_(pipelines), frame_(gpu, sizeof(FrameData), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, Memory::upload) {
    VkQueryPoolCreateInfo info{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
    info.queryType = VK_QUERY_TYPE_TIMESTAMP;
    info.queryCount = 2;
    VkQueryPool queries;
    check(vkCreateQueryPool(gpu.handle(), &info, nullptr, &queries), "make timestamps");
    queries_ = {gpu.handle(), queries};
    set_ = pipelines.newSet();
    try {
        scene.bind(set_);
        commands_ = gpu.newCommands();
    } catch (...) {
        pipelines.freeSet(set_);
        throw;
    }
}

Batch::~Batch() {
    gpu_.freeCommands(commands_);
    pipelines_.freeSet(set_);
}

bool Batch::takes(const Tile& tile, uint64_t wantedSamples) const {
    if (empty()) return true;
    return samples_ < wantedSamples && groups_ + groupsOf(tile) <= gpu_.limits().maxComputeWorkGroupCount[0] &&
           (pixels_ + pixelsOf(tile)) * sizeof(vec4) <= std::min<uint64_t>(gpu_.limits().maxStorageBufferRange, 256u << 20);
}

void Batch::add(const Tile& tile, bool firstSurface) {
    (firstSurface ? firstSurfaceTiles_ : tiles_).push_back(tile);
    pixels_ += pixelsOf(tile);
    groups_ += groupsOf(tile);
    samples_ += pixelsOf(tile) * tile.sampleCount;
}

// The tiles of each program in a row.
void Batch::arrange() {
    uint64_t groups = 0, pixels = 0;
    auto enter = [&](const Tile& tile) {
        entries_.push_back({tile.origin, tile.size, tile.firstSample, tile.sampleCount, static_cast<uint32_t>(groups),
                            static_cast<uint32_t>(pixels)});
        groups += groupsOf(tile);
        pixels += pixelsOf(tile);
    };
    for (const Tile& tile : tiles_) enter(tile);
    fullGroups_ = static_cast<uint32_t>(groups);
    for (const Tile& tile : firstSurfaceTiles_) enter(tile);
    tiles_.insert(tiles_.end(), firstSurfaceTiles_.begin(), firstSurfaceTiles_.end());
    firstSurfaceTiles_.clear();
}

// Buffers grow by half, so that a growing window does not allocate at every step.
void Batch::makeRoom() {
    auto grow = [&](GpuBuffer& buffer, uint64_t bytes, VkBufferUsageFlags usage, Memory memory) {
        if (buffer.bytes() >= bytes) return false;
        uint64_t wanted = std::min<uint64_t>(std::max<uint64_t>(bytes + bytes / 2, 4096), gpu_.limits().maxStorageBufferRange);
        buffer = GpuBuffer();
        buffer = GpuBuffer(gpu_, std::max(bytes, wanted), usage, memory);
        return true;
    };
    uint64_t counts = tiles_.size() * COUNTS_PER_TILE * sizeof(uint32_t);
    bool grown = grow(sums_, pixels_ * sizeof(vec4), STORAGE, Memory::readback);
    grown |= grow(tileList_, entries_.size() * sizeof(TraceTile), STORAGE, Memory::upload);
    grown |=
        grow(counts_, counts, STORAGE | VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT, Memory::device);
    grow(countsOut_, counts, VK_BUFFER_USAGE_TRANSFER_DST_BIT, Memory::readback);
    if (grown) bindOutputs();
}

void Batch::bindOutputs() {
    const std::pair<uint32_t, const GpuBuffer*> outputs[] = {
        {BINDING_FRAME, &frame_}, {BINDING_TILES, &tileList_}, {BINDING_SUMS, &sums_}, {BINDING_COUNTS, &counts_}};
    VkDescriptorBufferInfo infos[4];
    VkWriteDescriptorSet writes[4];
    for (int i = 0; i < 4; i++) {
        infos[i] = {outputs[i].second->handle(), 0, VK_WHOLE_SIZE};
        writes[i] = {VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
        writes[i].dstSet = set_;
        writes[i].dstBinding = outputs[i].first;
        writes[i].descriptorCount = 1;
        writes[i].descriptorType = GpuScene::descriptorType(outputs[i].first, 2);
        writes[i].pBufferInfo = &infos[i];
    }
    vkUpdateDescriptorSets(gpu_.handle(), 4, writes, 0, nullptr);
}

void Batch::submit(VkPipeline pipeline, VkPipeline firstSurface, const FrameData& frame) {
    arrange();
    makeRoom();
    std::memcpy(frame_.data(), &frame, sizeof frame);
    std::memcpy(tileList_.data(), entries_.data(), entries_.size() * sizeof(TraceTile));
    record(pipeline, firstSurface);
    submittedAt_ = wallSeconds();
    number_ = gpu_.submit(commands_);
}

void Batch::dispatch(VkPipeline pipeline, uint32_t groupsBefore, uint32_t groups) {
    if (groups == 0) return;
    const uint32_t constants[] = {static_cast<uint32_t>(tiles_.size()), groupsBefore};
    vkCmdBindPipeline(commands_, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    vkCmdPushConstants(commands_, pipelines_.layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof constants, constants);
    vkCmdDispatch(commands_, groups, 1, 1);
}

void Batch::record(VkPipeline pipeline, VkPipeline firstSurface) {
    gpu_.beginCommands(commands_);
    uint64_t counts = tiles_.size() * COUNTS_PER_TILE * sizeof(uint32_t);
    vkCmdResetQueryPool(commands_, queries_.get(), 0, 2);
    vkCmdWriteTimestamp(commands_, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, queries_.get(), 0);
    vkCmdFillBuffer(commands_, counts_.handle(), 0, counts, 0);
    VkMemoryBarrier barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER};
    barrier.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT;
    vkCmdPipelineBarrier(commands_, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, 0, 1, &barrier, 0,
                         nullptr, 0, nullptr);
    vkCmdBindDescriptorSets(commands_, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines_.layout(), 0, 1, &set_, 0, nullptr);
    dispatch(pipeline, 0, fullGroups_);
    dispatch(firstSurface, fullGroups_, static_cast<uint32_t>(groups_) - fullGroups_);
    barrier.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT | VK_ACCESS_HOST_READ_BIT;
    vkCmdPipelineBarrier(commands_, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                         VK_PIPELINE_STAGE_TRANSFER_BIT | VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &barrier, 0, nullptr, 0, nullptr);
    VkBufferCopy copy{0, 0, counts};
    vkCmdCopyBuffer(commands_, counts_.handle(), countsOut_.handle(), 1, &copy);
    barrier.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_HOST_READ_BIT;
    vkCmdPipelineBarrier(commands_, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &barrier, 0, nullptr, 0,
                         nullptr);
    vkCmdWriteTimestamp(commands_, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, queries_.get(), 1);
    check(vkEndCommandBuffer(commands_), "record");
}

double Batch::finish() {
    gpu_.wait(number_);
    number_ = 0;
    double wall = wallSeconds() - submittedAt_;
    uint64_t stamps[2] = {0, 0};
    VkResult read = vkGetQueryPoolResults(gpu_.handle(), queries_.get(), 0, 2, sizeof stamps, stamps, sizeof(uint64_t),
                                          VK_QUERY_RESULT_64_BIT);
    if (read == VK_SUCCESS && stamps[1] > stamps[0] && gpu_.limits().timestampPeriod > 0.0f)
        return static_cast<double>(stamps[1] - stamps[0]) * gpu_.limits().timestampPeriod * 1e-9;
    return wall;
}

TileResult Batch::result(size_t index, double batchSeconds) const {
    TileResult result;
    result.tile = tiles_[index];
    result.mapped = {sums_.as<const vec4>() + entries_[index].firstPixel, pixelsOf(tiles_[index])};
    const uint32_t* counts = countsOut_.as<const uint32_t>() + index * COUNTS_PER_TILE;
    for (size_t kind = 0; kind < result.rays.by.size(); kind++) result.rays.by[kind] = counts[kind];
    result.rays.untraceable = counts[COUNT_UNTRACEABLE];
    result.rays.mediaUnderflows = counts[COUNT_MEDIA_UNDERFLOW];
    result.rays.mediaOverflows = counts[COUNT_MEDIA_OVERFLOW];
    result.nonfiniteSamples = counts[COUNT_NONFINITE];
    uint64_t samples = pixelsOf(tiles_[index]) * tiles_[index].sampleCount;
    result.seconds = samples_ > 0 ? batchSeconds * static_cast<double>(samples) / static_cast<double>(samples_) : 0.0;
    return result;
}

bool Batch::wasCutOff(size_t index) const {
    return countsOut_.as<const uint32_t>()[index * COUNTS_PER_TILE + COUNT_CUT_OFF] > 0;
}

void Batch::forget() {
    number_ = 0;
    clear();
}

void Batch::clear() {
    tiles_.clear();
    firstSurfaceTiles_.clear();
    entries_.clear();
    pixels_ = groups_ = samples_ = 0;
}

}  // namespace heliograph
