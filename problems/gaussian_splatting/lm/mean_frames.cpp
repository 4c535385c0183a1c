#include "problems/gaussian_splatting/lm/mean_frames.h"

#include <array>
#include <cmath>

#include "kernels/core/block_diagonal.h"
#include "kernels/core/parallel.h"

namespace vesta::gs {
namespace {

constexpr Index kGrain = 1024;

using Vector3 = std::array<double, 3>;

double Dot(const Vector3& a, const Vector3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// The unit vector from the camera to `mean` where that lies within the image; false elsewhere.
bool Sight(const splat::PinholeView& view, const Vector3& mean, Vector3* direction) {
  Vector3 camera;
  for (int r = 0; r < 3; ++r) {
    camera[static_cast<std::size_t>(r)] =
        view.R[3 * r] * mean[0] + view.R[3 * r + 1] * mean[1] + view.R[3 * r + 2] * mean[2] + view.T[r];
  }
  if (!(camera[2] > view.near)) return false;
  const double u = view.fx * camera[0] / camera[2] + view.cx, v = view.fy * camera[1] / camera[2] + view.cy;
  if (!(u >= 0 && u <= view.width && v >= 0 && v <= view.height)) return false;
  const double length = std::sqrt(Dot(camera, camera));
  for (std::size_t k = 0; k < 3; ++k) (*direction)[k] = (mean[k] - view.centre[k]) / length;
  return true;
}

}  // namespace

template <class S>
MeanFrames<S>::MeanFrames(HostSpan<const S> x, Index count, const std::vector<splat::PinholeView>& views)
    : count_(count), normal_(3 * count), depth_share_(count) {
  ParallelFor(count, kGrain, [&](Index i) {
    const Vector3 mean{x[i], x[count + i], x[2 * count + i]};
    Vector3 sum{}, direction;
    std::array<double, 6> moments{};
    int seen = 0;
    for (const splat::PinholeView& view : views) {
      if (!Sight(view, mean, &direction)) continue;
      ++seen;
      for (std::size_t r = 0; r < 3; ++r) {
        sum[r] += direction[r];
        for (std::size_t c = 0; c <= r; ++c) moments[r * (r + 1) / 2 + c] += direction[r] * direction[c];
      }
    }
    const double length = std::sqrt(Dot(sum, sum));
    depth_share_[i] = S(1) / S(3);
    if (!(length > 0)) return;
    const Vector3 axis{sum[0] / length, sum[1] / length, sum[2] / length};
    double share = 0;
    for (std::size_t r = 0; r < 3; ++r) {
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t at = r >= c ? r * (r + 1) / 2 + c : c * (c + 1) / 2 + r;
        share += axis[r] * moments[at] * axis[c];
      }
    }
    depth_share_[i] = static_cast<S>(share / seen);
    // Takes the third axis to `axis`, or to its opposite: the one that is further away, so that nothing cancels.
    Vector3 normal = axis;
    normal[2] += axis[2] >= 0 ? 1 : -1;
    const double norm = std::sqrt(Dot(normal, normal));
    for (Index k = 0; k < 3; ++k) normal_[k * count + i] = static_cast<S>(normal[static_cast<std::size_t>(k)] / norm);
  });
}

template <class S>
void MeanFrames<S>::Reflect(HostSpan<S> v) const {
  if (empty()) return;
  const Index n = count_;
  const S* w = normal_.data();
  S* out = v.data();
  ParallelForChunks(n, kGrain, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      const S twice = 2 * (w[i] * out[i] + w[n + i] * out[n + i] + w[2 * n + i] * out[2 * n + i]);
      out[i] -= twice * w[i];
      out[n + i] -= twice * w[n + i];
      out[2 * n + i] -= twice * w[2 * n + i];
    }
  });
}

template <class S>
void MeanFrames<S>::ReflectBlocks(int size, HostSpan<S> blocks) const {
  if (empty()) return;
  const Index n = count_;
  ParallelFor(n, kGrain, [&](Index i) {
    const S w[3] = {normal_[i], normal_[n + i], normal_[2 * n + i]};
    const auto at = [&](int row, int col) -> S& {
      return blocks[(row >= col ? PackedLower(row, col) : PackedLower(col, row)) * n + i];
    };
    for (int row = 3; row < size; ++row) {
      const S twice = 2 * (at(row, 0) * w[0] + at(row, 1) * w[1] + at(row, 2) * w[2]);
      for (int k = 0; k < 3; ++k) at(row, k) -= twice * w[k];
    }
    // R B R = B - 2 (w (B w)^T + (B w) w^T) + 4 (w^T B w) w w^T.
    S product[3], square = 0;
    for (int k = 0; k < 3; ++k) product[k] = at(k, 0) * w[0] + at(k, 1) * w[1] + at(k, 2) * w[2];
    for (int k = 0; k < 3; ++k) square += w[k] * product[k];
    for (int row = 0; row < 3; ++row) {
      for (int col = 0; col <= row; ++col) {
        at(row, col) += -2 * (w[row] * product[col] + product[row] * w[col]) + 4 * square * w[row] * w[col];
      }
    }
  });
}

template class MeanFrames<float>;
template class MeanFrames<double>;

}  // namespace vesta::gs
