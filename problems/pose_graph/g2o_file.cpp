// SPDX-License-Identifier: Apache-2.0
#include "problems/pose_graph/g2o_file.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>
#include <unordered_map>

#include "kernels/core/check.h"
#include "kernels/core/files.h"

namespace vesta::pose_graph {
namespace {

// Order of a pose's numbers in a file, as indices into memory: quaternions are (w, x, y, z) in memory, (x, y, z, w) in
// files.
constexpr std::array<int, 3> kFileOrderSe2 = {0, 1, 2};
constexpr std::array<int, 7> kFileOrderSe3 = {0, 1, 2, 4, 5, 6, 3};

const int* FileOrder(PoseSpace space) { return space == PoseSpace::kSe2 ? kFileOrderSe2.data() : kFileOrderSe3.data(); }

class Reader {
 public:
  Reader(const std::string& path, const G2oOptions& options) : path_(path), options_(options) {}

  PoseGraph Read() {
    const std::string text = ReadFile(path_);
    for (std::string_view rest = text; NextLine(&rest, &line_);) {
      ++number_;
      const std::string_view tag = NextWord(&line_);
      if (!tag.empty() && tag.front() != '#') ReadRecord(tag);
    }
    if (!space_) Fail(kBadFile, "{}: contains neither vertices nor edges; give a g2o file", path_);
    if (graph_.ids.empty()) AddVerticesOfEdges();
    Resolve();
    semidefinite_.Note("are only semidefinite: they do not constrain some direction", graph_.notes);
    clipped_.Note("were indefinite and have been replaced by the nearest semidefinite ones", graph_.notes);
    return std::move(graph_);
  }

 private:
  // Counts lines with a common property and remembers the first.
  struct Lines {
    Index count = 0, first = 0;
    void Add(Index line) {
      if (count++ == 0) first = line;
    }
    void Note(const char* what, std::vector<std::string>& notes) const {
      if (count > 0)
        notes.push_back(fmt::format("{} information matrices {}; the first on line {}", count, what, first));
    }
  };
  // A vertex id, looked up after all vertices have been read, and its line.
  struct Reference {
    Index id, line;
  };

  void ReadRecord(std::string_view tag) {
    if (tag == "VERTEX_SE2") {
      ReadVertex(PoseSpace::kSe2);
    } else if (tag == "VERTEX_SE3:QUAT") {
      ReadVertex(PoseSpace::kSe3);
    } else if (tag == "EDGE_SE2") {
      ReadEdge(PoseSpace::kSe2);
    } else if (tag == "EDGE_SE3:QUAT") {
      ReadEdge(PoseSpace::kSe3);
    } else if (tag == "FIX") {
      do {
        fixed_.push_back({Whole("a vertex's id"), number_});
        SkipSpace();
      } while (!line_.empty());
    } else {
      Fail(kBadFile, "{}: unknown tag {}; known are VERTEX_SE2, EDGE_SE2, VERTEX_SE3:QUAT, EDGE_SE3:QUAT and FIX",
           Where(), Printable(tag));
    }
    SkipSpace();
    if (!line_.empty()) Fail(kBadFile, "{}: more words than {} takes", Where(), Printable(tag));
  }
  void ReadVertex(PoseSpace space) {
    SetSpace(space);
    const Index id = Whole("the vertex's id");
    if (!positions_.try_emplace(id, graph_.num_poses()).second)
      Fail(kBadFile, "{}: vertex {} is defined twice", Where(), id);
    graph_.ids.push_back(id);
    ReadPose(&graph_.poses);
  }
  void ReadEdge(PoseSpace space) {
    SetSpace(space);
    const Index from = Whole("the edge's first vertex"), to = Whole("the edge's second vertex");
    if (from == to) Fail(kBadFile, "{}: the edge goes from vertex {} to itself", Where(), from);
    ends_.push_back({from, number_});
    ends_.push_back({to, number_});
    ReadPose(&graph_.measurements);
    const std::size_t begin = graph_.information.size();
    for (int k = 0; k < InformationSize(space); ++k) graph_.information.push_back(Number("the information matrix"));
    CheckInformation(graph_.information.data() + begin, TangentSize(space));
  }
  void CheckInformation(double* information, int size) {
    double root[36];
    if (FactorInformation(information, size, root)) return;
    const Spectrum spectrum = SpectrumOf(information, size);
    if (spectrum.semidefinite) return semidefinite_.Add(number_);
    if (!options_.clip_indefinite) {
      Fail(kBadFile,
           "{}: the information matrix is indefinite: eigenvalues from {:.3g} to {:.3g}; correct it, or read with "
           "clip_indefinite",
           Where(), spectrum.least, spectrum.largest);
    }
    clipped_.Add(number_);
    for (int row = 0; row < size; ++row) {
      for (int col = row; col < size; ++col, ++information) {
        *information = 0;
        for (int k = 0; k < size; ++k) *information += root[row * size + k] * root[col * size + k];
      }
    }
  }
  void ReadPose(std::vector<double>* poses) {
    const std::size_t begin = poses->size();
    const int size = PoseSize(*space_);
    poses->resize(begin + static_cast<std::size_t>(size));
    double* pose = poses->data() + begin;
    for (int k = 0; k < size; ++k) pose[FileOrder(*space_)[k]] = Number("the pose");
    if (*space_ == PoseSpace::kSe2) return;
    const double norm = std::hypot(std::hypot(pose[3], pose[4]), std::hypot(pose[5], pose[6]));
    if (!(norm > 1e-3 && norm < 1e3)) Fail(kBadFile, "{}: the quaternion is far from unit length", Where());
    for (int k = 3; k < size; ++k) pose[k] /= norm;
  }
  void SetSpace(PoseSpace space) {
    if (!space_) space_ = graph_.space = space;
    if (*space_ != space) Fail(kUnsupported, "{}: the file mixes 2D and 3D poses; split it", Where());
  }
  // For a file of edges alone.
  void AddVerticesOfEdges() {
    graph_.has_poses = false;
    for (const Reference& end : ends_) {
      if (!positions_.try_emplace(end.id, graph_.num_poses()).second) continue;
      graph_.ids.push_back(end.id);
      const std::size_t begin = graph_.poses.size();
      graph_.poses.resize(begin + static_cast<std::size_t>(PoseSize(*space_)), 0.0);
      if (*space_ == PoseSpace::kSe3) graph_.poses[begin + 3] = 1;
    }
  }
  // Replaces vertex ids by indices into the poses.
  void Resolve() {
    for (std::size_t k = 0; k < ends_.size(); k += 2) {
      graph_.edges.push_back({PositionOf(ends_[k]), PositionOf(ends_[k + 1])});
    }
    for (const Reference& reference : fixed_) graph_.fixed.push_back(PositionOf(reference));
    std::sort(graph_.fixed.begin(), graph_.fixed.end());
    graph_.fixed.erase(std::unique(graph_.fixed.begin(), graph_.fixed.end()), graph_.fixed.end());
  }
  Index PositionOf(const Reference& reference) const {
    const auto found = positions_.find(reference.id);
    if (found == positions_.end()) {
      Fail(kBadFile, "{}: line {}: there is no vertex {}; add its VERTEX line", path_, reference.line, reference.id);
    }
    return found->second;
  }

  std::string_view Word(const char* what) {
    const std::string_view word = NextWord(&line_);
    if (word.empty()) Fail(kBadFile, "{}: the line ends before the end of {}", Where(), what);
    return word;
  }
  double Number(const char* what) {
    const std::string_view word = Word(what);
    double value = 0;
    if (!ParseNumber(word, &value) || !std::isfinite(value)) {
      Fail(kBadFile, "{}: {} in {} is not a finite number", Where(), Printable(word), what);
    }
    return value;
  }
  Index Whole(const char* what) {
    const std::string_view word = Word(what);
    Index value = 0;
    if (!ParseNumber(word, &value))
      Fail(kBadFile, "{}: {} is not a whole number, as {} must be", Where(), Printable(word), what);
    return value;
  }
  void SkipSpace() { line_.remove_prefix(std::min(line_.find_first_not_of(" \t\r"), line_.size())); }
  std::string Where() const { return fmt::format("{}: line {}", path_, number_); }

  const std::string& path_;
  G2oOptions options_;
  Lines semidefinite_, clipped_;
  std::string_view line_;
  Index number_ = 0;
  std::optional<PoseSpace> space_;
  PoseGraph graph_;
  std::unordered_map<Index, Index> positions_;
  std::vector<Reference> ends_, fixed_;
};

void AppendPose(PoseSpace space, const double* pose, std::string* text) {
  for (int k = 0; k < PoseSize(space); ++k) {
    fmt::format_to(std::back_inserter(*text), " {}", pose[FileOrder(space)[k]]);
  }
}

}  // namespace

PoseGraph ReadG2o(const std::string& path, const G2oOptions& options) { return Reader(path, options).Read(); }

void WriteG2o(const PoseGraph& graph, const std::string& path) {
  const char* name = graph.space == PoseSpace::kSe2 ? "SE2" : "SE3:QUAT";
  const Index pose_size = PoseSize(graph.space), information_size = InformationSize(graph.space);
  std::string text;
  for (Index i = 0; i < graph.num_poses(); ++i) {
    text += fmt::format("VERTEX_{} {}", name, graph.ids[static_cast<std::size_t>(i)]);
    AppendPose(graph.space, graph.poses.data() + i * pose_size, &text);
    text += '\n';
  }
  for (const Index i : graph.fixed) text += fmt::format("FIX {}\n", graph.ids[static_cast<std::size_t>(i)]);
  for (Index e = 0; e < graph.num_edges(); ++e) {
    const PoseGraph::Edge& edge = graph.edges[static_cast<std::size_t>(e)];
    text += fmt::format("EDGE_{} {} {}", name, graph.ids[static_cast<std::size_t>(edge.from)],
                        graph.ids[static_cast<std::size_t>(edge.to)]);
    AppendPose(graph.space, graph.measurements.data() + e * pose_size, &text);
    for (Index k = 0; k < information_size; ++k) {
      text += fmt::format(" {}", graph.information[static_cast<std::size_t>(e * information_size + k)]);
    }
    text += '\n';
  }
  WriteFileAtomically(path, text);
}

namespace {

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, 6, 6>;

Matrix Full(const double* upper, int size) {
  Matrix full(size, size);
  for (int row = 0; row < size; ++row) {
    for (int col = row; col < size; ++col) full(row, col) = full(col, row) = *upper++;
  }
  return full;
}

// Returns false if the matrix is not positive definite; `lower` is then undefined.
bool Cholesky(const double* upper, int size, double* lower) {
  for (int row = 0; row < size; ++row) {
    for (int col = 0; col < size; ++col) lower[row * size + col] = 0;
  }
  // The rows of the upper triangle are the columns of L.
  for (int col = 0; col < size; ++col) {
    for (int row = col; row < size; ++row, ++upper) {
      double value = *upper;
      for (int k = 0; k < col; ++k) value -= lower[row * size + k] * lower[col * size + k];
      if (row == col) {
        if (!(value > 0) || !std::isfinite(value)) return false;
        lower[col * size + col] = std::sqrt(value);
      } else {
        lower[row * size + col] = value / lower[col * size + col];
      }
    }
  }
  return true;
}

}  // namespace

Spectrum SpectrumOf(const double* upper, int size) {
  const Matrix full = Full(upper, size);
  if (!full.allFinite()) return {};
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(full, Eigen::EigenvaluesOnly);
  const double least = solver.eigenvalues()[0], largest = solver.eigenvalues()[size - 1];
  return {largest >= 0 && least >= -1e-12 * largest, least, largest};
}

bool FactorInformation(const double* upper, int size, double* root) {
  if (Cholesky(upper, size, root)) return true;
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(Full(upper, size));
  const auto& vectors = solver.eigenvectors();
  Eigen::Map<Matrix>(root, size, size) =
      vectors * solver.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() * vectors.transpose();
  return false;
}

}  // namespace vesta::pose_graph
