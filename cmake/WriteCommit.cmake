# Defines vesta::bench::kCommit (bench/commit.h) in the source OUTPUT, by the state of the folder SOURCE. Run with every
# build; the file is written only where it changes.
cmake_minimum_required(VERSION 3.25)
execute_process(COMMAND git describe --always --dirty --exclude=* WORKING_DIRECTORY ${SOURCE}
  OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(NOT commit)
  set(commit unknown)
endif()
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT [[#include "bench/commit.h"

const char* const vesta::bench::kCommit = "@commit@";
]] @ONLY)
