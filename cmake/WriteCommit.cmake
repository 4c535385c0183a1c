# SPDX-License-Identifier: Apache-2.0
# Writes the source OUTPUT, which defines the string VARIABLE declared in HEADER as the git commit of the folder SOURCE.
# Runs with every build; writes only changes.
cmake_minimum_required(VERSION 3.25)
execute_process(COMMAND git describe --always --dirty --exclude=* WORKING_DIRECTORY ${SOURCE}
  OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(NOT commit)
  set(commit unknown)
endif()
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT [[#include "@HEADER@"

const char* const @VARIABLE@ = "@commit@";
]] @ONLY)
