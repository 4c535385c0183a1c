// Explicit instantiation of the whole engine. A source file for one backend says
//   namespace vesta { using InstantiatedBackend = ...; }
// and includes this, once.

#include "solver/batched_system.inl"
#include "solver/bounds.inl"
#include "solver/check_problem.inl"
#include "solver/compose.inl"
#include "solver/derivative_check.inl"
#include "solver/levenberg_marquardt.inl"
#include "solver/linear/pcg.inl"
#include "solver/normal_equations/damped_normal_equations.inl"
#include "solver/normal_equations/damping_metric.inl"
#include "solver/normal_equations/dense_jacobian.inl"
#include "solver/normal_equations/normal_system.inl"
#include "solver/normal_equations/preconditioner.inl"
#include "solver/normal_equations/step_solver.inl"
#include "solver/normal_equations/system_fault.inl"
#include "solver/problem.inl"

namespace vesta {

template class Linearization<InstantiatedBackend>;
template class Problem<InstantiatedBackend>;
template class PcgWorkspace<InstantiatedBackend>;
template PcgSummary SolvePcg(const PcgOptions&, InstantiatedBackend&, LinearOperator<InstantiatedBackend>&,
                             InstantiatedBackend::ConstView, LinearOperator<InstantiatedBackend>&,
                             PcgWorkspace<InstantiatedBackend>&, InstantiatedBackend::View,
                             InstantiatedBackend::ConstView, const InnerProducts<InstantiatedBackend>&);
template class IdentityPreconditioner<InstantiatedBackend>;
template class JacobiPreconditioner<InstantiatedBackend>;
template class BlockJacobiPreconditioner<InstantiatedBackend>;
template std::unique_ptr<Preconditioner<InstantiatedBackend>> MakePreconditioner(
    PreconditionerKind, Problem<InstantiatedBackend>&, std::span<Linearization<InstantiatedBackend>* const>);
template LsmrSummary SolveLsmr(const LsmrOptions&, InstantiatedBackend&, LinearMap<InstantiatedBackend>&,
                               InstantiatedBackend::ConstView, InstantiatedBackend::View);
template DenseJacobian MakeDenseJacobian(InstantiatedBackend&, std::span<Linearization<InstantiatedBackend>* const>,
                                         InstantiatedBackend::ConstView);
template std::unique_ptr<StepSolver<InstantiatedBackend>> MakeStepSolver(const NormalSystemOptions&,
                                                                         const StepSystem<InstantiatedBackend>&);
template ColumnScale<InstantiatedBackend> MakeColumnScale(ColumnScaling, InstantiatedBackend&,
                                                          InstantiatedBackend::ConstView);
template void DiagonalMetric(const DampingMetricOptions&, InstantiatedBackend&, InstantiatedBackend::ConstView,
                             const ColumnScale<InstantiatedBackend>&, const std::vector<BlockGroup>&,
                             InstantiatedBackend::View);
template class BoundedProblem<InstantiatedBackend>;
template class DampedNormalEquations<InstantiatedBackend>;
template class NormalSystem<InstantiatedBackend>;
template class BatchedSystem<InstantiatedBackend>;
template class LmStepper<InstantiatedBackend>;
template LmSummary SolveLm(const LmOptions&, InstantiatedBackend&, Problem<InstantiatedBackend>&,
                           InstantiatedBackend::View, const LmCallback&);
template class ProductMap<InstantiatedBackend>;
template class ScaledRows<InstantiatedBackend>;
template class ScaledColumns<InstantiatedBackend>;
template void FillRandom(InstantiatedBackend&, std::uint64_t, InstantiatedBackend::View);
template double AdjointError(InstantiatedBackend&, LinearMap<InstantiatedBackend>&, InstantiatedBackend::ConstView,
                             InstantiatedBackend::ConstView);
template double WorstAdjointError(InstantiatedBackend&, LinearMap<InstantiatedBackend>&, std::uint64_t, int);
template ProblemCheck CheckProblem(InstantiatedBackend&, Problem<InstantiatedBackend>&, InstantiatedBackend::ConstView,
                                   const CheckProblemOptions&);
template Deviation WorstDiagonal(InstantiatedBackend&, Linearization<InstantiatedBackend>&, Index, Index);
template Deviation WorstBlock(InstantiatedBackend&, Linearization<InstantiatedBackend>&, Index);
template double DiagonalError(InstantiatedBackend&, Linearization<InstantiatedBackend>&, Index, Index);
template double BlockError(InstantiatedBackend&, Linearization<InstantiatedBackend>&, Index);
template double GradientError(InstantiatedBackend&, Problem<InstantiatedBackend>&, InstantiatedBackend::ConstView,
                              InstantiatedBackend::ConstView, double);
template double TangentError(InstantiatedBackend&, Problem<InstantiatedBackend>&, InstantiatedBackend::ConstView, int,
                             InstantiatedBackend::ConstView, double);

}  // namespace vesta
