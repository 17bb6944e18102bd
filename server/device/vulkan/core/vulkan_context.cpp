#include "server/device/vulkan/core/vulkan_context.h"

#include "server/base/text.h"
#include "server/base/error.h"
#include "server/base/log.h"
#include "server/device/vulkan/core/keep_libraries.h"
#include "server/device/vulkan/core/physical_device.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <mutex>

namespace heliograph {

namespace {

constexpr const char* VALIDATION_LAYER = "VK_LAYER_KHRONOS_validation";

bool layerPresent(const char* name) {
    uint32_t count = 0;
    vkEnumerateInstanceLayerProperties(&count, nullptr);
    std::vector<VkLayerProperties> layers(count);
    vkEnumerateInstanceLayerProperties(&count, layers.data());
    return std::any_of(layers.begin(), layers.end(), [&](const auto& layer) { return !std::strcmp(layer.layerName, name); });
}

std::string lower(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
    return text;
}

}  // namespace

VulkanContext::VulkanContext(const VulkanOptions& options) : options_(options) {
    // Mesa reads it when it makes its devices.
    if (options.lastCoreOnly) setenv("LP_NUM_THREADS", "1", 1);
    create();
    uint32_t count = 0;
    check(vkEnumeratePhysicalDevices(instance_, &count, nullptr), "list devices");
    std::vector<VkPhysicalDevice> handles(count);
    check(vkEnumeratePhysicalDevices(instance_, &count, handles.data()), "list devices");
    for (uint32_t i = 0; i < count; i++) devices_.push_back(describe(handles[i], i));
}

VulkanContext::~VulkanContext() {
    if (messenger_) {
        auto destroy = reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(
            vkGetInstanceProcAddr(instance_, "vkDestroyDebugUtilsMessengerEXT"));
        destroy(instance_, messenger_, nullptr);
    }
    vkDestroyInstance(instance_, nullptr);
}

VkBool32 VulkanContext::report(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                               const VkDebugUtilsMessengerCallbackDataEXT* data, void* user) {
    static_cast<VulkanContext*>(user)->messages_++;
    log().error("Vulkan validation: {}", data->pMessage);
    return VK_FALSE;
}

void VulkanContext::create() {
    VkApplicationInfo application{VK_STRUCTURE_TYPE_APPLICATION_INFO};
    application.pApplicationName = "heliograph";
    application.apiVersion = VK_API_VERSION_1_3;
    VkDebugUtilsMessengerCreateInfoEXT messenger{VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
    messenger.messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    messenger.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
    messenger.pfnUserCallback = report;
    messenger.pUserData = this;
    VkInstanceCreateInfo info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
    info.pApplicationInfo = &application;
    const char* extension = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
    if (options_.validation) {
        // The loader skips a layer that it cannot load, and says nothing: so look for it first.
        if (!layerPresent(VALIDATION_LAYER)) throw VulkanError(VK_ERROR_LAYER_NOT_PRESENT, "validate its calls");
        info.enabledLayerCount = 1;
        info.ppEnabledLayerNames = &VALIDATION_LAYER;
        info.enabledExtensionCount = 1;
        info.ppEnabledExtensionNames = &extension;
        info.pNext = &messenger;
    }
    check(vkCreateInstance(&info, nullptr, &instance_), "start");
    keepLibraries();
    if (!options_.validation) return;
    auto make = reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(
        vkGetInstanceProcAddr(instance_, "vkCreateDebugUtilsMessengerEXT"));
    check(make(instance_, &messenger, nullptr, &messenger_), "listen to the validation layer");
}

const PhysicalDevice& VulkanContext::find(const std::string& which) const {
    const std::string present = joined(
        devices_, ", ", [](const PhysicalDevice& device) { return std::to_string(device.index) + " (" + device.name + ")"; });
    const bool number = which.find_first_not_of("0123456789") == std::string::npos;  // names hold digits, too
    const PhysicalDevice* best = nullptr;
    for (const PhysicalDevice& device : devices_) {
        if (which.empty()) {
            if (device.refused.empty() && (!best || (best->isCpu() && !device.isCpu()))) best = &device;
        } else if (number ? which == std::to_string(device.index)
                          : lower(device.name).find(lower(which)) != std::string::npos) {
            if (!best) best = &device;
        }
    }
    if (!best && which.empty() && !devices_.empty()) best = &devices_.front();
    if (!best)
        throw InputError("device", "no Vulkan device " + (which.empty() ? std::string() : "'" + which + "' ") + "here",
                         present.empty() ? "none is installed" : present);
    if (!best->refused.empty()) throw InputError("device", best->name + " cannot be used: " + best->refused);
    return *best;
}

std::shared_ptr<VulkanContext> vulkanContext(const VulkanOptions& options) {
    static std::mutex mutex;
    static std::weak_ptr<VulkanContext> shared;
    std::lock_guard lock(mutex);
    std::shared_ptr<VulkanContext> context = shared.lock();
    if (context && context->options() == options) return context;
    auto made = std::make_shared<VulkanContext>(options);
    if (!context) shared = made;
    return made;
}

}  // namespace heliograph
