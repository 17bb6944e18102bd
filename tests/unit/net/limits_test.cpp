#include "server/net/guard/limits.h"

#include "tests/support/places.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

namespace heliograph::TEST_FILE {
namespace {

uint64_t whole(std::chrono::seconds seconds) { return static_cast<uint64_t>(seconds.count()); }
template <typename Number>
uint64_t whole(Number number) {
    return static_cast<uint64_t>(number);
}

/// "33,177,600"
std::string grouped(uint64_t number) {
    std::string text = std::to_string(number);
    for (size_t at = text.size(); at > 3; at -= 3) text.insert(at - 3, ",");
    return text;
}

TEST(Limits, AreThoseOfTheProtocolsPage) {
    std::ostringstream page;
    page << std::ifstream(sourceFolder() / "docs/reference/protocol.md").rdbuf();
    std::string table = "## Limits\n\n| limit | unit | of what |\n| --- | --- | --- |\n";
#define LIMIT_ROW(type, name, value, unit, what) table += "| " + grouped(whole(name)) + " | " unit " | " what " |\n";
    WIRE_LIMITS(LIMIT_ROW)
#undef LIMIT_ROW
    EXPECT_NE(page.str().find(table), std::string::npos) << "docs/reference/protocol.md should say:\n" << table;
}

}  // namespace
}  // namespace heliograph::TEST_FILE
