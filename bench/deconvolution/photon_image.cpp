// SPDX-License-Identifier: Apache-2.0
#include "bench/deconvolution/photon_image.h"

#include <cmath>
#include <numeric>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "solver/problem_interfaces.h"

namespace vesta::deconvolution {
namespace {

constexpr Index kGrain = 16384;
constexpr double kAnscombe = 3.0 / 8.0;

double Transform(double counts) { return 2 * std::sqrt(counts + kAnscombe); }

}  // namespace

// J at one x. Uses buffers of the problem, which must outlive it.
class PhotonImage::AtX final : public Linearization<CpuBackend<double>>, public WithProductH<CpuBackend<double>> {
 public:
  AtX(PhotonImage& problem, ConstVectorView x)
      : blur_(problem.blur_),
        plane_(problem.plane_),
        light_(x.size()),
        residuals_(problem.num_residuals()),
        slope_(problem.num_residuals()) {
    ParallelFor(x.size(), kGrain, [&](Index k) { light_[k] = std::exp(x[k]); });
    blur_.SetImage([&](Index k) { return light_[k]; });
    for (int f = 0; f < blur_.num_frames(); ++f) {
      blur_.Blur(f, Frame(residuals_, f));
    }
    ParallelFor(residuals_.size(), kGrain, [&](Index i) {
      const double expected = residuals_[i];
      residuals_[i] = Transform(expected) - Transform(problem.counts_[i]);
      slope_[i] = 1 / std::sqrt(expected + kAnscombe);
    });
  }
  Index num_residuals() const override { return residuals_.size(); }
  Index num_parameters() const override { return light_.size(); }
  ConstVectorView residuals() const override { return residuals_.view(); }

  void ApplyJ(ConstVectorView v, VectorView u) override {
    blur_.SetImage([&](Index k) { return light_[k] * v[k]; });
    for (int f = 0; f < blur_.num_frames(); ++f) {
      blur_.Blur(f, u.subspan(f * blur_.frame_size(), blur_.frame_size()));
    }
    ParallelFor(u.size(), kGrain, [&](Index i) { u[i] *= slope_[i]; });
  }
  void ApplyJT(ConstVectorView u, VectorView g) override {
    for (int f = 0; f < blur_.num_frames(); ++f) {
      const Index offset = f * blur_.frame_size();
      blur_.SetFrame([&](Index i) { return slope_[offset + i] * u[offset + i]; });
      blur_.AddAdjoint(f, f == 0, g);
    }
    ParallelFor(g.size(), kGrain, [&](Index k) { g[k] *= light_[k]; });
  }
  void DiagJTJ(VectorView d) override {
    for (int f = 0; f < blur_.num_frames(); ++f) {
      const Index offset = f * blur_.frame_size();
      blur_.SetFrame([&](Index i) { return slope_[offset + i] * slope_[offset + i]; });
      blur_.AddSquaredAdjoint(f, f == 0, d);
    }
    ParallelFor(d.size(), kGrain, [&](Index k) { d[k] *= light_[k] * light_[k]; });
  }
  // Buffers one frame instead of all residuals.
  void ApplyH(ConstVectorView v, VectorView Hv) override {
    blur_.SetImage([&](Index k) { return light_[k] * v[k]; });
    for (int f = 0; f < blur_.num_frames(); ++f) {
      const Index offset = f * blur_.frame_size();
      blur_.Blur(f, plane_);
      blur_.SetFrame([&](Index i) { return slope_[offset + i] * slope_[offset + i] * plane_[i]; });
      blur_.AddAdjoint(f, f == 0, Hv);
    }
    ParallelFor(Hv.size(), kGrain, [&](Index k) { Hv[k] *= light_[k]; });
  }

 private:
  VectorView Frame(HostBuffer<double>& frames, int f) const {
    return frames.view().subspan(f * blur_.frame_size(), blur_.frame_size());
  }

  CodedBlur& blur_;
  HostBuffer<double>& plane_;
  HostBuffer<double> light_;      // s
  HostBuffer<double> residuals_;  // all frames
  HostBuffer<double> slope_;      // dr/dy
};

PhotonImage::PhotonImage(Index side, std::vector<Aperture> apertures, HostBuffer<double> counts)
    : blur_(side, std::move(apertures)), counts_(std::move(counts)), plane_(blur_.frame_size()) {
  if (counts_.size() != blur_.num_frames() * blur_.frame_size()) {
    Fail(kBadArgument, "{} counts for {} frames of {} x {} pixels", counts_.size(), blur_.num_frames(),
         blur_.frame_side(), blur_.frame_side());
  }
}

double PhotonImage::stored_jacobian_bytes() const {
  return static_cast<double>(jacobian_entries()) * (sizeof(double) + sizeof(std::int32_t)) +
         static_cast<double>(num_residuals() + 1) * sizeof(std::int32_t);
}

double PhotonImage::UniformStart() const {
  const double total = ParallelSum<double>(counts_.size(), kGrain, [&](Index begin, Index end) {
    return std::accumulate(counts_.begin() + begin, counts_.begin() + end, 0.0);
  });
  return std::log(total / static_cast<double>(blur_.num_frames() * blur_.image_size()));
}

double PhotonImage::Cost(ConstVectorView x) {
  CheckSize(x);
  blur_.SetImage([&](Index k) { return std::exp(x[k]); });
  double cost = 0;
  for (int f = 0; f < blur_.num_frames(); ++f) {
    blur_.Blur(f, plane_);
    const double* counts = counts_.data() + f * blur_.frame_size();
    cost += ParallelSum<double>(plane_.size(), kGrain, [&](Index begin, Index end) {
      double sum = 0;
      for (Index i = begin; i < end; ++i) {
        const double r = Transform(plane_[i]) - Transform(counts[i]);
        sum += r * r;
      }
      return sum;
    });
  }
  return 0.5 * cost;
}

std::unique_ptr<Linearization<CpuBackend<double>>> PhotonImage::Linearize(ConstVectorView x) {
  CheckSize(x);
  return std::make_unique<AtX>(*this, x);
}

LmOptions PhotonImageOptions() {
  LmOptions options;
  options.function_tolerance = 0;
  options.gradient_tolerance = 1e-8;
  options.normal_system.linear_solver = LinearSolverKind::kPcg;
  return options;
}

HostBuffer<double> Expose(Index side, const std::vector<Aperture>& apertures, HostSpan<const double> image) {
  CodedBlur blur(side, apertures);
  HostBuffer<double> frames(blur.num_frames() * blur.frame_size());
  blur.SetImage([&](Index k) { return image[k]; });
  for (int f = 0; f < blur.num_frames(); ++f) {
    blur.Blur(f, frames.view().subspan(f * blur.frame_size(), blur.frame_size()));
  }
  return frames;
}

HostBuffer<double> TestScene(Index side) {
  HostBuffer<double> image(side * side);
  const auto size = static_cast<double>(side);
  for (Index i = 0; i < side; ++i) {
    for (Index j = 0; j < side; ++j) {
      // Tiles of 64 pixels, each with its own disc and its own grating.
      const Index tile = i / 64 * 7 + j / 64 * 3;
      const double y = static_cast<double>(i % 64) - 32, x = static_cast<double>(j % 64) - 32;
      const double angle = 0.4 * static_cast<double>(tile), pitch = 2.5 + static_cast<double>(tile % 11);
      double light = 60 + 60 * (static_cast<double>(i) + static_cast<double>(j)) / (2 * size);
      if (x * x + y * y < 22 * 22)
        light += 40 * (1 + std::sin((x * std::cos(angle) + y * std::sin(angle)) * 6 / pitch));
      if (std::abs(x) > 28 && std::abs(y) > 28) light -= 40;
      if (i % 64 == 5 && j % 16 == 5) light += 200;
      image[i * side + j] = light;
    }
  }
  return image;
}

}  // namespace vesta::deconvolution
