// Splats, cameras, lenses and exposures refined at once, by Levenberg-Marquardt on all views.
#pragma once

#include <array>
#include <vector>

#include "problems/gaussian_splatting/cameras/joint_problem.h"
#include "problems/gaussian_splatting/cameras/view_unknowns.h"
#include "problems/gaussian_splatting/lm/options.h"
#include "problems/gaussian_splatting/model/learning_rates.h"
#include "problems/gaussian_splatting/model/scene.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "solver/lm_options.h"
#include "solver/summary.h"

namespace vesta::gs {

struct JointOptions {
  FreeUnknowns free = {};
  int iterations = 10;  // most of Levenberg-Marquardt
  // Else of the engine and of the cost, and how the splats are damped. Batches and the line search are not used; views
  // are held.
  LmStageOptions lm;
  LearningRates rates;
  std::array<double, 3> background{0, 0, 0};  // 0..1
  double near = 0;                            // distance of the near plane, world units
  double extent = 1;                          // of the scene (Scene::extent), world units, > 0
  double prior_weight = 0.01;                 // ViewPrior::weight
  // Whether views are eliminated from each step (JointProblemOptions), or solved for along with the splats. From
  // cameras that are off it comes further by as many products, which take a fifth longer
  // (docs/results/2026-11-25-joint-cameras.md).
  bool eliminate_views = true;
};

// The problem of that, of splats laid out so; units: of length, of each Gaussian; given: as RefineJointly has views;
// unbent_by: what their photographs have been unbent by, of those of lenses that bend; empty: by nothing.
JointProblemOptions ProblemOptionsOf(const JointOptions& options, const splat::ModelLayout& layout,
                                     std::vector<float> units, const std::vector<const View*>& given,
                                     const std::vector<RadialCoefficients>& unbent_by = {});
// How the engine is to solve it.
vesta::LmOptions EngineOptionsOf(const JointOptions& options);
// x of the problem: the splats' parameters and the views' unknowns, which are as many as the layout has.
HostBuffer<float> JointStart(const JointLayout& layout, const SplatModel& model,
                             const std::vector<ViewUnknowns>& views);

struct JointRefinement {
  SplatModel model;
  std::vector<ViewUnknowns> views;  // from as they were given
  LmSummary summary;
};

// From the model and `start`, one for each view, from as it was given; empty: as given. Views must have their images.
// Views whose cameras were given alike share a lens. What is found has a cost no higher than the start's. Throws Error
// without views, where nothing of them is free, for images of another size than their cameras', for starts that are not
// as many as the views or whose gains are not all above 0, for one from no lens, or from another than views with the
// same start from, and for options out of range. The same bits for any number of threads.
JointRefinement RefineJointly(SplatModel model, const std::vector<const View*>& views,
                              const std::vector<ViewUnknowns>& start, const JointOptions& options);

}  // namespace vesta::gs
