// The small parts of the network layer: origins, addresses, tokens, files of the client, metrics, rate limits.

#include "server/base/error.h"
#include "server/net/client_files.h"
#include "server/net/guard/origin.h"
#include "server/net/guard/rate_limit.h"
#include "server/net/guard/departures.h"
#include "server/net/guard/request_size.h"
#include "server/net/guard/token.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace heliograph::TEST_FILE {
namespace {

namespace fs = std::filesystem;

/// A folder that goes away.
struct Folder {
    fs::path path;
    Folder() {
        std::string pattern = (fs::temp_directory_path() / "heliograph-XXXXXX").string();
        path = mkdtemp(pattern.data());
    }
    ~Folder() { fs::remove_all(path); }
    std::string write(const std::string& name, const std::string& bytes) const {
        fs::create_directories((path / name).parent_path());
        std::ofstream(path / name, std::ios::binary) << bytes;
        return (path / name).string();
    }
};

TEST(Origin, LoopbackIsThisMachineAlone) {
    for (const char* host : {"127.0.0.1", "127.9.9.9", "::1", "localhost"}) EXPECT_TRUE(isLoopback(host)) << host;
    for (const char* host : {"0.0.0.0", "::", "10.0.0.1", "127.evil.org", "1127.0.0.1", ""})
        EXPECT_FALSE(isLoopback(host)) << host;
}

TEST(Origin, HasToBeTheServersOwn) {
    EXPECT_TRUE(originAllowed("", "localhost:8080", {}, true));
    EXPECT_TRUE(originAllowed("http://localhost:8080", "localhost:8080", {}, true));
    EXPECT_TRUE(originAllowed("http://[::1]:8080", "[::1]:8080", {}, true));
    EXPECT_TRUE(originAllowed("http://LOCALHOST:8080", "localhost:8080", {}, true));
    EXPECT_TRUE(originAllowed("https://viewer.example", "viewer.example:443", {}, false));
    EXPECT_FALSE(originAllowed("http://evil.example", "localhost:8080", {}, true));
    EXPECT_FALSE(originAllowed("http://localhost:8081", "localhost:8080", {}, true));
    EXPECT_FALSE(originAllowed("http://localhost:8080.evil.example", "localhost:8080", {}, true));
    EXPECT_FALSE(originAllowed("null", "localhost:8080", {}, true));
    EXPECT_FALSE(originAllowed("http://localhost:8080", "", {}, true));
}

TEST(Origin, AForeignNameForThisMachineIsRefused) {
    EXPECT_FALSE(originAllowed("http://rebound.example:8080", "rebound.example:8080", {}, true));
    EXPECT_TRUE(originAllowed("http://rebound.example:8080", "rebound.example:8080", {}, false));
}

TEST(Origin, OthersCanBeAllowed) {
    EXPECT_TRUE(originAllowed("https://portal.example", "10.0.0.1:80", {"https://portal.example"}, true));
    EXPECT_FALSE(originAllowed("https://portal.example.org", "10.0.0.1:80", {"https://portal.example"}, true));
}

TEST(Token, ComparesWholeSecrets) {
    EXPECT_TRUE(sameSecret("0123456789abcdef", "0123456789abcdef"));
    for (const char* given :
         {"", "0", "0123456789abcde", "0123456789abcdeX", "0123456789abcdef0", "0123456789abcdef0123456789abcdef"}) {
        EXPECT_FALSE(sameSecret(given, "0123456789abcdef")) << given;
    }
    EXPECT_FALSE(sameSecret("", ""));  // no secret: nothing matches
}

TEST(Token, ReadsTheFirstLine) {
    Folder folder;
    EXPECT_EQ(readTokenFile(folder.write("a", "0123456789abcdef \r\nmore")), "0123456789abcdef");
    EXPECT_THROW(readTokenFile(folder.write("b", "short\n")), InputError);
    EXPECT_THROW(readTokenFile(folder.write("c", "")), InputError);
    EXPECT_THROW(readTokenFile((folder.path / "missing").string()), InputError);
}

TEST(ClientFiles, ServesWhatLiesInTheFolderAndNothingElse) {
    Folder folder, outside;
    folder.write("index.html", "<p>hello");
    folder.write("app.js", "1");
    folder.write("deep/er.css", "p {}");
    fs::create_symlink(outside.write("secret.txt", "secret"), folder.path / "link.txt");
    fs::create_directory_symlink(outside.path, folder.path / "linked");
    ClientFiles files = readClientFiles(folder.path.string());
    EXPECT_EQ(files.size(), 4u);
    EXPECT_EQ(files.at("/").bytes, "<p>hello");
    EXPECT_EQ(files.at("/").mimeType, "text/html; charset=utf-8");
    EXPECT_EQ(files.at("/deep/er.css").mimeType, "text/css; charset=utf-8");
    EXPECT_EQ(files.at("/app.js").mimeType, "text/javascript; charset=utf-8");
}

TEST(ClientFiles, CompressedFormsAreNoFilesOfTheirOwn) {
    Folder folder;
    folder.write("index.html", "<p>hello, hello, hello");
    folder.write("index.html.gz", "gzipped");
    folder.write("index.html.br", "brotli");
    folder.write("lonely.gz", "1");
    const ClientFiles files = readClientFiles(folder.path.string());
    EXPECT_EQ(files.size(), 3u);
    EXPECT_TRUE(files.contains("/lonely.gz"));
    const ClientFile& page = files.at("/");
    EXPECT_EQ(page.tag.size(), 20u);
    EXPECT_EQ(encodedFor(page, "").bytes, page.bytes);
    EXPECT_EQ(encodedFor(page, "gzip").bytes, "gzipped");
    EXPECT_EQ(encodedFor(page, "gzip;q=1.0, br;q=0.5").bytes, "brotli");
    EXPECT_EQ(encodedFor(page, "br;q=0, gzip;q=0.0").bytes, page.bytes);
    EXPECT_EQ(encodedFor(page, "xbr, brx").bytes, page.bytes);
}

TEST(ClientFiles, OnlyNamesWithAHashNameTheirContent) {
    EXPECT_TRUE(namesItsContent("/app-RO42B3C3.js"));
    for (const char* path :
         {"/", "/index.html", "/app.js", "/app-RO42B3C.js", "/app-ro42b3c3.js", "/app-RO42B3C3", "/a-b/x.js"})
        EXPECT_FALSE(namesItsContent(path)) << path;
}

TEST(ClientFiles, RefusesAFolderWithoutIndexAndTooLargeFiles) {
    Folder folder;
    EXPECT_THROW(readClientFiles(folder.path.string()), InputError);
    EXPECT_THROW(readClientFiles((folder.path / "missing").string()), InputError);
    folder.write("index.html", "x");
    fs::resize_file(folder.path / "index.html", (16u << 20) + 1);
    EXPECT_THROW(readClientFiles(folder.path.string()), InputError);
}

TEST(ClientFiles, KnowsTheTypesOfAClient) {
    EXPECT_EQ(mimeTypeOf("/a.js.map"), "application/json");
    EXPECT_EQ(mimeTypeOf("/favicon.svg"), "image/svg+xml");
    EXPECT_EQ(mimeTypeOf("/favicon.ico"), "image/x-icon");
    EXPECT_EQ(mimeTypeOf("/strange.bin"), "application/octet-stream");
}

TEST(RateLimit, LetsBurstsPassAndFillsAgain) {
    RateLimit limit(10.0, 3.0);
    EXPECT_TRUE(limit.take(3.0, 100.0));
    EXPECT_FALSE(limit.take(1.0, 100.0));
    EXPECT_TRUE(limit.take(1.0, 100.11));
    EXPECT_FALSE(limit.take(1.0, 100.12));
    EXPECT_TRUE(limit.take(3.0, 200.0));
    EXPECT_FALSE(limit.take(3.5, 300.0));
}

TEST(RequestSize, AddressBeforeHeaders) {
    EXPECT_EQ(statusOf({8192, 16384, 8192 + 16384}), 0u);
    EXPECT_EQ(statusOf({8193, 16385, 0}), 414u);
    EXPECT_EQ(statusOf({1, 16385, 0}), 431u);
    EXPECT_EQ(statusOf({1, 9, 60'000}), 431u) << "headers without a name that the library knows";
    EXPECT_EQ(statusOf({1, 16'000, 16'200 + 16'384}), 0u) << "more requests came with it";
}

TEST(Departures, SayWhenAPlaceIsFree) {
    Departures departures;
    EXPECT_EQ(departures.secondsToNext(100.0), 2) << "nobody has left yet";
    departures.left(100.0);
    EXPECT_EQ(departures.secondsToNext(107.5), 8) << "as long as none has left since";
    for (double at : {110.0, 120.0, 130.0}) departures.left(at);
    EXPECT_EQ(departures.secondsToNext(130.0), 10) << "every ten seconds one leaves";
    EXPECT_EQ(departures.secondsToNext(145.0), 15);
    EXPECT_EQ(departures.secondsToNext(1000.0), 60);
    for (int i = 0; i < 20; i++) departures.left(1000.0 + 0.1 * i);
    EXPECT_EQ(departures.secondsToNext(1002.0), 2);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
