# SPDX-License-Identifier: Apache-2.0
# Defines the string VARIABLE, which HEADER declares, in the source OUTPUT, by the state of the folder SOURCE. Run with
# every build; the file is written only where it changes.
cmake_minimum_required(VERSION 3.25)
execute_process(COMMAND git describe --always --dirty --exclude=* WORKING_DIRECTORY ${SOURCE}
  OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(NOT commit)
  set(commit unknown)
endif()
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT [[#include "@HEADER@"

const char* const @VARIABLE@ = "@commit@";
]] @ONLY)
