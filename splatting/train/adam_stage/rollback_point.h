// SPDX-License-Identifier: Apache-2.0
// The state of the Adam stage before its Gaussians last became more: what it goes back to where a GPU runs out of
// memory.
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

// A copy in memory of a state that is an archive's (kernels/core/archive.h), whose arrays lie in the memory of a
// device.
// Its arrays stay in the memory of the device where there is room for a second one of each, else they go to the host
// with the rest.
template <class Space>
class StateSnapshot {
 public:
  StateSnapshot() = default;
  // Throws OutOfDeviceMemory where the arrays are to stay on the device and do not fit.
  template <class State>
  StateSnapshot(State& state, bool on_device) : on_device_(on_device) {
    Writer writer(*this);
    writer(state);
  }
  bool empty() const { return bytes_.empty(); }

  // Bytes of a state's arrays in the memory of the device.
  template <class State>
  static double ArrayBytes(State& state) {
    Counter counter;
    counter(state);
    return counter.bytes;
  }

  // Gives it back; array by array the copy is freed.
  template <class State>
  void MoveTo(State& state) {
    Reader reader(*this);
    reader(state);
    *this = StateSnapshot();
  }

 private:
  template <class T>
  using Array = Buffer<T, Space>;

  // Visits members down to the arrays of the device, and leaves all else to `other`.
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
    explicit Writer(StateSnapshot& kept)
        : kept_(kept), archive_([&kept](std::string_view bytes) { kept.bytes_.append(bytes); }) {}
    template <class... Ts>
    void operator()(Ts&... values) {
      (Dispatch(
           *this, values, [&](auto& array) { Write(array); }, [&](auto& value) { archive_(value); }),
       ...);
    }

   private:
    template <class T>
    void Write(Array<T>& array) {
      if (!kept_.on_device_) return archive_(array);
      Index size = array.size();
      archive_(size);
      const auto* first = reinterpret_cast<const unsigned char*>(array.data());
      const Span<const unsigned char, Space> all(first, size * static_cast<Index>(sizeof(T)));
      kept_.arrays_.emplace_back().CopyFrom(all);
    }

    StateSnapshot& kept_;
    ArchiveWriter archive_;
  };

  class Reader {
   public:
    static constexpr bool kReads = true;
    explicit Reader(StateSnapshot& kept) : kept_(kept), archive_(kept.bytes_) {}
    template <class... Ts>
    void operator()(Ts&... values) {
      (Dispatch(
           *this, values, [&](auto& array) { Read(array); }, [&](auto& value) { archive_(value); }),
       ...);
    }

   private:
    template <class T>
    void Read(Array<T>& array) {
      if (!kept_.on_device_) return archive_(array);
      Index size = 0;
      archive_(size);
      array = Array<T>();
      Array<unsigned char> bytes = std::move(kept_.arrays_[next_++]);
      array.CopyFrom(Span<const T, Space>(reinterpret_cast<const T*>(bytes.data()), size));
    }

    StateSnapshot& kept_;
    ArchiveReader archive_;
    std::size_t next_ = 0;
  };

  bool on_device_ = false;
  std::string bytes_;
  std::vector<Array<unsigned char>> arrays_;
};

// The state of the Adam stage before its Gaussians last became more: what it goes back to where the memory of a device
// does not suffice for those.
template <class B>
class RollbackPoint {
 public:
  explicit RollbackPoint(TrainingSession& session) : session_(session) {}

  bool empty() const { return kept_.empty(); }
  // On the GPU as long as that takes no room from what was planned for there.
  void Keep(AdamStageState<B>& state) {
    kept_ = Kept();
    iteration_ = state.iteration;
    const double bytes = Kept::ArrayBytes(state);
    if (bytes <= session_.memory().spare_device_bytes()) {
      try {
        kept_ = Kept(state, true);
        session_.memory().NoteKeptOnDevice(bytes);
        return;
      } catch (const OutOfDeviceMemory&) {  // less is free than was
      }
    }
    kept_ = Kept(state, false);
  }
  void Forget() { kept_ = Kept(); }
  // Once every view has been through with the Gaussians there are, there is room for them.
  void ForgetWhatHolds(int iteration) {
    const auto seen =
        static_cast<std::size_t>(iteration - iteration_) * static_cast<std::size_t>(session_.options().adam.batch_size);
    if (!empty() && seen >= 2 * session_.training_views().size()) Forget();
  }
  // Puts it back; the Gaussians stay as many from then on. Needs what was kept.
  void GoBack(AdamStageState<B>* state) {
    state->model.Free();
    // Cameras stay where they were found since, and with them what was learned of them.
    StageCamerasState cameras = std::move(state->cameras);
    kept_.MoveTo(*state);
    state->cameras = std::move(cameras);
    state->model.StayAsMany();
  }

 private:
  using Kept = StateSnapshot<typename B::Space>;

  TrainingSession& session_;
  Kept kept_;
  int iteration_ = 0;  // that it is of
};

}  // namespace vesta::gs
