#pragma once
// Another program of this kind, or this one once more, that renders frames when it is told to. So two builds are compared
// frame by frame, in turns, on the same machine at the same time.

#include <nlohmann/json.hpp>

#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

#include <sys/types.h>

namespace heliograph {

class BenchPartner {
public:
    /// Starts `program` with these arguments, of which one has to make it answer (serveFrames). Waits for its first line.
    /// Throws std::runtime_error if it cannot be started, ends or says something else; then it is killed.
    BenchPartner(const std::string& program, const std::vector<std::string>& arguments);
    /// Ends the program's input and waits for it, two seconds at most: then it is killed.
    ~BenchPartner();
    BenchPartner(const BenchPartner&) = delete;
    BenchPartner& operator=(const BenchPartner&) = delete;

    /// What it said of itself when it was ready.
    const nlohmann::json& greeting() const { return greeting_; }
    /// Has it render a frame and returns its answer. Throws std::runtime_error if it ends instead.
    nlohmann::json frame();

private:
    nlohmann::json line();

    std::string program_;
    int line_ = -1;  // socket to its standard input and output
    pid_t process_ = -1;
    std::string unread_;
    nlohmann::json greeting_;
};

/// The other side: says `greeting`, then answers each line of `in` by what `frame` returns, until `in` ends.
void serveFrames(std::istream& in, std::ostream& out, const nlohmann::json& greeting,
                 const std::function<nlohmann::json()>& frame);

/// The file of the running program.
std::string ownProgram();

}  // namespace heliograph
