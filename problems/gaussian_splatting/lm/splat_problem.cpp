#include "problems/gaussian_splatting/lm/splat_problem.h"

#include <numeric>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "kernels/gaussian_splatting/layout.h"
#include "problems/gaussian_splatting/lm/length_metric.h"
#include "problems/gaussian_splatting/lm/splat_blocks.h"
#include "problems/gaussian_splatting/lm/splat_linearization.h"

namespace vesta::gs {

namespace {

template <class S>
std::vector<splat::PinholeView> Pinholes(const std::vector<TargetView<CpuBackend<S>>>& views) {
  std::vector<splat::PinholeView> pinholes;
  pinholes.reserve(views.size());
  for (const TargetView<CpuBackend<S>>& view : views) pinholes.push_back(view.pinhole);
  return pinholes;
}

}  // namespace

template <class S>
SplatProblem<S>::SplatProblem(const SplatProblemOptions& options, std::vector<TargetView<CpuBackend<S>>> views)
    : options_(options),
      views_(std::move(views)),
      batches_(options.batches, Pinholes(views_)),
      loss_(std::make_shared<PhotometricLoss<S>>(options.weights)),
      workspace_(std::make_shared<splat::ViewWorkspace<S>>()) {
  CheckSampling(options);
  CheckUnits(options);
  for (const TargetView<CpuBackend<S>>& view : views_) {
    VESTA_CHECK(view.truth.size() == 3 * Index{view.pinhole.width} * view.pinhole.height,
                "a truth image of {} values for a view of {} x {}", view.truth.size(), view.pinhole.width,
                view.pinhole.height);
  }
}

template <class S>
Index SplatProblem<S>::num_parameters() const {
  return splat::NumAttributes(options_.sh_degree) * options_.count;
}

template <class S>
double SplatProblem<S>::Cost(ConstView x) {
  std::vector<Index> all(views_.size());
  std::iota(all.begin(), all.end(), Index{0});
  return Cost(x, all);
}

template <class S>
double SplatProblem<S>::Cost(ConstView x, std::span<const Index> units) {
  const splat::Model<S> model{x.data(), options_.count, options_.sh_degree, options_.sh_degree};
  splat::View<S> view;
  HostBuffer<S> image;
  double cost = 0;
  for (const Index unit : units) {
    const TargetView<CpuBackend<S>>& target = views_[static_cast<std::size_t>(unit)];
    view.Build(model, target.pinhole, options_.background.data(), *workspace_);
    image.ResizeForOverwrite(target.truth.size());
    view.Render(image.data());
    cost += loss_->Evaluate(image, target.truth, {target.pinhole.width, target.pinhole.height}).cost;
  }
  return cost;
}

template <class S>
std::unique_ptr<Linearization<CpuBackend<S>>> SplatProblem<S>::Linearize(ConstView x, int batch) {
  std::vector<BatchView<S>> views;
  for (const Index v : batches_.views(batch)) views.push_back({&views_[static_cast<std::size_t>(v)], v});
  return std::make_unique<SplatLinearization<S>>(options_, x, views, batches_.scale(), turn_, loss_, workspace_);
}

template <class S>
void SplatProblem<S>::BeginTurn(int turn) {
  turn_ = turn;
  batches_.BeginTurn(turn);
}

template <class S>
bool SplatProblem<S>::LimitStep(ConstView x, View step) {
  return gs::LimitStep<S>(options_.step_limit, options_.count, options_.sh_degree, x, step);
}

template <class S>
bool SplatProblem<S>::DampingMetric(ConstView x, ConstView diag_h, View D) {
  if (options_.rates_damping <= 0) return false;
  const Index n = options_.count;
  const S* opacity_diagonal = diag_h.data() + splat::kOpacity * n;
  const double sum = ParallelSum<double>(n, 4096, [&](Index begin, Index end) {
    return std::accumulate(opacity_diagonal + begin, opacity_diagonal + end, 0.0);
  });
  const std::vector<double> metric = RatesMetric(options_, sum);
  for (std::size_t a = 0; a < metric.size(); ++a) {
    std::fill_n(D.data() + static_cast<Index>(a) * n, n, static_cast<S>(metric[a]));
  }
  if (metric.empty()) return false;
  const LengthMetric<S> lengths{static_cast<S>(options_.rotation_damping), n,
                                options_.units ? options_.units->data() : nullptr, x.data(), D.data()};
  ParallelFor(n, 4096, lengths);
  return true;
}

template class SplatProblem<float>;
template class SplatProblem<double>;

}  // namespace vesta::gs
