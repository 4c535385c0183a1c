// Moments and bases of Gaussians, from the processes that have them to others.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "kernels/ranks/ranks.h"
#include "problems/gaussian_splatting/adam/adam.h"
#include "problems/gaussian_splatting/train/gaussian_owners.h"

namespace vesta::gs {

// Gives each process what it wants of the others': wants(process, chunk), the same on all, who all call this.
template <class B, class Wants>
void MoveAdam(Ranks& ranks, const GaussianOwners& owners, const Wants& wants, Adam<B>* adam) {
  // Of each process's chunks, so that what is on its way takes little memory.
  const Index at_once = std::max<Index>(1, 64 / ranks.size());
  const auto size = static_cast<std::size_t>(ranks.size());
  Index rounds = 0;
  for (int r = 0; r < ranks.size(); ++r) rounds = std::max(rounds, (owners.ChunksOf(r).size() + at_once - 1) / at_once);
  HostBuffer<float> sent, received;
  for (Index round = 0; round < rounds; ++round) {
    // What `from` has for `to`, run by run of numbers.
    const auto for_each_run = [&](int from, int to, const auto& f) {
      if (from == to) return;
      const Share own = owners.ChunksOf(from);
      const Index first = own.begin + round * at_once, end = std::min(own.end, first + at_once);
      // Neighbours together: on a device each run is a copy.
      for (Index begin = first, next = first; begin < end; begin = next) {
        const bool is_wanted = wants(to, begin);
        for (next = begin + 1; next < end && wants(to, next) == is_wanted;) ++next;
        if (is_wanted) adam->ForEachRun(owners.layout(), owners.GaussiansOf({begin, next}), f);
      }
    };
    std::vector<std::size_t> send_sizes(size), receive_sizes(size);
    Index to_send = 0, to_receive = 0;
    for (int r = 0; r < ranks.size(); ++r) {
      const auto count = [](Index* total, std::size_t* bytes) {
        return [=](auto numbers) {
          *total += numbers.size();
          *bytes += static_cast<std::size_t>(numbers.size()) * sizeof(float);
        };
      };
      for_each_run(ranks.rank(), r, count(&to_send, &send_sizes[static_cast<std::size_t>(r)]));
      for_each_run(r, ranks.rank(), count(&to_receive, &receive_sizes[static_cast<std::size_t>(r)]));
    }
    sent.ResizeForOverwrite(to_send);
    received.ResizeForOverwrite(to_receive);
    Index at = 0;
    const auto next = [&](HostBuffer<float>& buffer, Index count) {
      return buffer.view().subspan(std::exchange(at, at + count), count);
    };
    for (int r = 0; r < ranks.size(); ++r) {
      for_each_run(ranks.rank(), r, [&](auto numbers) { B().ToHost(numbers, next(sent, numbers.size())); });
    }
    ranks.AllToAll(std::as_bytes(std::span(sent.data(), static_cast<std::size_t>(to_send))), send_sizes,
                   std::as_writable_bytes(std::span(received.data(), static_cast<std::size_t>(to_receive))),
                   receive_sizes);
    at = 0;
    for (int r = 0; r < ranks.size(); ++r) {
      for_each_run(r, ranks.rank(), [&](auto numbers) { B().FromHost(next(received, numbers.size()), numbers); });
    }
  }
}

}  // namespace vesta::gs
