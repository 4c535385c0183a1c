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

// Subfolder of the output folder.
inline constexpr const char* kCameraFolder = "cameras";

// Removes the cameras of an earlier training.
void RemoveCameras(const OutputFolder& out);

// Writes the refined cameras as a COLMAP model with the points of the scene. Returns a line for the user; if no camera
// moved, writes nothing and returns an empty text.
std::string SaveCameras(const gs::Scene& scene, const gs::TrainResult& result, const OutputFolder& out);

// The results of train and refine: DIR/point_cloud.ply, DIR/metrics.json and DIR/report.html, always from the same
// training. Cameras of an earlier training are removed together with its splat. Disk space is reserved before the
// training and kept until the results are written. If the program is killed, the folder has the old results, the new
// results, or only the new model.
class TrainingResults {
 public:
  // out: must outlive this object.
  explicit TrainingResults(OutputFolder* out);

  const std::string& model_path() const { return model_path_; }
  const std::string& metrics_path() const { return metrics_path_; }
  const std::string& report_path() const { return report_path_; }

  // Reserves disk space for `likely` Gaussians; returns false if there is only space for `least`. Throws Error if there
  // is less.
  bool Reserve(Index likely, Index least, int sh_degree);
  // Writes an intermediate model, then reserves space for as many Gaussians again.
  void SaveModel(const gs::SplatModel& model);
  bool has_saved_model() const { return has_saved_model_; }
  // Writes everything except the report, which is written last.
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
