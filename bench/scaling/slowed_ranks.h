// Ranks whose exchanges take as much longer as they would over a slower network.
#pragma once

#include <chrono>
#include <thread>

#include "kernels/ranks/ranks.h"

namespace vesta::bench {

struct Network {
  double latency = 0;           // seconds a message
  double bytes_per_second = 0;  // of one process's link; 0: no limit
  // What a process waits for that receives so many bytes from `others` processes, each in a message of its own, over
  // one link: messages are under way at once.
  double Seconds(double bytes) const { return latency + (bytes_per_second > 0 ? bytes / bytes_per_second : 0); }
};

// Waits after each exchange; the rest is the given ranks'.
class SlowedRanks final : public Ranks {
 public:
  SlowedRanks(Ranks& ranks, const Network& network) : ranks_(ranks), network_(network) {}
  int rank() const override { return ranks_.rank(); }
  int size() const override { return ranks_.size(); }
  void Abandon(const std::string& why) noexcept override { ranks_.Abandon(why); }

 private:
  void DoAllGather(Bytes all, std::span<const std::size_t> sizes) override {
    ranks_.AllGather(all, sizes);
    Wait(sizes);
  }
  void DoAllToAll(ConstBytes send, std::span<const std::size_t> send_sizes, Bytes receive,
                  std::span<const std::size_t> receive_sizes) override {
    ranks_.AllToAll(send, send_sizes, receive, receive_sizes);
    Wait(receive_sizes);
  }
  void Wait(std::span<const std::size_t> sizes) {
    if (size() == 1) return;
    double bytes = 0;
    for (std::size_t r = 0; r < sizes.size(); ++r) {
      if (static_cast<int>(r) != rank()) bytes += static_cast<double>(sizes[r]);
    }
    std::this_thread::sleep_for(std::chrono::duration<double>(network_.Seconds(bytes)));
  }

  Ranks& ranks_;
  Network network_;
};

}  // namespace vesta::bench
