// SPDX-License-Identifier: Apache-2.0
#include "apps/cli/child_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <system_error>
#include <utility>

#include "apps/cli/process.h"
#include "kernels/core/check.h"
#include "kernels/core/schema.h"

namespace vesta::app {
namespace {

class Descriptor {
 public:
  explicit Descriptor(int value) : value_(value) {}
  ~Descriptor() { Close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return value_; }
  void Close() {
    if (value_ >= 0) ::close(std::exchange(value_, -1));
  }

 private:
  int value_;
};

int OpenForOutput(const std::string& file, int flags) {
  const int opened = ::open(file.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | flags, 0666);
  if (opened < 0) Fail(kCannotWrite, "{}: cannot be written: {}", file, std::generic_category().message(errno));
  return opened;
}

// A line for the log, as a user would type the command in a shell.
std::string Typed(const std::vector<std::string>& words) {
  constexpr const char* kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_./=:,+@%";
  std::string line = "$";
  for (const std::string& word : words) {
    if (!word.empty() && word.find_first_not_of(kPlain) == word.npos) {
      line += " " + word;
      continue;
    }
    line += " '";
    for (const char c : word) line += c == '\'' ? std::string("'\\''") : std::string(1, c);
    line += "'";
  }
  return line + "\n";
}

// In the child, between fork and exec: only functions that are safe in a signal handler.
[[noreturn]] void Execute(char* const* words, const char* folder, int input, int output, int log, int failure,
                          pid_t parent) {
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);
  // The parent may have ended before the call above.
  const bool is_ready = ::getppid() == parent && ::dup2(input, STDIN_FILENO) >= 0 &&
                        ::dup2(output, STDOUT_FILENO) >= 0 && ::dup2(log, STDERR_FILENO) >= 0 &&
                        (folder == nullptr || ::chdir(folder) == 0);
  if (is_ready) ::execv(words[0], words);
  const int error = errno;
  if (::write(failure, &error, sizeof(error)) < 0) ::_exit(126);
  ::_exit(127);
}

void SleepMilliseconds(long milliseconds) {
  const timespec time{0, milliseconds * 1'000'000};
  ::nanosleep(&time, nullptr);  // a signal ends it early
}

// A running program. The destructor ends it.
class Child {
 public:
  explicit Child(pid_t pid) : pid_(pid) {}
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child() {
    constexpr int kPatience = 250;  // of 20 ms
    if (pid_ > 0) ::kill(pid_, SIGTERM);
    for (int i = 0; i < kPatience && !HasEnded(); ++i) SleepMilliseconds(20);
    if (pid_ > 0) ::kill(pid_, SIGKILL);
    Wait(0);
  }
  bool HasEnded() {
    Wait(WNOHANG);
    return pid_ < 0;
  }
  ChildEnd end() const {
    return WIFSIGNALED(status_) ? ChildEnd{0, WTERMSIG(status_)} : ChildEnd{WEXITSTATUS(status_), 0};
  }

 private:
  void Wait(int options) {
    pid_t ended = 0;
    while (pid_ > 0 && (ended = ::waitpid(pid_, &status_, options)) < 0 && errno == EINTR) {
    }
    if (ended != 0) pid_ = -1;
  }

  pid_t pid_;
  int status_ = 0;
};

}  // namespace

std::string FindProgram(const std::string& name) {
  const char* path = std::getenv("PATH");
  for (const std::string& folder : schema::SplitAt(path ? path : "", ':')) {
    std::string file = (folder.empty() ? "." : folder) + "/" + name;
    if (::access(file.c_str(), X_OK) == 0) return file;
  }
  return {};
}

std::string RequireProgram(const std::string& name, const std::string& package, const std::string& what_for) {
  std::string program = FindProgram(name);
  if (program.empty()) {
    Fail(kUnavailable, "{}: not installed, but needed {}; install it: apt-get install --no-install-recommends {}", name,
         what_for, package);
  }
  return program;
}

ChildEnd RunChild(const ChildCommand& command, const std::function<void()>& meanwhile) {
  std::vector<std::string> words = command.words;
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const Descriptor log(OpenForOutput(command.log, O_APPEND));
  const Descriptor output(command.output.empty() ? -1 : OpenForOutput(command.output, O_TRUNC));
  const Descriptor input(::open("/dev/null", O_RDONLY | O_CLOEXEC));
  const std::string typed = Typed(words);
  if (::write(log.get(), typed.data(), typed.size()) < 0) {
    Fail(kCannotWrite, "{}: cannot be written: {}; free some space", command.log,
         std::generic_category().message(errno));
  }
  int ends[2];
  const bool has_pipe = ::pipe2(ends, O_CLOEXEC) == 0;  // exec closes it, unless exec fails
  const pid_t parent = ::getpid(), pid = has_pipe ? ::fork() : -1;
  if (pid == 0) {
    Execute(arguments.data(), command.folder.empty() ? nullptr : command.folder.c_str(), input.get(),
            output.get() < 0 ? log.get() : output.get(), log.get(), ends[1], parent);
  }
  int error = pid < 0 ? errno : 0;
  Child child(pid);
  if (has_pipe) {
    const Descriptor failure(ends[0]);
    ::close(ends[1]);
    int reported = 0;
    if (pid > 0 && ::read(failure.get(), &reported, sizeof(reported)) == sizeof(reported)) error = reported;
  }
  if (error != 0) {
    Fail(kUnavailable, "cannot run {}: {}; install it again", words[0], std::generic_category().message(error));
  }
  while (!child.HasEnded()) {
    if (Interrupted()) throw StoppedBySignal();
    if (meanwhile) meanwhile();
    SleepMilliseconds(50);
  }
  // The terminal sends Ctrl-C to both processes.
  if (Interrupted()) throw StoppedBySignal();
  return child.end();
}

std::string Describe(const ChildEnd& end) {
  if (end.signal == 0) return fmt::format("exit status {}", end.status);
  return fmt::format("signal {}{}", end.signal, end.signal == SIGKILL ? ", perhaps because the memory was full" : "");
}

void RunChildOrFail(const std::string& name, const ChildCommand& command, const std::function<void()>& meanwhile) {
  const ChildEnd end = RunChild(command, meanwhile);
  if (end.status == 0 && end.signal == 0) return;
  Fail(kUnavailable, "{} failed ({}); its messages are in {}", name, Describe(end), command.log);
}

}  // namespace vesta::app
