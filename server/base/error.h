#pragma once
// Errors that come from outside: files, command line, sockets. The message is one line that names the file or field, what
// was found and what is allowed.

#include <stdexcept>
#include <string>

namespace heliograph {

/// Bad input. Commands end with exit code 2, a session answers its viewer with an `error` message.
class InputError : public std::runtime_error {
public:
    /// `where`: file or field. `found`: what is wrong there. `allowed`: what would be right; may be empty.
    InputError(const std::string& where, const std::string& found, const std::string& allowed = {})
        : std::runtime_error(where + ": " + found + (allowed.empty() ? "" : "; allowed: " + allowed)), field_(where) {}

    const std::string& field() const { return field_; }

private:
    std::string field_;
};

}  // namespace heliograph
