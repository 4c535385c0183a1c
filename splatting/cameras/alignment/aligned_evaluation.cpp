// SPDX-License-Identifier: Apache-2.0
#include "splatting/cameras/alignment/aligned_evaluation.h"

#include <algorithm>
#include <limits>
#include <numbers>

#include "problems/gaussian_splatting/model/masked_loss.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/cameras/alignment/align_view.h"
#include "splatting/cameras/unknowns/moved_view.h"
#include "splatting/evaluate/evaluation.h"
#include "splatting/evaluate/quality.h"

namespace vesta::gs {
namespace {

// Nothing was measured, which is not 0 dB.
constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

// Columns begin..end.
Image Columns(const Image& image, int begin, int end) {
  Image part(end - begin, image.height);
  for (int row = 0; row < 3 * image.height; ++row) {
    const float* from = image.rgb.data() + static_cast<std::ptrdiff_t>(row) * image.width;
    std::copy(from + begin, from + end, part.rgb.data() + static_cast<std::ptrdiff_t>(row) * part.width);
  }
  for (int row = 0; row < part.height && !image.mask.empty(); ++row) {
    const auto from = image.mask.begin() + static_cast<std::ptrdiff_t>(row) * image.width;
    part.mask.insert(part.mask.end(), from + begin, from + end);
  }
  return part;
}

// Of the pixels that count.
ImageQuality Measure(ImageQualityMeter& meter, Image rendered, const Image& truth) {
  ShowLeftOut<CpuBackend<float>>(MaskOf(truth), ValuesOf(truth),
                                 {rendered.rgb.data(), static_cast<Index>(rendered.rgb.size())});
  const ImageQuality whole = meter.Measure(ValuesOf(rendered), ValuesOf(truth), {truth.width, truth.height});
  return truth.mask.empty() ? whole : OfPart(whole, CountedPart(truth));
}

// Whether both halves have something to measure.
bool HasCountedHalves(const Image& image) {
  const int middle = image.width / 2;
  return middle > 0 && CountedPixels(Columns(image, 0, middle)) > 0 &&
         CountedPixels(Columns(image, middle, image.width)) > 0;
}

void MeasureHalves(ImageQualityMeter& meter, const PhotometricWeights& weights, const Image& rendered,
                   const Image& truth, AlignedView& view) {
  const int middle = truth.width / 2;
  view.has_halves = true;
  const Image left = Columns(rendered, 0, middle), left_truth = Columns(truth, 0, middle);
  view.exposure =
      FitExposure(ValuesOf(left), ValuesOf(left_truth), {middle, truth.height}, weights, MaskOf(left_truth));
  Image right = Columns(rendered, middle, truth.width);
  const Image right_truth = Columns(truth, middle, truth.width);
  view.right = Measure(meter, right, right_truth);
  view.exposure.Apply(HostSpan<float>{right.rgb.data(), static_cast<Index>(right.rgb.size())});
  view.right_exposed = Measure(meter, right, right_truth);
}

Quality Mean(const std::vector<AlignedView>& views, ImageQuality AlignedView::*of) {
  Quality mean;
  const bool is_of_halves = of != &AlignedView::whole;
  for (const AlignedView& view : views) {
    if (is_of_halves && !view.has_halves) continue;
    mean.psnr += (view.*of).psnr, mean.ssim += (view.*of).ssim;
    ++mean.views;
  }
  mean.psnr = mean.views > 0 ? mean.psnr / mean.views : kNothing;
  mean.ssim = mean.views > 0 ? mean.ssim / mean.views : kNothing;
  return mean;
}

}  // namespace

AlignedEvaluation EvaluateAligned(const SplatModel& model, const Scene& scene, const AlignOptions& options) {
  AlignedEvaluation evaluation;
  Renderer renderer(options.background, options.near);
  ImageQualityMeter meter;
  std::vector<double> degrees, pixels;
  for (const View& each : scene.views) {
    if (!each.is_test()) continue;
    const View view = HoldingPhotograph(each);
    AlignedView aligned;
    aligned.name = view.name;
    aligned.alignment = AlignView(model, view, options);
    const View moved = AsFound(view, aligned.alignment.found);
    aligned.degrees = aligned.alignment.found.motion.Angle() * 180 / std::numbers::pi;
    aligned.pixels = MedianShift(model, view, moved, options.near);
    const Image rendered = renderer.Render(model, moved);
    aligned.whole = Measure(meter, rendered, view.image);
    if (options.free.color && HasCountedHalves(view.image)) {
      MeasureHalves(meter, options.weights, rendered, view.image, aligned);
    }
    degrees.push_back(aligned.degrees);
    pixels.push_back(aligned.pixels);
    evaluation.not_found += aligned.alignment.is_found() ? 0 : 1;
    evaluation.views.push_back(std::move(aligned));
  }
  evaluation.whole = Mean(evaluation.views, &AlignedView::whole);
  if (options.free.color) {
    evaluation.right = Mean(evaluation.views, &AlignedView::right);
    evaluation.right_exposed = Mean(evaluation.views, &AlignedView::right_exposed);
  }
  const bool has_views = !evaluation.views.empty();
  evaluation.degrees = has_views ? Median(std::move(degrees)) : kNothing;
  evaluation.pixels = has_views ? Median(std::move(pixels)) : kNothing;
  return evaluation;
}

}  // namespace vesta::gs
