#include "problems/gaussian_splatting/cameras/refine_jointly.h"

#include <algorithm>
#include <cstddef>
#include <memory>
#include <optional>
#include <utility>

#include "kernels/core/check.h"
#include "problems/gaussian_splatting/cameras/shared_lenses.h"
#include "problems/gaussian_splatting/lm/engine_options.h"
#include "problems/gaussian_splatting/model/length_units.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "solver/levenberg_marquardt.h"

namespace vesta::gs {

using B = CpuBackend<float>;

JointProblemOptions ProblemOptionsOf(const JointOptions& options, const splat::ModelLayout& layout,
                                     std::vector<float> units, const std::vector<const View*>& given,
                                     const std::vector<RadialCoefficients>& unbent_by) {
  JointProblemOptions problem;
  SplatProblemOptions& splats = problem.splats;
  splats = SplatProblemOptionsOf(options.lm, layout);
  splats.background = options.background;
  splats.rates = options.rates;
  splats.units = std::make_shared<const std::vector<float>>(std::move(units));
  problem.free = options.free;
  problem.prior = {options.prior_weight, 2 * options.extent};
  problem.eliminate_views = options.eliminate_views;
  if (options.free.lens) problem.lens_of = LensesSharedBy(given).of;
  if (options.free.radial_tangent() > 0) {
    for (std::size_t v = 0; v < given.size(); ++v) {
      std::optional<RadialCoefficients>& own = problem.unbent_by.emplace_back();
      if (given[v]->bent) own = unbent_by.empty() ? RadialCoefficients{} : unbent_by[v];
    }
  }
  return problem;
}

vesta::LmOptions EngineOptionsOf(const JointOptions& options) {
  vesta::LmOptions engine = LmEngineOptions(options.lm);
  engine.max_iterations = options.iterations;
  engine.batch_mode = BatchMode::kExact;
  engine.line_search.enabled = false;
  engine.normal_system.linear_solver = options.eliminate_views ? LinearSolverKind::kReducedPcg : LinearSolverKind::kPcg;
  return engine;
}

HostBuffer<float> JointStart(const JointLayout& layout, const SplatModel& model,
                             const std::vector<ViewUnknowns>& views) {
  HostBuffer<float> x(layout.num_parameters());
  std::copy(model.data.begin(), model.data.end(), x.begin());
  for (Index v = 0; v < layout.views; ++v)
    layout.SetUnknowns(views[static_cast<std::size_t>(v)], v, layout.RestOf(x.view()));
  return x;
}

namespace {

void CheckLenses(const std::vector<const View*>& views, const std::vector<ViewUnknowns>& start,
                 const FreeUnknowns& free) {
  const SharedLenses lenses = LensesSharedBy(views);
  for (std::size_t v = 0; v < start.size(); ++v) {
    const LensChange& lens = start[v].lens;
    const std::size_t first = lenses.First(lenses.of[v]);
    VESTA_CHECK(!free.lens || lens == start[first].lens, "views {} and {} have one lens, and start from two", first, v);
    VESTA_CHECK(lens.is_sound() && lens.is_bend_sound(CornerOf(views[v]->camera)), "view {} starts from no lens", v);
    VESTA_CHECK(free.radial_tangent() > 0 || (lens.radial[0] == 0 && lens.radial[1] == 0),
                "view {} starts from a bend, which is not to be found; unbend its photograph first", v);
  }
}

}  // namespace

JointRefinement RefineJointly(SplatModel model, const std::vector<const View*>& views,
                              const std::vector<ViewUnknowns>& start, const JointOptions& options) {
  VESTA_CHECK(start.empty() || start.size() == views.size(), "{} views, but {} to start from", views.size(),
              start.size());
  for (const ViewUnknowns& view : start) {
    VESTA_CHECK(std::ranges::all_of(view.color.gain, [](double gain) { return gain > 0; }),
                "a view with gains {}, {} and {}; they must be above 0", view.color.gain[0], view.color.gain[1],
                view.color.gain[2]);
  }
  CheckLenses(views, start, options.free);
  const std::vector<TargetView<B>> targets = MakeTargets<B>(views, options.near);
  JointProblem<B> problem(
      ProblemOptionsOf(options, model, LengthUnits(model, views, options.near, options.extent), views), targets);
  const JointLayout& layout = problem.layout();
  HostBuffer<float> x = JointStart(layout, model, start.empty() ? std::vector<ViewUnknowns>(views.size()) : start);
  B backend;
  JointRefinement refined;
  refined.summary = SolveLm<B>(EngineOptionsOf(options), backend, problem, x);
  std::copy_n(x.begin(), model.data.size(), model.data.begin());
  refined.model = std::move(model);
  for (Index v = 0; v < layout.views; ++v)
    refined.views.push_back(layout.UnknownsOf(layout.RestOf(std::as_const(x).view()), v));
  return refined;
}

}  // namespace vesta::gs
