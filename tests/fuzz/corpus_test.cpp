// SPDX-License-Identifier: Apache-2.0
// Runs the corpus through its targets: seeds, and inputs that fuzzing found.
#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include "kernels/core/files.h"
#include "tests/fuzz/targets.h"

namespace vesta::fuzz {
namespace {

namespace fs = std::filesystem;

struct Target {
  const char* name;  // of its folder
  void (*run)(std::string_view bytes);
};
std::ostream& operator<<(std::ostream& os, const Target& target) { return os << target.name; }

constexpr Target kTargets[] = {{"antimatter_splat", FuzzAntimatterSplat},
                               {"bal", FuzzBal},
                               {"checkpoint", FuzzCheckpoint},
                               {"colmap", FuzzColmap},
                               {"command_line", FuzzCommandLine},
                               {"compressed_ply", FuzzCompressedPly},
                               {"config", FuzzConfig},
                               {"g2o", FuzzG2o},
                               {"image", FuzzImage},
                               {"ksplat", FuzzKsplat},
                               {"nerf", FuzzNerf},
                               {"operators", FuzzOperators},
                               {"point_ply", FuzzPointPly},
                               {"sog", FuzzSog},
                               {"splat_ply", FuzzSplatPly},
                               {"spz", FuzzSpz},
                               {"spz_streams", FuzzSpzStreams}};

const fs::path kCorpus = "tests/fuzz/corpus";

class FuzzCorpus : public testing::TestWithParam<Target> {};

TEST_P(FuzzCorpus, HoldsNoFinding) {
  int files = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(kCorpus / GetParam().name)) {
    SCOPED_TRACE(entry.path());
    EXPECT_NO_THROW(GetParam().run(ReadFile(entry.path().string())));
    ++files;
  }
  EXPECT_GT(files, 0);
}

INSTANTIATE_TEST_SUITE_P(All, FuzzCorpus, testing::ValuesIn(kTargets), testing::PrintToStringParamName());

// Seeds of an older format would be refused at once, without a test of the code behind that check.
TEST(FuzzCorpusSeeds, CheckpointsAreOfThisVersion) {
  for (const char* seed : {"adam", "lm"}) {
    EXPECT_TRUE(ReadsCheckpoint(ReadFile((kCorpus / "checkpoint" / seed).string()))) << seed << ": see docs/fuzzing.md";
  }
}

TEST(FuzzCorpusFolders, AreThoseOfTheTargets) {
  std::set<std::string> names, folders;
  for (const Target& target : kTargets) names.insert(target.name);
  for (const fs::directory_entry& entry : fs::directory_iterator(kCorpus)) folders.insert(entry.path().filename());
  EXPECT_EQ(names, folders);
}

}  // namespace
}  // namespace vesta::fuzz
