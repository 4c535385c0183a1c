#include "problems/gaussian_splatting/cameras/view_linearization.h"

#include <algorithm>

#include "problems/gaussian_splatting/cameras/image_products.h"
#include "problems/gaussian_splatting/model/masked_loss.h"

namespace vesta::gs {
namespace {

template <class From, class To>
void Convert(HostSpan<From> from, HostSpan<To> to) {
  ParallelFor(from.size(), kImageGrain, [&](Index i) { to[i] = static_cast<To>(from[i]); });
}

}  // namespace

template <class S>
ViewLinearization<S>::ViewLinearization(const FreeUnknowns& free, const AffineColor& color,
                                        const TargetView<CpuBackend<S>>& target, HostBuffer<S>&& rendered,
                                        HostBuffer<S>&& moves, std::shared_ptr<PhotometricLoss<S>> loss)
    : free_(free),
      shape_(target.shape()),
      rendered_(std::move(rendered)),
      moves_(std::move(moves)),
      loss_(std::move(loss)) {
  const Index n = shape_.NumValues();
  AffineColor gain = color;
  gain.offset = {};
  for (int k = 0; k < free_.pose_tangent(); ++k) gain.Apply(moves_.view().subspan(k * n, n));
  HostBuffer<S> shown, image_gradient(n);
  shown.CopyFrom(rendered_.view());
  color.Apply(shown.view());
  // With the mask in J, that of W need not be: J^T W J is the same.
  for (int k = 0; k < free_.pose_tangent(); ++k) {
    ClearLeftOut<CpuBackend<S>>(target.mask, moves_.view().subspan(k * n, n));
  }
  LinearizeLoss(*loss_, target, shown.view(), image_gradient.view(), curvature_);
  residuals_.ResizeForOverwrite(n);
  ParallelFor(n, kImageGrain,
              [&](Index i) { residuals_[i] = static_cast<double>(shown[i]) - static_cast<double>(target.truth[i]); });
  if (free_.color) {
    ones_.ResizeForOverwrite(n);
    std::fill(ones_.begin(), ones_.end(), S(1));
    ClearLeftOut<CpuBackend<S>>(target.mask, ones_.view());
    ClearLeftOut<CpuBackend<S>>(target.mask, rendered_.view());
  } else {
    rendered_ = {};
  }
  gradient_.resize(static_cast<std::size_t>(num_parameters()));
  Project(image_gradient.data(), {gradient_.data(), num_parameters()});
  FormH();
}

template <class S>
const S* ViewLinearization<S>::Column(int k) const {
  const int pose = free_.pose_tangent();
  return k < pose ? moves_.data() + k * shape_.NumValues() : k == pose ? rendered_.data() : ones_.data();
}

template <class S>
int ViewLinearization<S>::Place(int k, int channel) const {
  const int pose = free_.pose_tangent();
  return k < pose ? k : k == pose ? free_.Gain(channel) : free_.Offset(channel);
}

template <class S>
template <class U>
void ViewLinearization<S>::Project(const U* u, View g) const {
  const Index n = shape_.PlaneSize();
  std::fill(g.begin(), g.end(), 0.0);
  for (int k = 0; k < num_columns(); ++k) {
    for (int c = 0; c < ImageShape::kChannels; ++c) g[Place(k, c)] += Dot(Column(k) + c * n, u + c * n, n);
  }
}

template <class S>
void ViewLinearization<S>::FormH() {
  const Index n = shape_.PlaneSize();
  HostBuffer<S> weighted(shape_.NumValues());
  h_.assign(gradient_.size() * gradient_.size(), 0);
  for (int k = 0; k < num_columns(); ++k) {
    loss_->ApplyW(curvature_, {Column(k), shape_.NumValues()}, weighted);
    for (int l = 0; l <= k; ++l) {
      for (int c = 0; c < ImageShape::kChannels; ++c) {
        const double product = Dot(Column(l) + c * n, weighted.data() + c * n, n);
        H(Place(k, c), Place(l, c)) += product;
        if (l != k) H(Place(l, c), Place(k, c)) += product;
      }
    }
  }
}

template <class S>
void ViewLinearization<S>::ApplyJ(ConstView v, View u) {
  const Index n = shape_.PlaneSize();
  for (int c = 0; c < ImageShape::kChannels; ++c) {
    ParallelFor(n, kImageGrain, [&](Index i) {
      double sum = 0;
      for (int k = 0; k < num_columns(); ++k) sum += v[Place(k, c)] * static_cast<double>(Column(k)[c * n + i]);
      u[c * n + i] = sum;
    });
  }
}

template <class S>
void ViewLinearization<S>::ApplyJT(ConstView u, View g) {
  Project(u.data(), g);
}

template <class S>
void ViewLinearization<S>::ApplyW(ConstView u, View Wu) {
  HostBuffer<S> in(u.size()), out(u.size());
  Convert(u, in.view());
  loss_->ApplyW(curvature_, in, out);
  Convert(out.view(), Wu);
}

template <class S>
void ViewLinearization<S>::ApplyH(ConstView v, View Hv) {
  for (int i = 0; i < num_parameters(); ++i) {
    Hv[i] = 0;
    for (int j = 0; j < num_parameters(); ++j) Hv[i] += H(i, j) * v[j];
  }
}

template <class S>
void ViewLinearization<S>::Gradient(View g) {
  std::copy(gradient_.begin(), gradient_.end(), g.begin());
}

template <class S>
void ViewLinearization<S>::DiagJTJ(View d) {
  for (int i = 0; i < num_parameters(); ++i) d[i] = H(i, i);
}

template <class S>
void ViewLinearization<S>::BlockGram(BlockDiagonal<CpuBackend<double>>& blocks) {
  const auto values = blocks.values(0);
  for (int row = 0; row < num_parameters(); ++row) {
    for (int col = 0; col <= row; ++col) values[PackedLower(row, col)] = H(row, col);
  }
}

template class ViewLinearization<float>;
template class ViewLinearization<double>;

}  // namespace vesta::gs
