// SPDX-License-Identifier: Apache-2.0
// Communication between the processes of one run, called ranks as in MPI. Only kernels/mpi uses MPI itself.
//
// The communicator only copies bytes. vesta computes all sums itself, in an order that does not depend on the number of
// ranks (sum_tree.h), so the number of ranks changes no bit of a result.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "kernels/core/error.h"

namespace vesta {

// Another rank failed. what() names the rank and its message: "process 2 of 4: out of memory".
class OtherRankFailed : public Error {
 public:
  explicit OtherRankFailed(const std::string& message) : Error(kUnavailable, message) {}
};

// Statistics of the data that a rank received.
struct RankTraffic {
  std::int64_t exchanges = 0;  // calls of AllGather and AllToAll
  std::int64_t bytes = 0;
  std::int64_t gathered = 0;  // part of `bytes` received by AllGather
  double seconds = 0;         // time in these calls, including the wait for other ranks
};

// AllGather and AllToAll are collective: all ranks must call them in the same order, each rank from one thread. If a
// rank has called Abandon, these calls throw OtherRankFailed on the other ranks.
class Communicator {
 public:
  using Bytes = std::span<std::byte>;
  using ConstBytes = std::span<const std::byte>;

  virtual ~Communicator() = default;
  virtual int rank() const = 0;
  virtual int size() const = 0;

  // Gathers one piece per rank. `all` has space for all pieces, in rank order. sizes: number of bytes of each piece;
  // all ranks pass the same list. On entry `all` contains this rank's piece, on return all pieces.
  void AllGather(Bytes all, std::span<const std::size_t> sizes);
  // Sends the r-th piece of `send` to rank r. The piece from rank r becomes the r-th piece of `receive`. Pieces are
  // stored one after another. Sizes are in bytes and are multiples of 4.
  void AllToAll(ConstBytes send, std::span<const std::size_t> send_sizes, Bytes receive,
                std::span<const std::size_t> receive_sizes);
  // Tells the other ranks why this rank stops. Their pending and later collective calls throw OtherRankFailed. Never
  // throws.
  virtual void Abandon(const std::string& why) noexcept = 0;
  // Whether another rank has called Abandon with the same message, for instance because all ranks miss the same file.
  // The message then need not be printed again. Waits up to half a second, except on rank 0.
  virtual bool IsReportedByOtherRank(const std::string& /*why*/) noexcept { return false; }

  const RankTraffic& traffic() const { return traffic_; }

 private:
  virtual void DoAllGather(Bytes all, std::span<const std::size_t> sizes) = 0;
  virtual void DoAllToAll(ConstBytes send, std::span<const std::size_t> send_sizes, Bytes receive,
                          std::span<const std::size_t> receive_sizes) = 0;
  // Runs exchange() and updates the statistics.
  template <class Exchange>
  void Count(std::span<const std::size_t> sizes, const Exchange& exchange);

  RankTraffic traffic_;
};

// Communicator of a single process.
class SingleRankCommunicator final : public Communicator {
 public:
  int rank() const override { return 0; }
  int size() const override { return 1; }
  void Abandon(const std::string&) noexcept override {}

 private:
  void DoAllGather(Bytes, std::span<const std::size_t>) override {}
  void DoAllToAll(ConstBytes send, std::span<const std::size_t> send_sizes, Bytes receive,
                  std::span<const std::size_t> receive_sizes) override;
};

// Whether mpirun or a similar launcher started this process. This and the next two functions read environment variables
// of launchers.
bool IsStartedInRanks();
// Number of started processes; 1 if unknown.
int NumStartedRanks();
// Number of these processes on this machine; 1 if unknown. Slurm does not say which machine this is. Under Slurm, the
// result is therefore the largest number on any machine.
int NumRanksOnThisMachine();

// The k-th of `parts` pieces of [0, count), of about equal size.
struct Share {
  std::int64_t begin, end;
  std::int64_t size() const { return end - begin; }
};
inline Share ShareOf(std::int64_t count, int parts, int k) { return {count * k / parts, count * (k + 1) / parts}; }

// Returns the values `mine` of all ranks, in rank order. Ranks may have different numbers of values. Collective, like
// the functions below.
template <class T>
std::vector<T> GatherValues(Communicator& ranks, const std::vector<T>& mine);
// The same if all ranks know counts, the number of values of each rank. On entry `all` contains this rank's values, on
// return the values of all ranks.
template <class T>
void GatherInto(Communicator& ranks, std::span<T> all, std::span<const std::size_t> counts);
// Returns one string per rank, in rank order.
std::vector<std::string> GatherStrings(Communicator& ranks, const std::string& mine);
// Logical or over all ranks.
bool OnAnyRank(Communicator& ranks, bool mine);

template <class T>
void GatherInto(Communicator& ranks, std::span<T> all, std::span<const std::size_t> counts) {
  std::vector<std::size_t> sizes(counts.begin(), counts.end());
  for (std::size_t& size : sizes) size *= sizeof(T);
  ranks.AllGather(std::as_writable_bytes(all), sizes);
}

template <class T>
std::vector<T> GatherValues(Communicator& ranks, const std::vector<T>& mine) {
  const auto size = static_cast<std::size_t>(ranks.size()), rank = static_cast<std::size_t>(ranks.rank());
  std::vector<std::size_t> counts(size);
  counts[rank] = mine.size();
  GatherInto(ranks, std::span(counts), std::vector<std::size_t>(size, 1));
  std::size_t total = 0, before = 0;
  for (std::size_t r = 0; r < size; ++r) {
    if (r < rank) before += counts[r];
    total += counts[r];
  }
  std::vector<T> all(total);
  std::copy(mine.begin(), mine.end(), all.begin() + static_cast<std::ptrdiff_t>(before));
  GatherInto(ranks, std::span(all), counts);
  return all;
}

}  // namespace vesta
