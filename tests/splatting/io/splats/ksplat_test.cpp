// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/splats/ksplat.h"

#include <cmath>

#include "splatting/io/splats/splat_file.h"
#include "tests/splatting/io/ksplat_parts.h"
#include "tests/splatting/io/random_splat.h"
#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

class Ksplat : public testing::Test {
 protected:
  SplatModel Read(const std::string& file) {
    WriteBytes(path_, file);
    return ReadSplat(path_);
  }
  template <class... Tokens>
  void ExpectRefused(const std::string& file, ErrorCode code, const Tokens&... tokens) {
    WriteBytes(path_, file);
    EXPECT_THAT([&] { ReadSplat(path_); }, ThrowsError(code, path_, tokens...));
  }
  TempFolder folder_;
  std::string path_ = folder_ / "a.ksplat";
};

TEST_F(Ksplat, ReadsAllLevelsAndDegrees) {
  for (int level = 0; level <= 2; ++level) {
    for (std::uint16_t degree = 0; degree <= 2; ++degree) {
      SCOPED_TRACE(testing::Message() << "level " << level << ", degree " << degree);
      KsplatParts parts;
      parts.level = level;
      parts.sections[0].degree = degree;
      const SplatModel model = Read(parts.File());
      ASSERT_EQ(model.count, 2);
      ASSERT_EQ(model.sh_degree, degree);
      // Units of a mean: half a block over 1000.
      const float first[] = {1, level == 0 ? 2.0f : 3, level == 0 ? 3.0f : -1};
      const float quaternion[] = {0.5f, 0, 0, -0.25f}, color[] = {1, 0, 0.2f};
      for (int k = 0; k < 3; ++k) {
        EXPECT_NEAR(model.attribute(splat::kMean + k)[0], first[k], 1e-6);
        EXPECT_NEAR(model.attribute(splat::kMean + k)[1], first[k] + (level == 0 ? 0 : 10), 1e-5);
        EXPECT_NEAR(model.attribute(splat::kSh + k)[0], (color[k] - 0.5f) / 0.28209479f, 1e-5);
      }
      EXPECT_EQ(model.attribute(splat::kLogScale)[0], 0);
      EXPECT_EQ(model.attribute(splat::kLogScale + 1)[1], std::log(0.5f));
      EXPECT_EQ(model.attribute(splat::kLogScale + 2)[1], std::log(level == 0 ? 0x1p-25f : 0x1p-24f));
      for (int k = 0; k < 4; ++k) EXPECT_EQ(model.attribute(splat::kQuaternion + k)[1], quaternion[k]);
      EXPECT_NEAR(Opacity(model, 1), 128.0 / 255, 1e-6);
      // The value of coefficient c and a channel is at 3 channel + c - 1 of band 1, and at 9 + 5 channel + c - 4 of
      // band 2.
      for (int a = splat::kSh + 3; a < model.num_attributes(); ++a) {
        const int c = (a - splat::kSh) / 3, channel = (a - splat::kSh) % 3;
        const int at = c < 4 ? 3 * channel + c - 1 : 9 + 5 * channel + c - 4;
        EXPECT_EQ(model.attribute(a)[1], at % 2 == 1 ? 1 : 0.5f) << a;
      }
    }
  }
}

TEST_F(Ksplat, JoinsSections) {
  KsplatParts parts;
  parts.sections = {{}, {}, {}};
  parts.sections[0].degree = 1;
  parts.sections[1].count = 0;
  parts.sections[2].count = 1;
  parts.num_sections = 3;
  parts.count = 3;
  const SplatModel model = Read(parts.File());
  ASSERT_EQ(model.count, 3);
  EXPECT_EQ(model.DegreeOf(1), 1);
  EXPECT_EQ(model.DegreeOf(2), 0);
  EXPECT_EQ(model.attribute(splat::kMean)[0], 1);
  EXPECT_EQ(model.attribute(splat::kMean)[1], 11);
  EXPECT_EQ(model.attribute(splat::kMean)[2], 1);
}

// Zero stands for the usual limits.
TEST_F(Ksplat, UsualLimitsOfHarmonics) {
  KsplatParts parts;
  parts.level = 2;
  parts.min_sh = parts.max_sh = 0;
  parts.sections[0].degree = 1;
  const SplatModel model = Read(parts.File());
  EXPECT_EQ(model.attribute(splat::kSh + 3)[0], -1.5f);
  EXPECT_EQ(model.attribute(splat::kSh + 6)[0], 1.5f);
}

TEST_F(Ksplat, EveryShorterFileIsRefused) {
  KsplatParts parts;
  parts.sections[0].degree = 1;
  const std::string file = parts.File();
  for (std::size_t length = 5000; length < file.size(); ++length) ExpectRefused(file.substr(0, length), kBadFile);
  for (const std::size_t length : {0u, 1u, 45u, 4095u, 4096u}) ExpectRefused(file.substr(0, length), kBadFile);
}

TEST_F(Ksplat, OverwrittenBytesLoadOrAreRefused) {
  const std::string file = KsplatParts().File();
  // Without the unused bytes of the headers.
  const std::string used = file.substr(0, 44) + file.substr(4096, 42) + file.substr(5120);
  const int refused = CountRefusedCopies(used, 500, [&](const std::string& damaged) {
    std::string whole = file;
    whole.replace(0, 44, damaged.substr(0, 44)).replace(4096, 42, damaged.substr(44, 42));
    Read(whole.replace(5120, std::string::npos, damaged.substr(86)));
  });
  EXPECT_TRUE(refused > 0 && refused < 500) << refused;
}

TEST_F(Ksplat, MessagesNameTheProblem) {
  const auto refused = [&](const auto& change, ErrorCode code, const std::string& token) {
    KsplatParts parts;
    change(&parts, &parts.sections[0]);
    ExpectRefused(parts.File(), code, token);
  };
  using P = KsplatParts;
  using S = KsplatSection;
  refused([](P* p, S*) { p->minor = 7; }, kUnsupported, "0.7");
  refused([](P* p, S*) { p->level = 3; }, kUnsupported, "3");
  refused([](P* p, S*) { p->count = 0; }, kBadFile, "");
  refused([](P* p, S*) { p->count = 77; }, kBadFile, "77");
  refused([](P* p, S*) { p->num_sections = 0xffffffff; }, kBadFile, "headers");
  refused([](P*, S* s) { s->degree = 3; }, kBadFile, "3");
  refused([](P*, S* s) { s->count = 3; }, kBadFile, "");
  refused([](P*, S* s) { s->bucket_bytes = 8; }, kBadFile, "");
  refused([](P*, S* s) { s->full = 2; }, kBadFile, "");
  refused([](P*, S* s) { s->full = s->other = 0xffffffff; }, kBadFile, "");
  refused([](P*, S* s) { s->buckets = 0xffffffff; }, kBadFile, "centres");
  refused([](P*, S* s) { s->bucket_size = 0; }, kBadFile, "1");
  refused([](P*, S* s) { s->other_size = 0; }, kBadFile, "1");
  std::string file = KsplatParts().File();
  ExpectRefused(file.replace(4100, 4, "\xff\xff\xff\xff"), kBadFile, "Gaussians");
}

}  // namespace
}  // namespace vesta::gs
