// SPDX-License-Identifier: Apache-2.0
// Damaged splat .ply files give a one-line error, without a crash.
#include <array>

#include "tests/splatting/io/test_ply.h"

namespace vesta::gs {
namespace {

class PlyDamage : public testing::Test {
 protected:
  PlyDamage() {
    WriteSplatPly(path_, ExampleSplat(1, 3));
    bytes_ = ReadBytes(path_);
  }
  template <class... Tokens>
  void ExpectRefused(const std::string& bytes, ErrorCode code, const Tokens&... tokens) {
    WriteBytes(path_, bytes);
    EXPECT_THAT([&] { ReadSplatPly(path_); }, ThrowsError(code, path_, tokens...));
  }
  TempFolder folder_;
  std::string path_ = folder_ / "a.ply";
  std::string bytes_;
};

TEST_F(PlyDamage, EveryPrefixIsRefused) {
  for (std::size_t length = 0; length < bytes_.size(); ++length) ExpectRefused(bytes_.substr(0, length), kBadFile);
}

TEST_F(PlyDamage, OverwrittenBytesLoadOrAreRefused) {
  const auto read = [&](const std::string& damaged) {
    WriteBytes(path_, damaged);
    ReadSplatPly(path_);
  };
  EXPECT_GT(CountRefusedCopies(bytes_, 500, read), 0);
}

TEST_F(PlyDamage, MessagesNameWhatIsWrong) {
  for (const auto& [from, to, token] : std::vector<std::array<const char*, 3>>{
           {"format binary_little_endian 1.0\n", "", ""},
           {"binary_little_endian", "ascii", ""},
           {"end_header", "end_footer", "end_header"},
           {"vertex 3", "vertex 18446744073709551615", ""},
           {"vertex 3", "vertex -3", ""},
           {"vertex 3", "vertex 9223372036854775807", "9223372036854775807"},
           {"vertex 3", "vertex 4", "312"},
           {"vertex 3", "vertex 0", ""},
           {"element vertex", "element corner", ""},
           {"element vertex", "element face 1000000\nproperty list uchar int i\nelement vertex", "face"},
           {"property float nx", "property list uchar", ""},
           {"property float nx", "property list uchar int nx", "list"},
           {"float ny", "float nx", ""},
           {"scale_1", "size__1", "scale_1"},
           {"float opacity", "float f_rest_9", "10"},
           {"f_rest_3", "f_rest_x", "f_rest_3"}}) {
    ExpectRefused(Replaced(bytes_, from, to), kBadFile, token);
  }
  for (const char* comment : {"background 1 2 3", "background 1 0", "origin 1 two 3", "origin 1 2 inf", "eps2d",
                              "eps2d 0", "eps2d 0.009", "eps2d 5", "eps2d -1", "eps2d nan", "eps2d x"}) {
    const std::string text = comment, key = text.substr(0, text.find(' '));
    ExpectRefused(Replaced(bytes_, "element", "comment vesta " + text + "\nelement"), kBadFile, key);
  }
  for (const char* none : {"", "plywood\n"}) ExpectRefused(none, kBadFile);
  ExpectRefused(Replaced(bytes_, "binary_little_endian", "binary_middle_endian"), kUnsupported, "binary_middle_endian");
  ExpectRefused("\x1f\x8b\x08 and so on", kUnsupported);
}

TEST_F(PlyDamage, AsciiCutsAreRefused) {
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
      "property float z\nend_header\n";
  const std::string values = "1 2 3\n4 5 6";
  for (std::size_t length = 0; length < values.size(); ++length) {
    WriteBytes(path_, header + values.substr(0, length));
    EXPECT_THAT([&] { ReadPointPly(path_); }, ThrowsError(kBadFile, path_)) << length;
  }
  WriteBytes(path_, header + "1 2 3\n4 5 six\n");
  EXPECT_THAT([&] { ReadPointPly(path_); }, ThrowsError(kBadFile, "1"));
}

}  // namespace
}  // namespace vesta::gs
