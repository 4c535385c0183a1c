// SPDX-License-Identifier: Apache-2.0
// A cache for photographs that do not all fit into memory. It decodes a photograph when it is requested, or ahead of
// the request if the order of the requests is known. Decoded images stay in memory up to a limit, the budget. Decoding
// always gives the same image, so the budget affects only speed.
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
  // Number of photographs to decode ahead. It is small because decoding one takes less time than a training iteration.
  static constexpr Index kAhead = 2;

  // budget_bytes: limit for all decoded images, in use or not. The store decodes ahead only if twice the largest image
  // is within the limit.
  explicit PhotographStore(double budget_bytes) : budget_(budget_bytes) {}
  ~PhotographStore();
  PhotographStore(const PhotographStore&) = delete;
  PhotographStore& operator=(const PhotographStore&) = delete;

  // Adds a photograph and returns its number: 0, 1, 2, ... in the order of the calls.
  Index Add(PhotographSource source);
  void Remove(Index number);
  // Stores a photograph that the caller has decoded already, if it fits into the budget; otherwise does nothing.
  void Offer(Index number, Image image);

  // Returns the photograph; waits until it is decoded. It stays in memory as long as the result exists. Destroy the
  // previous result first, because otherwise both count towards the budget. If only images in use are left to evict,
  // the budget is exceeded. Throws the exceptions of PhotographSource::decode.
  std::shared_ptr<const Image> Get(Index number);
  // The same for a single use: if the store has to decode the image, it does not store it.
  std::shared_ptr<const Image> Read(Index number) const;
  // Announces the next calls of Get, in their order: these photographs are decoded ahead. Without an announcement, or
  // after another number was requested, the store expects the kAhead numbers after the latest one.
  void Expect(const std::vector<Index>& numbers);

  double budget_bytes() const { return budget_; }
  // Size of the images that are decoded or being decoded.
  double kept_bytes() const;
  // Peak memory of a full store with the memory for decoding: a photograph may be decoded ahead while Get decodes
  // another.
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
  // Evicts photographs that are not in use until `bytes` bytes of the budget are free. Returns false if that is not
  // possible. With spares_expected, announced or expected photographs are not evicted.
  bool MakeRoom(double bytes, bool spares_expected);
  // Decodes the photograph, unlocked meanwhile.
  void DecodeInto(Entry& entry, Lock& lock);
  // Updates expected_ after a request.
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
