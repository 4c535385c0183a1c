// SPDX-License-Identifier: Apache-2.0
// Explicit instantiation of the whole engine. The source file of a backend defines
//   namespace vesta { using InstantiatedBackend = ...; }
// and includes this file once.

#include "solver/internal/batched_system.inl"
#include "solver/internal/bounds.inl"
#include "solver/internal/check_problem.inl"
#include "solver/internal/compose.inl"
#include "solver/internal/derivative_check.inl"
#include "solver/internal/levenberg_marquardt.inl"
#include "solver/internal/linear/pcg.inl"
#include "solver/internal/normal_equations/damped_normal_equations.inl"
#include "solver/internal/normal_equations/normal_system.inl"
#include "solver/internal/normal_equations/preconditioner.inl"
#include "solver/internal/normal_equations/problem_adaptor.inl"
#include "solver/internal/normal_equations/step_solver.inl"
#include "solver/internal/problem.inl"

namespace vesta {

template class Problem<InstantiatedBackend>;
template class InUnits<InstantiatedBackend>;
template class InBatches<InstantiatedBackend>;
template class LinearizationAdaptor<InstantiatedBackend>;
template class ProblemAdaptor<InstantiatedBackend>;
template class PcgWorkspace<InstantiatedBackend>;
template PcgSummary SolvePcg(const PcgOptions&, InstantiatedBackend&, LinearOperator<InstantiatedBackend>&,
                             InstantiatedBackend::ConstVectorView, LinearOperator<InstantiatedBackend>&,
                             PcgWorkspace<InstantiatedBackend>&, InstantiatedBackend::VectorView,
                             InstantiatedBackend::ConstVectorView, const InnerProducts<InstantiatedBackend>&);
template class IdentityPreconditioner<InstantiatedBackend>;
template class JacobiPreconditioner<InstantiatedBackend>;
template class BlockJacobiPreconditioner<InstantiatedBackend>;
template std::unique_ptr<Preconditioner<InstantiatedBackend>> MakePreconditioner(
    PreconditionerKind, ProblemAdaptor<InstantiatedBackend>,
    std::span<LinearizationAdaptor<InstantiatedBackend>* const>);
template LsmrSummary SolveLsmr(const LsmrOptions&, InstantiatedBackend&, LinearMap<InstantiatedBackend>&,
                               InstantiatedBackend::ConstVectorView, InstantiatedBackend::VectorView);
template DenseJacobian MakeDenseJacobian(InstantiatedBackend&,
                                         std::span<LinearizationAdaptor<InstantiatedBackend>* const>,
                                         InstantiatedBackend::ConstVectorView);
template std::unique_ptr<StepSolver<InstantiatedBackend>> MakeStepSolver(const NormalSystemOptions&,
                                                                         const StepSystem<InstantiatedBackend>&, bool);
template ColumnScale<InstantiatedBackend> MakeColumnScale(ColumnScaling, InstantiatedBackend&,
                                                          InstantiatedBackend::ConstVectorView);
template void DiagonalMetric(const DampingMetricOptions&, InstantiatedBackend&, InstantiatedBackend::ConstVectorView,
                             const ColumnScale<InstantiatedBackend>&, const std::vector<BlockGroup>&,
                             InstantiatedBackend::VectorView);
template class BoundedProblem<InstantiatedBackend>;
template class DampedNormalEquations<InstantiatedBackend>;
template class NormalSystem<InstantiatedBackend>;
template class BatchedSystem<InstantiatedBackend>;
template class LmStepper<InstantiatedBackend>;
template LmSummary SolveLm(const LmOptions&, InstantiatedBackend&, Problem<InstantiatedBackend>&,
                           InstantiatedBackend::VectorView, const IterationCallback<InstantiatedBackend>&);
template class ProductMap<InstantiatedBackend>;
template class ScaledRows<InstantiatedBackend>;
template class ScaledColumns<InstantiatedBackend>;
template void FillRandom(InstantiatedBackend&, std::uint64_t, InstantiatedBackend::VectorView);
template double AdjointError(InstantiatedBackend&, LinearMap<InstantiatedBackend>&,
                             InstantiatedBackend::ConstVectorView, InstantiatedBackend::ConstVectorView);
template double WorstAdjointError(InstantiatedBackend&, LinearMap<InstantiatedBackend>&, std::uint64_t, int);
template ProblemCheck CheckProblem(InstantiatedBackend&, Problem<InstantiatedBackend>&,
                                   InstantiatedBackend::ConstVectorView, const CheckProblemOptions&);
template Deviation WorstDiagonal(InstantiatedBackend&, Linearization<InstantiatedBackend>&, Index, Index);
template Deviation WorstBlock(InstantiatedBackend&, Linearization<InstantiatedBackend>&, Index);
template double DiagonalError(InstantiatedBackend&, Linearization<InstantiatedBackend>&, Index, Index);
template double BlockError(InstantiatedBackend&, Linearization<InstantiatedBackend>&, Index);
template double GradientError(InstantiatedBackend&, Problem<InstantiatedBackend>&, InstantiatedBackend::ConstVectorView,
                              InstantiatedBackend::ConstVectorView, double);
template double TangentError(InstantiatedBackend&, Problem<InstantiatedBackend>&, InstantiatedBackend::ConstVectorView,
                             int, InstantiatedBackend::ConstVectorView, double);

}  // namespace vesta
