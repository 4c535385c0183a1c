// SPDX-License-Identifier: Apache-2.0
#include "kernels/mpi/mpi_communicator.h"

#include <fmt/format.h>
#include <mpi.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <climits>
#include <cstring>
#include <span>
#include <thread>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/core/cpu_dispatch.h"

namespace vesta {
namespace {

// Message that a rank sends when it stops.
constexpr int kAbandonTag = 1;
constexpr std::size_t kMessageBytes = 2000;
using Message = std::array<char, kMessageBytes>;

void CheckMpi(int code, const char* what) {
  if (code == MPI_SUCCESS) return;
  std::array<char, MPI_MAX_ERROR_STRING> text{};
  int length = 0;
  MPI_Error_string(code, text.data(), &length);
  Fail(kUnavailable, "MPI failed in {}: {}", what, std::string(text.data(), static_cast<std::size_t>(length)));
}

// MPI counts in int. If possible the unit is four bytes.
struct Units {
  MPI_Datatype type = MPI_BYTE;
  std::size_t bytes = 1;
};
Units UnitsOf(std::span<const std::size_t> sizes) {
  const bool in_words = std::all_of(sizes.begin(), sizes.end(), [](std::size_t size) { return size % 4 == 0; });
  return in_words ? Units{MPI_UINT32_T, 4} : Units{};
}

// Counts and displacements of consecutive pieces.
struct Pieces {
  Pieces(std::span<const std::size_t> sizes, const Units& units) {
    counts.reserve(sizes.size());
    offsets.reserve(sizes.size());
    std::size_t at = 0;
    for (const std::size_t size : sizes) {
      counts.push_back(Count(size / units.bytes));
      offsets.push_back(Count(at / units.bytes));
      at += size;
    }
  }
  static int Count(std::size_t count) {
    if (count > INT_MAX)
      Fail(kUnsupported, "a message of {} values between processes exceeds MPI's limit of {}: the problem is too large",
           count, INT_MAX);
    return static_cast<int>(count);
  }
  std::vector<int> counts, offsets;
};

class MpiCommunicator final : public Communicator {
 public:
  explicit MpiCommunicator(const MpiOptions& options) : options_(options) {
    int provided = 0;
    CheckMpi(MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided), "MPI_Init_thread");
    if (provided < MPI_THREAD_FUNNELED)
      Fail(kUnavailable, "this MPI library does not support programs with several threads; use another one");
    MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_RETURN);
    // Abandon messages have their own communicator, so they never match other messages.
    CheckMpi(MPI_Comm_dup(MPI_COMM_WORLD, &abandon_comm_), "MPI_Comm_dup");
    MPI_Comm_set_errhandler(abandon_comm_, MPI_ERRORS_RETURN);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &size_);
    CheckMpi(
        MPI_Irecv(message_.data(), kMessageBytes, MPI_CHAR, MPI_ANY_SOURCE, kAbandonTag, abandon_comm_, &abandoned_by_),
        "MPI_Irecv");
  }
  ~MpiCommunicator() override {
    if (is_abandoned_) return;  // MPI_Finalize would not return while other ranks wait in a call
    MPI_Cancel(&abandoned_by_);
    MPI_Wait(&abandoned_by_, MPI_STATUS_IGNORE);
    MPI_Comm_free(&abandon_comm_);
    MPI_Finalize();
  }
  MpiCommunicator(const MpiCommunicator&) = delete;
  MpiCommunicator& operator=(const MpiCommunicator&) = delete;

  int rank() const override { return rank_; }
  int size() const override { return size_; }

  void Abandon(const std::string& why) noexcept override {
    if (is_abandoned_) return;
    is_abandoned_ = true;
    const Message message = MessageOf(why);
    std::vector<MPI_Request> sends(static_cast<std::size_t>(size_), MPI_REQUEST_NULL);
    for (int r = 0; r < size_; ++r) {
      if (r == rank_) continue;
      MPI_Isend(message.data(), kMessageBytes, MPI_CHAR, r, kAbandonTag, abandon_comm_,
                &sends[static_cast<std::size_t>(r)]);
    }
    // Ranks that have died never receive the message.
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(5);
    for (int done = 0; done == 0 && std::chrono::steady_clock::now() < deadline;) {
      if (MPI_Testall(size_, sends.data(), &done, MPI_STATUSES_IGNORE) != MPI_SUCCESS) break;
      std::this_thread::sleep_for(std::chrono::microseconds(100));
    }
  }
  bool IsReportedByOtherRank(const std::string& why) noexcept override {
    if (rank_ == 0 || is_abandoned_) return is_abandoned_;
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::milliseconds(500);
    while (std::chrono::steady_clock::now() < deadline) {
      int arrived = 0;
      if (MPI_Test(&abandoned_by_, &arrived, MPI_STATUS_IGNORE) != MPI_SUCCESS) return false;
      if (arrived != 0) {
        is_abandoned_ = true;
        return message_ == MessageOf(why);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return false;
  }

 private:
  static Message MessageOf(const std::string& why) noexcept {
    Message message{};
    std::memcpy(message.data(), why.data(), std::min(why.size(), kMessageBytes - 1));
    return message;
  }
  void DoAllGather(Bytes all, std::span<const std::size_t> sizes) override {
    const Units units = UnitsOf(sizes);
    const Pieces pieces(sizes, units);
    MPI_Request request = MPI_REQUEST_NULL;
    CheckMpi(MPI_Iallgatherv(MPI_IN_PLACE, 0, MPI_DATATYPE_NULL, all.data(), pieces.counts.data(),
                             pieces.offsets.data(), units.type, MPI_COMM_WORLD, &request),
             "MPI_Iallgatherv");
    Wait(request);
  }
  void DoAllToAll(ConstBytes send, std::span<const std::size_t> send_sizes, Bytes receive,
                  std::span<const std::size_t> receive_sizes) override {
    const Units units{MPI_UINT32_T, 4};
    const Pieces to(send_sizes, units), from(receive_sizes, units);
    MPI_Request request = MPI_REQUEST_NULL;
    CheckMpi(MPI_Ialltoallv(send.data(), to.counts.data(), to.offsets.data(), units.type, receive.data(),
                            from.counts.data(), from.offsets.data(), units.type, MPI_COMM_WORLD, &request),
             "MPI_Ialltoallv");
    Wait(request);
  }

  // Waits until the request is complete; throws if a rank abandoned the others. Leaves the CPU to computing ranks.
  void Wait(MPI_Request request) {
    using Clock = std::chrono::steady_clock;
    constexpr int kBusyPolls = 2000;
    const auto start = Clock::now();
    bool is_warned = false;
    for (int polls = 0;;) {
      int done = 0;
      CheckMpi(MPI_Test(&request, &done, MPI_STATUS_IGNORE), "MPI_Test");
      if (done != 0) return;
      ThrowIfAbandoned();
      if (polls < kBusyPolls) {
        ++polls;
        std::this_thread::yield();
        continue;
      }
      std::this_thread::sleep_for(std::chrono::microseconds(20));
      const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
      if (!is_warned && options_.warn != nullptr && seconds > options_.warn_after) {
        is_warned = true;
        options_.warn(fmt::format("process {} of {} has waited {:.0f} s for the others", rank_, size_, seconds));
      }
    }
  }
  void ThrowIfAbandoned() {
    int arrived = 0;
    MPI_Status status;
    CheckMpi(MPI_Test(&abandoned_by_, &arrived, &status), "MPI_Test");
    if (arrived == 0) return;
    is_abandoned_ = true;
    throw OtherRankFailed(fmt::format("process {} of {}: {}", status.MPI_SOURCE, size_, message_.data()));
  }

  MpiOptions options_;
  int rank_ = 0, size_ = 1;
  MPI_Comm abandon_comm_ = MPI_COMM_NULL;
  MPI_Request abandoned_by_ = MPI_REQUEST_NULL;
  Message message_{};
  bool is_abandoned_ = false;
};

void CheckSameInstructions(Communicator& ranks) {
  const std::vector<std::string> names = GatherStrings(ranks, IsaName(ActiveIsa()));
  for (std::size_t r = 1; r < names.size(); ++r) {
    if (names[r] != names[0]) {
      Fail(kUnavailable,
           "process 0 runs {} and process {} {}: their results would differ; set VESTA_SIMD to an instruction set of "
           "all machines",
           names[0], r, names[r]);
    }
  }
}

}  // namespace

std::unique_ptr<Communicator> StartMpi(const MpiOptions& options) {
  auto ranks = std::make_unique<MpiCommunicator>(options);
  CheckSameInstructions(*ranks);
  return ranks;
}

}  // namespace vesta
