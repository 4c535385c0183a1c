// How photographs are exposed beside each other, and how well that was found.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/cameras/view_unknowns.h"
#include "problems/gaussian_splatting/model/scene.h"

namespace vesta::bench {

// Of numbers of all views those of the training views.
std::vector<double> OfTrainingViews(const gs::Scene& scene, const std::vector<double>& of_views);

// The gains of green that were found, of training views; where none were (found is empty), 1 for each.
std::vector<double> GainsOf(const gs::Scene& scene, const std::vector<gs::ViewUnknowns>& found);

// Median deviation of the gains found from those that are true, each divided by their own mean.
double GainError(const std::vector<double>& truth, const std::vector<double>& found);

}  // namespace vesta::bench
