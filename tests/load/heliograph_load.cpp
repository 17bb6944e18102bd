// heliograph-load: N viewers look at one server at once; prints what came out, and exits with 1 when a requirement is missed.

#include "server/base/error.h"
#include "server/base/text.h"
#include "server/base/version.h"
#include "tests/load/load_report.h"

#include <CLI/CLI.hpp>
#include <spdlog/fmt/fmt.h>

#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <fstream>

namespace heliograph::load {

namespace {

std::atomic<bool> stopping{false};

struct Options {
    LoadPlan plan;
    std::string size = "320x180", script = "orbit", network = "none", tokenFile;
    std::vector<std::string> requirements;
    std::string csv, junit, html;
    bool json = false;
};

void describe(CLI::App& app, Options& o) {
    app.name("heliograph-load");
    app.description("Lets many viewers look at a Heliograph server at once and says what they saw.");
    app.set_version_flag("--version", std::string("heliograph-load ") + programVersion());
    app.add_option("URL", o.plan.url, "Server, such as ws://127.0.0.1:8080/ws or its page's address")->required();
    app.add_option("--viewers", o.plan.viewers, "Viewers at once")->check(CLI::Range(1, 10000))->capture_default_str();
    app.add_option("--seconds", o.plan.seconds, "Seconds of steady load")
        ->check(CLI::Range(0.1, 86400.0))
        ->capture_default_str();
    app.add_option("--ramp", o.plan.rampSeconds, "Seconds over which the viewers come")
        ->check(CLI::Range(0.0, 3600.0))
        ->capture_default_str();
    app.add_option("--inputs", o.plan.inputsPerSecond, "Inputs a second and viewer")
        ->check(CLI::Range(0.1, 1000.0))
        ->capture_default_str();
    app.add_option("--size", o.size, "Picture, WIDTHxHEIGHT")->capture_default_str();
    app.add_option("--scene", o.plan.scene, "Scene to open; the server's own where not given");
    app.add_option("--script", o.script,
                   "What the hands do: orbit, path, walk, idle, settings, attacker, watch (all look at the view of the first "
                   "one, which orbits) or mixed")
        ->capture_default_str();
    app.add_flag("--vp9", o.plan.vp9, "Pictures that change as a video, each one decoded; else JPEG");
    app.add_option("--network", o.network, "The line: none, slow, latency, lossy, stalls or close")->capture_default_str();
    app.add_option("--seed", o.plan.seed, "Of the random walks, settings and stalls")->capture_default_str();
    app.add_option("--token-file", o.tokenFile, "File with the server's secret");
    app.add_flag("--trust-any-certificate", o.plan.trustAnyCertificate, "Take a self-signed certificate");
    app.add_option("--require", o.requirements, "FIGURE<=NUMBER, may be repeated: p95_ms<=80, errors==0, fps_min>=5 ...")
        ->expected(1)
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    app.add_flag("--json", o.json, "Print JSON");
    app.add_option("--csv", o.csv, "Write one line a viewer to this file");
    app.add_option("--junit", o.junit, "Write the requirements as test cases to this file");
    app.add_option("--html", o.html, "Write a page with curves to this file");
    app.footer("Exit code: 0 done, 1 a requirement was missed or no viewer got in, 2 bad input.");
}

std::string firstLine(const std::string& path) {
    std::ifstream file(path);
    std::string line;
    if (!file || !std::getline(file, line) || line.empty())
        throw InputError("--token-file", "'" + path + "' has no first line");
    return line;
}

void writeText(const std::string& path, const std::string& text) {
    if (path.empty()) return;
    std::ofstream file(path, std::ios::binary);
    if (!(file << text) || !file.flush()) throw InputError(path, "cannot be written");
}

void readySize(Options& o) {
    unsigned width = 0, height = 0;
    char rest = 0;
    if (std::sscanf(o.size.c_str(), "%ux%u%c", &width, &height, &rest) != 2 || width < MIN_SIDE || height < MIN_SIDE ||
        width > MAX_SIDE || height > MAX_SIDE)
        throw InputError("--size", "'" + o.size + "'", fmt::format("WIDTHxHEIGHT, {} to {} each", MIN_SIDE, MAX_SIDE));
    o.plan.width = width;
    o.plan.height = height;
}

void printTable(const LoadResult& result, const std::vector<Verdict>& verdicts) {
    for (const auto& [name, value] : figuresOf(result)) std::printf("%-16s %12.2f\n", name.c_str(), value);
    for (const ViewerResult& viewer : result.viewers) {
        for (const std::string& fault : viewer.viewer->faults()) std::printf("fault: %s\n", oneLine(fault).c_str());
    }
    for (const Verdict& v : verdicts)
        std::printf("%-7s %s (%.2f)\n", v.met ? "met" : "MISSED", v.requirement.text.c_str(), v.value);
}

int run(Options& o) {
    readySize(o);
    o.plan.script = scriptOf(o.script);
    o.plan.network = networkOf(o.network);
    addressOf(o.plan.url);
    if (!o.tokenFile.empty()) o.plan.token = firstLine(o.tokenFile);
    std::vector<Requirement> requirements;
    for (const std::string& text : o.requirements) requirements.push_back(requirementOf(text));
    judge(requirements, figuresOf({}));  // an unknown figure is refused before the test, not after it
    const bool terminal = isatty(STDERR_FILENO) != 0;
    const auto progress = [&](double gone, double all, size_t ready) {
        if (terminal)
            std::fprintf(stderr, "\r\033[K%.0f of about %.0f s, %zu of %u viewers see the scene", gone, all, ready,
                         o.plan.viewers);
    };
    const LoadResult result = runLoad(o.plan, progress, stopping);
    if (terminal) std::fputs("\r\033[K", stderr);
    const std::vector<Verdict> verdicts = judge(requirements, figuresOf(result));
    if (o.json)
        std::printf("%s\n",
                    reportJson(o.plan, result, verdicts).dump(2, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
    else printTable(result, verdicts);
    writeText(o.csv, reportCsv(o.plan, result));
    writeText(o.junit, reportJunit(o.plan, result, verdicts));
    writeText(o.html, reportHtml(o.plan, result, verdicts));
    const bool met = std::all_of(verdicts.begin(), verdicts.end(), [](const Verdict& v) { return v.met; });
    const bool somebody =
        std::any_of(result.viewers.begin(), result.viewers.end(), [](const ViewerResult& v) { return v.admitted; });
    if (!somebody) std::fprintf(stderr, "heliograph-load: no viewer got in at %s\n", o.plan.url.c_str());
    return met && somebody ? 0 : 1;
}

}  // namespace

}  // namespace heliograph::load

int main(int argc, char** argv) {
    using namespace heliograph;
    load::Options options;
    CLI::App app;
    load::describe(app, options);
    for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { load::stopping = true; });
    try {
        app.parse(argc, argv);
        return load::run(options);
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() == 0) return app.exit(error);
        std::fprintf(stderr, "heliograph-load: command line: %s\n", oneLine(error.what()).c_str());
        return 2;
    } catch (const InputError& error) {
        std::fprintf(stderr, "heliograph-load: %s\n", oneLine(error.what()).c_str());
        return 2;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "heliograph-load: %s\n", oneLine(error.what()).c_str());
        return 1;
    }
}
