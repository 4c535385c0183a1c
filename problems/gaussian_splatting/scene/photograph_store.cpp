// SPDX-License-Identifier: Apache-2.0
#include "problems/gaussian_splatting/scene/photograph_store.h"

#include <algorithm>
#include <exception>
#include <utility>

#include "kernels/core/check.h"
#include "kernels/core/profile.h"

namespace vesta::gs {

PhotographStore::~PhotographStore() {
  const Lock lock(mutex_);
  ends_ = true;
}

Index PhotographStore::Add(PhotographSource source) {
  const Lock lock(mutex_);
  most_bytes_ = std::max(most_bytes_, source.bytes);
  most_work_ = std::max(most_work_, source.work_bytes);
  entries_[next_number_] = std::make_shared<Entry>(Entry{std::move(source)});
  return next_number_++;
}

void PhotographStore::Remove(Index number) {
  std::shared_ptr<Entry> entry;  // outlives the lock: it may hold photographs of this store
  Lock lock(mutex_);
  entry = Find(number);
  decoded_.wait(lock, [&] { return !entry->is_decoding; });
  if (entry->image) used_bytes_ -= entry->source.bytes;
  entries_.erase(number);
}

void PhotographStore::Offer(Index number, Image image) {
  const Lock lock(mutex_);
  const std::shared_ptr<Entry> entry = Find(number);
  if (entry->image || used_bytes_ + entry->source.bytes > budget_) return;
  used_bytes_ += entry->source.bytes;
  entry->image = std::make_shared<const Image>(std::move(image));
  entry->used = ++clock_;
}

std::shared_ptr<const Image> PhotographStore::Get(Index number) {
  const ScopedPhase phase("photographs");
  Lock lock(mutex_);
  const std::shared_ptr<Entry> entry = Find(number);
  decoded_.wait(lock, [&] { return !entry->is_decoding; });
  if (!entry->image) {
    const double bytes = entry->source.bytes;
    if (!MakeRoom(bytes, true)) MakeRoom(bytes, false);
    DecodeInto(*entry, lock);
  }
  std::shared_ptr<const Image> image = entry->image;
  entry->used = ++clock_;
  UpdateExpected(number);
  // Decoding ahead needs space for two: that photograph, and another one requested meanwhile.
  if (!is_ahead_ && budget_ >= 2 * most_bytes_) {
    is_ahead_ = true;
    background_.Run([this] { DecodeAhead(); });
  }
  return image;
}

std::shared_ptr<const Image> PhotographStore::Read(Index number) const {
  const ScopedPhase phase("photographs");
  Lock lock(mutex_);
  const std::shared_ptr<Entry> entry = Find(number);
  if (entry->image) return entry->image;
  lock.unlock();
  return std::make_shared<const Image>(entry->source.decode());
}

void PhotographStore::Expect(const std::vector<Index>& numbers) {
  const Lock lock(mutex_);
  expected_.assign(numbers.begin(), numbers.end());
  is_announced_ = true;
}

double PhotographStore::kept_bytes() const {
  const Lock lock(mutex_);
  return used_bytes_;
}

double PhotographStore::MostBytes() const {
  const Lock lock(mutex_);
  return budget_ + 2 * most_work_;
}

std::int64_t PhotographStore::decodings() const {
  const Lock lock(mutex_);
  return decodings_;
}

std::shared_ptr<PhotographStore::Entry> PhotographStore::Find(Index number) const {
  const auto found = entries_.find(number);
  VESTA_CHECK(found != entries_.end(), "there is no photograph {} in the store", number);
  return found->second;
}

bool PhotographStore::MakeRoom(double bytes, bool spares_expected) {
  while (used_bytes_ + bytes > budget_) {
    // Views are used in cycles: the most recently used photograph is needed last.
    Entry* last = nullptr;
    for (const auto& [number, entry] : entries_) {
      const bool is_free = entry->image && entry->image.use_count() == 1;
      const bool is_spared = spares_expected && std::ranges::find(expected_, number) != expected_.end();
      if (is_free && !is_spared && (last == nullptr || entry->used > last->used)) last = entry.get();
    }
    if (last == nullptr) return false;
    last->image = nullptr;
    used_bytes_ -= last->source.bytes;
  }
  return true;
}

void PhotographStore::DecodeInto(Entry& entry, Lock& lock) {
  entry.is_decoding = true;
  used_bytes_ += entry.source.bytes;
  ++decodings_;
  lock.unlock();
  std::shared_ptr<const Image> image;
  std::exception_ptr failure;
  try {
    image = std::make_shared<const Image>(entry.source.decode());
  } catch (...) {
    failure = std::current_exception();
  }
  lock.lock();
  entry.is_decoding = false;
  entry.image = std::move(image);
  entry.used = ++clock_;
  if (failure) used_bytes_ -= entry.source.bytes;
  decoded_.notify_all();
  if (failure) std::rethrow_exception(failure);
}

void PhotographStore::UpdateExpected(Index number) {
  if (is_announced_ && !expected_.empty() && expected_.front() == number) return expected_.pop_front();
  is_announced_ = false;
  expected_.clear();
  for (auto next = entries_.upper_bound(number); next != entries_.end() && std::ssize(expected_) < kAhead; ++next) {
    expected_.push_back(next->first);
  }
}

void PhotographStore::DecodeAhead() {
  Lock lock(mutex_);
  const auto next = [&]() -> std::shared_ptr<Entry> {
    for (const Index number : expected_) {
      const auto found = entries_.find(number);
      if (found != entries_.end() && !found->second->image && !found->second->is_decoding) return found->second;
    }
    return nullptr;
  };
  try {
    for (std::shared_ptr<Entry> entry = next(); entry && !ends_; entry = next()) {
      if (!MakeRoom(entry->source.bytes, true)) break;
      DecodeInto(*entry, lock);
    }
  } catch (...) {  // Get() will report the failure
  }
  is_ahead_ = false;
}

}  // namespace vesta::gs
