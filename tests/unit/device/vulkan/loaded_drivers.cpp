// Keeps Vulkan's drivers loaded until a test process ends: a leak checker can name the library that a block came from only
// while the library is there, and what LLVM never frees (tests/support/lsan.supp) must not hide leaks of ours.

#include <gtest/gtest.h>
#include <vulkan/vulkan.h>

namespace {

class LoadedDrivers : public ::testing::Environment {
public:
    void SetUp() override {
        static VkInstance held = VK_NULL_HANDLE;
        const VkInstanceCreateInfo info{.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
        uint32_t count = 0;
        ASSERT_EQ(vkCreateInstance(&info, nullptr, &held), VK_SUCCESS);
        ASSERT_EQ(vkEnumeratePhysicalDevices(held, &count, nullptr), VK_SUCCESS);
    }
};

[[maybe_unused]] ::testing::Environment* const loadedDrivers = ::testing::AddGlobalTestEnvironment(new LoadedDrivers);

}  // namespace
