// SPDX-License-Identifier: Apache-2.0
#include "apps/training/training_results.h"

#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <system_error>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "kernels/core/profile.h"
#include "splatting/cameras/unknowns/moved_view.h"
#include "splatting/io/scenes/colmap.h"
#include "splatting/io/splats/ply.h"

namespace vesta::app {

void RemoveCameras(const OutputFolder& out) {
  const std::string folder = out.File(kCameraFolder);
  if (!FolderExists(folder)) return;
  RemoveAbandonedTemporaries(folder, [](const std::string& name) { return name.ends_with(".txt"); });
  std::error_code ignored;
  for (const char* file : {"/cameras.txt", "/images.txt", "/points3D.txt", ""}) {  // the folder too, if it is empty
    std::filesystem::remove(folder + file, ignored);
  }
}

std::string SaveCameras(const gs::Scene& scene, const gs::TrainResult& result, const OutputFolder& out) {
  const gs::CameraChanges& changes = result.camera_changes;
  if (changes.is_none()) return "";
  const std::string folder = out.File(kCameraFolder);
  gs::WriteColmapModel(gs::ColmapOf(scene, gs::MovedViews(scene, result.cameras)), folder, gs::ColmapFormat::kText);
  const auto by = [](const char* what, double part) {
    return part > 0 ? fmt::format("; {} by up to {:.1f} %", what, 100 * part) : "";
  };
  return fmt::format(
      "cameras moved by {:.2f} pixels and {:.3f} degrees (medians), {:.2f} pixels at most{}{}; saved as the COLMAP "
      "model {}\n",
      changes.pixels, changes.degrees, changes.most_pixels, by("exposure gains changed", changes.most_gain),
      by("focal lengths changed", changes.most_focal), folder);
}

namespace {

constexpr std::int64_t kMetricsBytes = 1 << 18;  // enough for some hundred rows of history
constexpr std::int64_t kHeaderBytes = 1 << 14;

}  // namespace

TrainingResults::TrainingResults(OutputFolder* out)
    : out_(out),
      model_path_(out->File("point_cloud.ply")),
      metrics_path_(out->File("metrics.json")),
      report_path_(out->File("report.html")) {
  Open();
}

void TrainingResults::Open() {
  if (!metrics_) metrics_ = std::make_unique<AtomicFile>(metrics_path_);
  model_.reset();  // releases its temporary file, whose name the next one needs
  model_ = std::make_unique<AtomicFile>(model_path_);
}

bool TrainingResults::Reserve(Index likely, Index least, int sh_degree) {
  const ScopedPhase phase("write results");
  const auto reserve = [&](Index gaussians) {
    model_->Reserve(kHeaderBytes + gs::SplatPlyBytes(gaussians, sh_degree));
  };
  bool has_room = true;
  try {
    reserve(likely);
  } catch (const Error&) {
    has_room = false;
    reserve(least);
  }
  metrics_->Reserve(kMetricsBytes);
  return has_room;
}

void TrainingResults::CommitModel(const gs::SplatModel& model) {
  gs::WriteSplatPly(*model_, model);
  model_->Finish();
  // Results of an earlier training do not belong to the new model.
  std::error_code ignored;
  std::filesystem::remove(metrics_path_, ignored);
  std::filesystem::remove(report_path_, ignored);
  RemoveCameras(*out_);
  model_->Commit();
}

void TrainingResults::SaveModel(const gs::SplatModel& model) {
  const ScopedPhase phase("write results");
  try {
    CommitModel(model);
  } catch (const Error&) {
    Open();  // opens new files after the failed write
    throw;
  }
  has_saved_model_ = true;
  out_->Keep();
  Open();
  Reserve(model.count, model.count, model.sh_degree);
}

void TrainingResults::Save(const gs::SplatModel& model, const std::string& metrics) {
  const ScopedPhase phase("write results");
  if (!model_ || !metrics_) Open();  // if opening failed before
  metrics_->Write(metrics);
  metrics_->Finish();
  CommitModel(model);
  metrics_->Commit();
  out_->Keep();
}

}  // namespace vesta::app
