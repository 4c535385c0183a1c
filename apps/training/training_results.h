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

// Subfolder of the output folder for the refined cameras.
inline constexpr const char* kCameraFolder = "cameras";

// Removes the refined cameras of an earlier training from the output folder.
void RemoveCameras(const OutputFolder& out);

// Writes the refined cameras and the points of the scene as a COLMAP model. Returns one line for the user. If cameras
// were not refined, writes nothing and returns an empty text.
std::string SaveCameras(const gs::Scene& scene, const gs::TrainResult& result, const OutputFolder& out);

// Writes DIR/point_cloud.ply, DIR/metrics.json and DIR/report.html, so that DIR never has files of different trainings:
// the files of an earlier training, also its cameras, are removed when the new splat is written. Disk space is reserved
// before the training. If the program is killed, DIR has the old results, the new results, or only the new splat.
class TrainingResults {
 public:
  // out: must outlive this object.
  explicit TrainingResults(OutputFolder* out);

  const std::string& model_path() const { return model_path_; }
  const std::string& metrics_path() const { return metrics_path_; }
  const std::string& report_path() const { return report_path_; }

  // Reserves disk space for `likely` Gaussians. If there is too little, reserves it for `least` Gaussians and returns
  // false. Throws Error if there is too little for that too.
  bool Reserve(Index likely, Index least, int sh_degree);
  // Writes the splat before the LM stage, then reserves space for a splat of the same size.
  void SaveModel(const gs::SplatModel& model);
  bool has_saved_model() const { return has_saved_model_; }
  // Writes the splat and metrics.json. The caller writes the report afterwards.
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
