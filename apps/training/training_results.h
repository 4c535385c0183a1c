// SPDX-License-Identifier: Apache-2.0
// The output files of train, refine and prune: DIR/point_cloud.ply, DIR/metrics.json, DIR/report.html and DIR/cameras.
#pragma once

#include <memory>
#include <string>

#include "apps/cli/outputs.h"
#include "kernels/core/files.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/train/session/train_result.h"

namespace vesta::app {

// Subfolder of the output folder for refined cameras.
inline constexpr const char* kCameraFolder = "cameras";

// Removes the refined cameras of an earlier training.
void RemoveCameras(const OutputFolder& out);

// Writes refined cameras and the points of the scene as a COLMAP model. Returns one line for the user. If cameras were
// not refined, writes nothing and returns an empty text.
std::string SaveCameras(const gs::Scene& scene, const gs::TrainResult& result, const OutputFolder& out);

// Writes DIR/point_cloud.ply, DIR/metrics.json and DIR/report.html. DIR never has files of different trainings, because
// writing the new splat removes the files of an earlier training, including its cameras. Disk space is reserved before
// the training. If the program is killed, DIR has the old results, the new results, or only the new splat.
class TrainingResults {
 public:
  // Must outlive this object.
  explicit TrainingResults(OutputFolder* out);

  const std::string& model_path() const { return model_path_; }
  const std::string& metrics_path() const { return metrics_path_; }
  const std::string& report_path() const { return report_path_; }

  // Reserves disk space for `likely` Gaussians. If there is too little, reserves space for `least` Gaussians instead
  // and returns false. Throws Error if that fails too.
  bool Reserve(Index likely, Index least, int sh_degree);
  // Writes the splat before the LM stage, then reserves the same space.
  void SaveModel(const gs::SplatModel& model);
  bool has_saved_model() const { return has_saved_model_; }
  // Writes the splat and metrics.json; the caller then writes the report.
  void Save(const gs::SplatModel& model, const std::string& metrics);

 private:
  void Open();
  void CommitModel(const gs::SplatModel& model);

  OutputFolder* out_;
  std::string model_path_, metrics_path_, report_path_;
  std::unique_ptr<AtomicFile> model_, metrics_;  // open until they are saved
  bool has_saved_model_ = false;
};

}  // namespace vesta::app
