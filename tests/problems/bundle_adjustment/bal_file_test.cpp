// SPDX-License-Identifier: Apache-2.0
#include "problems/bundle_adjustment/bal_file.h"

#include "bench/collections/generate_bundle.h"
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

// kFile with one piece replaced must be refused with a message that holds `message`.
void ExpectRefusal(const std::string& piece, const std::string& by, const std::string& message) {
  std::string text = kFile;
  ASSERT_NE(text.find(piece), std::string::npos);
  text.replace(text.find(piece), piece.size(), by);
  ExpectError([&] { Read(text); }, message);
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

TEST(BalFile, ReadsBackBitForBit) {
  BundleData data = Generate({.num_cameras = 20, .num_points = 300, .mean_track = 5});
  data.x[0] = 5e-324, data.x[1] = -0.0, data.x[2] = 1.7976931348623157e308, data.x[3] = 0.1;
  const TempFolder folder;
  WriteBal(folder / "a.txt", data);
  const BundleData back = ReadBal(folder / "a.txt");
  EXPECT_EQ(back.num_cameras, data.num_cameras);
  EXPECT_EQ(back.num_points, data.num_points);
  EXPECT_EQ(std::memcmp(back.x.data(), data.x.data(), data.x.size() * sizeof(double)), 0);
  ASSERT_EQ(back.x.size(), data.x.size());
  ASSERT_EQ(back.observations.size(), data.observations.size());
  for (std::size_t i = 0; i < data.observations.size(); ++i) {
    EXPECT_EQ(back.observations[i].camera, data.observations[i].camera);
    EXPECT_EQ(back.observations[i].point, data.observations[i].point);
    EXPECT_EQ(back.observations[i].pixel[0], data.observations[i].pixel[0]);
    EXPECT_EQ(back.observations[i].pixel[1], data.observations[i].pixel[1]);
  }
}

TEST(BalFile, EmptyProblem) {
  EXPECT_EQ(Read("0 0 0\n").observations.size(), 0u);
  EXPECT_EQ(Read("0 0 0").x.size(), 0u);
}

TEST(BalFile, TruncatedAnywhereIsRefused) {
  const std::string text = kFile;
  // Without its last character the file ends in another number, or none: only the very end may go unnoticed.
  for (std::size_t length = 0; length < text.size() - 1; ++length) {
    SCOPED_TRACE(length);
    ExpectError([&] { Read(text.substr(0, length)); }, "a.txt: ");
  }
}

TEST(BalFile, SaysWhichLineIsAtFault) {
  ExpectError([] { Read(""); }, "a.txt: line 1: the file ends where the number of cameras should stand");
  ExpectRefusal("2 1 2", "2 1 x", "line 1: 'x' where the number of observations should stand");
  ExpectRefusal("2 1 2", "2 -1 2", "line 1: the number of points is -1; it must be 0 to 2147483647");
  ExpectRefusal("2 1 2", "2 1 3000000000", "line 1: the number of observations is 3000000000");
  ExpectRefusal("2 1 2", "2 1 99999999999999999999", "line 1: '99999999999999999999' where");
  ExpectRefusal("2 1 2", "2000000000 2000000000 2000000000", "do not fit into");
  ExpectRefusal("1 0 +4", "2 0 +4", "line 4: '2' where the camera of an observation should stand; it must be 0 to 1");
  ExpectRefusal("1 0 +4", "1 1 +4", "line 4: '1' where the point of an observation should stand; it must be 0 to 0");
  ExpectRefusal("1 0 +4", "1 -1 +4", "line 4: '-1' where the point");
  ExpectRefusal("1 0 +4", "1 0.5 +4", "line 4: '0.5' where the point");
  ExpectRefusal("1 0 +4", "1 0 nan", "line 4: 'nan' where a pixel coordinate should stand; it must be finite");
  ExpectRefusal("-0.125", "-0.125x", "line 4: '-0.125x' where a pixel coordinate");
  ExpectRefusal("500", "inf", "line 11: 'inf' where a parameter should stand; it must be finite");
  ExpectRefusal("500", "1e999", "line 11: '1e999' where a parameter should stand; it must be a number of ordinary");
  ExpectRefusal("500", "\x01\xff", "where a parameter should stand");
  ExpectRefusal("  3", "  3\n\n4", "line 27: '4' where the end of the file should stand");
  ExpectRefusal("  3", std::string("3\0", 2), "'3?' where a parameter");
}

TEST(BalFile, MissingAndUnwritable) {
  const TempFolder folder;
  ExpectError([&] { ReadBal(folder / "none.txt"); }, "none.txt: no such file");
  ExpectError([&] { ReadBal(folder.path()); }, "not a file");
  // As they are handed round.
  WriteBytes(folder / "packed.txt.bz2", "BZh91AY&SY");
  ExpectError([&] { ReadBal(folder / "packed.txt.bz2"); }, "packed.txt.bz2: compressed; unpack it first");
  ExpectError([&] { WriteBal(folder / "none/a.txt", BundleData{}); }, "none/a.txt: cannot be written");
}

}  // namespace
}  // namespace vesta::bundle
