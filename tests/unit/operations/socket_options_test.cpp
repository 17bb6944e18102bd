#include "server/operations/socket_options.h"

#include "server/base/error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace heliograph {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class SocketOptionsTest : public testing::Test {
protected:
    SocketOptionsTest() {
        std::string pattern = (fs::temp_directory_path() / "heliograph-XXXXXX").string();
        folder_ = mkdtemp(pattern.data());
    }
    ~SocketOptionsTest() override { fs::remove_all(folder_); }
    std::string write(const std::string& name, const std::string& text) const {
        std::ofstream(folder_ / name) << text << "\n";
        return (folder_ / name).string();
    }
    static std::string refusal(const ServeOptions& options) {
        try {
            socketOptions(options);
        } catch (const InputError& error) {
            return error.what();
        }
        return {};
    }

private:
    fs::path folder_;
};

TEST_F(SocketOptionsTest, ListenInSeveralPlaces) {
    ServeOptions options;
    options.listen = {"127.0.0.1:1", "[::1]:2", "unix:/run/h.sock", "systemd"};
    const SocketOptions socket = socketOptions(options);
    EXPECT_EQ(socket.listen.text(), "127.0.0.1:1");
    ASSERT_EQ(socket.moreListens.size(), 3u);
    EXPECT_EQ(socket.moreListens[0].text(), "[::1]:2");
    EXPECT_EQ(socket.moreListens[1].path, "/run/h.sock");
    EXPECT_TRUE(socket.moreListens[2].systemd);
    options.listen.clear();
    EXPECT_THAT(refusal(options), HasSubstr("--listen: no address"));
}

TEST_F(SocketOptionsTest, AdminsHaveATokenOfTheirOwn) {
    ServeOptions options;
    options.tokenFile = write("viewers", "0123456789abcdef");
    options.adminTokenFile = write("admins", "fedcba9876543210");
    EXPECT_EQ(socketOptions(options).token, "0123456789abcdef");
    EXPECT_EQ(socketOptions(options).adminToken, "fedcba9876543210");
    options.adminTokenFile = options.tokenFile;
    EXPECT_THAT(refusal(options), HasSubstr("--admin-token-file: the token of viewers"));
    options.adminTokenFile = "/nowhere";
    EXPECT_THAT(refusal(options), HasSubstr("/nowhere: no token could be read"));
}

TEST_F(SocketOptionsTest, CertificateAndKeyComeTogether) {
    ServeOptions options;
    options.certificate = "cert.pem";
    EXPECT_THAT(refusal(options), HasSubstr("--tls-key: missing"));
}

}  // namespace
}  // namespace heliograph
