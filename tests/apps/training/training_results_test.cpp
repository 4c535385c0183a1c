// SPDX-License-Identifier: Apache-2.0
#include "apps/training/training_results.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <csignal>

#include "kernels/core/check.h"
#include "splatting/io/splats/ply.h"
#include "tests/support/test_files.h"

namespace vesta::app {
namespace {

// Limits the size of written files, to emulate a full disk.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() { setrlimit(RLIMIT_FSIZE, &before_); }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit before_ = {};
};

// If Adam's result cannot be saved, LM is skipped. The final result is saved once the disk has space.
TEST(TrainingResults, WhatFoundNoRoomIsNotPartOfWhatComesLater) {
  const TempFolder folder;
  OutputFolder out(folder / "out");
  TrainingResults results(&out);
  gs::SplatModel model;
  model.Resize(0, 2000);
  std::fill_n(model.attribute(splat::kQuaternion), model.count, 1.0f);
  {
    const FileSizeLimit limit(50000);
    EXPECT_THROW(results.SaveModel(model), Error);
  }
  EXPECT_FALSE(results.has_saved_model());
  results.Save(model, "{}");
  gs::WriteSplatPly(folder / "alone.ply", model);
  EXPECT_EQ(ReadBytes(results.model_path()), ReadBytes(folder / "alone.ply"));
  EXPECT_EQ(ReadBytes(results.metrics_path()), "{}");
}

}  // namespace
}  // namespace vesta::app
