// SPDX-License-Identifier: Apache-2.0
#include "problems/bundle_adjustment/bundle_problem.h"

#include <utility>

#include "kernels/core/check.h"
#include "kernels/core/cpu_dispatch.h"
#include "kernels/core/parallel.h"
#include "problems/bundle_adjustment/context.h"
#include "problems/bundle_adjustment/kernels.h"
#include "problems/bundle_adjustment/reduced.h"

namespace vesta::bundle {
namespace internal {
namespace {

// Let p be the number of observation pairs per observation. Forming the reduced matrix takes as long as about 2 p
// implicit products; the inner solves need some tens of products. So forming it pays off unless tracks are long.
constexpr Index kPairsPerObservation = 12;

bool FormReducedMatrix(ReducedForm form, const Structure& structure) {
  if (form != ReducedForm::kAuto) return form == ReducedForm::kExplicit;
  return structure.num_pairs() <= kPairsPerObservation * structure.num_observations();
}

}  // namespace

BundleContext::BundleContext(const BundleData& data, BundleProblemOptions given)
    : options(std::move(given)), structure(data) {
  pattern = structure.MakeReducedPattern(!FormReducedMatrix(options.reduced_form, structure));
  if (options.factorize_reduced) cholesky = ReducedCholeskyPlan::Make(pattern);
}

HostBuffer<Camera<double>> MakeCameras(const Structure& structure, Cpu::ConstVectorView x) {
  HostBuffer<Camera<double>> cameras(structure.num_cameras());
  ParallelFor(cameras.size(), 64, [&](Index i) { cameras[i] = MakeCamera(x.data() + kCameraSize * i); });
  return cameras;
}

}  // namespace internal

LmOptions BundleLmOptions() {
  LmOptions options;
  options.normal_system.linear_solver = LinearSolverKind::kReducedPcg;
  // Chosen by measurements on BAL problems and generated ones. Products with the reduced matrix are cheap compared with
  // the linearization, so systems are solved accurately.
  options.normal_system.pcg.model_tolerance = 0.01;
  // One iteration reaches this if the reduced matrix is factorised.
  options.normal_system.pcg.relative_tolerance = 1e-8;
  return options;
}

BundleProblem::BundleProblem(const BundleData& data, BundleProblemOptions options)
    : context_(std::make_unique<internal::BundleContext>(data, std::move(options))) {
  VESTA_CHECK(IsaAvailable(context_->options.isa), "this CPU does not have {}", IsaName(context_->options.isa));
}

BundleProblem::~BundleProblem() = default;

Index BundleProblem::num_parameters() const { return structure().num_parameters(); }
const Structure& BundleProblem::structure() const { return context_->structure; }

template <class Term>
double BundleProblem::SumOverSlices(ConstVectorView x, const Term& term) {
  const Structure& s = structure();
  VESTA_CHECK(x.size() == s.num_parameters(), "x has {} entries, but the problem has {} parameters", x.size(),
              s.num_parameters());
  const HostBuffer<Camera<double>> cameras = internal::MakeCameras(s, x);
  const double* points = x.data() + s.num_camera_parameters();
  // The double kernel serves either storage.
  const auto squared_norms = KernelsFor<double>(context_->options.isa).squared_norms;
  return ParallelSum<double>(s.num_slices(), 1, [&](Index begin, Index end) {
    double sum = 0;
    for (Index k = begin; k < end; ++k) {
      const CameraSlice slice = s.slice(k);
      alignas(64) double squared[Structure::kSliceSize];
      squared_norms(cameras[s.slice_camera(k)], points, slice, squared);
      sum += term(slice.count, squared);
    }
    return sum;
  });
}

double BundleProblem::SquaredError(ConstVectorView x) {
  return SumOverSlices(x, [](Index count, const double* squared) {
    double partial[4] = {0, 0, 0, 0};
    for (Index i = 0; i < count; ++i) partial[i % 4] += squared[i];
    return (partial[0] + partial[1]) + (partial[2] + partial[3]);
  });
}

double BundleProblem::Cost(ConstVectorView x) {
  CheckSize(x);
  const Loss* loss = context_->options.loss.get();
  if (loss == nullptr) return 0.5 * SquaredError(x);
  return 0.5 * SumOverSlices(x, [loss](Index count, const double* squared) {
           double sum = 0;
           for (Index i = 0; i < count; ++i) sum += loss->Evaluate(squared[i]).rho;
           return sum;
         });
}

std::unique_ptr<Linearization<CpuBackend<double>>> BundleProblem::Linearize(ConstVectorView x) {
  CheckSize(x);
  if (context_->options.storage == JacobianStorage::kFloat) {
    return internal::MakeLinearization<float>(*context_, x);
  }
  return internal::MakeLinearization<double>(*context_, x);
}

VESTA_DECLARE_PER_ISA(template <class S> const Kernels<S>& CompiledKernels();
                      SymmetricProduct CompiledSymmetricProduct();)

template <class S>
const Kernels<S>& KernelsFor(Isa isa) {
  return VESTA_OF_ISA(isa, CompiledKernels<S>)();
}

template const Kernels<float>& KernelsFor<float>(Isa);
template const Kernels<double>& KernelsFor<double>(Isa);

SymmetricProduct SymmetricProductFor(Isa isa) { return VESTA_OF_ISA(isa, CompiledSymmetricProduct)(); }

}  // namespace vesta::bundle
