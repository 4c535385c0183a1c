// SPDX-License-Identifier: Apache-2.0
#include "problems/pose_graph/pose_graph_problem.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "kernels/math/quaternion.h"
#include "problems/pose_graph/chordal.h"
#include "problems/pose_graph/information.h"
#include "problems/pose_graph/pose_graph_linearization.h"
#include "problems/pose_graph/poses.h"
#include "solver/internal/sparse_cholesky/block_cholesky.h"

namespace vesta::pose_graph {
namespace {

constexpr Index kGrain = 256;

void CheckSizes(const PoseGraph& graph) {
  const auto poses = static_cast<std::size_t>(graph.num_poses()), edges = static_cast<std::size_t>(graph.num_edges());
  const auto pose_size = static_cast<std::size_t>(PoseSize(graph.space));
  const auto information_size = static_cast<std::size_t>(InformationSize(graph.space));
  if (graph.poses.size() != poses * pose_size || graph.measurements.size() != edges * pose_size ||
      graph.information.size() != edges * information_size) {
    Fail(kBadArgument,
         "pose graph: {} values for {} poses, {} for {} measurements, {} for their information; each pose needs {}, "
         "each information matrix {}",
         graph.poses.size(), poses, graph.measurements.size(), edges, graph.information.size(), pose_size,
         information_size);
  }
  for (const Index pose : graph.fixed) {
    if (pose < 0 || pose >= graph.num_poses())
      Fail(kBadArgument, "pose graph: fixed pose {} is out of range: there are {} poses", pose, poses);
  }
  for (std::size_t e = 0; e < edges; ++e) {
    const auto [from, to] = graph.edges[e];
    if (std::min(from, to) < 0 || std::max(from, to) >= graph.num_poses() || from == to) {
      Fail(kBadArgument, "pose graph: edge {} joins poses {} and {}, which must differ and be less than {}", e, from,
           to, poses);
    }
  }
}

void CheckLandmarks(const PoseGraph& graph) {
  if (graph.landmarks.empty()) return;
  const int size = PoseSize(graph.space), num_positions = PositionSize(graph.space);
  for (const Index pose : graph.landmarks) {
    if (pose < 0 || pose >= graph.num_poses())
      Fail(kBadArgument, "pose graph: landmark {} is out of range: there are {} poses", pose, graph.num_poses());
    const double* rotation = graph.poses.data() + pose * size + num_positions;
    const bool is_identity =
        graph.space == PoseSpace::kSe2
            ? rotation[0] == 0
            : rotation[0] == 1 && std::all_of(rotation + 1, rotation + 4, [](double q) { return q == 0; });
    if (!is_identity) Fail(kBadArgument, "pose graph: landmark {} has a rotation; it must be the identity", pose);
  }
  for (Index e = 0; e < graph.num_edges(); ++e) {
    const auto [from, to] = graph.edges[static_cast<std::size_t>(e)];
    if (graph.IsLandmark(from))
      Fail(kBadArgument, "pose graph: edge {} starts at landmark {}; a landmark must be its second end", e, from);
    if (!graph.IsLandmark(to)) continue;
    if (from == graph.world) Fail(kUnsupported, "pose graph: edge {} is a prior of a landmark; fix it instead", e);
    const double* information = graph.information.data() + e * InformationSize(graph.space);
    double block[6], expected[21];
    PositionBlock(graph.space, information, block);
    FromPositionBlock(graph.space, block, expected);
    if (!std::equal(expected, expected + InformationSize(graph.space), information))
      Fail(kBadArgument, "pose graph: edge {} to landmark {} has information of a rotation; it must be 0", e, to);
  }
}

// FactorInformation of an edge. For a landmark, the factor of the rotation, which has no information, is the identity.
bool FactorOf(const PoseGraph& graph, Index e, double* root) {
  const int d = TangentSize(graph.space), n = PositionSize(graph.space);
  const double* information = graph.information.data() + e * InformationSize(graph.space);
  if (!graph.IsLandmark(graph.edges[static_cast<std::size_t>(e)].to)) return FactorInformation(information, d, root);
  double block[6], small[9];
  PositionBlock(graph.space, information, block);
  const bool is_definite = FactorInformation(block, n, small);
  std::fill_n(root, d * d, 0.0);
  for (int i = 0; i < n; ++i) std::copy_n(small + n * i, n, root + d * i);
  for (int i = n; i < d; ++i) root[i * (d + 1)] = 1;
  return is_definite;
}

// Replaces L by L^T M, where M r is g2o's error for the residual r of poses.h. With q_d = q_a^-1 q_b, the rotation
// errors are vec(q_m^-1 q_d) and vec(q_m q_d^-1) = -R_m vec(q_m^-1 q_d), so M = diag(R_m^T, -R_m^T / 2). In 2D,
// M = diag(R_m^T, 1).
void UseErrorOfG2o(PoseSpace space, const double* m, double* root) {
  const int d = TangentSize(space);
  for (int i = 0; i < d; ++i) {
    for (int k = 0; k < i; ++k) std::swap(root[i * d + k], root[k * d + i]);
  }
  double rotation[9];
  const int n = space == PoseSpace::kSe2 ? 2 : 3;
  if (space == PoseSpace::kSe2) {
    const double c = std::cos(m[2]), s = std::sin(m[2]);
    for (const auto& [k, value] : {std::pair{0, c}, {1, -s}, {2, s}, {3, c}}) rotation[k] = value;
  } else {
    RotationFromQuaternion(m + 3, rotation);
  }
  // Rows times R_m^T, for n columns from `column`.
  const auto rotate = [&](int column, double factor) {
    for (int i = 0; i < d; ++i) {
      double* row = root + i * d + column;
      double rotated[3] = {};
      for (int k = 0; k < n; ++k) {
        for (int j = 0; j < n; ++j) rotated[k] += factor * row[j] * rotation[k * n + j];
      }
      std::copy_n(rotated, n, row);
    }
  };
  rotate(0, 1);
  if (space == PoseSpace::kSe3) rotate(3, -0.5);
}

EdgeTerms MakeTerms(const PoseGraph& graph, const PoseGraphProblemOptions& options) {
  const int d = TangentSize(graph.space), num_positions = PositionSize(graph.space);
  EdgeTerms terms{.space = graph.space,
                  .edges = graph.edges,
                  .measurements = graph.measurements,
                  .whitening = std::vector<double>(graph.edges.size() * static_cast<std::size_t>(d * d)),
                  .to_landmark = std::vector<char>(graph.edges.size(), 0),
                  .loss = options.loss,
                  .has_chords = options.error == EdgeError::kIsotropic};
  for (Index e = 0; e < graph.num_edges(); ++e) {
    double* root = terms.whitening.data() + e * d * d;
    const bool to_landmark = graph.IsLandmark(graph.edges[static_cast<std::size_t>(e)].to);
    terms.to_landmark[static_cast<std::size_t>(e)] = to_landmark ? 1 : 0;
    if (options.error == EdgeError::kIsotropic) {
      const IsotropicWeights weights = IsotropicWeightsOf(graph, e);
      // |R_b - R_a R_m|^2 is 2 (2 sin(angle / 2))^2; the residual has 2 sin(angle / 2).
      for (int i = 0; i < d; ++i) {
        const double of_rotation = to_landmark ? 1 : 2 * weights.rotation;
        root[i * (d + 1)] = std::sqrt(i < num_positions ? weights.translation : of_rotation);
      }
      continue;
    }
    if (!FactorOf(graph, e, root)) {
      const Spectrum spectrum = SpectrumOf(graph.information.data() + e * InformationSize(graph.space), d);
      if (!spectrum.semidefinite) {
        Fail(kBadArgument,
             "pose graph: the information matrix of edge {} is indefinite: eigenvalues from {:.3g} to {:.3g}", e,
             spectrum.least, spectrum.largest);
      }
    }
    if (options.error == EdgeError::kG2o) {
      UseErrorOfG2o(graph.space, graph.measurements.data() + e * PoseSize(graph.space), root);
    }
  }
  return terms;
}

PoseGraphLayout LayOut(const PoseGraph& graph, const PoseGraphProblemOptions& options) {
  CheckSizes(graph);
  CheckLandmarks(graph);
  std::vector<Index> held = graph.fixed;
  if (held.empty() && options.hold_first && graph.num_poses() > 0) held.push_back(0);
  return MakeLayout(MakeTerms(graph, options), graph.num_poses(), held);
}

template <class Space>
void MovePoses(const PoseGraphLayout& layout, const double* x, const double* delta, double* out) {
  ParallelFor(static_cast<Index>(layout.row_of_pose.size()), kGrain, [&](Index pose) {
    const double* from = x + pose * Space::kPose;
    double* to = out + pose * Space::kPose;
    const Index row = layout.row_of_pose[static_cast<std::size_t>(pose)];
    if (row < 0) {
      std::copy_n(from, Space::kPose, to);
    } else {
      Space::Plus(from, delta + row * Space::kTangent, to);
    }
  });
}

}  // namespace

class PoseGraphProblem::Impl {
 public:
  Impl(const PoseGraph& graph, const PoseGraphProblemOptions& options)
      : start(graph.poses), layout(LayOut(graph, options)), max_factor_gib(options.max_factor_gib) {
    if (!(max_factor_gib > 0))
      Fail(kBadArgument, "pose graph: max_factor_gib is {}; it must be positive", max_factor_gib);
  }

  // Null if the factor would be too large.
  const std::shared_ptr<SparseCholesky>& Cholesky() {
    if (!planned) cholesky = SparseCholesky::Plan(*layout.pattern, max_factor_gib * 0x1p30);
    planned = true;
    return cholesky;
  }

  std::vector<double> start;
  PoseGraphLayout layout;
  double max_factor_gib;

 private:
  bool planned = false;
  std::shared_ptr<SparseCholesky> cholesky;
};

PoseGraphProblem::PoseGraphProblem(const PoseGraph& graph, const PoseGraphProblemOptions& options)
    : impl_(std::make_unique<Impl>(graph, options)) {}

PoseGraphProblem::~PoseGraphProblem() = default;

Index PoseGraphProblem::num_parameters() const { return static_cast<Index>(impl_->start.size()); }

Index PoseGraphProblem::num_tangent() const { return impl_->layout.num_tangent(); }

Index PoseGraphProblem::num_units() const { return impl_->layout.terms.num_edges(); }

double PoseGraphProblem::Cost(ConstVectorView x) {
  CheckSize(x);
  return ParallelSum<double>(num_units(), kGrain, [&](Index begin, Index end) {
    double sum = 0;
    for (Index e = begin; e < end; ++e) sum += impl_->layout.terms.Cost(e, x.data());
    return sum;
  });
}

double PoseGraphProblem::Cost(ConstVectorView x, std::span<const Index> units) {
  CheckSize(x);
  CheckUnits(units);
  return ParallelSum<double>(static_cast<Index>(units.size()), kGrain, [&](Index begin, Index end) {
    double sum = 0;
    for (Index k = begin; k < end; ++k) sum += impl_->layout.terms.Cost(units[static_cast<std::size_t>(k)], x.data());
    return sum;
  });
}

std::unique_ptr<Linearization<CpuBackend<double>>> PoseGraphProblem::Linearize(ConstVectorView x) {
  CheckSize(x);
  return std::make_unique<PoseGraphLinearization>(impl_->layout, x);
}

std::unique_ptr<Preconditioner<CpuBackend<double>>> PoseGraphProblem::MakePreconditioner() {
  const std::shared_ptr<SparseCholesky>& cholesky = impl_->Cholesky();
  return cholesky ? std::make_unique<SparseCholeskyPreconditioner>(cholesky) : nullptr;
}

std::unique_ptr<Preconditioner<CpuBackend<double>>> PoseGraphProblem::MakeSparseCholesky() {
  auto made = MakePreconditioner();
  if (!made)
    Fail(kOutOfMemory, "pose graph: the Cholesky factor would take more than max_factor_gib={}; increase it",
         impl_->max_factor_gib);
  return made;
}

void PoseGraphProblem::Plus(B& /*backend*/, ConstVectorView x, ConstVectorView delta, VectorView out) {
  if (impl_->layout.terms.space == PoseSpace::kSe2) {
    MovePoses<Se2>(impl_->layout, x.data(), delta.data(), out.data());
  } else {
    MovePoses<Se3>(impl_->layout, x.data(), delta.data(), out.data());
  }
}

std::string PoseGraphProblem::NameTangent(Index k) {
  const Index d = impl_->layout.tangent();
  return fmt::format("tangent entry {} of pose {}", k % d, impl_->layout.pose_of_row[static_cast<std::size_t>(k / d)]);
}

std::string PoseGraphProblem::NameResidual(int /*batch*/, Index row) {
  const Index d = impl_->layout.tangent();
  return fmt::format("residual {} of edge {}", row % d, row / d);
}

std::string PoseGraphProblem::DescribeDegenerate(ConstVectorView x) {
  if (impl_->layout.terms.space == PoseSpace::kSe2) return "";
  for (const Index pose : impl_->layout.pose_of_row) {
    const double* q = x.data() + pose * Se3::kPose + 3;
    if (std::any_of(q, q + 4, [](double value) { return value != 0; })) continue;
    return fmt::format(
        "the quaternion of pose {} is all zeros, so no step can change it; initialise it with unit length", pose);
  }
  return "";
}

const std::vector<double>& PoseGraphProblem::start() const { return impl_->start; }

PlannedPattern PoseGraphProblem::Planned() const { return {impl_->layout.pattern, impl_->Cholesky()}; }

LmOptions PoseGraphOptions() {
  LmOptions options;
  options.column_scaling = ColumnScaling::kOnePlusInverse;
  options.step_control.initial_lambda = 1e-10;
  options.step_control.lambda_after_first_reject = 1;
  options.normal_system.linear_solver = LinearSolverKind::kPcg;
  options.normal_system.preconditioner = PreconditionerKind::kProblem;
  // The second test is for problems whose factor would be too large. A factor meets the first test in one iteration.
  options.normal_system.pcg = {.max_iterations = 500, .relative_tolerance = 1e-10, .model_tolerance = 1e-2};
  return options;
}

}  // namespace vesta::pose_graph
