// SPDX-License-Identifier: Apache-2.0
#include "problems/pose_graph/g2o_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>
#include <unordered_map>

#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "problems/pose_graph/information.h"

namespace vesta::pose_graph {
namespace {

// Order of a pose's numbers in a file, as indices into memory: quaternions are (w, x, y, z) in memory, (x, y, z, w) in
// files.
constexpr std::array<int, 3> kFileOrderSe2 = {0, 1, 2};
constexpr std::array<int, 7> kFileOrderSe3 = {0, 1, 2, 4, 5, 6, 3};

const int* FileOrder(PoseSpace space) { return space == PoseSpace::kSe2 ? kFileOrderSe2.data() : kFileOrderSe3.data(); }

struct VertexTag {
  std::string_view name;
  PoseSpace space;
  bool is_landmark;
};
constexpr VertexTag kVertexTags[] = {
    {"VERTEX_SE2", PoseSpace::kSe2, false},
    {"VERTEX_SE3:QUAT", PoseSpace::kSe3, false},
    {"VERTEX_XY", PoseSpace::kSe2, true},
    {"VERTEX_TRACKXYZ", PoseSpace::kSe3, true},
};

struct EdgeTag {
  std::string_view name;
  PoseSpace space;
  bool is_prior = false;           // one vertex; from the world's frame
  bool to_landmark = false;        // the second vertex is a landmark
  bool measures_position = false;  // and not the rotation
  bool has_offset = false;         // the id of a PARAMS_SE3OFFSET follows the vertices
};
constexpr EdgeTag kEdgeTags[] = {
    {.name = "EDGE_SE2", .space = PoseSpace::kSe2},
    {.name = "EDGE_SE3:QUAT", .space = PoseSpace::kSe3},
    {.name = "EDGE_SE2_XY", .space = PoseSpace::kSe2, .to_landmark = true, .measures_position = true},
    {.name = "EDGE_SE3_TRACKXYZ",
     .space = PoseSpace::kSe3,
     .to_landmark = true,
     .measures_position = true,
     .has_offset = true},
    {.name = "EDGE_PRIOR_SE2", .space = PoseSpace::kSe2, .is_prior = true},
    {.name = "EDGE_PRIOR_SE2_XY", .space = PoseSpace::kSe2, .is_prior = true, .measures_position = true},
    {.name = "EDGE_SE3_PRIOR", .space = PoseSpace::kSe3, .is_prior = true, .has_offset = true},
};

constexpr const char* kOffsetTag = "PARAMS_SE3OFFSET";

// The entry of `tags` with this name, or null.
template <class Tag, std::size_t N>
const Tag* Find(const Tag (&tags)[N], std::string_view name) {
  const Tag* found = std::find_if(tags, tags + N, [&](const Tag& tag) { return tag.name == name; });
  return found == tags + N ? nullptr : found;
}

void AppendIdentity(PoseSpace space, std::vector<double>* poses) {
  poses->resize(poses->size() + static_cast<std::size_t>(PoseSize(space)), 0.0);
  if (space == PoseSpace::kSe3) (*poses)[poses->size() - 4] = 1;
}

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
  // As in PoseGraph; `from` has no meaning for a prior.
  struct Edge {
    const EdgeTag* tag;
    Reference from, to;
  };

  void ReadRecord(std::string_view tag) {
    if (const VertexTag* vertex = Find(kVertexTags, tag)) {
      ReadVertex(*vertex);
    } else if (const EdgeTag* edge = Find(kEdgeTags, tag)) {
      ReadEdge(*edge);
    } else if (tag == kOffsetTag) {
      ReadOffset();
    } else if (tag == "FIX") {
      do {
        fixed_.push_back({Whole("a vertex's id"), number_});
        SkipSpace();
      } while (!line_.empty());
    } else {
      std::string known = "FIX, ";
      for (const VertexTag& each : kVertexTags) known += fmt::format("{}, ", each.name);
      for (const EdgeTag& each : kEdgeTags) known += fmt::format("{}, ", each.name);
      Fail(kBadFile, "{}: unknown tag {}; known are {}{}", Where(), Printable(tag), known, kOffsetTag);
    }
    SkipSpace();
    if (!line_.empty()) Fail(kBadFile, "{}: more words than {} takes", Where(), Printable(tag));
  }
  void ReadVertex(const VertexTag& tag) {
    SetSpace(tag.space);
    const Index id = Whole("the vertex's id");
    if (!positions_.try_emplace(id, graph_.num_poses()).second)
      Fail(kBadFile, "{}: vertex {} is defined twice", Where(), id);
    if (tag.is_landmark) graph_.landmarks.push_back(graph_.num_poses());
    graph_.ids.push_back(id);
    ReadPose(tag.is_landmark, &graph_.poses);
  }
  void ReadEdge(const EdgeTag& tag) {
    SetSpace(tag.space);
    Edge edge{&tag, {}, {}};
    if (!tag.is_prior) edge.from = {Whole("the edge's first vertex"), number_};
    edge.to = {Whole(tag.is_prior ? "the vertex" : "the edge's second vertex"), number_};
    if (!tag.is_prior && edge.from.id == edge.to.id)
      Fail(kBadFile, "{}: the edge goes from vertex {} to itself", Where(), edge.to.id);
    if (tag.has_offset) offsets_used_.push_back({Whole("the offset's id"), number_});
    edges_.push_back(edge);
    ReadPose(tag.measures_position, &graph_.measurements);
    const std::size_t begin = graph_.information.size();
    graph_.information.resize(begin + static_cast<std::size_t>(InformationSize(tag.space)));
    double* information = graph_.information.data() + begin;
    const int size = tag.measures_position ? PositionSize(tag.space) : TangentSize(tag.space);
    for (int k = 0; k < size * (size + 1) / 2; ++k) information[k] = Number("the information matrix");
    CheckInformation(information, size);
    if (!tag.measures_position) return;
    double block[6];
    std::copy_n(information, size * (size + 1) / 2, block);
    FromPositionBlock(tag.space, block, information);
  }
  void ReadOffset() {
    const Index id = Whole("the offset's id");
    std::vector<double> offset, identity;
    AppendIdentity(PoseSpace::kSe3, &identity);
    SetSpace(PoseSpace::kSe3);
    ReadPose(false, &offset);
    if (offset != identity)
      Fail(kUnsupported, "{}: the sensor's pose is not the identity; only 0 0 0 0 0 0 1 is supported", Where());
    offsets_.push_back(id);
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
  // is_position: without a rotation, which becomes the identity.
  void ReadPose(bool is_position, std::vector<double>* poses) {
    const int size = PoseSize(*space_), given = is_position ? PositionSize(*space_) : size;
    AppendIdentity(*space_, poses);
    double* pose = poses->data() + poses->size() - size;
    for (int k = 0; k < given; ++k) pose[FileOrder(*space_)[k]] = Number("the pose");
    if (is_position || *space_ == PoseSpace::kSe2) return;
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
    for (const Edge& edge : edges_) {
      if (!edge.tag->is_prior) AddVertex(edge.from.id, false);
      AddVertex(edge.to.id, edge.tag->to_landmark);
    }
  }
  void AddVertex(Index id, bool is_landmark) {
    if (!positions_.try_emplace(id, graph_.num_poses()).second) return;
    if (is_landmark) graph_.landmarks.push_back(graph_.num_poses());
    graph_.ids.push_back(id);
    AppendIdentity(*space_, &graph_.poses);
  }
  // Replaces vertex ids by indices into the poses.
  void Resolve() {
    if (std::any_of(edges_.begin(), edges_.end(), [](const Edge& edge) { return edge.tag->is_prior; })) {
      graph_.world = graph_.num_poses();
      graph_.ids.push_back(UnusedId());
      AppendIdentity(*space_, &graph_.poses);
      graph_.fixed.push_back(graph_.world);
    }
    for (const Edge& edge : edges_) {
      const Index from = edge.tag->is_prior ? graph_.world : PositionOf(edge.from, false);
      graph_.edges.push_back({from, PositionOf(edge.to, edge.tag->to_landmark)});
    }
    for (const Reference& reference : fixed_) graph_.fixed.push_back(PositionOf(reference));
    std::sort(graph_.fixed.begin(), graph_.fixed.end());
    graph_.fixed.erase(std::unique(graph_.fixed.begin(), graph_.fixed.end()), graph_.fixed.end());
    for (const Reference& used : offsets_used_) {
      if (std::find(offsets_.begin(), offsets_.end(), used.id) == offsets_.end())
        Fail(kBadFile, "{}: line {}: there is no offset {}; add its {} line", path_, used.line, used.id, kOffsetTag);
    }
  }
  Index UnusedId() const {
    Index id = -1;
    while (positions_.count(id) > 0) --id;
    return id;
  }
  Index PositionOf(const Reference& reference, bool is_landmark) const {
    const Index position = PositionOf(reference);
    if (graph_.IsLandmark(position) != is_landmark) {
      Fail(kBadFile, "{}: line {}: vertex {} is {}", path_, reference.line, reference.id,
           is_landmark ? "a pose; this edge needs a landmark" : "a landmark; this edge needs a pose");
    }
    return position;
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
  std::vector<Edge> edges_;
  std::vector<Index> offsets_;  // ids of PARAMS_SE3OFFSET
  std::vector<Reference> fixed_, offsets_used_;
};

void AppendPose(PoseSpace space, const double* pose, int count, std::string* text) {
  for (int k = 0; k < count; ++k) fmt::format_to(std::back_inserter(*text), " {}", pose[FileOrder(space)[k]]);
}

// Whether an edge measures a position alone.
bool MeasuresPosition(const PoseGraph& graph, Index e) {
  const auto [from, to] = graph.edges[static_cast<std::size_t>(e)];
  if (graph.IsLandmark(to)) return true;
  if (from != graph.world || graph.space != PoseSpace::kSe2) return false;
  const double* information = graph.information.data() + e * InformationSize(graph.space);
  double block[6], without_rotation[21];
  PositionBlock(graph.space, information, block);
  FromPositionBlock(graph.space, block, without_rotation);
  const bool has_rotation = graph.measurements[static_cast<std::size_t>(e * PoseSize(graph.space) + 2)] != 0;
  return !has_rotation && std::equal(information, information + InformationSize(graph.space), without_rotation);
}

void AppendEdge(const PoseGraph& graph, Index e, std::string* text) {
  const auto [from, to] = graph.edges[static_cast<std::size_t>(e)];
  const bool is_prior = from == graph.world, measures_position = MeasuresPosition(graph, e);
  const EdgeTag* tag = std::find_if(std::begin(kEdgeTags), std::end(kEdgeTags), [&](const EdgeTag& candidate) {
    return candidate.space == graph.space && candidate.is_prior == is_prior &&
           candidate.measures_position == measures_position;
  });
  if (tag == std::end(kEdgeTags)) Fail(kUnsupported, "pose graph: edge {} is a prior of a landmark; fix it instead", e);
  *text += tag->name;
  if (!is_prior) *text += fmt::format(" {}", graph.ids[static_cast<std::size_t>(from)]);
  *text += fmt::format(" {}", graph.ids[static_cast<std::size_t>(to)]);
  if (tag->has_offset) *text += " 0";
  const int pose_size = PoseSize(graph.space), information_size = InformationSize(graph.space);
  AppendPose(graph.space, graph.measurements.data() + e * pose_size,
             measures_position ? PositionSize(graph.space) : pose_size, text);
  const double* information = graph.information.data() + e * information_size;
  double block[6];
  if (measures_position) PositionBlock(graph.space, std::exchange(information, block), block);
  const int n = PositionSize(graph.space);
  for (int k = 0; k < (measures_position ? n * (n + 1) / 2 : information_size); ++k) {
    *text += fmt::format(" {}", information[k]);
  }
  *text += '\n';
}

}  // namespace

PoseGraph ReadG2o(const std::string& path, const G2oOptions& options) { return Reader(path, options).Read(); }

void WriteG2o(const PoseGraph& graph, const std::string& path) {
  std::string text;
  const bool has_offsets = graph.space == PoseSpace::kSe3 && (graph.world >= 0 || !graph.landmarks.empty());
  if (has_offsets) text += fmt::format("{} 0 0 0 0 0 0 0 1\n", kOffsetTag);
  for (Index i = 0; i < graph.num_poses(); ++i) {
    if (i == graph.world) continue;
    const bool is_landmark = graph.IsLandmark(i);
    const VertexTag* tag = std::find_if(std::begin(kVertexTags), std::end(kVertexTags), [&](const VertexTag& t) {
      return t.space == graph.space && t.is_landmark == is_landmark;
    });
    text += fmt::format("{} {}", tag->name, graph.ids[static_cast<std::size_t>(i)]);
    AppendPose(graph.space, graph.poses.data() + i * PoseSize(graph.space),
               is_landmark ? PositionSize(graph.space) : PoseSize(graph.space), &text);
    text += '\n';
  }
  for (const Index i : graph.fixed) {
    if (i != graph.world) text += fmt::format("FIX {}\n", graph.ids[static_cast<std::size_t>(i)]);
  }
  for (Index e = 0; e < graph.num_edges(); ++e) AppendEdge(graph, e, &text);
  WriteFileAtomically(path, text);
}

}  // namespace vesta::pose_graph
