#include "server/base/output_file.h"

#include "server/base/error.h"

#include <unistd.h>

#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <system_error>

namespace heliograph {

namespace fs = std::filesystem;

OutputFile::OutputFile(const std::string& option, const std::string& path) : path_(path) {
    auto refuse = [&](const std::string& found) {
        throw InputError(option + " " + path, found, "a file in a folder that can be written");
    };
    std::error_code error;
    fs::file_status status = fs::status(path, error);
    if (path.empty() || fs::is_directory(status)) refuse("not the name of a file");
    fs::path folder = fs::path(path).parent_path();
    if (folder.empty()) folder = ".";
    if (!fs::is_directory(folder, error)) refuse("its folder does not exist");
    direct_ = fs::exists(status) && !fs::is_regular_file(status);
    if (fs::exists(status) && access(path.c_str(), W_OK) != 0) refuse(std::generic_category().message(errno));
    if (!direct_ && access(folder.c_str(), W_OK | X_OK) != 0)
        refuse(std::string("its folder: ") + std::generic_category().message(errno));
}

std::string OutputFile::extension() const {
    std::string text = fs::path(path_).extension().string();
    if (!text.empty()) text.erase(0, 1);
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
}

void OutputFile::write(std::span<const uint8_t> bytes) const {
    std::string target = direct_ ? path_ : path_ + ".part";
    auto fail = [&] {
        std::string reason = std::generic_category().message(errno);
        if (!direct_) std::remove(target.c_str());
        throw std::runtime_error(path_ + ": cannot be written: " + reason);
    };
    std::FILE* file = std::fopen(target.c_str(), "wb");
    if (file == nullptr) fail();
    bool written = std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
    if (std::fclose(file) != 0 || !written) fail();
    if (!direct_ && std::rename(target.c_str(), path_.c_str()) != 0) fail();
}

}  // namespace heliograph
