// SPDX-License-Identifier: Apache-2.0
// What train and refine write: DIR/point_cloud.ply, DIR/metrics.json and DIR/report.html, which always belong to one
// training; cameras that an earlier one has found go with its splat (camera_files.h).
#pragma once

#include <memory>
#include <string>

#include "apps/cli/outputs.h"
#include "kernels/core/files.h"
#include "problems/gaussian_splatting/model/splat_model.h"

namespace vesta::app {

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
