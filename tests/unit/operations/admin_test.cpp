#include "server/operations/admin.h"

#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

using Kind = AdminRequest::Kind;

TEST(AdminRequest, SaysWhatIsAskedFor) {
    EXPECT_EQ(parseAdminRequest("GET", "/admin/viewers").kind, Kind::listViewers);
    EXPECT_EQ(parseAdminRequest("DELETE", "/admin/viewers/12").viewer, 12u);
    EXPECT_EQ(parseAdminRequest("POST", "/admin/scenes/a/b.glb").scene, "a/b.glb");
    EXPECT_EQ(parseAdminRequest("POST", "/admin/drain").kind, Kind::drain);
    EXPECT_EQ(parseAdminRequest("DELETE", "/admin/drain").kind, Kind::admit);
}

TEST(AdminRequest, OtherWordsAreUnknown) {
    for (const char* path : {"/admin", "/admin/", "/admin/viewers/", "/admin/viewers/x", "/admin/viewers/1x",
                             "/admin/viewers/4294967296", "/admin/viewers/-1", "/admin/drains"}) {
        EXPECT_EQ(parseAdminRequest("DELETE", path).kind, Kind::unknown) << path;
    }
}

TEST(AdminRequest, AnotherMethodIsToldWhichOnesThereAre) {
    const AdminRequest request = parseAdminRequest("GET", "/admin/drain");
    EXPECT_EQ(request.kind, Kind::otherMethod);
    EXPECT_EQ(request.methods, "POST, DELETE");
}

}  // namespace
}  // namespace heliograph::TEST_FILE
