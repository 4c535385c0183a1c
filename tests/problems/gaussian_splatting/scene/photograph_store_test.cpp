// SPDX-License-Identifier: Apache-2.0
// Has the label "threads": also runs under the thread sanitizer (preset tsan).
#include "problems/gaussian_splatting/scene/photograph_store.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <memory>
#include <thread>
#include <vector>

#include "kernels/core/error.h"
#include "kernels/core/random.h"

namespace vesta::gs {
namespace {

constexpr int kSide = 8;
constexpr double kBytes = 3 * sizeof(float) * kSide * kSide;  // per photograph

Image Picture(Index number) {
  Image image(kSide, kSide);
  for (std::size_t i = 0; i < image.rgb.size(); ++i) image.rgb[i] = static_cast<float>(number) + static_cast<float>(i);
  return image;
}

PhotographSource SourceOf(Index number) {
  return {.decode = [number] { return Picture(number); }, .bytes = kBytes, .work_bytes = 0};
}

// With memory for `room` of its `photographs`.
std::unique_ptr<PhotographStore> MakeStore(Index photographs, double room) {
  auto store = std::make_unique<PhotographStore>(room * kBytes);
  for (Index i = 0; i < photographs; ++i) EXPECT_EQ(store->Add(SourceOf(i)), i);
  return store;
}

TEST(PhotographStore, GivesEachWhateverTheRoomAndTheOrder) {
  for (const double room : {0.0, 1.0, 2.0, 3.5, 100.0}) {
    const auto store = MakeStore(12, room);
    CounterRandom random(7, 1);
    for (int k = 0; k < 200; ++k) {
      const Index number = random.Below(12);
      EXPECT_EQ(store->Get(number)->rgb, Picture(number).rgb);
      EXPECT_EQ(store->Read(11 - number)->rgb, Picture(11 - number).rgb);
    }
  }
}

TEST(PhotographStore, KeepsNoMoreThanItsBudget) {
  const auto store = MakeStore(20, 3);
  for (int epoch = 0; epoch < 3; ++epoch) {
    for (Index i = 0; i < 20; ++i) {
      store->Get(i);
      EXPECT_LE(store->kept_bytes(), 3 * kBytes);
    }
  }
  EXPECT_GT(store->kept_bytes(), kBytes);
}

TEST(PhotographStore, WhatFitsIsDecodedOnce) {
  const auto store = MakeStore(10, 10);
  for (int epoch = 0; epoch < 5; ++epoch) {
    for (Index i = 0; i < 10; ++i) store->Get((7 * i + epoch) % 10);
  }
  EXPECT_EQ(store->decodings(), 10);
}

// If memory lacks for few photographs, few are decoded again. Evicting the least recently used ones would decode all of
// them in every round.
TEST(PhotographStore, RoundAfterRoundMostOfWhatIsKeptServes) {
  const auto store = MakeStore(20, 16);
  constexpr int kRounds = 11;
  for (int round = 0; round < kRounds; ++round) {
    for (Index i = 0; i < 20; ++i) store->Get(i);
  }
  EXPECT_LT(store->decodings(), 20 + (kRounds - 1) * 12);
}

TEST(PhotographStore, WhatIsExpectedIsDecodedAhead) {
  PhotographStore store(3 * kBytes);
  std::promise<void> decoded;
  for (Index i = 0; i < 9; ++i) store.Add(SourceOf(i));
  store.Add({.decode =
                 [&] {
                   decoded.set_value();
                   return Picture(9);
                 },
             .bytes = kBytes,
             .work_bytes = 0});
  store.Expect({4, 9});
  EXPECT_EQ(store.Get(4)->rgb, Picture(4).rgb);
  // It is decoded without a request.
  EXPECT_EQ(decoded.get_future().wait_for(std::chrono::seconds(60)), std::future_status::ready);
  EXPECT_EQ(store.Get(9)->rgb, Picture(9).rgb) << "decoded once; a second decoding would throw at the promise";
}

// Next to the first image, of half the size, only one more fits.
TEST(PhotographStore, WithoutRoomForTwoNoneIsDecodedAhead) {
  PhotographStore store(1.5 * kBytes);
  std::promise<void> begun;
  store.Add({.decode = [] { return Picture(0); }, .bytes = kBytes / 2});
  store.Add({.decode =
                 [&begun] {
                   begun.set_value();
                   return Picture(1);
                 },
             .bytes = kBytes});
  store.Get(0);
  EXPECT_EQ(begun.get_future().wait_for(std::chrono::milliseconds(200)), std::future_status::timeout);
  EXPECT_EQ(store.decodings(), 1);
}

TEST(PhotographStore, WhatIsHeldStays) {
  const auto store = MakeStore(10, 2);
  const std::shared_ptr<const Image> held = store->Get(3);
  for (Index i = 0; i < 10; ++i) store->Get(i);
  EXPECT_EQ(held->rgb, Picture(3).rgb);
  EXPECT_EQ(store->Get(3), held) << "not decoded again";
}

TEST(PhotographStore, AnErrorComesWithItsPhotograph) {
  PhotographStore store(4 * kBytes);
  for (Index i = 0; i < 3; ++i) store.Add(SourceOf(i));
  store.Add({.decode = []() -> Image { throw Error(kNotFound, "gone.jpg: no such file"); },
             .bytes = kBytes,
             .work_bytes = 0});
  for (int k = 0; k < 20; ++k) {
    store.Expect({1, 3, 2});
    EXPECT_EQ(store.Get(1)->rgb, Picture(1).rgb);
    EXPECT_THROW(store.Get(3), Error);
    EXPECT_EQ(store.Get(2)->rgb, Picture(2).rgb);
  }
  EXPECT_LE(store.kept_bytes(), 3 * kBytes);
}

TEST(PhotographStore, OfferedOnesAreKeptWhileThereIsRoom) {
  const auto store = MakeStore(4, 2);
  for (Index i = 0; i < 4; ++i) store->Offer(i, Picture(i));
  EXPECT_EQ(store->kept_bytes(), 2 * kBytes);
  store->Read(0), store->Read(1);
  EXPECT_EQ(store->decodings(), 0);
}

TEST(PhotographStore, ForeseesItsBudgetAndTheWorkOfDecoding) {
  PhotographStore store(10 * kBytes);
  store.Add({.decode = [] { return Picture(0); }, .bytes = kBytes, .work_bytes = 3 * kBytes});
  store.Add(SourceOf(1));
  EXPECT_EQ(store.MostBytes(), 16 * kBytes);
}

// Computed from another one in the same store, for example at half resolution.
TEST(StoredPhotograph, GoesWithItsLastHolder) {
  const auto store = std::make_shared<PhotographStore>(8 * kBytes);
  auto whole = std::make_shared<const StoredPhotograph>(store, SourceOf(5));
  auto half = std::make_shared<const StoredPhotograph>(
      store,
      PhotographSource{
          .decode = [whole] { return ResizeArea(*whole->Read(), 4, 4); }, .bytes = kBytes / 4, .work_bytes = kBytes});
  whole.reset();
  EXPECT_EQ(half->Get()->rgb, ResizeArea(Picture(5), 4, 4).rgb);
  EXPECT_EQ(store->kept_bytes(), kBytes / 4) << "Read does not keep the image";
  half.reset();
  EXPECT_EQ(store->kept_bytes(), 0);
}

TEST(PhotographStore, ThreadsMayAskAtOnce) {
  const auto store = MakeStore(16, 3);
  std::atomic<int> wrong{0};
  std::vector<std::thread> threads;
  for (std::uint64_t t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      CounterRandom random(11, t);
      for (int k = 0; k < 300; ++k) {
        const Index number = random.Below(16);
        if (k % 5 == 0) store->Expect({number, random.Below(16), random.Below(16)});
        if (store->Get(number)->rgb != Picture(number).rgb) ++wrong;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace vesta::gs
