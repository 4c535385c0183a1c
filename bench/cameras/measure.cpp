#include "bench/cameras/measure.h"

#include <algorithm>
#include <cmath>

#include "bench/cameras/gains.h"
#include "problems/gaussian_splatting/cameras/aligned_evaluation.h"
#include "problems/gaussian_splatting/cameras/moved_view.h"
#include "problems/gaussian_splatting/evaluate/renderer.h"
#include "problems/gaussian_splatting/model/median.h"
#include "problems/gaussian_splatting/model/to_kernel.h"
#include "problems/gaussian_splatting/train/training_cameras.h"

namespace vesta::bench {
namespace {

// Median over the training views of how much longer or shorter focal lengths are than the true ones, as a part.
double FocalError(const std::vector<const gs::View*>& truth, const std::vector<const gs::View*>& found) {
  std::vector<double> errors;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    errors.push_back(std::abs(found[i]->camera.lens.fx / truth[i]->camera.lens.fx - 1));
  }
  return gs::Median(std::move(errors));
}

// Photographs of views that were found brighter or darker together with others: gains of both, one after the other.
std::vector<double> Product(std::vector<double> a, const std::vector<double>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] *= b[i];
  return a;
}

}  // namespace

FoundCameras FoundBy(const gs::TrainResult& result, const gs::Scene& given) {
  FoundCameras found{given, GainsOf(given, result.cameras)};
  const std::vector<gs::View> moved = gs::MovedViews(given, result.cameras);
  for (std::size_t v = 0; v < moved.size(); ++v) {
    gs::View& view = found.scene.views[v];
    view.camera = moved[v].camera, view.rotation = moved[v].rotation, view.translation = moved[v].translation;
  }
  return found;
}

Row MeasureCameras(const TrueCameras& truth, const FoundCameras& found, const std::optional<FoundCameras>& settled) {
  const std::vector<const gs::View*> trained = gs::TrainingViews(found.scene.views);
  const PoseError error = ErrorOf(truth.scene, trained);
  const PoseError left = settled ? ErrorOf(settled->scene, trained) : PoseError();
  return {{"off_degrees", error.degrees},
          {"off_pixels", error.pixels},
          {"off_pixels_most", error.most},
          {"off_pixels_near", error.near},
          {"left_pixels", left.pixels},
          {"left_pixels_near", left.near},
          {"off_focal", FocalError(gs::TrainingViews(truth.scene.views), trained)},
          {"off_gain", GainError(truth.gains, found.gains)},
          {"left_gain", settled ? GainError(Product(truth.gains, settled->gains), found.gains) : 0.0}};
}

Row MeasureImages(const gs::TrainResult& result, const FoundCameras& found, const gs::Scene& given,
                  const gs::TrainOptions& options) {
  gs::AlignOptions align;
  align.near = gs::NearPlane(given);
  align.background = options.background;
  align.levels = 5;
  gs::Scene judged = given;  // test views through the lenses that were found
  for (std::size_t v = 0; v < judged.views.size(); ++v) judged.views[v].camera = found.scene.views[v].camera;
  const gs::AlignedEvaluation aligned = gs::EvaluateAligned(result.model, judged, align);
  align.free.color = true;
  const gs::AlignedEvaluation exposed = gs::EvaluateAligned(result.model, judged, align);
  // Test views as stated, training views as found.
  gs::TrainingCameras cameras(given, {.refine = gs::CameraChoice::kAll});
  cameras.Restore(result.cameras);
  cameras.DevelopAll();
  const gs::Evaluation quality =
      gs::Renderer(options.background, gs::NearPlane(given)).Evaluate(result.model, cameras.scene());
  return {{"psnr", quality.test.psnr},
          {"psnr_train", quality.train.psnr},
          {"psnr_aligned", aligned.whole.psnr},
          {"ssim_aligned", aligned.whole.ssim},
          {"psnr_right", exposed.right.psnr},
          {"psnr_right_exposed", exposed.right_exposed.psnr},
          {"not_aligned", static_cast<double>(aligned.not_found)},
          {"cost", quality.cost}};
}

}  // namespace vesta::bench
