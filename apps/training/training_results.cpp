// SPDX-License-Identifier: Apache-2.0
#include "apps/training/training_results.h"

#include <cstdint>
#include <filesystem>

#include "apps/training/camera_files.h"
#include "kernels/core/check.h"
#include "kernels/core/profile.h"
#include "splatting/io/splats/ply.h"

namespace vesta::app {
namespace {

constexpr std::int64_t kMetricsBytes = 1 << 18;  // of some hundred rows of history
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
  model_.reset();  // its temporary file has the name of the next one's
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
  // Between this and new ones there are none: those of an earlier training are not this model's.
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
    Open();  // what comes later does not follow what there was no room for
    throw;
  }
  has_saved_model_ = true;
  out_->Keep();
  Open();
  Reserve(model.count, model.count, model.sh_degree);
}

void TrainingResults::Save(const gs::SplatModel& model, const std::string& metrics) {
  const ScopedPhase phase("write results");
  if (!model_ || !metrics_) Open();  // where that failed before
  metrics_->Write(metrics);
  metrics_->Finish();
  CommitModel(model);
  metrics_->Commit();
  out_->Keep();
}

}  // namespace vesta::app
