#include "server/app/program.h"

int main(int argc, char** argv) { return heliograph::runProgram(argc, argv); }
