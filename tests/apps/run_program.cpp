// SPDX-License-Identifier: Apache-2.0
#include "tests/apps/run_program.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <stdexcept>

namespace vesta::test {

Program::Program(const std::vector<std::string>& arguments) {
  std::vector<std::string> words = {VESTA_PROGRAM};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  const std::string out = folder_ / "out", err = folder_ / "err";
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out.c_str(), O_WRONLY | O_CREAT, 0600);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, err.c_str(), O_WRONLY | O_CREAT, 0600);
  // The program must not inherit an ignored SIGHUP, as under nohup.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t hangup;
  sigemptyset(&hangup);
  sigaddset(&hangup, SIGHUP);
  posix_spawnattr_setsigdefault(&attributes, &hangup);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);
  const int error = ::posix_spawn(&pid_, VESTA_PROGRAM, &actions, &attributes, argv.data(), ::environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) throw std::runtime_error(std::string(VESTA_PROGRAM) + " cannot be started");
}

bool Program::HasEnded() {
  if (!ended_) ended_ = ::waitpid(pid_, &wait_status_, WNOHANG) == pid_;
  return ended_;
}

bool Program::WaitForOutput(const std::string& text) {
  constexpr int kPolls = 12000;
  for (int i = 0; i < kPolls; ++i) {
    const bool ended = HasEnded();
    if (ReadBytes(folder_ / "out").find(text) != std::string::npos) return !ended;
    if (ended) return false;
    ::usleep(5000);
  }
  return false;
}

void Program::Signal(int number) const { ::kill(pid_, number); }

ProgramOutput Program::Wait() {
  if (!ended_) ::waitpid(pid_, &wait_status_, 0);
  ended_ = true;
  const int status = WIFEXITED(wait_status_) ? WEXITSTATUS(wait_status_) : 128 + WTERMSIG(wait_status_);
  return {status, ReadBytes(folder_ / "out"), ReadBytes(folder_ / "err")};
}

ProgramOutput RunProgram(const std::vector<std::string>& arguments) { return Program(arguments).Wait(); }

ProgramOutput RunShell(const std::string& command) {
  ProgramOutput output;
  FILE* pipe = popen(command.c_str(), "r");
  if (!pipe) return output;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) output.out += static_cast<char>(c);
  const int status = pclose(pipe);
  output.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return output;
}

int CountLines(const std::string& text) { return static_cast<int>(std::count(text.begin(), text.end(), '\n')); }

std::vector<std::string> FilesIn(const std::string& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    names.push_back(entry.path().filename().string());
  }
  return names;
}

}  // namespace vesta::test
