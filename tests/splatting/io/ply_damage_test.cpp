// SPDX-License-Identifier: Apache-2.0
// Splats that cannot be used: each gives one line, none crashes.
#include "tests/splatting/io/test_ply.h"

namespace vesta::gs {
namespace {

class PlyDamage : public testing::Test {
 protected:
  PlyDamage() {
    WriteSplatPly(path_, ExampleSplat(1, 3));
    bytes_ = ReadBytes(path_);
  }
  void ExpectRefused(const std::string& bytes, const std::string& part) {
    WriteBytes(path_, bytes);
    ExpectError([&] { ReadSplatPly(path_); }, path_ + ": " + part);
  }
  std::string Replaced(const std::string& from, const std::string& to) const {
    std::string bytes = bytes_;
    const std::size_t at = bytes.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return bytes.replace(at, from.size(), to);
  }
  TempFolder folder_;
  std::string path_ = folder_ / "a.ply";
  std::string bytes_;
};

TEST_F(PlyDamage, EveryPrefixIsRefused) {
  for (std::size_t length = 0; length < bytes_.size(); ++length) ExpectRefused(bytes_.substr(0, length), "");
}

TEST_F(PlyDamage, OverwrittenBytesLoadOrAreRefused) {
  int refused = 0;
  ForDamagedCopies(bytes_, 500, [&](const std::string& damaged) {
    WriteBytes(path_, damaged);
    refused += ErrorOf([&] { ReadSplatPly(path_); }).empty() ? 0 : 1;
  });
  EXPECT_GT(refused, 0);
}

TEST_F(PlyDamage, MessagesSayWhatIsWrong) {
  ExpectRefused("", "not a .ply file");
  ExpectRefused("plywood\n", "not a .ply file");
  ExpectRefused(Replaced("binary_little_endian", "binary_big_endian"), "its format binary_big_endian is not read");
  ExpectRefused(Replaced("format binary_little_endian 1.0\n", ""), "the header has no format line");
  ExpectRefused(Replaced("end_header", "end_footer"), "the header has no end_header");
  ExpectRefused(Replaced("vertex 3", "vertex 18446744073709551615"), "the header's number of vertices");
  ExpectRefused(Replaced("vertex 3", "vertex -3"), "the header's number of vertices");
  ExpectRefused(Replaced("vertex 3", "vertex 9223372036854775807"), "the header counts 9223372036854775807 vertices");
  ExpectRefused(Replaced("vertex 3", "vertex 4"), "the header counts 4 vertices, but the 312 bytes after it hold 3");
  ExpectRefused(Replaced("vertex 3", "vertex 0"), "it holds no Gaussians");
  ExpectRefused(Replaced("element vertex", "element corner"), "it has no vertices with properties");
  ExpectRefused(Replaced("element vertex", "element face 1\nproperty list uchar int i\nelement vertex"),
                "unknown property type 'list'");
  ExpectRefused(Replaced("property float nx", "property list uchar int nx"), "unknown property type 'list'");
  ExpectRefused(Replaced("float ny", "float nx"), "the header has a property without a name of its own");
  ExpectRefused(Replaced("scale_2", "size__2"),
                "not a splat in the INRIA layout: its vertices have no property scale_2");
  ExpectRefused(Replaced("float opacity", "float f_rest_9"), "10 properties f_rest_*; a splat of degree 0, 1, 2 or 3");
  ExpectRefused(Replaced("f_rest_3", "f_rest_x"),
                "not a splat in the INRIA layout: its vertices have no property f_rest_3");
  ExpectRefused(Replaced("element", "comment vesta background 1 2 3\nelement"), "the comment 'vesta background'");
  ExpectRefused(Replaced("element", "comment vesta background 1 0\nelement"), "the comment 'vesta background'");
  for (const char* number : {"", " 0", " 0.009", " 5", " -1", " nan", " x"}) {
    ExpectRefused(Replaced("element", std::string("comment vesta low_pass") + number + "\nelement"),
                  "the comment 'vesta low_pass' is not followed by a number in 0.01..4");
  }
  ExpectRefused(Replaced("element", "comment vesta origin 1 two 3\nelement"), "the comment 'vesta origin'");
  ExpectRefused(Replaced("element", "comment vesta origin 1 2 inf\nelement"), "the comment 'vesta origin'");
  ExpectRefused("\x1f\x8b\x08 and so on", "compressed by gzip");
  ExpectRefused(Replaced("binary_little_endian", "ascii"), "");
}

TEST_F(PlyDamage, AsciiCutsAreRefused) {
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
      "property float z\nend_header\n";
  const std::string values = "1 2 3\n4 5 6";
  for (std::size_t length = 0; length < values.size(); ++length) {
    WriteBytes(path_, header + values.substr(0, length));
    EXPECT_THAT(ErrorOf([&] { ReadPointPly(path_); }), testing::HasSubstr(path_ + ": ")) << length;
  }
  WriteBytes(path_, header + "1 2 3\n4 5 six\n");
  ExpectError([&] { ReadPointPly(path_); }, "z of vertex 1 is missing or not a number");
}

}  // namespace
}  // namespace vesta::gs
