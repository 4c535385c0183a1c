// The views of an iteration of Adam, shared by processes: each takes some of them, and steps some of the Gaussians.
#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/ranks/ranks.h"
#include "problems/gaussian_splatting/train/gaussian_owners.h"
#include "problems/gaussian_splatting/train/sum_of_views.h"

namespace vesta::gs {

// Which training views this process takes of iterations.
class OwnViewsOfIterations {
 public:
  // own: OwnViewsInAdam (over_ranks.h).
  explicit OwnViewsOfIterations(const Share& own) : own_(own) {}

  bool Has(std::size_t view) const {
    return static_cast<Index>(view) >= own_.begin && static_cast<Index>(view) < own_.end;
  }
  const Share& share() const { return own_; }
  // The k-th of `of` of them, about as far from one another.
  std::size_t At(std::size_t k, std::size_t of) const {
    return static_cast<std::size_t>(own_.begin) + k * static_cast<std::size_t>(own_.size()) / of;
  }
  // The next of those that next() gives.
  template <class Next>
  std::size_t NextOf(const Next& next) const {
    std::size_t view = next();
    while (!Has(view)) view = next();
    return view;
  }
  std::size_t size() const { return static_cast<std::size_t>(own_.size()); }

 private:
  Share own_;
};

// An iteration of several views by processes each of which has taken some of them and steps some of the Gaussians: what
// the views tell goes to who steps them, and what became of them goes to all. From each process come the terms of its
// views at this one's Gaussians, and then the parameters of those of its Gaussians that a view saw; on a device both go
// through the host's memory. Keeps the memory for that.
class ViewExchange {
 public:
  // Once each process has added its own views: then the sum is that of all views, at this process's Gaussians.
  template <class Space>
  void ToOwners(Ranks& ranks, const GaussianOwners& owners, SumOfViews<Space>* sum) {
    const auto size = static_cast<std::size_t>(ranks.size()), self = static_cast<std::size_t>(ranks.rank());
    VESTA_CHECK(sum->num_views() > 1, "a single view is each process's own");
    auto parts = sum->TakeParts();
    if (rooms_.size() < parts.size()) rooms_.resize(parts.size());
    // By part and process.
    std::vector<term::Piece> pieces;
    pieces.reserve(parts.size() * size);
    std::vector<std::int64_t> told;
    for (std::size_t k = 0; k < parts.size(); ++k) {
      auto& [node, part] = parts[k];
      const HostSpan<const unsigned char> bytes = part.Bytes(&rooms_[k]);
      told.insert(told.end(), {ranks.rank(), node.begin, node.end, sum->num_gaussians()});
      for (std::size_t r = 0; r < size; ++r) {
        const Share blocks = owners.BlocksOf(static_cast<int>(r));
        told.push_back(pieces.emplace_back(bytes, blocks.begin, blocks.end).NumBytes());
      }
    }
    told = GatherValues(ranks, told);
    for (std::size_t k = 0; k < told.size(); k += kToldOf + size) {
      VESTA_CHECK(told[k + 3] == sum->num_gaussians(), "processes train {} and {} Gaussians", told[k + 3],
                  sum->num_gaussians());
    }
    const std::vector<std::size_t> sent = Write(pieces, size), received = Received(told, size, self);
    Resize(static_cast<Index>(std::reduce(received.begin(), received.end())), &received_);
    ranks.AllToAll(std::as_bytes(std::span(sent_.data(), static_cast<std::size_t>(sent_.size()))), sent,
                   std::as_writable_bytes(std::span(received_.data(), static_cast<std::size_t>(received_.size()))),
                   received);
    for (auto& part : parts) sum->Recycle(std::move(part));
    const unsigned char* at = received_.data();
    for (std::size_t k = 0; k < told.size(); k += kToldOf + size) {
      const Index bytes = told[k + kToldOf + self];
      sum->AddPart({told[k + 1], told[k + 2]}, {at, bytes});
      at += bytes;
    }
  }

  // Once each process has stepped its own Gaussians in x: then x, and what density control has observed, are those of
  // all.
  template <class Space>
  void FromOwners(Ranks& ranks, SumOfViews<Space>* sum, float* x) {
    const auto size = static_cast<std::size_t>(ranks.size()), self = static_cast<std::size_t>(ranks.rank());
    rooms_.resize(std::max<std::size_t>(rooms_.size(), 1));
    const HostSpan<const unsigned char> own = sum->Stepped(x, &rooms_[0]);
    std::vector<std::size_t> sizes(size);
    sizes[self] = static_cast<std::size_t>(own.size());
    GatherInto(ranks, std::span(sizes), std::vector<std::size_t>(size, 1));
    const auto place = [&](std::size_t r) { return received_.data() + std::reduce(sizes.begin(), sizes.begin() + r); };
    Resize(static_cast<Index>(std::reduce(sizes.begin(), sizes.end())), &received_);
    std::copy_n(own.data(), own.size(), place(self));
    GatherInto(ranks, std::span(received_.data(), static_cast<std::size_t>(received_.size())), sizes);
    for (std::size_t r = 0; r < size; ++r) {
      if (r != self) sum->TakeStepped({place(r), static_cast<Index>(sizes[r])}, x);
    }
  }

 private:
  // Of each part all processes are told who has it, its node, of how many Gaussians it is, and the bytes for each.
  static constexpr std::size_t kToldOf = 4;

  // With some room, since each iteration has a little more or less than the last.
  static void Resize(Index bytes, HostBuffer<unsigned char>* buffer) {
    if (buffer->capacity() < bytes) buffer->ResizeForOverwrite(bytes + bytes / 4);
    buffer->ResizeForOverwrite(bytes);
  }

  // To `sent_`, process after process. Returns the bytes for each.
  std::vector<std::size_t> Write(const std::vector<term::Piece>& pieces, std::size_t processes) {
    std::vector<std::size_t> sizes(processes);
    Index total = 0;
    for (const term::Piece& piece : pieces) total += piece.NumBytes();
    Resize(total, &sent_);
    unsigned char* to = sent_.data();
    for (std::size_t r = 0; r < processes; ++r) {
      for (std::size_t k = r; k < pieces.size(); k += processes) {
        pieces[k].Write(to);
        to += pieces[k].NumBytes();
        sizes[r] += static_cast<std::size_t>(pieces[k].NumBytes());
      }
    }
    return sizes;
  }
  // The bytes from each.
  static std::vector<std::size_t> Received(const std::vector<std::int64_t>& told, std::size_t processes,
                                           std::size_t self) {
    std::vector<std::size_t> sizes(processes);
    for (std::size_t k = 0; k < told.size(); k += kToldOf + processes) {
      sizes[static_cast<std::size_t>(told[k])] += static_cast<std::size_t>(told[k + kToldOf + self]);
    }
    return sizes;
  }

  std::vector<HostBuffer<unsigned char>> rooms_;  // of parts that are on a device
  HostBuffer<unsigned char> sent_, received_;
};

}  // namespace vesta::gs
