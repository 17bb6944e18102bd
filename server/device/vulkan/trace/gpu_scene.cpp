#include "server/device/vulkan/trace/gpu_scene.h"

#include "server/base/clock.h"
#include "server/base/error.h"
#include "server/device/vulkan/tree/bvh_builder.h"
#include "server/scene/kernel_tables.h"

#include <algorithm>

namespace heliograph {

namespace {

std::string mebibytes(uint64_t bytes) { return std::to_string((bytes + (1 << 20) - 1) >> 20) + " MiB"; }

}  // namespace

uint32_t varietiesOf(const Scene& scene) {
    uint32_t bits = 0;
    auto note = [&](bool met, uint32_t variety) { bits |= met ? variety : 0u; };
    for (const Material& m : scene.materials) {
        note(m.baseTexture != NO_INDEX, VARIETY_BASE_TEXTURE);
        note(m.opacityTexture != NO_INDEX, VARIETY_OPACITY_TEXTURE);
        note(m.metallicRoughnessTexture != NO_INDEX, VARIETY_METALLIC_ROUGHNESS_TEXTURE);
        note(m.transmissionTexture != NO_INDEX, VARIETY_TRANSMISSION_TEXTURE);
        note(m.specularTexture != NO_INDEX, VARIETY_SPECULAR_TEXTURE);
        note(m.emissionTexture != NO_INDEX, VARIETY_EMISSION_TEXTURE);
        note((m.flags & MATERIAL_BUMP) != 0u, VARIETY_BUMP);
        note((m.flags & MATERIAL_UNLIT) != 0u, VARIETY_UNLIT);
        // What shows its own colour is shaded by the model that reflects nothing.
        note((m.flags & (MATERIAL_PHONG | MATERIAL_UNLIT)) != 0u, VARIETY_PHONG);
        note((m.flags & (MATERIAL_PHONG | MATERIAL_UNLIT)) == 0u, VARIETY_MICROFACET);
    }
    for (const TextureSlot& slot : scene.textures) {
        note(slot.nearest != 0u, VARIETY_NEAREST);
        note(slot.wrapU != WRAP_REPEAT || slot.wrapV != WRAP_REPEAT, VARIETY_WRAP);
    }
    for (const Image& image : scene.images) note(image.format == IMAGE_RGB9E5, VARIETY_SHARED_EXPONENT);
    const bool surrounded = scene.environment.image != NO_INDEX || !scene.offered.empty();
    note(surrounded, VARIETY_WRAP);  // a lat-long image ends at the poles
    return bits;
}

VkDescriptorType GpuScene::descriptorType(uint32_t index, uint32_t width) {
    if (index == BINDING_FRAME) return VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
    if (width == 4 && index <= BINDING_BVH_TRIANGLES) return VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
    return VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
}

template <typename T>
void GpuScene::put(uint32_t index, const char* what, const T* data, size_t count) {
    // Rows of 16 bytes; texels and sample points are smaller than a row.
    constexpr VkFormat FORMAT = sizeof(T) == 4   ? VK_FORMAT_R32_UINT
                                : sizeof(T) == 8 ? VK_FORMAT_R32G32_UINT
                                                 : VK_FORMAT_R32G32B32A32_UINT;
    constexpr uint64_t ELEMENT = sizeof(T) < 16 ? sizeof(T) : 16;
    static_assert(sizeof(T) % ELEMENT == 0);
    VkDescriptorType type = descriptorType(index, bvhWidth_);
    bool texels = type == VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
    uint64_t bytes = count * sizeof(T);
    uint64_t limit = texels ? uint64_t(gpu_.physical().texelElements) * ELEMENT : gpu_.physical().bufferRange;
    if (bytes > limit)
        throw InputError("scene", std::string(what) + " of " + mebibytes(bytes),
                         gpu_.physical().name + " takes at most " + mebibytes(limit) + " of them; use another device");
    VkBufferUsageFlags usage = texels                                      ? VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT
                               : type == VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER ? VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT
                                                                           : VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
    auto array = std::make_shared<Array>(Array{gpu_.filled(data, bytes, usage), {}});
    if (texels) array->view = view(array->buffer, FORMAT);
    arrays_[index] = std::move(array);
}

GpuScene::GpuScene(Gpu& gpu, std::shared_ptr<const Scene> scene, uint32_t quality, const Progress& progress)
    : gpu_(gpu), scene_(std::move(scene)), bvhWidth_(widthFor(gpu.physical())), varieties_(varietiesOf(*scene_)) {
    putTrees(quality, progress);
    const double begin = wallSeconds();
    putArrays();
    uploadSeconds_ += wallSeconds() - begin;
}

GpuScene::GpuScene(const GpuScene& other, uint32_t quality, const Progress& progress)
    : gpu_(other.gpu_), scene_(other.scene_), bvhWidth_(other.bvhWidth_), varieties_(other.varieties_) {
    std::ranges::copy(other.arrays_, arrays_);
    putTrees(quality, progress);
}

GpuScene::GpuScene(Gpu& gpu, std::shared_ptr<const Scene> scene, const Progress& progress)
    : gpu_(gpu), scene_(std::move(scene)) {
    double begin = wallSeconds();
    report(progress, "uploading the scene", 0.0);
    put(BINDING_INSTANCES, "instances", scene_->instances.data(), scene_->instances.size());
    putArrays();
    uploadSeconds_ = wallSeconds() - begin;
}

// Builds the trees and uploads them, with the instances, which know their roots.
void GpuScene::putTrees(uint32_t quality, const Progress& progress) {
    double begin = wallSeconds();
    BvhOptions options;
    options.width = bvhWidth_;
    options.maxLeaf = bvhWidth_ == 4 ? 4 : 3;
    options.quality = quality;
    Bvh bvh = buildBvh(*scene_, options, progress);
    stackDepth_ = bvh.stackDepth;
    double built = wallSeconds();
    buildSeconds_ = built - begin;
    report(progress, "uploading the scene", 0.8);
    std::vector<Instance> instances = scene_->instances;
    for (Instance& instance : instances) instance.root = bvh.meshRoots[instance.mesh];
    put(BINDING_INSTANCES, "instances", instances.data(), instances.size());
    put(BINDING_BVH_NODES, "tree nodes", bvh.nodes.data.get(), bvh.nodes.count);
    put(BINDING_BVH_TRIANGLES, "triangles of the tree", bvh.triangles.data.get(), bvh.triangles.count);
    uploadSeconds_ = wallSeconds() - built;
}

// What is the same for all trees.
void GpuScene::putArrays() {
    const Scene& s = *scene_;
    put(BINDING_POSITIONS, "vertices", s.positions.data(), s.positions.size());
    put(BINDING_ATTRIBUTES, "vertex attributes", s.attributes.data(), s.attributes.size());
    put(BINDING_TANGENTS, "tangents", s.tangents.data(), s.tangents.size());
    put(BINDING_TRIANGLES, "triangles", s.triangles.data(), s.triangles.size());
    put(BINDING_MESHES, "meshes", s.meshes.data(), s.meshes.size());
    put(BINDING_MATERIALS, "materials", s.materials.data(), s.materials.size());
    put(BINDING_TEXTURES, "textures", s.textures.data(), s.textures.size());
    put(BINDING_IMAGES, "images", s.images.data(), s.images.size());
    put(BINDING_IMAGE_LEVELS, "image levels", s.imageLevels.data(), s.imageLevels.size());
    put(BINDING_TEXELS, "images' texels", s.texels.data(), s.texels.size());
    put(BINDING_LIGHTS, "lights", s.lights.data(), s.lights.size());
    put(BINDING_SOBOL, "tables", kernelTable().data(), kernelTable().size());
}

OwnedBufferView GpuScene::view(const GpuBuffer& buffer, VkFormat format) const {
    VkBufferViewCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO};
    info.buffer = buffer.handle();
    info.format = format;
    info.range = VK_WHOLE_SIZE;
    VkBufferView view;
    check(vkCreateBufferView(gpu_.handle(), &info, nullptr, &view), "make a view of a buffer");
    return {gpu_.handle(), view};
}

void GpuScene::bindKernel(VkDescriptorSet set, const GpuBuffer& frame) const {
    bindUpTo(set, BINDING_SOBOL);
    VkDescriptorBufferInfo info{frame.handle(), 0, VK_WHOLE_SIZE};
    VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
    write.dstSet = set;
    write.dstBinding = BINDING_FRAME;
    write.descriptorCount = 1;
    write.descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
    write.pBufferInfo = &info;
    vkUpdateDescriptorSets(gpu_.handle(), 1, &write, 0, nullptr);
}

void GpuScene::bindUpTo(VkDescriptorSet set, uint32_t last) const {
    VkDescriptorBufferInfo infos[BINDING_COUNT];
    VkBufferView views[BINDING_COUNT];
    std::vector<VkWriteDescriptorSet> writes;
    for (uint32_t i = BINDING_POSITIONS; i <= last; i++) {
        VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
        write.dstSet = set;
        write.dstBinding = i;
        write.descriptorCount = 1;
        write.descriptorType = descriptorType(i, bvhWidth_);
        infos[i] = {arrays_[i]->buffer.handle(), 0, VK_WHOLE_SIZE};
        views[i] = arrays_[i]->view.get();
        write.pBufferInfo = &infos[i];
        write.pTexelBufferView = &views[i];
        writes.push_back(write);
    }
    vkUpdateDescriptorSets(gpu_.handle(), static_cast<uint32_t>(writes.size()), writes.data(), 0, nullptr);
}

}  // namespace heliograph
