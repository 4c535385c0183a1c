// SPDX-License-Identifier: Apache-2.0
// Photographs that do not all fit into memory: decoded when they are looked at, ahead of their turn where that is
// known, and kept as far as a budget goes. A photograph is the same however often it is decoded, so nothing but time
// depends on what is kept.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "kernels/core/parallel.h"
#include "kernels/core/span.h"
#include "problems/gaussian_splatting/scene/image.h"

namespace vesta::gs {

// How a photograph comes to be.
struct PhotographSource {
  std::function<Image()> decode;  // called from any thread; throws Error where the file cannot be read any more
  double bytes = 0;               // that the result takes
  double work_bytes = 0;          // that decoding takes beside it
};

class PhotographStore {
 public:
  // Photographs that are decoded before they are asked for. One takes less time than an iteration on it.
  static constexpr Index kAhead = 2;

  // budget_bytes: of all that is kept and looked at. Without room for two of the largest none is decoded ahead.
  explicit PhotographStore(double budget_bytes) : budget_(budget_bytes) {}
  ~PhotographStore();
  PhotographStore(const PhotographStore&) = delete;
  PhotographStore& operator=(const PhotographStore&) = delete;

  // Photographs are numbered in the order in which they are added.
  Index Add(PhotographSource source);
  void Remove(Index number);
  // Keeps a photograph that is decoded already, where there is room.
  void Offer(Index number, Image image);

  // The photograph. It stays in memory while the result is held: let go of the last one first, or the budget has to
  // hold both. Throws what decoding throws.
  std::shared_ptr<const Image> Get(Index number);
  // The same for who needs it once: nothing is kept of it.
  std::shared_ptr<const Image> Read(Index number) const;
  // What Get will be asked for next, in order. Where it was not told, those that follow in number.
  void Expect(const std::vector<Index>& numbers);

  double budget_bytes() const { return budget_; }
  double kept_bytes() const;
  // Most that the store and its decoding take, once it is full: one photograph is decoded ahead while another one is
  // asked for that was not expected.
  double MostBytes() const;
  // How often a photograph was decoded.
  std::int64_t decodings() const;

 private:
  struct Entry {
    PhotographSource source;
    std::shared_ptr<const Image> image = nullptr;
    bool is_decoding = false;
    std::int64_t used = 0;  // when it was decoded or asked for
  };
  using Lock = std::unique_lock<std::mutex>;

  std::shared_ptr<Entry> Find(Index number) const;
  // True where so many bytes are free now. Those that are expected go only where spares_expected is false.
  bool MakeRoom(double bytes, bool spares_expected);
  void DecodeInto(Entry& entry, Lock& lock);
  void Follow(Index number);
  void DecodeAhead();

  const double budget_;
  mutable std::mutex mutex_;
  std::condition_variable decoded_;
  std::map<Index, std::shared_ptr<Entry>> entries_;
  std::deque<Index> expected_;
  Index next_number_ = 0;
  double taken_ = 0, most_bytes_ = 0, most_work_ = 0;
  std::int64_t clock_ = 0, decodings_ = 0;
  bool is_told_ = false, is_ahead_ = false, ends_ = false;
  Background background_;  // ends before what it works on
};

// A photograph in a store. It goes from there with its last holder.
class StoredPhotograph {
 public:
  StoredPhotograph(std::shared_ptr<PhotographStore> store, PhotographSource source)
      : store_(std::move(store)), bytes_(source.bytes), work_bytes_(source.work_bytes) {
    number_ = store_->Add(std::move(source));
  }
  ~StoredPhotograph() { store_->Remove(number_); }
  StoredPhotograph(const StoredPhotograph&) = delete;
  StoredPhotograph& operator=(const StoredPhotograph&) = delete;

  std::shared_ptr<const Image> Get() const { return store_->Get(number_); }
  std::shared_ptr<const Image> Read() const { return store_->Read(number_); }
  const std::shared_ptr<PhotographStore>& store() const { return store_; }
  Index number() const { return number_; }
  double bytes() const { return bytes_; }
  double work_bytes() const { return work_bytes_; }

 private:
  std::shared_ptr<PhotographStore> store_;
  double bytes_, work_bytes_;
  Index number_ = 0;
};

}  // namespace vesta::gs
