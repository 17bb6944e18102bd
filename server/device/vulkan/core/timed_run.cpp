#include "server/device/vulkan/core/timed_run.h"

#include "server/device/vulkan/core/vulkan_handle.h"

#include <chrono>

namespace heliograph {

std::vector<double> timedRuns(Gpu& gpu, const std::function<void(VkCommandBuffer)>& record, uint32_t repetitions,
                              double warmUpSeconds) {
    using Clock = std::chrono::steady_clock;
    VkQueryPoolCreateInfo info{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
    info.queryType = VK_QUERY_TYPE_TIMESTAMP;
    info.queryCount = 2;
    VkQueryPool queries;
    check(vkCreateQueryPool(gpu.handle(), &info, nullptr, &queries), "make timestamps");
    const OwnedQueryPool owner(gpu.handle(), queries);
    auto once = [&] {
        gpu.runNow([&](VkCommandBuffer commands) {
            vkCmdResetQueryPool(commands, queries, 0, 2);
            vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, queries, 0);
            record(commands);
            vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, queries, 1);
        });
        uint64_t stamps[2];
        check(vkGetQueryPoolResults(gpu.handle(), queries, 0, 2, sizeof stamps, stamps, 8, VK_QUERY_RESULT_64_BIT),
              "read timestamps");
        return static_cast<double>(stamps[1] - stamps[0]) * gpu.limits().timestampPeriod * 1e-9;
    };
    auto end = Clock::now() + std::chrono::duration<double>(warmUpSeconds);
    do once();
    while (Clock::now() < end);
    std::vector<double> seconds;
    for (uint32_t i = 0; i < repetitions; i++) seconds.push_back(once());
    return seconds;
}

}  // namespace heliograph
