#include "server/operations/configuration.h"

#include "server/base/error.h"
#include "server/operations/config_file.h"
#include "server/request/settings.h"
#include "tests/support/places.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>

namespace heliograph::TEST_FILE {
namespace {

using Kind = GivenValue::Kind;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;
namespace fs = std::filesystem;

/// What an InputError of `work` says; empty if there is none.
template <typename Work>
std::string complaint(Work work) {
    try {
        work();
    } catch (const InputError& error) {
        return error.what();
    }
    return {};
}

class ConfigurationTest : public testing::Test {
protected:
    void SetUp() override {
        folder_ = fs::temp_directory_path() / ("heliograph-configuration-" + std::to_string(getpid()));
        fs::create_directories(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }
    std::string file(const std::string& text, const std::string& name = "heliograph.toml") {
        const fs::path path = folder_ / name;
        std::ofstream(path, std::ios::binary) << text;
        return path.string();
    }
    Configuration with(const std::string& text, std::vector<std::string> environment = {}, std::vector<GivenValue> flags = {}) {
        return configure({std::move(flags), std::move(environment), file(text)});
    }
    std::string refusal(const std::string& text) {
        return complaint([&] { with(text); });
    }
    fs::path folder_;
};

TEST_F(ConfigurationTest, FlagsWinOverEnvironmentOverFile) {
    const std::string text = "max-viewers = 3\nlisten = '127.0.0.1:1'\nlog-level = \"warn\"\n";
    const Configuration all = with(text, {"HELIOGRAPH_MAX_VIEWERS=4", "HELIOGRAPH_LISTEN=127.0.0.1:2", "HOME=/"},
                                   {{"max-viewers", Kind::word, {"5"}, "--max-viewers"}});
    EXPECT_EQ(all.options.maxViewers, 5u);
    EXPECT_EQ(all.options.listen, std::vector<std::string>{"127.0.0.1:2"});
    EXPECT_EQ(all.options.logLevel, "warn");
    EXPECT_EQ(all.options.scene, "courtyard");
    const std::string printed = configurationText(all);
    EXPECT_THAT(printed, HasSubstr("\nmax-viewers = 5  # --max-viewers\n"));
    EXPECT_THAT(printed, HasSubstr("\nlisten = [\"127.0.0.1:2\"]  # HELIOGRAPH_LISTEN\n"));
    EXPECT_THAT(printed, HasSubstr("\nlog-level = \"warn\"  # " + all.file + ":3\n"));
    EXPECT_THAT(printed, HasSubstr("\nscene = \"courtyard\"  # default\n"));
}

TEST_F(ConfigurationTest, EachSettingHasItsOwnPrecedence) {
    const Configuration all = with("[set]\nsamples = 64\nshadows = false\n", {"HELIOGRAPH_SET=shadows=true,jpegQuality=50"},
                                   {{"set", Kind::word, {"samples=2"}, "--set"}});
    Settings settings;
    for (const std::string& one : all.options.settings) settings.setFromText(one);
    EXPECT_EQ(settings.samples, 2u);
    EXPECT_TRUE(settings.shadows);
    EXPECT_EQ(settings.jpegQuality, 50u);
    EXPECT_THAT(configurationText(all),
                AllOf(HasSubstr("\nsamples = \"2\"  # --set\n"), HasSubstr("\nshadows = \"true\"  # HELIOGRAPH_SET\n")));
}

TEST_F(ConfigurationTest, WhatIsPrintedCanBeReadAgain) {
    const Configuration first = with(
        "scene = 'C:\\\\a \"b\".glb'\ndevices = ['embree']\ninsecure = true\nallow-origin = [\"https://a.org\", "
        "\"https://b.org\"]\n"
        "[set]\nsamples = 7\n");
    const Configuration second = with(configurationText(first));
    EXPECT_EQ(second.options.scene, first.options.scene);
    EXPECT_EQ(second.options.origins, first.options.origins);
    EXPECT_EQ(second.options.settings, first.options.settings);
    EXPECT_EQ(needsRestart(first.options, second.options), "");
}

TEST_F(ConfigurationTest, NamesLineValueAndRange) {
    const std::string at = folder_.string() + "/heliograph.toml:";
    EXPECT_EQ(refusal("\nmax-viewers = 0\n"), at + "2: max-viewers: 0; allowed: a whole number from 1 to 1000");
    EXPECT_EQ(refusal("max-viewers = 1.5"), at + "1: max-viewers: 1.5; allowed: a whole number from 1 to 1000");
    EXPECT_EQ(refusal("max-viewers = \"8\""), at + "1: max-viewers: \"8\"; allowed: a whole number from 1 to 1000");
    EXPECT_EQ(refusal("max-viewers = -9223372036854775808"),
              at + "1: max-viewers: -9223372036854775808; allowed: a whole number from 1 to 1000");
    EXPECT_EQ(refusal("insecure = 1"), at + "1: insecure: 1; allowed: true or false");
    EXPECT_EQ(refusal("client = 8080"), at + "1: client: 8080; allowed: a text in quotes");
    EXPECT_EQ(refusal("client = ['a', 'b']"), at + "1: client: a list of 2 values; allowed: a text in quotes");
    EXPECT_THAT(refusal("listen = ['8080', 'b']"), StartsWith(at + "1: listen: \"b\"; allowed: HOST:PORT"));
    EXPECT_EQ(refusal("socket-mode = '0888'"), at + "1: socket-mode: \"0888\"; allowed: octal digits up to 0777, as 0660");
    EXPECT_EQ(refusal("#\n#\nmax_viewers = 3"), at + "3: max_viewers: no such option; allowed: did you mean max-viewers?");
    EXPECT_EQ(refusal("frobnicate = 3"), at + "1: frobnicate: no such option; allowed: the options of heliograph serve --help");
    EXPECT_EQ(refusal("[listen]\na = 1"), at + "1: listen: a table; allowed: a plain value; only [set] is a table");
    EXPECT_THAT(refusal("listen = 'nowhere'"),
                AllOf(StartsWith(at + "1: listen: \"nowhere\"; allowed: HOST:PORT"), testing::Not(HasSubstr("--listen"))));
    EXPECT_THAT(refusal("log-level = 'loud'"), StartsWith(at + "1: log-level: "));
    EXPECT_THAT(refusal("[set]\n\nsamples = 0"),
                AllOf(StartsWith(at + "3: set.samples: setting samples: 0"), HasSubstr("1 to ")));
    EXPECT_THAT(refusal("[set]\nsample = 5"), StartsWith(at + "2: set.sample: "));
    EXPECT_THAT(refusal("listen = 2020-01-01"), StartsWith(at + "1: listen: a date or a time"));
    EXPECT_THAT(refusal("devices = [1]"), StartsWith(at + "1: devices: a list with something that is no text"));
    EXPECT_THAT(refusal("scene = 'a'\nscene = 'b'"), StartsWith(at + "2: "));
    EXPECT_THAT(refusal("scene = "), StartsWith(at + "1: "));
    EXPECT_THAT(refusal("scene = '\xff'"), StartsWith(at + "1: "));
    EXPECT_THAT(refusal("scene = \"a\\u0000b\""), StartsWith(at + "1: scene: "));
}

TEST_F(ConfigurationTest, TakesWhatEditorsWrite) {
    EXPECT_EQ(with("\xef\xbb\xbfmax-viewers = 3\r\n# ü\r\nlog-json = true\r\n").options.maxViewers, 3u);
    EXPECT_EQ(with("").options.maxViewers, MAX_VIEWERS);
    EXPECT_EQ(with("max-viewers = 3").options.maxViewers, 3u) << "no line feed at the end";
}

TEST_F(ConfigurationTest, SaysWhyAFileCannotBeRead) {
    const auto refused = [](const std::string& path) { return complaint([&] { readConfigFile(path); }); };
    EXPECT_THAT(refused(folder_.string()), HasSubstr(": is a folder; allowed: a text file"));
    EXPECT_THAT(refused((folder_ / "missing.toml").string()), HasSubstr("cannot be read (No such file"));
    EXPECT_THAT(refused(""), HasSubstr("cannot be read"));
    const std::string pipe = (folder_ / "pipe").string();
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    EXPECT_THAT(refused(pipe), HasSubstr("is no regular file"));
    EXPECT_THAT(refused(file(std::string(CONFIG_FILE_BYTES + 1, '#'), "large.toml")), HasSubstr("is larger than 1 MiB"));
    const std::string locked = file("", "locked.toml");
    fs::permissions(locked, fs::perms::none);
    if (geteuid() != 0) {
        EXPECT_THAT(refused(locked), HasSubstr("Permission denied"));
    }
    EXPECT_TRUE(readConfigFile("/dev/null").empty());
}

TEST_F(ConfigurationTest, ReadsTheFileThatIsNamedOrTheUsualOne) {
    ConfigurationInputs inputs;
    inputs.usual = (folder_ / "usual.toml").string();
    EXPECT_EQ(configure(inputs).file, "");
    file("max-viewers = 1", "usual.toml");
    EXPECT_EQ(configure(inputs).options.maxViewers, 1u);
    inputs.environment = {"HELIOGRAPH_CONFIG=" + file("max-viewers = 2", "named.toml")};
    EXPECT_EQ(configure(inputs).options.maxViewers, 2u);
    inputs.file = file("max-viewers = 3", "flag.toml");
    EXPECT_EQ(configure(inputs).options.maxViewers, 3u);
    inputs.file = "";
    EXPECT_THROW(configure(inputs), InputError) << "--config '' is a mistake, not the absence of a file";
}

TEST_F(ConfigurationTest, EnvironmentIsCheckedTheSameWay) {
    const auto refused = [](const std::string& entry) {
        return complaint([&] { configure({{}, {entry}, {}, "no such file"}); });
    };
    EXPECT_EQ(refused("HELIOGRAPH_MAX_VIEWERS=many"),
              "HELIOGRAPH_MAX_VIEWERS: \"many\"; allowed: a whole number from 1 to 1000");
    EXPECT_EQ(refused("HELIOGRAPH_MAX_VIEWERS= 3"), "HELIOGRAPH_MAX_VIEWERS: \" 3\"; allowed: a whole number from 1 to 1000");
    EXPECT_EQ(refused("HELIOGRAPH_INSECURE=yes"), "HELIOGRAPH_INSECURE: \"yes\"; allowed: true or false");
    EXPECT_EQ(refused("HELIOGRAPH_TOKEN_FILE="), "") << "an empty variable is none";
    const Configuration typo = configure({{}, {"HELIOGRAPH_MAXVIEWERS=3", "HELIOGRAPH_IMAGE_MODULE=x"}, {}, "no such file"});
    EXPECT_THAT(
        typo.warnings,
        ElementsAre("HELIOGRAPH_MAXVIEWERS in the environment means nothing here; did you mean HELIOGRAPH_MAX_VIEWERS?"));
}

TEST(ServeOptionsTest, NamesWhatNeedsARestart) {
    ServeOptions running, wanted;
    wanted.maxViewers = 5;
    EXPECT_EQ(needsRestart(running, wanted), "");
    wanted.listen = {"127.0.0.1:1"};
    wanted.client = "elsewhere";
    EXPECT_EQ(needsRestart(running, wanted), "listen, client");
}

TEST(ServeOptionsTest, AreThoseOfTheServingPage) {
    std::ostringstream page;
    page << std::ifstream(sourceFolder() / "docs/reference/serving.md").rdbuf();
    for (const OptionRow& row : optionRows()) {
        const std::string name = row.name == "scene" ? "[SCENE]" : "`--" + std::string(row.name);
        EXPECT_THAT(page.str(), HasSubstr(name));
        if (!row.reloadable) {
            EXPECT_THAT(page.str(), HasSubstr("`" + std::string(row.name) + "`")) << "should be listed as needing a restart";
        }
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE
