#include "server/device/vulkan/raster/raster_device.h"

#include "server/base/error.h"
#include "server/device/vulkan/raster/raster_pipelines.h"
#include "server/device/vulkan/raster/raster_target.h"
#include "server/request/frame_request.h"
#include "server/scene/kernel_tables.h"
#include "server/request/surroundings.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <map>
#include <mutex>

namespace heliograph {

namespace {

// Offset of a sample inside its pixel: pixelJitter of kernel/sampling.glsl.
vec2 sampleJitter(uint32_t index) {
    auto unit = [](uint32_t bits) { return static_cast<float>(bits >> 8) * 5.9604644775390625e-8f; };
    return {unit(0x80000000u + index * 0xc13fa9a9u), unit(0x80000000u + index * 0x91e10da5u)};
}

class RasterDevice : public Device {
public:
    RasterDevice(const std::string& which, const VulkanOptions& options)
        : context_(vulkanContext(options)),
          gpu_(context_, withGraphics(context_->find(which))),
          pipelines_(gpu_),
          frame_(gpu_, sizeof(FrameData), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, Memory::upload) {}

    ~RasterDevice() override { vkDeviceWaitIdle(gpu_.handle()); }

    DeviceInfo info() const override {
        DeviceInfo info;
        info.name = device_name::raster;
        info.details = "raster preview on " + gpu_.physical().name;
        info.hardware = gpu_.physical().isCpu() ? "cpu" : "gpu:" + std::to_string(gpu_.physical().index);
        info.workers = 1 << 16;
        info.drawsWhole = true;
        return info;
    }

    void load(std::shared_ptr<const Scene> scene, const Settings&, const Progress& progress) override {
        std::lock_guard lock(mutex_);
        scene_.reset();
        scene_ = std::make_unique<GpuScene>(gpu_, std::move(scene), progress);
        scene_->bindKernel(pipelines_.set(), frame_);
    }

    void render(const FrameRequest& request, std::span<const Tile> tiles, const TileSink& sink, std::stop_token stop) override {
        std::lock_guard lock(mutex_);
        if (!scene_) throw std::logic_error("render before load");
        FrameRequest whole = request;
        whole.effects.bits &=
            ~(EFFECT_MANY_LIGHTS | EFFECT_SHAPES);  // without rays all lights are cheap, and shapes are triangles
        const FrameData frame = frameData(scene_->scene(), whole);
        background_ = backdropOf(scene_->scene(), request.settings);
        std::memcpy(frame_.data(), &frame, sizeof frame);
        if (!target_ || target_->size() != request.resolution) {
            target_.reset();
            target_ = std::make_unique<RasterTarget>(gpu_, pipelines_.pass(), request.resolution);
        }
        // Tiles that show the same samples are cut from the same drawings.
        std::map<std::pair<uint32_t, uint32_t>, std::vector<Tile>> groups;
        for (const Tile& tile : tiles) groups[{tile.firstSample, tile.sampleCount}].push_back(tile);
        for (const auto& [samples, group] : groups)
            if (!stop.stop_requested()) renderGroup(request, group, sink);
    }

private:
    static const PhysicalDevice& withGraphics(const PhysicalDevice& physical) {
        if (!physical.graphics) throw InputError("device", physical.name + " does not draw", "a device with graphics");
        return physical;
    }

    void renderGroup(const FrameRequest& request, const std::vector<Tile>& tiles, const TileSink& sink) {
        auto begin = std::chrono::steady_clock::now();
        std::vector<TileResult> results(tiles.size());
        for (size_t i = 0; i < tiles.size(); i++) {
            results[i].tile = tiles[i];
            results[i].device = device_name::raster;
            results[i].radianceSum.assign(size_t(tiles[i].size.x) * tiles[i].size.y, vec4(0.0f));
        }
        for (uint32_t sample = 0; sample < tiles.front().sampleCount; sample++) {
            draw(request, tiles.front().firstSample + sample);
            for (TileResult& result : results) addSample(result);
        }
        double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
        for (TileResult& result : results) {
            result.seconds = seconds / static_cast<double>(results.size());
            sink(std::move(result));
        }
    }

    // What nothing covers shows one colour, for an image its mean.
    void addSample(TileResult& result) const {
        for (uint32_t y = 0; y < result.tile.size.y; y++)
            for (uint32_t x = 0; x < result.tile.size.x; x++) {
                vec4 pixel = target_->pixels()[size_t(result.tile.origin.y + y) * target_->size().x + result.tile.origin.x + x];
                vec3 radiance = pixel.w > 0.0f ? vec3(pixel) : background_;
                if (!std::isfinite(radiance.x + radiance.y + radiance.z)) {
                    result.nonfiniteSamples++;
                    continue;
                }
                float luminance = glm::dot(radiance, vec3(LUMINANCE_RED, LUMINANCE_GREEN, LUMINANCE_BLUE));
                result.radianceSum[size_t(y) * result.tile.size.x + x] += vec4(radiance, luminance * luminance);
            }
    }

    void draw(const FrameRequest& request, uint32_t sample) {
        const Scene& scene = scene_->scene();
        RasterConstants constants{sampleJitter(sample), request.settings.rasterView, 1e-4f * scene.bounds.radius()};
        uvec2 size = request.resolution;
        gpu_.runNow([&](VkCommandBuffer commands) {
            VkClearValue clear[2] = {};  // nothing there, infinitely far
            VkRenderPassBeginInfo begin{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
            begin.renderPass = pipelines_.pass();
            begin.framebuffer = target_->framebuffer();
            begin.renderArea.extent = {size.x, size.y};
            begin.clearValueCount = 2;
            begin.pClearValues = clear;
            vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
            VkViewport viewport{0.0f, 0.0f, static_cast<float>(size.x), static_cast<float>(size.y), 0.0f, 1.0f};
            VkRect2D scissor{{0, 0}, {size.x, size.y}};
            vkCmdSetViewport(commands, 0, 1, &viewport);
            vkCmdSetScissor(commands, 0, 1, &scissor);
            vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS,
                              pipelines_.get({request.effects.bits & ~EFFECT_SHAPES}));
            VkDescriptorSet set = pipelines_.set();
            vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipelines_.layout(), 0, 1, &set, 0, nullptr);
            vkCmdPushConstants(commands, pipelines_.layout(), VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0,
                               sizeof constants, &constants);
            for (uint32_t i = 0; i < scene.instances.size(); i++)
                if (uint32_t triangles = scene.meshes[scene.instances[i].mesh].triangleCount)
                    vkCmdDraw(commands, 3 * triangles, 1, 0, i);
            vkCmdEndRenderPass(commands);
            target_->recordCopy(commands);
        });
    }

    std::shared_ptr<VulkanContext> context_;
    Gpu gpu_;
    RasterPipelines pipelines_;
    GpuBuffer frame_;
    vec3 background_{0.0f};  // where nothing is
    std::unique_ptr<GpuScene> scene_;
    std::unique_ptr<RasterTarget> target_;
    std::mutex mutex_;
};

}  // namespace

std::unique_ptr<Device> makeRasterDevice(const std::string& which, const VulkanOptions& options) {
    return std::make_unique<RasterDevice>(which, options);
}

}  // namespace heliograph
