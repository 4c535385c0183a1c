// SPDX-License-Identifier: Apache-2.0
// Runs other programs: without a shell, with their output in a file. They end when this process ends.
#pragma once

#include <exception>
#include <functional>
#include <string>
#include <vector>

namespace vesta::app {

// The program's file on PATH, or empty.
std::string FindProgram(const std::string& name);

// FindProgram, or Error with the Debian package to install. what_for: "for films", for the message.
std::string RequireProgram(const std::string& name, const std::string& package, const std::string& what_for);

struct ChildCommand {
  std::vector<std::string> words;  // words[0]: file of the program
  std::string log;                 // receives the command and all output of the program; appended
  std::string output = {};         // unless empty, receives stdout instead of `log`; replaced
  std::string folder = {};         // working folder of the program; empty: that of this process
};

struct ChildEnd {
  int status = 0;  // exit status
  int signal = 0;  // number of the signal that ended the program; 0: none
};

// Thrown by RunChild after a signal to this process (Interrupted).
class StoppedBySignal : public std::exception {
 public:
  const char* what() const noexcept override { return "stopped by a signal"; }
};

// Waits until the program ends, and calls `meanwhile` about 20 times per second. If Interrupted(), or if `meanwhile`
// throws, ends the program first. Throws Error if the program cannot be started or a file cannot be written.
ChildEnd RunChild(const ChildCommand& command, const std::function<void()>& meanwhile = {});

// "exit status 3" or "signal 9, ...", for messages.
std::string Describe(const ChildEnd& end);

// RunChild, and Error with the name of the program and the log unless the exit status is 0. name: for the message.
void RunChildOrFail(const std::string& name, const ChildCommand& command, const std::function<void()>& meanwhile = {});

}  // namespace vesta::app
