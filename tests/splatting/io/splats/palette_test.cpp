// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/splats/palette.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "kernels/core/parallel.h"

namespace vesta::gs {
namespace {

std::vector<float> NormalNumbers(std::size_t count) {
  std::mt19937 random(3);
  std::vector<float> values(count);
  // A sum of uniform numbers, because std::normal_distribution depends on the library.
  for (float& value : values) {
    for (int k = 0; k < 12; ++k) value += static_cast<float>(random() / 4294967296.0 - 0.5);
  }
  return values;
}

double MeanSquaredError(const NumberPalette& palette, const std::vector<float>& values) {
  double sum = 0;
  for (const float value : values) {
    const double error = static_cast<double>(palette[NearestEntry(palette, value)]) - static_cast<double>(value);
    sum += error * error;
  }
  return sum / static_cast<double>(values.size());
}

TEST(NumberPalettes, KeepFewValuesExactly) {
  std::vector<float> values;
  for (int i = 0; i < 256; ++i) values.insert(values.end(), {0.37f * static_cast<float>(i * i % 257), -3.5f});
  const NumberPalette palette = MakeNumberPalette(values);
  EXPECT_TRUE(std::is_sorted(palette.begin(), palette.end()));
  EXPECT_EQ(MeanSquaredError(palette, values), 0);
  EXPECT_THAT(MakeNumberPalette({7.25f}), testing::Each(7.25f));
}

// Panter and Dite: the least possible error is the variance times sqrt(3) pi / 2, divided by 256^2.
TEST(NumberPalettes, ErrorIsNearTheLeastPossible) {
  const std::vector<float> values = NormalNumbers(100'000);
  const double error = MeanSquaredError(MakeNumberPalette(values), values);
  EXPECT_LT(error, 1.15 * std::sqrt(3.0) * M_PI / 2 / 65536);
}

TEST(NumberPalettes, OutliersDoNotCoarsenTheRest) {
  std::vector<float> values = NormalNumbers(100'000);
  const double before = MeanSquaredError(MakeNumberPalette(values), values);
  values.insert(values.end(), {-1e4f, 2e4f, 3e4f});
  const NumberPalette palette = MakeNumberPalette(values);
  EXPECT_TRUE(std::is_sorted(palette.begin(), palette.end()));
  values.resize(100'000);
  EXPECT_LT(MeanSquaredError(palette, values), 4 * before);
}

TEST(NumberPalettes, ZeroIsKeptExactly) {
  std::vector<float> values = NormalNumbers(2000);
  EXPECT_THAT(MakeNumberPalette(values), testing::Not(testing::Contains(0.0f)));
  values.push_back(0);
  EXPECT_THAT(MakeNumberPalette(values), testing::Contains(0.0f));
}

TEST(NumberPalettes, TheNearestEntryIsFound) {
  NumberPalette palette;
  for (std::size_t i = 0; i < palette.size(); ++i) palette[i] = 0.5f * static_cast<float>(i);
  EXPECT_EQ(NearestEntry(palette, -100), 0);
  EXPECT_EQ(NearestEntry(palette, 0.2f), 0);
  EXPECT_EQ(NearestEntry(palette, 0.3f), 1);
  EXPECT_EQ(NearestEntry(palette, 50), 100);
  EXPECT_EQ(NearestEntry(palette, 1e30f), 255);
}

double MeanSquaredDistance(const std::vector<float>& vectors, std::size_t dimension, const VectorPalette& palette) {
  double sum = 0;
  for (std::size_t i = 0; i < vectors.size(); ++i) {
    const float entry = palette.entries[palette.labels[i / dimension] * dimension + i % dimension];
    sum += std::pow(static_cast<double>(vectors[i] - entry), 2);
  }
  return sum / static_cast<double>(vectors.size()) * static_cast<double>(dimension);
}

TEST(VectorPalettes, WithEnoughEntriesNothingChanges) {
  const std::vector<float> vectors = NormalNumbers(9 * 300);
  for (const Index count : {300, 512}) {
    const VectorPalette palette = MakeVectorPalette(vectors, 9, count);
    EXPECT_EQ(palette.entries.size(), static_cast<std::size_t>(9 * count));
    EXPECT_EQ(MeanSquaredDistance(vectors, 9, palette), 0);
  }
}

// In the plane, the least possible error for uniform vectors is that of a hexagonal lattice, 0.1604 times the area per
// entry.
TEST(VectorPalettes, ErrorIsNearTheLeastPossible) {
  std::mt19937 random(4);
  std::vector<float> vectors(2 * 40'000);
  for (float& value : vectors) value = static_cast<float>(random() / 4294967296.0);
  for (const Index count : {64, 2048}) {
    const double error = MeanSquaredDistance(vectors, 2, MakeVectorPalette(vectors, 2, count));
    EXPECT_LT(error, 1.35 * 0.1604 / static_cast<double>(count)) << count;
  }
}

TEST(VectorPalettes, FarGroupsAreKeptApart) {
  std::vector<float> vectors = NormalNumbers(3 * 6000);
  for (std::size_t i = 0; i < vectors.size(); ++i) vectors[i] = 1e-3f * vectors[i] + static_cast<float>(i / 3 % 700);
  EXPECT_LT(MeanSquaredDistance(vectors, 3, MakeVectorPalette(vectors, 3, 2048)), 0.01);
}

TEST(VectorPalettes, EqualVectorsAreKeptExactly) {
  const VectorPalette palette = MakeVectorPalette(std::vector<float>(3 * 5000, 0.25f), 3, 4096);
  EXPECT_EQ(MeanSquaredDistance(std::vector<float>(3 * 5000, 0.25f), 3, palette), 0);
}

TEST(VectorPalettes, DoNotDependOnTheThreads) {
  const std::vector<float> vectors = NormalNumbers(9 * 5000);
  const int threads = NumThreads();
  SetNumThreads(1);
  const VectorPalette one = MakeVectorPalette(vectors, 9, 1024);
  SetNumThreads(3);
  const VectorPalette three = MakeVectorPalette(vectors, 9, 1024);
  SetNumThreads(threads);
  EXPECT_EQ(one.entries, three.entries);
  EXPECT_EQ(one.labels, three.labels);
}

}  // namespace
}  // namespace vesta::gs
