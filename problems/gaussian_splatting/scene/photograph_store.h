// SPDX-License-Identifier: Apache-2.0
// A store for photographs that do not all fit into memory. It decodes them on demand, or ahead of demand if their order
// is known, and keeps them within a memory budget. Decoding always gives the same image, so the budget affects only
// speed.
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

// A photograph that can be decoded on demand.
struct PhotographSource {
  std::function<Image()> decode;  // called from any thread; throws Error if the file can no longer be read
  double bytes = 0;               // size of the decoded image
  double work_bytes = 0;          // extra memory while decoding
};

class PhotographStore {
 public:
  // Number of photographs decoded ahead. Decoding one takes less time than a training iteration on it.
  static constexpr Index kAhead = 2;

  // budget_bytes: limit for all images kept or in use. The store decodes ahead only if two of the largest images fit.
  explicit PhotographStore(double budget_bytes) : budget_(budget_bytes) {}
  ~PhotographStore();
  PhotographStore(const PhotographStore&) = delete;
  PhotographStore& operator=(const PhotographStore&) = delete;

  // Photographs are numbered in the order in which they are added.
  Index Add(PhotographSource source);
  void Remove(Index number);
  // Keeps a photograph that is already decoded, if it fits into the budget.
  void Offer(Index number, Image image);

  // Returns the photograph, which stays in memory while the result is held. Release the previous one first, or the
  // budget must hold both. Throws the exceptions of decode.
  std::shared_ptr<const Image> Get(Index number);
  // The same for a single use: the store does not keep the image.
  std::shared_ptr<const Image> Read(Index number) const;
  // Announces the next calls of Get, in order. Without it, the photographs with the next numbers are expected.
  void Expect(const std::vector<Index>& numbers);

  double budget_bytes() const { return budget_; }
  double kept_bytes() const;
  // Peak memory of a full store, including decoding: one photograph may be decoded ahead while an unexpected one is
  // requested.
  double MostBytes() const;
  // Number of decodings so far.
  std::int64_t decodings() const;

 private:
  struct Entry {
    PhotographSource source;
    std::shared_ptr<const Image> image = nullptr;
    bool is_decoding = false;
    std::int64_t used = 0;  // time of the last decoding or request, in ticks of clock_
  };
  using Lock = std::unique_lock<std::mutex>;

  std::shared_ptr<Entry> Find(Index number) const;
  // Evicts photographs until `bytes` bytes are free; returns false if that is not possible. With spares_expected,
  // expected photographs are not evicted.
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
  Background background_;  // declared last, so that it ends before the members it uses
};

// A photograph in a store. The destructor removes it from there.
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
