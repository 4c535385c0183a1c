// SPDX-License-Identifier: Apache-2.0
// Profiler: wall and CPU seconds of named phases of a run (`--profile`, LmOptions::profile).
//
// A phase that begins within another one is its child. Every second belongs to exactly one phase, the innermost open
// one, so the phases add up to the whole. Phases begin deep in the kernels, so each thread has a current profile
// (ProfileScope) and functions do not pass it on. Threads without a profile, which decode photographs or serve the
// viewer, record no phases. Their CPU seconds are added to the phase that the run has open at that time. Phases begin
// on the main thread of the run, never in the body of a parallel loop.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "kernels/core/device_memory.h"
#include "kernels/core/span.h"

namespace vesta {

// Clock readings, or their differences, in seconds. cpu: sum over all threads of the process.
struct PhaseSeconds {
  double wall = 0, cpu = 0;
  PhaseSeconds& operator+=(const PhaseSeconds& other) {
    wall += other.wall, cpu += other.cpu;
    return *this;
  }
};
PhaseSeconds ReadClocks();
// Reads the clocks for work in a memory space. On a GPU it first waits for pending work, so that a phase includes its
// kernels. This slows the run down.
template <class Space>
PhaseSeconds ReadClocksOf() {
  if constexpr (std::is_same_v<Space, Device>) {
    try {
      device::Synchronize();
    } catch (const Error&) {  // reported by the next call that waits for the GPU
    }
  }
  return ReadClocks();
}

struct PhaseRow {
  std::string name;
  int depth = 0;           // 0: the whole run; a row of depth d is the sum of the rows of depth d + 1 below it
  std::int64_t calls = 0;  // 0: the row "other", the time of the parent outside its listed phases
  PhaseSeconds seconds;    // including its child phases
};

class Profile {
 public:
  using Clock = std::function<PhaseSeconds()>;
  explicit Profile(Clock clock = ReadClocks) : clock_(std::move(clock)) {}

  // The profile of the calling thread; null without one.
  static Profile* Current() { return current_; }

  // Begins a phase within the open phase, or continues an earlier one of the same name there. name: a string literal.
  void Begin(const char* name);
  // Ends the open phase. Its parent is then open again.
  void End();
  // Returns the times until now. Each parent precedes its child phases, which are sorted by decreasing wall time.
  // Phases whose fraction of the total wall time is below least_share are combined in "other".
  std::vector<PhaseRow> Rows(double least_share = 0.005);

 private:
  friend class ProfileScope;
  struct Phase {
    const char* name;
    int parent;  // -1: the whole run
    std::int64_t calls = 0;
    PhaseSeconds own = {};  // excluding child phases
  };
  // Adds the time since the last call to the open phase.
  void AddElapsed();

  static inline constinit thread_local Profile* current_ = nullptr;
  Clock clock_;
  std::vector<Phase> phases_;  // parents before children
  int open_ = -1;
  PhaseSeconds last_;
};

// Formats the rows as a table, one line each.
std::string ProfileTable(const std::vector<PhaseRow>& rows);

// While this object exists, `profile` is the profile of the current thread, and its phase "total" is open. If `profile`
// is null, the thread's existing profile continues.
class ProfileScope {
 public:
  explicit ProfileScope(Profile* profile) : profile_(profile), before_(Profile::current_) {
    if (profile_) Profile::current_ = profile_, profile_->Begin("total");
  }
  ~ProfileScope() {
    if (profile_) profile_->End(), Profile::current_ = before_;
  }
  ProfileScope(const ProfileScope&) = delete;
  ProfileScope& operator=(const ProfileScope&) = delete;

 private:
  Profile *profile_, *before_;
};

// A phase that ends with this object. Does nothing if the thread has no profile.
class ScopedPhase {
 public:
  explicit ScopedPhase(const char* name) : profile_(Profile::Current()) {
    if (profile_) profile_->Begin(name);
  }
  ~ScopedPhase() {
    if (profile_) profile_->End();
  }
  ScopedPhase(const ScopedPhase&) = delete;
  ScopedPhase& operator=(const ScopedPhase&) = delete;
  // Ends the phase and begins another one.
  void Next(const char* name) {
    if (profile_) profile_->End(), profile_->Begin(name);
  }

 private:
  Profile* profile_;
};

}  // namespace vesta
