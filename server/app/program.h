#pragma once
// The program: its sub-commands, and what becomes of their errors.

namespace heliograph {

/// Runs the command that the arguments ask for. Returns the exit code: 0 done, 1 failed, 2 bad input. Errors are one line
/// on stderr.
int runProgram(int argc, const char* const* argv);

}  // namespace heliograph
