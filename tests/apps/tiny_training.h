// SPDX-License-Identifier: Apache-2.0
// Trainings of the tiny scene with the program.
#pragma once

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/apps/run_program.h"
#include "tests/apps/tiny_scene.h"

namespace vesta::test {

using nlohmann::json;

inline std::vector<std::string> Keys(const json& object) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : object.items()) keys.push_back(key);
  return keys;
}

class TinyTraining : public testing::Test {
 protected:
  TinyTraining() { WriteTinyScene(scene_); }

  static std::string Ply(const std::string& out) { return out + "/point_cloud.ply"; }
  static json Metrics(const std::string& out) { return json::parse(ReadBytes(out + "/metrics.json")); }

  ProgramOutput Train(const std::string& out, std::vector<std::string> flags) const {
    flags.insert(flags.begin(), {"train", scene_, "--out=" + out});
    return RunProgram(flags);
  }

  // `vesta eval` must reproduce the figures in metrics.json.
  void ExpectEvalReproduces(const std::string& out) const {
    const std::string file = folder_ / "eval.json";
    const ProgramOutput output = RunProgram({"eval", Ply(out), scene_, "--json=" + file});
    ASSERT_EQ(output.status, 0) << output.err;
    const json eval = json::parse(ReadBytes(file)), metrics = Metrics(out);
    for (const char* split : {"test", "train"}) {
      EXPECT_NEAR(eval[split]["psnr"], metrics[split]["psnr"].get<double>(), 0.01);
      EXPECT_NEAR(eval[split]["ssim"], metrics[split]["ssim"].get<double>(), 0.001);
    }
    EXPECT_EQ(eval["gaussians"], metrics["gaussians"]);
    EXPECT_EQ(eval["parameters"], metrics["parameters"]);
  }

  TempFolder folder_;
  std::string scene_ = folder_ / "scene", out_ = folder_ / "new/out";
};

}  // namespace vesta::test
