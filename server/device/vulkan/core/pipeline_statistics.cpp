#include "server/device/vulkan/core/pipeline_statistics.h"

#include "server/base/text.h"

#include <fmt/format.h>

namespace heliograph {

namespace {

template <typename Function>
Function functionOf(const Gpu& gpu, const char* name) {
    return reinterpret_cast<Function>(vkGetDeviceProcAddr(gpu.handle(), name));
}

std::string valueOf(const VkPipelineExecutableStatisticKHR& statistic) {
    switch (statistic.format) {
        case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_BOOL32_KHR: return statistic.value.b32 ? "yes" : "no";
        case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_INT64_KHR: return fmt::to_string(statistic.value.i64);
        case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_UINT64_KHR: return fmt::to_string(statistic.value.u64);
        default: return fmt::to_string(statistic.value.f64);
    }
}

}  // namespace

std::string pipelineStatistics(const Gpu& gpu, VkPipeline pipeline) {
    const auto executables = functionOf<PFN_vkGetPipelineExecutablePropertiesKHR>(gpu, "vkGetPipelineExecutablePropertiesKHR");
    const auto statisticsOf = functionOf<PFN_vkGetPipelineExecutableStatisticsKHR>(gpu, "vkGetPipelineExecutableStatisticsKHR");
    if (!executables || !statisticsOf) return {};
    const VkPipelineInfoKHR info{VK_STRUCTURE_TYPE_PIPELINE_INFO_KHR, nullptr, pipeline};
    uint32_t programs = 0;
    check(executables(gpu.handle(), &info, &programs, nullptr), "count the programs of a pipeline");
    std::vector<std::string> words;
    for (uint32_t program = 0; program < programs; program++) {
        const VkPipelineExecutableInfoKHR which{VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_INFO_KHR, nullptr, pipeline, program};
        uint32_t count = 0;
        check(statisticsOf(gpu.handle(), &which, &count, nullptr), "count a pipeline's statistics");
        std::vector<VkPipelineExecutableStatisticKHR> found(count, {VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_STATISTIC_KHR});
        check(statisticsOf(gpu.handle(), &which, &count, found.data()), "read a pipeline's statistics");
        for (const auto& statistic : found) words.push_back(fmt::format("{} {}", statistic.name, valueOf(statistic)));
    }
    return joined(words);
}

}  // namespace heliograph
