// SPDX-License-Identifier: Apache-2.0
// Where the time of a run goes: wall and CPU seconds of named phases (`--profile`, LmOptions::profile).
//
// A phase that begins within another one is its child. Every second belongs to exactly one open phase, the innermost
// one, so the phases add up to the whole. The profile belongs to the thread (ProfileScope) instead of being passed to
// functions: phases begin deep in the kernels, and dozens of signatures lie between them and the program. So other
// threads, which decode photographs or serve the viewer, time nothing; their CPU seconds count in the phase that is
// open meanwhile. Phases begin on the thread that drives the run, never in the body of a parallel loop.
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

// Since some moment in the past; cpu: of all threads of the process.
struct PhaseSeconds {
  double wall = 0, cpu = 0;
  PhaseSeconds& operator+=(const PhaseSeconds& other) {
    wall += other.wall, cpu += other.cpu;
    return *this;
  }
};
PhaseSeconds ReadClocks();
// For work in a memory space. A GPU first ends the work it has, so that phases have the time of kernels instead of that
// of their launches; this costs time.
template <class Space>
PhaseSeconds ReadClocksOf() {
  if constexpr (std::is_same_v<Space, Device>) {
    try {
      device::Synchronize();
    } catch (const Error&) {  // the next call that waits for the GPU reports it
    }
  }
  return ReadClocks();
}

struct PhaseRow {
  std::string name;
  int depth = 0;           // 0: the whole; the rows of depth d + 1 beneath a row of depth d add up to it
  std::int64_t calls = 0;  // 0: the row "other", time of the parent that no phase within it has
  PhaseSeconds seconds;    // phases within it included
};

class Profile {
 public:
  using Clock = std::function<PhaseSeconds()>;
  explicit Profile(Clock clock = ReadClocks) : clock_(std::move(clock)) {}

  // Of the calling thread; null: nothing is timed.
  static Profile* Current() { return current_; }

  // name: a string literal.
  void Begin(const char* name);
  void End();
  // Up to now. Each parent comes before its phases, which come by falling wall time; phases with less than this share
  // of the whole wall time count as "other".
  std::vector<PhaseRow> Rows(double least_share = 0.005);

 private:
  friend class ProfileScope;
  struct Phase {
    const char* name;
    int parent;  // -1: the whole
    std::int64_t calls = 0;
    PhaseSeconds own = {};  // phases within it excluded
  };
  // Adds the time since the last call to the open phase.
  void Charge();

  static inline constinit thread_local Profile* current_ = nullptr;
  Clock clock_;
  std::vector<Phase> phases_;  // parents before children
  int open_ = -1;
  PhaseSeconds last_;
};

// The rows as a table for people, a line each.
std::string ProfileTable(const std::vector<PhaseRow>& rows);

// During its life the profile times this thread, as the phase "total". Null: whatever times the thread goes on.
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

// A phase lasts as long as this object. Without a profile it only tests a pointer.
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
  // Ends the phase and begins another one in its place.
  void Next(const char* name) {
    if (profile_) profile_->End(), profile_->Begin(name);
  }

 private:
  Profile* profile_;
};

}  // namespace vesta
