// SPDX-License-Identifier: Apache-2.0
// A cache for photographs that do not all fit into memory. It decodes them on request, or ahead if the order of
// requests is known. Decoded images stay in memory up to a limit, the budget, which affects only speed.
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
  double bytes = 0;               // size of the decoded image, bytes
  double work_bytes = 0;          // extra memory while decoding, bytes
};

class PhotographStore {
 public:
  // Photographs to decode ahead. Small, because decoding one takes less time than a training iteration.
  static constexpr Index kAhead = 2;

  // budget_bytes: limit for all decoded images, in use or not. Decoding ahead needs twice the largest image.
  explicit PhotographStore(double budget_bytes) : budget_(budget_bytes) {}
  ~PhotographStore();
  PhotographStore(const PhotographStore&) = delete;
  PhotographStore& operator=(const PhotographStore&) = delete;

  // Returns the number of the photograph: 0, 1, 2, ...
  Index Add(PhotographSource source);
  void Remove(Index number);
  // Stores a photograph that is decoded already, if it fits into the budget.
  void Offer(Index number, Image image);

  // Waits until the photograph is decoded. It stays in memory while the result exists, so destroy the previous one
  // first. Exceeds the budget if all other images are in use. Throws the exceptions of PhotographSource::decode.
  std::shared_ptr<const Image> Get(Index number);
  // Like Get, for a single use: does not store an image that it has to decode.
  std::shared_ptr<const Image> Read(Index number) const;
  // Announces the next calls of Get, in order, for decoding ahead. Without an announcement, or after a request that
  // differs from it, the store expects the kAhead numbers that follow the requested number.
  void Expect(const std::vector<Index>& numbers);

  double budget_bytes() const { return budget_; }
  // Images decoded or being decoded.
  double kept_bytes() const;
  // Peak memory of a full store: a photograph may be decoded ahead while Get decodes another.
  double MostBytes() const;
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
  // Evicts unused photographs until `bytes` bytes of the budget are free; returns false if that is impossible. With
  // spares_expected, announced or expected photographs stay.
  bool MakeRoom(double bytes, bool spares_expected);
  // Releases the lock while decoding.
  void DecodeInto(Entry& entry, Lock& lock);
  // Call after a request.
  void UpdateExpected(Index number);
  void DecodeAhead();

  const double budget_;
  mutable std::mutex mutex_;
  std::condition_variable decoded_;
  std::map<Index, std::shared_ptr<Entry>> entries_;
  std::deque<Index> expected_;  // numbers of the next requests, in order
  Index next_number_ = 0;
  double used_bytes_ = 0;                  // see kept_bytes
  double most_bytes_ = 0, most_work_ = 0;  // maxima of PhotographSource::bytes and work_bytes
  std::int64_t clock_ = 0, decodings_ = 0;
  bool is_announced_ = false;  // true if expected_ comes from Expect
  bool is_ahead_ = false;      // true while DecodeAhead runs
  bool ends_ = false;
  Background background_;  // declared last, so that it ends before the members it uses
};

// The destructor removes the photograph from the store.
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
