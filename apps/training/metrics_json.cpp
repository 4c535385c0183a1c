// SPDX-License-Identifier: Apache-2.0
#include "apps/training/metrics_json.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "apps/cli/version.h"
#include "apps/settings/train_settings.h"
#include "kernels/core/check.h"
#include "problems/gaussian_splatting/model/splat_model.h"

namespace vesta::app {
namespace {

using Json = nlohmann::ordered_json;

// gs::Quality or ImageQuality.
template <class Q>
Json QualityToJson(const Q& quality) {
  return {{"psnr", quality.psnr}, {"ssim", quality.ssim}};
}
Json ToJson(const gs::Quality& quality) { return QualityToJson(quality); }

Json ToJson(const gs::AlignedView& view) {
  Json json = {{"name", view.name}, {"status", gs::ToString(view.alignment.status)}};
  json.update(QualityToJson(view.whole));
  json["degrees"] = view.degrees;
  json["pixels"] = view.pixels;
  if (!view.has_halves) return json;
  json["right_half"] = QualityToJson(view.right);
  json["right_half_exposed"] = QualityToJson(view.right_exposed);
  json["gain"] = view.exposure.gain;
  json["offset"] = view.exposure.offset;
  return json;
}

Json ToJson(const gs::AlignedEvaluation& aligned) {
  const bool exposed = aligned.right.views > 0;
  Json json = ToJson(aligned.whole);
  if (exposed) json["right_half"] = ToJson(aligned.right), json["right_half_exposed"] = ToJson(aligned.right_exposed);
  json["moved_degrees"] = aligned.degrees;
  json["moved_pixels"] = aligned.pixels;
  json["not_found"] = aligned.not_found;
  json["views"] = Json::array();
  for (const gs::AlignedView& view : aligned.views) json["views"].push_back(ToJson(view));
  return json;
}

Json ToJson(const Communicator& ranks) {
  constexpr double kBytesInMib = 1 << 20;
  const RankTraffic& traffic = ranks.traffic();
  return {{"count", ranks.size()},
          {"exchanges", traffic.exchanges},
          {"received_mib", static_cast<double>(traffic.bytes) / kBytesInMib},
          {"exchange_seconds", traffic.seconds}};
}

Json ToJson(const std::vector<PhaseRow>& phases) {
  Json json = Json::array();
  for (const PhaseRow& row : phases) {
    json.push_back({{"phase", row.name},
                    {"depth", row.depth},
                    {"calls", row.calls},
                    {"wall_seconds", row.seconds.wall},
                    {"cpu_seconds", row.seconds.cpu}});
  }
  return json;
}

Json ToJson(const gs::HistoryRow& row) {
  Json json = {{"stage", gs::StageName(row.stage)},
               {"iteration", row.iteration},
               {"seconds", row.seconds},
               {"cost", row.cost},
               {"train_psnr", row.train.psnr},
               {"train_ssim", row.train.ssim},
               {"test_psnr", row.test.psnr},
               {"test_ssim", row.test.ssim},
               {"gaussians", row.gaussians}};
  if (row.held_out.views > 0) json["held_out_psnr"] = row.held_out.psnr, json["held_out_ssim"] = row.held_out.ssim;
  return json;
}

void AddModel(const gs::SplatModel& model, Json* json) {
  (*json)["gaussians"] = model.count;
  // For a reader of the splat file.
  (*json)["parameters"] = gs::OrderByDegree(model, gs::StoredDegrees(model)).layout.Size();
}

void AddCameras(const gs::TrainResult& result, Json* json) {
  const gs::CameraChanges& changes = result.camera_changes;
  Json cameras = {{"moved_degrees", changes.degrees},         {"moved_pixels", changes.pixels},
                  {"moved_pixels_most", changes.most_pixels}, {"gain_most", changes.most_gain},
                  {"focal_most", changes.most_focal},         {"views", Json::array()}};
  for (const gs::ViewUnknowns& view : result.cameras) {
    cameras["views"].push_back({{"quaternion", view.motion.quaternion},
                                {"translation", view.motion.translation},
                                {"gain", view.color.gain},
                                {"offset", view.color.offset},
                                {"log_focal", view.lens.log_focal},
                                {"principal_shift", view.lens.shift}});
  }
  (*json)["cameras"] = std::move(cameras);
}

// End of a stage: the seconds of its last row, or of the stage before.
double EndOfAdam(const std::vector<gs::HistoryRow>& history) {
  double end = history.front().seconds;
  for (const gs::HistoryRow& row : history) {
    if (row.stage == gs::Stage::kAdam) end = row.seconds;
  }
  return end;
}

// File names need not be valid UTF-8.
std::string Text(const Json& json) { return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n"; }

}  // namespace

std::string MetricsJson(const gs::TrainResult& result, const RunFacts& facts, const TrainSettings& settings) {
  VESTA_CHECK(!result.history.empty(), "no evaluation to write");
  const double adam_end = EndOfAdam(result.history);
  Json json;
  json["test"] = ToJson(result.history.back().test);
  json["train"] = ToJson(result.history.back().train);
  if (result.history.back().held_out.views > 0) json["held_out"] = ToJson(result.history.back().held_out);
  AddModel(result.model, &json);
  json["seconds"] = {{"load", facts.load_seconds},
                     {"adam_end", adam_end},
                     {"lm_end", std::max(adam_end, result.history.back().seconds)},
                     {"eval", result.eval_seconds},
                     {"total", facts.total_seconds}};
  json["peak_memory_mib"] = facts.peak_memory_mib;
  json["memory"] = {{"predicted_mib", result.memory.predicted_mib},
                    {"peak_mib", facts.peak_memory_mib},
                    {"budget_mib", 1024 * settings.options.memory.budget_gib},
                    {"jacobian", schema::NameOf(result.memory.jacobian, gs::kJacobianKinds)},
                    {"batches", result.memory.batches}};
  if (result.memory.device_free_mib > 0) {
    json["memory"]["gpu"] = {{"predicted_mib", result.memory.device_predicted_mib},
                             {"peak_mib", result.memory.device_peak_mib},
                             {"free_mib", result.memory.device_free_mib}};
  }
  json["version"] = Version();
  json["command"] = facts.command;
  json["scene"] = facts.scene;
  for (const auto& [name, value] : facts.scene_flags) json["scene_flags"][name] = value;
  json["device"] = facts.device;
  json["threads"] = facts.threads;
  if (facts.ranks) json["processes"] = ToJson(*facts.ranks);
  if (!facts.profile.empty()) json["profile"] = ToJson(facts.profile);
  json["seed"] = settings.options.seed;
  json["preset"] = settings.preset;
  json["options"] = OptionsJson(settings.options);
  if (!result.cameras.empty()) AddCameras(result, &json);
  if (!result.notes.empty()) json["notes"] = result.notes;
  json["history"] = Json::array();
  for (const gs::HistoryRow& row : result.history) json["history"].push_back(ToJson(row));
  return Text(json);
}

std::string EvaluationJson(const gs::Evaluation& evaluation, const gs::AlignedEvaluation* aligned,
                           const gs::SplatModel& model, const RunFacts& facts) {
  Json json;
  json["test"] = ToJson(evaluation.test);
  if (aligned != nullptr) json["aligned"] = ToJson(*aligned);
  json["train"] = ToJson(evaluation.train);
  json["cost"] = evaluation.cost;
  json["eps2d"] = model.eps2d;
  json["antialiased"] = model.antialiased;
  AddModel(model, &json);
  json["device"] = facts.device;
  json["threads"] = facts.threads;
  return Text(json);
}

}  // namespace vesta::app
