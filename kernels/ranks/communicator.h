// SPDX-License-Identifier: Apache-2.0
// Processes that work on one task together, each its part: MPI's ranks, as the rest of vesta sees them.
//
// What is asked of them only moves bytes. Sums are formed by vesta itself, in an order that does not depend on how many
// ranks there are (sum_tree.h), and so all results are the same bits for any number of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "kernels/core/error.h"

namespace vesta {

// What calls throw where another rank gave up: its words, "process 2 of 4: no room".
class OthersGaveUp : public Error {
 public:
  explicit OthersGaveUp(const std::string& words) : Error(kUnavailable, words) {}
};

// What a rank has received from others.
struct RankTraffic {
  std::int64_t exchanges = 0;  // calls of AllGather and AllToAll
  std::int64_t bytes = 0;
  std::int64_t gathered = 0;  // of these bytes, by AllGather
  double seconds = 0;         // in these calls, waiting for others among them
};

// All ranks call the same functions in the same order, each from one thread. Where a rank has called Abandon, or is
// gone, the others' calls throw OthersGaveUp with its words.
class Communicator {
 public:
  using Bytes = std::span<std::byte>;
  using ConstBytes = std::span<const std::byte>;

  virtual ~Communicator() = default;
  virtual int rank() const = 0;
  virtual int size() const = 0;

  // all: the pieces of all ranks one after another, of the sizes given (the same on all ranks); that of this rank is
  // filled in, the others become those of their ranks.
  void AllGather(Bytes all, std::span<const std::size_t> sizes);
  // Sends rank r the r-th piece of `send`, and receives its piece for this rank as the r-th of `receive`. All
  // sizes are multiples of 4 bytes.
  void AllToAll(ConstBytes send, std::span<const std::size_t> send_sizes, Bytes receive,
                std::span<const std::size_t> receive_sizes);
  // Says why this rank goes on no more. The others' pending and later calls throw OthersGaveUp. Never throws.
  virtual void Abandon(const std::string& why) noexcept = 0;
  // Whether another rank has just abandoned this one with the same words, as where all find the same file missing: then
  // it need not be said again. Waits for it half a second, but for the first rank.
  virtual bool IsKnown(const std::string& /*why*/) noexcept { return false; }

  const RankTraffic& traffic() const { return traffic_; }

 private:
  virtual void DoAllGather(Bytes all, std::span<const std::size_t> sizes) = 0;
  virtual void DoAllToAll(ConstBytes send, std::span<const std::size_t> send_sizes, Bytes receive,
                          std::span<const std::size_t> receive_sizes) = 0;
  // Counts what exchange() receives, pieces of such sizes.
  template <class Exchange>
  void Count(std::span<const std::size_t> sizes, const Exchange& exchange);

  RankTraffic traffic_;
};

// One process alone.
class SoloRank final : public Communicator {
 public:
  int rank() const override { return 0; }
  int size() const override { return 1; }
  void Abandon(const std::string&) noexcept override {}

 private:
  void DoAllGather(Bytes, std::span<const std::size_t>) override {}
  void DoAllToAll(ConstBytes send, std::span<const std::size_t> send_sizes, Bytes receive,
                  std::span<const std::size_t> receive_sizes) override;
};

// Whether mpirun or alike started this process, by the environment that it gives its processes; how many it started, as
// far as that says so; and how many of them run on this machine, 1 where it does not say, the most on any where it does
// not say of which.
bool IsStartedInRanks();
int NumStartedRanks();
int NumRanksOnThisMachine();

// The k-th of `parts` pieces of [0, count), all of about the same size.
struct Share {
  std::int64_t begin, end;
  std::int64_t size() const { return end - begin; }
};
inline Share ShareOf(std::int64_t count, int parts, int k) { return {count * k / parts, count * (k + 1) / parts}; }

// Of values of one type. mine: this rank's; the result has the values of all ranks, rank by rank.
template <class T>
std::vector<T> GatherValues(Communicator& ranks, const std::vector<T>& mine);
// The same where all know how many there are of each: `all` holds this rank's already.
template <class T>
void GatherInto(Communicator& ranks, std::span<T> all, std::span<const std::size_t> counts);
// This rank's words and those of the others.
std::vector<std::string> GatherWords(Communicator& ranks, const std::string& mine);
// Whether any rank says so.
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
