#include "apps/report/view_errors.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "apps/inputs/posed_model.h"
#include "apps/report/error_map.h"
#include "apps/report/html.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "problems/gaussian_splatting/model/to_kernel.h"
#include "splatting/io/images/image.h"

namespace vesta::app {
namespace {

std::string Jpeg(const gs::Image& image, int max_width) {
  constexpr int kQuality = 85;
  const int width = std::min(image.width, max_width);
  const auto height = static_cast<int>(std::lround(static_cast<double>(image.height) * width / image.width));
  return DataUri(
      "image/jpeg",
      gs::EncodeJpeg(width == image.width ? image : gs::ResizeArea(image, width, std::max(height, 1)), kQuality));
}

}  // namespace

ViewRenderer::ViewRenderer(const gs::SplatModel& model, const gs::Scene& scene)
    : model_(model), scene_(scene), renderer_(ToDouble(model.background), gs::NearPlane(scene)) {}

std::vector<ViewError> ViewRenderer::Measure() {
  std::vector<ViewError> errors;
  ImageQualityMeter meter;
  for (const gs::View& view : scene_.views) {
    if (!view.is_test()) continue;
    const std::shared_ptr<const gs::Image> photograph = view.Photograph();
    const gs::Image render = gs::ToCompare(renderer_.Render(model_, view), *photograph);
    const ImageQuality whole =
        meter.Measure(gs::ValuesOf(render), gs::ValuesOf(*photograph), {view.camera.width, view.camera.height});
    const gs::ViewQuality of_counted = gs::QualityOf(0, *photograph, whole, 0);
    errors.push_back({view.name, of_counted.quality, PartWithHalfOfError(render, *photograph) / of_counted.counted});
  }
  return errors;
}

ViewPictures ViewRenderer::Picture(const gs::View& view, int max_width) {
  const std::shared_ptr<const gs::Image> photograph = view.Photograph();
  const gs::Image render = renderer_.Render(model_, view);
  return {.width = view.camera.width,
          .height = view.camera.height,
          .truth = Jpeg(*photograph, max_width),
          .render = Jpeg(render, max_width),
          .error = Jpeg(ErrorMap(gs::ToCompare(render, *photograph), *photograph),
                        (std::min(max_width, render.width) + 1) / 2)};
}

}  // namespace vesta::app
