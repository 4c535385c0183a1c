// SPDX-License-Identifier: Apache-2.0
#include "apps/cli/process.h"

#include <fcntl.h>
#include <unistd.h>

#include <chrono>
#include <csignal>

namespace vesta::app {

double SecondsSinceStart() {
  using Clock = std::chrono::steady_clock;
  static const Clock::time_point start = Clock::now();
  return std::chrono::duration<double>(Clock::now() - start).count();
}

namespace {

volatile std::sig_atomic_t interrupted = 0;
std::string_view interrupt_message;  // set before the handler is installed

// Async-signal-safe: no allocation, no stdio.
void Note(int signal) {
  interrupted = 1;
  if (signal != SIGINT) return;
  if (write(STDERR_FILENO, interrupt_message.data(), interrupt_message.size()) < 0) return;  // no stderr
}

// The reader of stdout has gone: discards further output, so that the run can still write results.
void DropOutput(int) {
  const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (nowhere >= 0) dup2(nowhere, STDOUT_FILENO);
}

void Catch(int signal, void (*handler)(int), int flags) {
  struct sigaction action = {};
  action.sa_handler = handler;
  action.sa_flags = flags | SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(signal, &action, nullptr);
}

bool IsIgnored(int signal) {
  struct sigaction action = {};
  sigaction(signal, nullptr, &action);
  return action.sa_handler == SIG_IGN;
}

}  // namespace

void CatchInterrupts(std::string_view message) {
  interrupt_message = message;
  const int once = static_cast<int>(SA_RESETHAND);
  Catch(SIGINT, Note, once);
  Catch(SIGTERM, Note, once);
  if (!IsIgnored(SIGHUP)) Catch(SIGHUP, Note, once);  // nohup ignores SIGHUP
  Catch(SIGPIPE, DropOutput, 0);
}

bool Interrupted() { return interrupted != 0; }

}  // namespace vesta::app
