// How near cameras that were found are to the true ones, and what the splat that was trained with them shows.
#pragma once

#include <optional>
#include <vector>

#include "bench/cameras/perturbed_scene.h"
#include "bench/report.h"
#include "problems/gaussian_splatting/train/trainer.h"

namespace vesta::bench {

// Where training views have been found.
struct FoundCameras {
  gs::Scene scene;            // with all views there
  std::vector<double> gains;  // of the training views
};
// given: of the training.
FoundCameras FoundBy(const gs::TrainResult& result, const gs::Scene& given);

// What found is measured beside.
struct TrueCameras {
  const gs::Scene& scene;
  std::vector<double> gains;  // of the training views
};

// Columns for a report: how far the cameras are off. settled: where a training takes right cameras, if that is known.
Row MeasureCameras(const TrueCameras& truth, const FoundCameras& found, const std::optional<FoundCameras>& settled);
// Of the splat: test views as they were given, and fitted to it.
Row MeasureImages(const gs::TrainResult& result, const FoundCameras& found, const gs::Scene& given,
                  const gs::TrainOptions& options);

}  // namespace vesta::bench
