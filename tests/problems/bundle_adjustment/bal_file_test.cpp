// SPDX-License-Identifier: Apache-2.0
#include "problems/bundle_adjustment/bal_file.h"

#include <array>
#include <cstring>
#include <string>

#include "bench/collections/generate_bundle.h"
#include "kernels/core/files.h"
#include "kernels/core/random.h"
#include "tests/support/test_files.h"

namespace vesta::bundle {
namespace {

// Two cameras, one point, two observations.
const char kFile[] =
    "2 1 2\n"
    "\n"
    "0 0     -3.5e+02 3.25\n"
    "1 0 +4 -0.125\r\n"
    "0.1\n0.2\n0.3\n0\n0\n-1\n500\n0\n0\n"
    "0.1\n0.2\n0.3\n0\n0\n-2\n600\n0\n0\n"
    "1e-3\n2\n  3";

BundleData Read(const std::string& text) {
  const TempFolder folder;
  WriteBytes(folder / "a.txt", text);
  return ReadBal(folder / "a.txt");
}

TEST(BalFile, Reads) {
  const BundleData data = Read(kFile);
  EXPECT_EQ(data.num_cameras, 2);
  EXPECT_EQ(data.num_points, 1);
  ASSERT_EQ(data.observations.size(), 2u);
  EXPECT_EQ(data.observations[0].camera, 0);
  EXPECT_EQ(data.observations[0].pixel[0], -350);
  EXPECT_EQ(data.observations[1].camera, 1);
  EXPECT_EQ(data.observations[1].pixel[0], 4);
  EXPECT_EQ(data.observations[1].pixel[1], -0.125);
  ASSERT_EQ(data.x.size(), 21u);
  EXPECT_EQ(data.x[14], -2);
  EXPECT_EQ(data.x[20], 3);
}

void ExpectSameBits(const BundleData& a, const BundleData& b) {
  EXPECT_EQ(a.num_cameras, b.num_cameras);
  EXPECT_EQ(a.num_points, b.num_points);
  ASSERT_EQ(a.x.size(), b.x.size());
  EXPECT_EQ(std::memcmp(a.x.data(), b.x.data(), a.x.size() * sizeof(double)), 0);
  ASSERT_EQ(a.observations.size(), b.observations.size());
  for (std::size_t i = 0; i < a.observations.size(); ++i) {
    ASSERT_EQ(a.observations[i].camera, b.observations[i].camera);
    ASSERT_EQ(a.observations[i].point, b.observations[i].point);
    ASSERT_EQ(a.observations[i].pixel[0], b.observations[i].pixel[0]);
    ASSERT_EQ(a.observations[i].pixel[1], b.observations[i].pixel[1]);
  }
}

TEST(BalFile, ReadsBackBitForBit) {
  BundleData data = Generate({.num_cameras = 20, .num_points = 300, .mean_track = 5});
  data.x[0] = 5e-324, data.x[1] = -0.0, data.x[2] = 1.7976931348623157e308, data.x[3] = 0.1;
  const TempFolder folder;
  WriteBal(folder / "a.txt", data);
  const BundleData back = ReadBal(folder / "a.txt");
  ExpectSameBits(back, data);
}

TEST(BalFile, EmptyProblem) {
  EXPECT_EQ(Read("0 0 0\n").observations.size(), 0u);
  EXPECT_EQ(Read("0 0 0").x.size(), 0u);
}

TEST(BalFile, TruncatedAnywhereIsRefused) {
  const std::string text = kFile;
  // Only the truncation of the last character, after which the file ends in another number or none, may go undetected.
  for (std::size_t length = 0; length < text.size() - 1; ++length) {
    SCOPED_TRACE(length);
    EXPECT_THAT([&] { Read(text.substr(0, length)); }, ThrowsError(kBadFile, "a.txt"));
  }
}

TEST(BalFile, SaysWhichLineIsAtFault) {
  EXPECT_THAT([] { Read(""); }, ThrowsError(kBadFile, "a.txt", "1"));
  for (const auto& [piece, by, line, token] :
       std::vector<std::array<std::string, 4>>{{"2 1 2", "2 1 x", "1", "x"},
                                               {"2 1 2", "2 -1 2", "1", "-1"},
                                               {"2 1 2", "2 1 3000000000", "1", "3000000000"},
                                               {"2 1 2", "2 1 99999999999999999999", "1", "99999999999999999999"},
                                               {"2 1 2", "2000000000 2000000000 2000000000", "1", "2000000000"},
                                               {"1 0 +4", "2 0 +4", "4", "2"},
                                               {"1 0 +4", "1 1 +4", "4", "1"},
                                               {"1 0 +4", "1 -1 +4", "4", "-1"},
                                               {"1 0 +4", "1 0.5 +4", "4", "0.5"},
                                               {"1 0 +4", "1 0 nan", "4", "nan"},
                                               {"-0.125", "-0.125x", "4", "-0.125x"},
                                               {"500", "inf", "11", "inf"},
                                               {"500", "1e999", "11", "1e999"},
                                               {"500", "\x01\xff", "11", "??"},
                                               {"  3", "  3\n\n4", "27", "4"},
                                               {"  3", std::string("3\0", 2), "25", "3?"}}) {
    const std::string text = Replaced(kFile, piece, by);
    EXPECT_THAT([&] { Read(text); }, ThrowsError(kBadFile, "a.txt", line, token)) << text;
  }
}

// Large files are read in parts, in parallel.
TEST(BalFile, LargeFilesHaveTheSameNumbersAndTheFirstError) {
  BundleData data;
  data.num_cameras = 3, data.num_points = 50000;
  CounterRandom random(1, 2);
  for (std::int32_t i = 0; i < 50000; ++i) {
    data.observations.push_back({i % 3, i, {random.Normal() * 1e3, random.Normal()}});
  }
  data.x.resize(static_cast<std::size_t>(9 * data.num_cameras + 3 * data.num_points));
  for (double& value : data.x) value = random.Normal();
  TempFolder folder;
  WriteBal(folder / "a.txt", data);
  const std::string text = ReadFile(folder / "a.txt");
  ASSERT_GT(text.size(), 3u << 20);
  ExpectSameBits(Read(text), data);
  std::string damaged = text;
  for (const std::string line : {"120001", "170001"}) {
    std::size_t at = 0;
    for (Index number = 1; number < std::stoll(line); ++number) at = damaged.find('\n', at) + 1;
    damaged[at] = 'x';
  }
  EXPECT_THAT([&] { Read(damaged); }, ThrowsError(kBadFile, "a.txt", "120001"));
  EXPECT_THAT([&] { Read(text + "\n7"); }, ThrowsError(kBadFile, "a.txt", "200030", "7"));
  EXPECT_THAT([&] { Read(text.substr(0, text.size() / 2)); }, ThrowsError(kBadFile, "a.txt"));
}

TEST(BalFile, MissingAndUnwritable) {
  const TempFolder folder;
  EXPECT_THAT([&] { ReadBal(folder / "none.txt"); }, ThrowsError(kNotFound, "none.txt"));
  EXPECT_THAT([&] { ReadBal(folder.path()); }, ThrowsError(kNotFound, folder.path()));
  // Files are usually distributed compressed.
  WriteBytes(folder / "packed.txt.bz2", "BZh91AY&SY");
  EXPECT_THAT([&] { ReadBal(folder / "packed.txt.bz2"); }, ThrowsError(kUnsupported, "packed.txt.bz2"));
  EXPECT_THAT([&] { WriteBal(folder / "none/a.txt", BundleData{}); }, ThrowsError(kCannotWrite, "none/a.txt"));
}

}  // namespace
}  // namespace vesta::bundle
