#pragma once
// The text of OBJ and MTL files: lines, words and numbers. Pure. Private to server/scene.
//
// Format: Wavefront, "Advanced Visualizer" manual, appendix B1 (object files) and 5 (material library); lines may be continued by
// a backslash at their end.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace heliograph {

/// Lines of a file, those that a backslash continues joined to one, without byte order marks, comments that begin a line, and
/// blanks around. Ends of lines: LF, CR LF or CR.
class ObjLines {
public:
    /// UTF-8, or UTF-16 with a byte order mark. `file`: for messages. Throws InputError for NUL characters, which no text has.
    ObjLines(std::span<const uint8_t> bytes, std::string file);
    ObjLines(const ObjLines&) = delete;

    /// The next line that is not empty. Its text is valid until the next call. Throws InputError for one that is too long.
    std::optional<std::string_view> next();
    /// Number of that line's first row, from 1.
    uint64_t number() const { return number_; }
    /// "file: line 12", for messages.
    std::string where() const { return file_ + ": line " + std::to_string(number_); }
    /// Bytes read so far, of all.
    double share() const { return text_.empty() ? 1.0 : static_cast<double>(at_) / static_cast<double>(text_.size()); }

private:
    std::string_view row();

    std::string converted_;  // of UTF-16
    std::string_view text_;
    std::string file_;
    std::string joined_;
    size_t at_ = 0;
    uint64_t row_ = 0;
    uint64_t number_ = 0;
};

/// The next word of the line, which is cut off its front; empty at the end.
std::string_view nextWord(std::string_view& line);
/// What stands before the last blank and # of a name, which begin a comment unless they belong to the name ("Material #25");
/// empty where there are none.
std::string_view beforeComment(std::string_view name);
/// Without the quotation marks that stand around it.
std::string_view unquoted(std::string_view name);
/// Without blanks around.
std::string_view trimmed(std::string_view text);
/// The number that the word begins with; none where it begins otherwise. Beyond what a double holds: infinite. `whole`, if given,
/// becomes false where something follows the number.
std::optional<double> numberIn(std::string_view word, bool* whole = nullptr);
/// The words of the line that begin with numbers, from its first to the first one that does not, at most as many as there is room
/// for. Returns how many. `whole`: as for numberIn.
size_t numbersIn(std::string_view line, std::span<double> numbers, bool* whole = nullptr);

}  // namespace heliograph
