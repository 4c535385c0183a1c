#include "bench/solver_race/race.h"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <exception>
#include <limits>

#include "kernels/core/check.h"

namespace vesta::bench {

double Run::SecondsTo(double cost) const {
  for (const Moment& moment : moments) {
    if (moment.cost <= cost) return moment.seconds;
  }
  return std::numeric_limits<double>::infinity();
}

namespace {

bool WriteAll(int file, const void* data, std::size_t bytes) {
  const char* at = static_cast<const char*>(data);
  while (bytes > 0) {
    const ssize_t written = write(file, at, bytes);
    if (written <= 0) return false;
    at += written;
    bytes -= static_cast<std::size_t>(written);
  }
  return true;
}

[[noreturn]] void Child(const Contender& contender, int out) {
  int status = 1;
  try {
    const std::vector<Moment> moments = contender.run();
    if (WriteAll(out, moments.data(), moments.size() * sizeof(Moment))) status = 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", contender.name.c_str(), error.what());
  }
  close(out);
  // No destructors: threads of this process may still be parked.
  _exit(status);
}

}  // namespace

Run RunAlone(const Contender& contender) {
  int ends[2];
  if (pipe(ends) != 0) Fail("no pipe for a child process");
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child < 0) Fail("no child process could be made");
  if (child == 0) {
    close(ends[0]);
    Child(contender, ends[1]);
  }
  close(ends[1]);
  Run run;
  Moment moment;
  char* const at = reinterpret_cast<char*>(&moment);
  std::size_t have = 0;
  for (ssize_t got = 0; (got = read(ends[0], at + have, sizeof(Moment) - have)) > 0;) {
    have += static_cast<std::size_t>(got);
    if (have < sizeof(Moment)) continue;
    run.moments.push_back(moment);
    have = 0;
  }
  close(ends[0]);
  int status = 0;
  rusage usage{};
  wait4(child, &status, 0, &usage);
  run.failed = !WIFEXITED(status) || WEXITSTATUS(status) != 0 || run.moments.empty();
  run.peak_mib = static_cast<double>(usage.ru_maxrss) / 1024;
  return run;
}

}  // namespace vesta::bench
