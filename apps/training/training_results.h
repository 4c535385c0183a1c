// SPDX-License-Identifier: Apache-2.0
// The output files of train and refine: DIR/point_cloud.ply, DIR/metrics.json, DIR/report.html and DIR/cameras.
#pragma once

#include <memory>
#include <string>

#include "apps/cli/outputs.h"
#include "kernels/core/files.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/train/session/train_result.h"

namespace vesta::app {

// Of the output's folder.
inline constexpr const char* kCameraFolder = "cameras";

// Those of an earlier training.
void RemoveCameras(const OutputFolder& out);

// What was found of the cameras, as a COLMAP model with the scene's points. Returns a line that says so; none where
// nothing moved: then nothing is written.
std::string SaveCameras(const gs::Scene& scene, const gs::TrainResult& result, const OutputFolder& out);

// What train and refine write: DIR/point_cloud.ply, DIR/metrics.json and DIR/report.html, which always belong to one
// training; cameras that an earlier one has found go with its splat (SaveCameras).
// Room on the disk is taken before the work and kept until the results fill it. A program that is killed at any time
// leaves the results of before, or new ones, or a new model alone.
class TrainingResults {
 public:
  // out: must outlive this.
  explicit TrainingResults(OutputFolder* out);

  const std::string& model_path() const { return model_path_; }
  const std::string& metrics_path() const { return metrics_path_; }
  const std::string& report_path() const { return report_path_; }

  // Takes room for `likely` Gaussians; false where there is room for `least` only. Throws Error where not even for
  // those.
  bool Reserve(Index likely, Index least, int sh_degree);
  // What there is before the training is over; then room for as many Gaussians again.
  void SaveModel(const gs::SplatModel& model);
  bool has_saved_model() const { return has_saved_model_; }
  // All but the report, which is written when all else is safe.
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
