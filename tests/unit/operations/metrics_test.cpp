#include "server/operations/metrics_text.h"
#include "tests/support/places.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <fstream>
#include <limits>
#include <regex>
#include <set>
#include <sstream>

namespace heliograph::TEST_FILE {
namespace {

using testing::HasSubstr;

std::string text(const Metrics& metrics, const ServerState& state = {}) { return metricsText(metricFamilies(metrics, state)); }

std::string fileText(const std::string& path) {
    std::ostringstream out;
    out << std::ifstream(sourceFolder() / path).rdbuf();
    return out.str();
}

std::set<std::string> names() {
    std::set<std::string> all;
    ServerState state;
    state.pool.emplace();
    for (const auto& family : metricFamilies(Metrics(), state)) all.insert(family.name);
    return all;
}

TEST(MetricsText, HistogramsAreCumulativeAndCannotBePoisoned) {
    Metrics metrics;
    Histogram& h = metrics.motionToPhoton;
    for (double s : {0.0005, 0.004, 0.004, 99.0}) h.add(s);
    for (double s : {std::nan(""), -1.0, 1.7e305, static_cast<double>(INFINITY)}) h.add(s);
    const std::string out = text(metrics);
    const std::string name = "heliograph_motion_to_photon_seconds";
    EXPECT_THAT(out, HasSubstr(name + "_bucket{le=\"0.001\"} 1\n"));
    EXPECT_THAT(out, HasSubstr(name + "_bucket{le=\"0.005\"} 3\n"));
    EXPECT_THAT(out, HasSubstr(name + "_bucket{le=\"5\"} 3\n"));
    EXPECT_THAT(out, HasSubstr(name + "_bucket{le=\"+Inf\"} 4\n"));
    EXPECT_THAT(out, HasSubstr(name + "_count 4\n"));
    EXPECT_NEAR(h.sum(), 99.0085, 1e-9);
}

TEST(MetricsText, CountsByReasonDeviceAndOutcome) {
    Metrics metrics;
    metrics.closes.add(closeReason(CloseCode::stalled));
    metrics.refusals.add(refusalReason(503));
    metrics.loads.add("failed");
    metrics.framesSent = 3;
    metrics.stages[Metrics::encode].add(0.01);
    metrics.devices.change("vulkan:0", [](DeviceCount& count) { count = {7, std::nan(""), 1}; });
    ServerState state;
    state.ready = true;
    state.viewers = 2;
    state.mostViewers = 32;
    const std::string out = text(metrics, state);
    for (const char* line :
         {"heliograph_connections_closed_total{reason=\"stalled\"} 1\n", "heliograph_viewers_stalled_total 1\n",
          "heliograph_connections_closed_total{reason=\"viewer_left\"} 0\n",
          "heliograph_connections_refused_total{reason=\"no_room\"} 1\n",
          "heliograph_connections_refused_total{reason=\"token\"} 0\n", "heliograph_scene_loads_total{outcome=\"failed\"} 1\n",
          "heliograph_scene_loads_total{outcome=\"ready\"} 0\n", "heliograph_frames_sent_total 3\n",
          "heliograph_frame_stage_seconds_count{stage=\"encode\"} 1\n",
          "heliograph_device_tiles_total{device=\"vulkan:0\"} 7\n",
          "heliograph_device_set_aside_total{device=\"vulkan:0\"} 1\n",
          "heliograph_device_seconds_total{device=\"vulkan:0\"} 0\n", "heliograph_ready 1\n", "heliograph_viewers 2\n",
          "heliograph_viewers_limit 32\n"})
        EXPECT_THAT(out, HasSubstr(line));
}

TEST(MetricsText, KeepsPrometheusConventions) {
    for (const auto& family : metricFamilies(Metrics(), {})) {
        EXPECT_TRUE(std::regex_match(family.name, std::regex("(heliograph|process)_[a-z_]+"))) << family.name;
        EXPECT_EQ(family.name.ends_with("_total"), family.type == prometheus::MetricType::Counter) << family.name;
        EXPECT_EQ(family.help.back(), '.') << family.name;
    }
    EXPECT_EQ(text(Metrics()).find("nan"), std::string::npos);
}

TEST(MetricsText, APoolIsToldOfWhereThereIsOne) {
    EXPECT_EQ(text(Metrics()).find("heliograph_pool"), std::string::npos);
    Metrics metrics;
    for (const char* node : {"node:1", "node:2", "node:77"})
        metrics.devices.change(node, [](DeviceCount& count) { count.tiles += 5; });
    EXPECT_THAT(text(metrics), HasSubstr("heliograph_device_tiles_total{device=\"node\"} 15\n"));
    ServerState state;
    state.pool = PoolState{true, 3, 1, 2.5e6, 40, 9, 2, 5000, 600, 7, 8};
    const std::string out = text(Metrics(), state);
    for (const char* line :
         {"pool_connected 1\n", "pool_nodes 3\n", "pool_nodes_refused 1\n", "pool_rays_per_second 2500000\n",
          "pool_tiles_total 40\n", "pool_batches_total 9\n", "pool_batches_lost_total 2\n", "pool_received_bytes_total 5000\n",
          "pool_sent_bytes_total 600\n", "pool_messages_unsound_total 7\n", "pool_messages_late_total 8\n"})
        EXPECT_THAT(out, HasSubstr(std::string("heliograph_") + line));
}

TEST(MetricsText, KnowsItsProcess) {
    ServerState state;
    readProcess(state);
    EXPECT_GT(state.residentBytes, 1u << 20);
    EXPECT_GE(state.descriptors, 3u);
    EXPECT_GT(state.mostDescriptors, state.descriptors);
    EXPECT_GE(state.threads, 1u);
    EXPECT_GT(state.startTime, 1.5e9);
    EXPECT_LE(state.startTime, static_cast<double>(time(nullptr)) + 2.0);
}

TEST(MetricsText, EveryCloseCodeHasAWord) {
    std::set<std::string> words{closeReason(std::nullopt)};
    for (int code : {1000, 1001, 1003, 1008, 1009, 1011, 4001, 4008}) words.insert(closeReason(static_cast<CloseCode>(code)));
    EXPECT_EQ(words.size(), 9u);
    EXPECT_EQ(words.count("other"), 0u);
    EXPECT_EQ(closeReason(static_cast<CloseCode>(4999)), "other");
}

TEST(MetricsText, IsDocumented) {
    const std::string page = fileText("docs/reference/metrics.md");
    std::set<std::string> documented;
    const std::regex row("\n\\| `([a-z_]+)`");
    for (std::sregex_iterator match(page.begin(), page.end(), row), end; match != end; ++match) documented.insert((*match)[1]);
    EXPECT_EQ(documented, names()) << "docs/reference/metrics.md";
}

TEST(MetricsText, TheDashboardAsksForWhatIsThere) {
    const auto dashboard = nlohmann::json::parse(fileText("docs/reference/dashboard.json"));
    const std::set<std::string> known = names();
    std::set<std::string> asked;
    for (const auto& panel : dashboard["panels"]) {
        for (const auto& target : panel.value("targets", nlohmann::json::array())) {
            const std::string query = target["expr"];
            const std::regex metric("(heliograph|process)_[a-z_]+");
            for (std::sregex_iterator match(query.begin(), query.end(), metric), end; match != end; ++match) {
                std::string name = std::regex_replace(match->str(), std::regex("_(bucket|sum|count)$"), "");
                EXPECT_EQ(known.count(name), 1u) << query;
                asked.insert(name);
            }
        }
    }
    EXPECT_GE(asked.size(), 15u);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
