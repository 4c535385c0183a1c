// SPDX-License-Identifier: Apache-2.0
#include "bench/collections/generate_bundle.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "kernels/core/random.h"
#include "problems/bundle_adjustment/projection.h"

namespace vesta::bundle {
namespace {

constexpr double kPi = std::numbers::pi;
// Metres.
constexpr double kSide = 8;       // distance from the path to the facades
constexpr double kSpacing = 0.5;  // distance of the cameras, unless the ring has too few
constexpr double kLargestSpacing = 1.5;
constexpr double kSightRange = 40;  // largest distance of a visible point
constexpr double kSmallestRing = 3 * kSide;
// Cosine of the largest angle to the facade normal.
constexpr double kGrazing = 0.26;
// Pixels.
constexpr double kFocal = 1000, kHalfWidth = 1000, kHalfHeight = 750;
constexpr Index kGrain = 64;
constexpr int kMaxAttempts = 50;

// Keys of the random streams; equal keys give equal streams.
enum Purpose : std::uint64_t { kCameraTruth = 1, kPointTruth, kTrack, kPixel, kCameraStart, kPointStart };

struct Vector3 {
  double x = 0, y = 0, z = 0;
};
double DistanceSquared(const Vector3& a, const Vector3& b) {
  const double x = a.x - b.x, y = a.y - b.y, z = a.z - b.z;
  return x * x + y * y + z * z;
}

// The path of the vehicle: along +x, then a circle; y points up. A place is `along` metres from the start and `aside`
// metres to the left.
class Way {
 public:
  explicit Way(Index cameras) : Way(cameras / 2, cameras - cameras / 2) {}

  double spacing() const { return spacing_; }
  double length() const { return street_ + ring_; }
  double ring() const { return ring_; }
  // With too few cameras the ring is an arc.
  bool ring_is_closed() const { return ring_ >= 2 * kPi * kSmallestRing; }
  // Length of the straight part.
  double street() const { return street_; }
  // Angle of the direction of travel, from +x towards -z.
  double Heading(double along) const { return along <= street_ ? 0 : (along - street_) / radius_; }
  Vector3 Place(double along, double aside, double height) const {
    if (along <= street_) return {along - street_, height, -aside};
    const double angle = Heading(along), r = radius_ - aside;
    return {r * std::sin(angle), height, -radius_ + r * std::cos(angle)};
  }

 private:
  Way(Index street_cameras, Index ring_cameras)
      : spacing_(std::clamp(2 * kPi * kSmallestRing / static_cast<double>(ring_cameras), kSpacing, kLargestSpacing)),
        street_(spacing_ * static_cast<double>(street_cameras)),
        ring_(spacing_ * static_cast<double>(ring_cameras)),
        radius_(std::max(ring_ / (2 * kPi), kSmallestRing)) {}

  double spacing_, street_, ring_, radius_;
};

struct World {
  Way way;
  std::vector<double> cameras;  // nine parameters each
  std::vector<Camera<double>> models;
  std::vector<Vector3> centres;
  std::vector<Vector3> points;
};

// R X + t = R (X - centre).
void SetTranslation(const Vector3& centre, double* parameters) {
  const Camera<double> model = MakeCamera(parameters);
  for (int i = 0; i < 3; ++i) {
    const double* row = model.rotation + 3 * i;
    parameters[3 + i] = -(row[0] * centre.x + row[1] * centre.y + row[2] * centre.z);
  }
}

void PlaceCamera(const GenerateOptions& options, Index i, World& world) {
  CounterRandom random(options.seed, kCameraTruth, static_cast<std::uint64_t>(i));
  const double along = world.way.spacing() * (static_cast<double>(i) + 0.5);
  // The cameras look left, right, and diagonally forward to either side, in turn.
  constexpr double kTurns[4] = {kPi / 2, -kPi / 2, kPi / 4, -kPi / 4};
  // Angle-axis (0, a, 0) looks along (sin a, 0, -cos a); heading h is the direction (cos h, 0, -sin h).
  const double look = world.way.Heading(along) + kTurns[i % 4];
  double* parameters = world.cameras.data() + kCameraSize * i;
  parameters[0] = 0.02 * random.Normal();
  parameters[1] = std::remainder(kPi / 2 - look + 0.05 * random.Normal(), 2 * kPi);
  parameters[2] = 0.02 * random.Normal();
  parameters[6] = kFocal * (1 + 0.02 * random.Normal());
  parameters[7] = -0.05 + 0.01 * random.Normal();
  parameters[8] = 0.01 + 0.002 * random.Normal();
  const Vector3 centre = world.way.Place(along + 0.1 * random.Normal(), 0.2 * random.Normal(), 0.1 * random.Normal());
  SetTranslation(centre, parameters);
  const auto k = static_cast<std::size_t>(i);
  world.centres[k] = centre;
  world.models[k] = MakeCamera(parameters);
}

struct Facade {
  double along = 0;
  Vector3 point, normal;
};

Facade RandomFacadePoint(const Way& way, CounterRandom& random) {
  Facade facade;
  facade.along = way.length() * random.Uniform();
  const double side = random.Uniform() < 0.5 ? -1 : 1;
  // Depth of up to 1 m, as of bays and balconies.
  const double aside = side * (kSide - random.Uniform()), height = -1.5 + 8 * random.Uniform();
  facade.point = way.Place(facade.along, aside, height);
  const Vector3 inward = way.Place(facade.along, aside - side, height);
  facade.normal = {inward.x - facade.point.x, 0, inward.z - facade.point.z};
  return facade;
}

bool Sees(const World& world, Index camera, const Facade& facade) {
  const auto k = static_cast<std::size_t>(camera);
  const Vector3 &c = world.centres[k], &p = facade.point, &n = facade.normal;
  const double square = DistanceSquared(c, p);
  if (square > kSightRange * kSightRange) return false;
  if ((c.x - p.x) * n.x + (c.z - p.z) * n.z < kGrazing * std::sqrt(square)) return false;
  const double X[3] = {p.x, p.y, p.z};
  const Projection<double> at = Project(world.models[k], X);
  return at.inverse_z < 0 && at.inverse_z > -1 && std::abs(at.predicted[0]) < kHalfWidth &&
         std::abs(at.predicted[1]) < kHalfHeight;
}

// The cameras that could see a point, sorted along the path, including those beyond the closure of the ring.
void CollectSeeing(const World& world, const Facade& facade, std::vector<std::int32_t>& seeing) {
  seeing.clear();
  const Index cameras = static_cast<Index>(world.centres.size());
  const auto add = [&](double along) {
    const double spacing = world.way.spacing();
    const Index begin = std::max<Index>(0, static_cast<Index>((along - kSightRange) / spacing) - 1);
    const Index end = std::min(cameras, static_cast<Index>((along + kSightRange) / spacing) + 2);
    for (Index i = begin; i < end; ++i) {
      if (Sees(world, i, facade)) seeing.push_back(static_cast<std::int32_t>(i));
    }
  };
  add(facade.along);
  if (world.way.ring_is_closed()) {
    if (std::abs(facade.along - world.way.street()) < kSightRange) add(facade.along + world.way.ring());
    if (facade.along > world.way.length() - kSightRange) add(facade.along - world.way.ring());
  }
  std::sort(seeing.begin(), seeing.end());
  seeing.erase(std::unique(seeing.begin(), seeing.end()), seeing.end());
}

// Places the points. Returns the cameras that could see each: at least two, unless all attempts failed.
std::vector<std::vector<std::int32_t>> PlacePoints(const GenerateOptions& options, World& world) {
  std::vector<std::vector<std::int32_t>> seeing(static_cast<std::size_t>(options.num_points));
  ParallelFor(options.num_points, kGrain, [&](Index p) {
    const auto k = static_cast<std::size_t>(p);
    CounterRandom random(options.seed, kPointTruth, static_cast<std::uint64_t>(p));
    for (int attempt = 0; attempt < kMaxAttempts && seeing[k].size() < 2; ++attempt) {
      const Facade facade = RandomFacadePoint(world.way, random);
      world.points[k] = facade.point;
      CollectSeeing(world, facade, seeing[k]);
    }
  });
  return seeing;
}

// Lengths weight / sqrt(uniform), whose density falls with the cube of the length. Bisection finds the weight for the
// requested mean.
std::vector<Index> TrackLengths(const GenerateOptions& options, const std::vector<std::vector<std::int32_t>>& seeing) {
  std::vector<double> tail(seeing.size());
  for (std::size_t p = 0; p < seeing.size(); ++p) {
    tail[p] = 1 / std::sqrt(1 - CounterRandom(options.seed, kTrack, p).Uniform());
  }
  const auto length = [&](std::size_t p, double weight) {
    const auto visible = static_cast<double>(seeing[p].size());
    return static_cast<Index>(std::min(visible, std::max(2.0, std::round(weight * tail[p]))));
  };
  const double goal = options.mean_track * static_cast<double>(seeing.size());
  double low = 0, high = 4 * options.mean_track;
  for (int step = 0; step < 40; ++step) {
    const double weight = 0.5 * (low + high);
    Index sum = 0;
    for (std::size_t p = 0; p < seeing.size(); ++p) sum += length(p, weight);
    (static_cast<double>(sum) < goal ? low : high) = weight;
  }
  std::vector<Index> lengths(seeing.size());
  for (std::size_t p = 0; p < seeing.size(); ++p) lengths[p] = length(p, high);
  return lengths;
}

Observation Observe(const GenerateOptions& options, const World& world, std::int32_t camera, std::size_t point) {
  CounterRandom random(options.seed, kPixel, static_cast<std::uint64_t>(camera) << 32 | point);
  const Vector3& p = world.points[point];
  const double X[3] = {p.x, p.y, p.z};
  const Projection<double> at = Project(world.models[static_cast<std::size_t>(camera)], X);
  Observation o{camera, static_cast<std::int32_t>(point), {at.predicted[0], at.predicted[1]}};
  const double sigma = random.Uniform() < options.outliers ? 30 : options.pixel_noise;
  for (double& value : o.pixel) value += sigma * random.Normal();
  return o;
}

void AddObservations(const GenerateOptions& options, const World& world,
                     const std::vector<std::vector<std::int32_t>>& seeing, BundleData& data) {
  const std::vector<Index> lengths = TrackLengths(options, seeing);
  std::vector<Index> first(lengths.size() + 1, 0);
  for (std::size_t p = 0; p < lengths.size(); ++p) first[p + 1] = first[p] + lengths[p];
  if (first.back() > std::numeric_limits<std::int32_t>::max())
    Fail(kBadArgument, "{} observations are too many", first.back());
  data.observations.resize(static_cast<std::size_t>(first.back()));
  ParallelFor(options.num_points, kGrain, [&](Index p) {
    const auto k = static_cast<std::size_t>(p);
    CounterRandom random(options.seed, kTrack, static_cast<std::uint64_t>(p));
    random.Bits();  // used by TrackLengths
    const Index begin = random.Below(static_cast<Index>(seeing[k].size()) - lengths[k] + 1);
    for (Index i = 0; i < lengths[k]; ++i) {
      data.observations[static_cast<std::size_t>(first[k] + i)] =
          Observe(options, world, seeing[k][static_cast<std::size_t>(begin + i)], k);
    }
  });
}

// Bends the whole scene slowly, like the drift of visual odometry. Cameras and points move together, so reprojection
// errors stay small and only the ends of the path are far from the truth. The ring stays closed.
Vector3 Drifted(const GenerateOptions& options, const World& world, const Vector3& v) {
  const double length = world.way.length(), size = 0.01 * options.start_drift * length;
  const double phase = kPi * v.x / length;
  return {v.x + 0.3 * size * std::sin(2 * phase), v.y + 0.5 * size * std::sin(3 * phase),
          v.z + size * (1 - std::cos(phase)) + 0.3 * size * std::sin(kPi * v.z / length)};
}

void WriteStart(const GenerateOptions& options, const World& world, BundleData& data) {
  data.x.resize(static_cast<std::size_t>(kCameraSize * data.num_cameras + kPointSize * data.num_points));
  const double noise = options.start_noise;
  ParallelFor(data.num_cameras, kGrain, [&](Index i) {
    CounterRandom random(options.seed, kCameraStart, static_cast<std::uint64_t>(i));
    double* parameters = data.x.data() + kCameraSize * i;
    std::copy_n(world.cameras.data() + kCameraSize * i, kCameraSize, parameters);
    for (int c = 0; c < 3; ++c) parameters[c] += 0.005 * noise * random.Normal();
    Vector3 centre = Drifted(options, world, world.centres[static_cast<std::size_t>(i)]);
    for (double* value : {&centre.x, &centre.y, &centre.z}) *value += 0.05 * noise * random.Normal();
    SetTranslation(centre, parameters);
    parameters[6] *= 1 + 0.01 * noise * random.Normal();
    for (int c = 7; c < 9; ++c) parameters[c] += (0 - parameters[c]) * std::min(noise, 1.0);
  });
  double* points = data.x.data() + kCameraSize * data.num_cameras;
  ParallelFor(data.num_points, kGrain, [&](Index p) {
    CounterRandom random(options.seed, kPointStart, static_cast<std::uint64_t>(p));
    Vector3 point = Drifted(options, world, world.points[static_cast<std::size_t>(p)]);
    for (double* value : {&point.x, &point.y, &point.z}) *value += 0.1 * noise * random.Normal();
    points[3 * p] = point.x, points[3 * p + 1] = point.y, points[3 * p + 2] = point.z;
  });
}

void Validate(const GenerateOptions& o) {
  constexpr Index kMost = std::numeric_limits<std::int32_t>::max();
  if (o.num_cameras < 8 || o.num_cameras > kMost)
    Fail(kBadArgument, "num_cameras is {}; choose at least 8", o.num_cameras);
  if (o.num_points < 1 || o.num_points > kMost) Fail(kBadArgument, "num_points is {}; choose at least 1", o.num_points);
  if (!(o.mean_track >= 2 && o.mean_track <= 1e6))
    Fail(kBadArgument, "mean_track is {}; choose at least 2", o.mean_track);
  if (!(o.outliers >= 0 && o.outliers <= 1)) Fail(kBadArgument, "outliers is {}; choose 0 to 1", o.outliers);
  for (const double factor : {o.pixel_noise, o.start_noise, o.start_drift}) {
    if (!(factor >= 0 && std::isfinite(factor)))
      Fail(kBadArgument, "a factor on noise or drift is {}; choose at least 0", factor);
  }
}

}  // namespace

BundleData Generate(const GenerateOptions& options) {
  Validate(options);
  const auto cameras = static_cast<std::size_t>(options.num_cameras);
  World world{Way(options.num_cameras), std::vector<double>(cameras * kCameraSize),
              std::vector<Camera<double>>(cameras), std::vector<Vector3>(cameras),
              std::vector<Vector3>(static_cast<std::size_t>(options.num_points))};
  ParallelFor(options.num_cameras, kGrain, [&](Index i) { PlaceCamera(options, i, world); });
  const auto seeing = PlacePoints(options, world);
  for (const auto& cameras_of_point : seeing) {
    if (cameras_of_point.size() < 2)
      Fail(kBadArgument, "no place on the facades that two of {} cameras see", options.num_cameras);
  }
  BundleData data;
  data.num_cameras = options.num_cameras;
  data.num_points = options.num_points;
  AddObservations(options, world, seeing, data);
  WriteStart(options, world, data);
  return data;
}

}  // namespace vesta::bundle
