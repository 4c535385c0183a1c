// SPDX-License-Identifier: Apache-2.0
#include "tests/support/thread_ranks.h"

#include <algorithm>
#include <condition_variable>
#include <cstring>
#include <exception>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "kernels/core/error.h"

namespace vesta::test {
namespace {

// Where ranks publish data for others and wait for each other.
class Board {
 public:
  explicit Board(int count) : laid_out_(static_cast<std::size_t>(count)) {}

  struct LaidOut {
    const std::byte* data = nullptr;
    std::vector<std::size_t> sizes;
  };
  LaidOut& of(int rank) { return laid_out_[static_cast<std::size_t>(rank)]; }

  void Meet() {
    std::unique_lock lock(mutex_);
    ThrowIfAbandoned();
    const long round = round_;
    if (++waiting_ == laid_out_.size()) {
      waiting_ = 0;
      ++round_;
      changed_.notify_all();
      return;
    }
    changed_.wait(lock, [&] { return round_ != round || !why_.empty(); });
    if (round_ == round) ThrowIfAbandoned();
  }
  void Abandon(const std::string& why) {
    const std::lock_guard lock(mutex_);
    if (why_.empty()) why_ = why;
    changed_.notify_all();
  }

 private:
  void ThrowIfAbandoned() const {
    if (!why_.empty()) throw OtherRankFailed(why_);
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<LaidOut> laid_out_;
  std::size_t waiting_ = 0;
  long round_ = 0;
  std::string why_;
};

class ThreadCommunicator final : public Communicator {
 public:
  ThreadCommunicator(Board& board, int rank, int size) : board_(board), rank_(rank), size_(size) {}
  int rank() const override { return rank_; }
  int size() const override { return size_; }
  void Abandon(const std::string& why) noexcept override {
    board_.Abandon("process " + std::to_string(rank_) + " of " + std::to_string(size_) + ": " + why);
  }

 private:
  void DoAllGather(Bytes all, std::span<const std::size_t> sizes) override {
    board_.of(rank_) = {all.data(), {sizes.begin(), sizes.end()}};
    board_.Meet();
    std::size_t at = 0;
    for (int r = 0; r < size_; ++r) {
      const std::size_t size = sizes[static_cast<std::size_t>(r)];
      if (r != rank_ && size > 0) std::memcpy(all.data() + at, board_.of(r).data + at, size);
      at += size;
    }
    board_.Meet();
  }
  void DoAllToAll(ConstBytes send, std::span<const std::size_t> send_sizes, Bytes receive,
                  std::span<const std::size_t> receive_sizes) override {
    board_.of(rank_) = {send.data(), {send_sizes.begin(), send_sizes.end()}};
    board_.Meet();
    std::byte* to = receive.data();
    for (int r = 0; r < size_; ++r) {
      const std::vector<std::size_t>& sizes = board_.of(r).sizes;
      std::size_t before = 0;
      for (int s = 0; s < rank_; ++s) before += sizes[static_cast<std::size_t>(s)];
      const std::size_t size = sizes[static_cast<std::size_t>(rank_)];
      if (size != receive_sizes[static_cast<std::size_t>(r)])
        throw Error(kBadArgument, "a piece does not have the expected size");
      if (size > 0) std::memcpy(to, board_.of(r).data + before, size);
      to += size;
    }
    board_.Meet();
  }

  Board& board_;
  int rank_, size_;
};

}  // namespace

void OnThreadRanks(int count, const std::function<void(Communicator&)>& body) {
  Board board(count);
  std::mutex mutex;
  std::exception_ptr first;
  std::vector<std::thread> threads;
  threads.reserve(static_cast<std::size_t>(count));
  for (int r = 0; r < count; ++r) {
    threads.emplace_back([&, r] {
      ThreadCommunicator ranks(board, r, count);
      try {
        body(ranks);
      } catch (const std::exception& error) {
        {
          const std::lock_guard lock(mutex);
          if (!first) first = std::current_exception();
        }
        ranks.Abandon(error.what());
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  if (first) std::rethrow_exception(first);
}

}  // namespace vesta::test
