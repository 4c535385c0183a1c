// SPDX-License-Identifier: Apache-2.0
// A copy of the Adam stage's state before its last densification, for a GPU that runs out of memory.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "kernels/core/archive.h"
#include "kernels/core/buffer.h"
#include "kernels/core/device_memory.h"
#include "splatting/train/adam_stage/trained_model.h"
#include "splatting/train/session/session.h"

namespace vesta::gs {

// A copy of an object with arrays in device memory and a Visit function (kernels/core/archive.h). The arrays are copied
// within the device or to the host, other members to the host.
template <class Space>
class StateSnapshot {
 public:
  StateSnapshot() = default;
  // Throws OutOfDeviceMemory if on_device is set and the arrays do not fit.
  template <class State>
  StateSnapshot(State& state, bool on_device) : on_device_(on_device) {
    Writer writer(*this);
    writer(state);
  }
  bool empty() const { return bytes_.empty(); }

  // Bytes of a state's device arrays.
  template <class State>
  static double ArrayBytes(State& state) {
    Counter counter;
    counter(state);
    return counter.bytes;
  }

  // Restores `state` from the copy, which is empty afterwards. Frees each array's copy as soon as possible.
  template <class State>
  void MoveTo(State& state) {
    Reader reader(*this);
    reader(state);
    *this = StateSnapshot();
  }

 private:
  template <class T>
  using Array = Buffer<T, Space>;

  // Calls on_array for each device array in `value`, including its members' arrays, and `other` for all other members.
  template <class OnArray, class Other, class Archive, class T>
  static void Dispatch(Archive& archive, T& value, const OnArray& on_array, const Other& other) {
    if constexpr (requires { value.Visit(archive); }) {
      value.Visit(archive);
    } else if constexpr (requires { IsArray(value); }) {
      on_array(value);
    } else {
      other(value);
    }
  }
  template <class T>
  static void IsArray(Array<T>&);

  struct Counter {
    static constexpr bool kReads = false;
    double bytes = 0;
    template <class... Ts>
    void operator()(Ts&... values) {
      (Dispatch(
           *this, values, [&]<class T>(Array<T>& array) { bytes += static_cast<double>(array.size()) * sizeof(T); },
           [](auto&) {}),
       ...);
    }
  };

  class Writer {
   public:
    static constexpr bool kReads = false;
    explicit Writer(StateSnapshot& snapshot)
        : snapshot_(snapshot), archive_([&snapshot](std::string_view bytes) { snapshot.bytes_.append(bytes); }) {}
    template <class... Ts>
    void operator()(Ts&... values) {
      (Dispatch(
           *this, values, [&](auto& array) { Write(array); }, [&](auto& value) { archive_(value); }),
       ...);
    }

   private:
    template <class T>
    void Write(Array<T>& array) {
      if (!snapshot_.on_device_) return archive_(array);
      Index size = array.size();
      archive_(size);
      const auto* first = reinterpret_cast<const unsigned char*>(array.data());
      const Span<const unsigned char, Space> all(first, size * static_cast<Index>(sizeof(T)));
      snapshot_.arrays_.emplace_back().CopyFrom(all);
    }

    StateSnapshot& snapshot_;
    ArchiveWriter archive_;
  };

  class Reader {
   public:
    static constexpr bool kReads = true;
    explicit Reader(StateSnapshot& snapshot) : snapshot_(snapshot), archive_(snapshot.bytes_) {}
    template <class... Ts>
    void operator()(Ts&... values) {
      (Dispatch(
           *this, values, [&](auto& array) { Read(array); }, [&](auto& value) { archive_(value); }),
       ...);
    }

   private:
    template <class T>
    void Read(Array<T>& array) {
      if (!snapshot_.on_device_) return archive_(array);
      Index size = 0;
      archive_(size);
      array = Array<T>();
      Array<unsigned char> bytes = std::move(snapshot_.arrays_[next_++]);
      array.CopyFrom(Span<const T, Space>(reinterpret_cast<const T*>(bytes.data()), size));
    }

    StateSnapshot& snapshot_;
    ArchiveReader archive_;
    std::size_t next_ = 0;
  };

  bool on_device_ = false;
  std::string bytes_;
  std::vector<Array<unsigned char>> arrays_;
};

// The state of the Adam stage before the last densification that added Gaussians.
template <class B>
class RollbackPoint {
 public:
  explicit RollbackPoint(TrainingSession& session) : session_(session) {}

  bool empty() const { return snapshot_.empty(); }
  // Replaces the copy. The new copy is on the GPU if it fits there in addition to the planned memory of the stage, else
  // on the host.
  void Store(AdamStageState<B>& state) {
    snapshot_ = Snapshot();
    iteration_ = state.iteration;
    const double bytes = Snapshot::ArrayBytes(state);
    if (bytes <= session_.memory().spare_device_bytes()) {
      try {
        snapshot_ = Snapshot(state, true);
        session_.memory().NoteDeviceSnapshot(bytes);
        return;
      } catch (const OutOfDeviceMemory&) {  // less memory is free than planned
      }
    }
    snapshot_ = Snapshot(state, false);
  }
  void Discard() { snapshot_ = Snapshot(); }
  // Discards the copy after two passes over all views, which show that the memory suffices.
  void DropSnapshotIfMemoryLasts(int iteration) {
    const auto seen =
        static_cast<std::size_t>(iteration - iteration_) * static_cast<std::size_t>(session_.options().adam.batch_size);
    if (!empty() && seen >= 2 * session_.training_views().size()) Discard();
  }
  // Restores the copy, which must exist, and stops growth.
  void Restore(AdamStageState<B>* state) {
    state->model.Free();
    // Cameras keep their current state.
    StageCamerasState cameras = std::move(state->cameras);
    snapshot_.MoveTo(*state);
    state->cameras = std::move(cameras);
    state->model.LimitToCurrentCount();
  }

 private:
  using Snapshot = StateSnapshot<typename B::Space>;

  TrainingSession& session_;
  Snapshot snapshot_;
  int iteration_ = 0;  // iteration of the copied state
};

}  // namespace vesta::gs
