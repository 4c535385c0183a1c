// SPDX-License-Identifier: Apache-2.0
// Linearization of a bundle adjustment at one x.
#include <algorithm>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "problems/bundle_adjustment/context.h"
#include "problems/bundle_adjustment/reduced.h"

namespace vesta::bundle::internal {
namespace {

void CorrectForLoss(const Loss& loss, double* lanes) {
  for (int l = 0; l < 4; ++l) {
    double f[2] = {lanes[l], lanes[4 + l]};
    const double s = f[0] * f[0] + f[1] * f[1];
    LossCorrection(loss.Evaluate(s), s).Apply(2, kRowSize, f, lanes + 8 + l, 4 * kRowSize, 4);
    lanes[l] = f[0], lanes[4 + l] = f[1];
  }
}

template <class S>
class BundleLinearization final : public Linearization<Cpu>,
                                  public WithGradient<Cpu>,
                                  public WithProductH<Cpu>,
                                  public WithBlocks<Cpu>,
                                  public WithReducedSystem<Cpu> {
 public:
  BundleLinearization(BundleContext& context, ConstVectorView x)
      : context_(context),
        structure_(context.structure),
        kernels_(KernelsFor<S>(context.options.isa)),
        arrays_(context.pool<S>().Get()),
        padded_(structure_.num_cameras() * kRowSize),
        camera_sums_(structure_.num_cameras(), structure_.num_chunks()) {
    arrays_->records.ResizeForOverwrite(kRecordSize * structure_.num_observations());
    arrays_->residuals.ResizeForOverwrite(num_residuals());
    arrays_->gradient.ResizeForOverwrite(num_parameters());
    arrays_->camera_gram.ResizeForOverwrite(kCameraGramSize * structure_.num_cameras());
    arrays_->point_gram.ResizeForOverwrite(kPointGramSize * structure_.num_points());
    // A float Jacobian would give a gradient of float precision, so each Jp' r is stored in double.
    if (kRounded) arrays_->point_products.ResizeForOverwrite(kPointSize * structure_.num_observations());
    order_ = {structure_.track_first(), structure_.track_point(), structure_.camera(), arrays_->records.data()};
    LinearizeCameras(x);
    SumOverPoints();
  }
  ~BundleLinearization() override { context_.pool<S>().Return(std::move(arrays_)); }

  Index num_residuals() const override { return 2 * structure_.num_observations(); }
  Index num_parameters() const override { return structure_.num_parameters(); }
  ConstVectorView residuals() const override { return arrays_->residuals.view(); }

  void ApplyJ(ConstVectorView v, VectorView u) override {
    CheckSizes(v.size(), u.size());
    PadCameras(structure_.num_cameras(), v.data(), padded_.data());
    ParallelFor(structure_.num_chunks(), 1,
                [&](Index k) { kernels_.apply_j(order_, Begin(k), End(k), padded_.data(), Points(v), u.data()); });
  }
  void ApplyJT(ConstVectorView u, VectorView g) override {
    CheckSizes(g.size(), u.size());
    camera_sums_.Run(
        [&](Index k, double* sums) { kernels_.apply_jt(order_, Begin(k), End(k), u.data(), sums, Points(g)); },
        StoreCamera(g));
  }
  void ApplyH(ConstVectorView v, VectorView Hv) override {
    CheckSizes(v.size(), num_residuals());
    CheckSizes(Hv.size(), num_residuals());
    PadCameras(structure_.num_cameras(), v.data(), padded_.data());
    camera_sums_.Run(
        [&](Index k, double* sums) {
          kernels_.apply_h(order_, Begin(k), End(k), padded_.data(), Points(v), sums, Points(Hv));
        },
        StoreCamera(Hv));
  }
  void Gradient(VectorView g) override { std::copy_n(arrays_->gradient.data(), g.size(), g.data()); }
  void DiagJTJ(VectorView d) override {
    for (Index i = 0; i < structure_.num_cameras(); ++i) {
      const double* gram = arrays_->camera_gram.data() + kCameraGramSize * i;
      for (int c = 0; c < kCameraSize; ++c) d[kCameraSize * i + c] = gram[PackedLower(c, c)];
    }
    ParallelFor(structure_.num_points(), kPointsPerTask, [&](Index p) {
      for (int c = 0; c < kPointSize; ++c) {
        Points(d)[kPointSize * p + c] = arrays_->point_gram[PackedLower(c, c) * structure_.num_points() + p];
      }
    });
  }
  std::vector<BlockGroup> block_groups() const override {
    return {CameraBlocks(structure_), {kPointSize, structure_.num_points(), structure_.num_camera_parameters(), 1, 3}};
  }
  void BlockGram(BlockDiagonal<Cpu>& blocks) override {
    for (Index i = 0; i < structure_.num_cameras(); ++i) {
      const double* gram = arrays_->camera_gram.data() + kCameraGramSize * i;
      for (int k = 0; k < kCameraGramSize; ++k) blocks.values(0)[k * structure_.num_cameras() + i] = gram[k];
    }
    std::copy(arrays_->point_gram.begin(), arrays_->point_gram.end(), blocks.values(1).begin());
  }
  std::unique_ptr<ReducedSystem<Cpu>> MakeReducedSystem() override {
    return std::make_unique<BundleReducedSystem<S>>(context_, *arrays_);
  }

 private:
  static constexpr bool kRounded = sizeof(S) == sizeof(float);
  static constexpr Index kPointsPerTask = 4096;

  Index Begin(Index chunk) const { return structure_.chunk_first(chunk); }
  Index End(Index chunk) const { return structure_.chunk_first(chunk + 1); }
  const double* Points(ConstVectorView v) const { return v.data() + structure_.num_camera_parameters(); }
  double* Points(VectorView v) const { return v.data() + structure_.num_camera_parameters(); }
  void CheckSizes(Index parameters, Index residuals) const {
    VESTA_CHECK(parameters == num_parameters() && residuals == num_residuals(),
                "vectors of {} and {} entries do not match a Jacobian of {} x {}", parameters, residuals,
                num_residuals(), num_parameters());
  }
  static auto StoreCamera(VectorView out) {
    return [out](Index i, const double* sums) { std::copy_n(sums, kCameraSize, out.data() + kCameraSize * i); };
  }

  void LinearizeCameras(ConstVectorView x) {
    const HostBuffer<Camera<double>> cameras = MakeCameras(structure_, x);
    constexpr Index kSums = kCameraSize + kCameraGramSize;
    HostBuffer<double> sums(structure_.num_slices() * kSums);
    ParallelFor(structure_.num_slices(), 1, [&](Index k) {
      double* out = sums.data() + k * kSums;
      kernels_.linearize(cameras[structure_.slice_camera(k)], Points(x), structure_.slice(k),
                         context_.options.loss.get(), CorrectForLoss,
                         {arrays_->residuals.data(), arrays_->records.data(),
                          kRounded ? arrays_->point_products.data() : nullptr, out, out + kCameraSize});
    });
    for (Index i = 0; i < structure_.num_cameras(); ++i) {
      double* gradient = arrays_->gradient.data() + kCameraSize * i;
      double* gram = arrays_->camera_gram.data() + kCameraGramSize * i;
      std::fill_n(gradient, kCameraSize, 0.0);
      std::fill_n(gram, kCameraGramSize, 0.0);
      for (Index k = structure_.first_slice(i); k < structure_.first_slice(i + 1); ++k) {
        const double* part = sums.data() + k * kSums;
        for (int c = 0; c < kCameraSize; ++c) gradient[c] += part[c];
        for (int c = 0; c < kCameraGramSize; ++c) gram[c] += part[kCameraSize + c];
      }
    }
  }
  // Gram blocks and gradient of the points.
  void SumOverPoints() {
    double* gradient = Points(arrays_->gradient.view());
    ParallelFor(structure_.num_chunks(), 1, [&](Index k) {
      kernels_.point_gram(order_, Begin(k), End(k), structure_.num_points(), arrays_->point_gram.data());
      for (Index track = Begin(k); track < End(k); ++track) {
        double sum[kPointSize] = {};
        for (Index o = order_.first[track]; o < order_.first[track + 1]; ++o) {
          for (int c = 0; c < kPointSize; ++c) sum[c] += PointProduct(o, c);
        }
        std::copy_n(sum, kPointSize, gradient + kPointSize * order_.point[track]);
      }
    });
  }
  // Entry c of Jp' r of an observation.
  double PointProduct(Index o, int c) const {
    if (kRounded) return arrays_->point_products[kPointSize * o + c];
    const S* record = order_.records + kRecordSize * o;
    return record[c] * arrays_->residuals[2 * o] + record[kRowSize + c] * arrays_->residuals[2 * o + 1];
  }

  BundleContext& context_;
  const Structure& structure_;
  const Kernels<S>& kernels_;
  std::unique_ptr<LinearizationArrays<S>> arrays_;
  TrackOrder<S> order_{};
  HostBuffer<double> padded_;
  CameraSums camera_sums_;
};

}  // namespace

template <class S>
std::unique_ptr<Linearization<Cpu>> MakeLinearization(BundleContext& context, Cpu::ConstVectorView x) {
  return std::make_unique<BundleLinearization<S>>(context, x);
}

template std::unique_ptr<Linearization<Cpu>> MakeLinearization<float>(BundleContext&, Cpu::ConstVectorView);
template std::unique_ptr<Linearization<Cpu>> MakeLinearization<double>(BundleContext&, Cpu::ConstVectorView);

}  // namespace vesta::bundle::internal
