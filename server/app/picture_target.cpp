#include "server/app/picture_target.h"

#include "server/base/error.h"

#include <unistd.h>

#include <cctype>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <stdexcept>

namespace heliograph {

namespace {

constexpr uint32_t MOST_DIGITS = 9;

PictureFormat formatOf(const std::string& word, const std::string& where, const std::string& allowed) {
    if (word == "png") return PictureFormat::png;
    if (word == "exr") return PictureFormat::exr;
    if (word == "jpg" || word == "jpeg") return PictureFormat::jpg;
    throw InputError(where, "unknown format '" + word + "'", allowed);
}

}  // namespace

std::string FramePattern::name(uint32_t frame) const {
    std::string number = std::to_string(frame);
    if (number.size() < digits) number.insert(0, digits - number.size(), '0');
    return before + number + after;
}

std::optional<FramePattern> framePattern(const std::string& text) {
    const size_t percent = text.find('%');
    if (percent == std::string::npos) return {};
    FramePattern pattern;
    size_t at = percent + 1;
    if (at < text.size() && text[at] == '0') {
        while (++at < text.size() && std::isdigit(static_cast<unsigned char>(text[at])) != 0 && pattern.digits <= MOST_DIGITS)
            pattern.digits = 10 * pattern.digits + static_cast<uint32_t>(text[at] - '0');
        if (pattern.digits == 0 || pattern.digits > MOST_DIGITS) return {};
    }
    if (at >= text.size() || text[at] != 'd') return {};
    pattern.before = text.substr(0, percent);
    pattern.after = text.substr(at + 1);
    if (pattern.after.find('%') != std::string::npos) return {};
    return pattern;
}

PictureTarget::PictureTarget(const std::string& out, const std::string& format, bool frames) : out_(out) {
    if (toStdout()) {
        if (isatty(STDOUT_FILENO) != 0) throw InputError("--out -", "standard output is a terminal", "a pipe or a file");
    } else if (frames) {
        pattern_ = framePattern(out);
        if (!pattern_)
            throw InputError("--out " + out, "one place for the frame's number is lacking", "%d or %04d in the name");
    }
    if (!format.empty()) format_ = formatOf(format, "--format", "png, exr or jpg");
    if (toStdout()) return;
    const OutputFile file("--out", name(0));
    if (format.empty()) format_ = formatOf(file.extension(), "--out " + out, "a name that ends in .png, .exr or .jpg");
}

std::string PictureTarget::name(uint32_t frame) const { return pattern_ ? pattern_->name(frame) : out_; }

bool PictureTarget::isThere(uint32_t frame) const {
    std::error_code error;
    return !toStdout() && std::filesystem::is_regular_file(name(frame), error);
}

void PictureTarget::write(std::span<const uint8_t> bytes, uint32_t frame) const {
    if (!toStdout()) {
        OutputFile("--out", name(frame)).write(bytes);
        return;
    }
    const bool written = std::fwrite(bytes.data(), 1, bytes.size(), stdout) == bytes.size();
    if (!written || std::fflush(stdout) != 0) {
        throw std::runtime_error("standard output: cannot be written: " + std::generic_category().message(errno));
    }
}

}  // namespace heliograph
