// SPDX-License-Identifier: Apache-2.0
// Derivatives of splats with respect to the camera of their view, one Gaussian or splat per thread.
#include <vector>

#include "kernels/gaussian_splatting/device/device_by_degree.cuh"
#include "kernels/gaussian_splatting/device/device_passes.h"
#include "kernels/gaussian_splatting/projection/camera_block.h"

namespace vesta::splat::device_passes {
namespace {

// Index k is Gaussian first + k in the next two functors.
template <int kDegree, class L>
struct PoseTangentOne {
  Model<float> model;
  CameraConstants<float, L> camera;
  Index first;
  WorldMotion motion;
  const std::int32_t* rank_of;
  SplatTangent<float>* tangents;
  VESTA_HD void operator()(Index k) const {
    const Index i = first + k;
    CameraTangentRange<float, float, kDegree>(model, camera, motion, i, i + 1, rank_of, tangents);
  }
};

// In world axes: turn, then shift.
template <int kDegree, class L>
struct PoseCotangentOne {
  Model<float> model;
  CameraConstants<float, L> camera;
  Index first;
  const std::int32_t* rank_of;
  const SplatTangent<float>* cotangents;
  VESTA_HD void operator()(Index k, double* sums) const {
    const Index i = first + k;
    WorldMotion motion;
    CameraAdjointRange<float, float, kDegree>(model, camera, i, i + 1, rank_of, cotangents, motion);
    for (int axis = 0; axis < 3; ++axis) sums[axis] += motion.turn[axis], sums[3 + axis] += motion.shift[axis];
  }
};

struct LensTangentOne {
  PosedCamera camera;
  LensTangent delta;
  const Splat<float>* splats;
  SplatTangent<float>* tangents;
  VESTA_HD void operator()(Index rank) const { tangents[rank] = LensRows(splats[rank], camera).Tangent<float>(delta); }
};

struct AddTangentOne {
  const SplatTangent<float>* tangents;
  SplatTangent<float>* sum;
  VESTA_HD void operator()(Index rank) const {
    for (int k = 0; k < kSplatTangent; ++k) sum[rank].w[k] += tangents[rank].w[k];
  }
};

struct LensCotangentOne {
  PosedCamera camera;
  const Splat<float>* splats;
  const SplatTangent<float>* cotangents;
  VESTA_HD void operator()(Index rank, double* sums) const {
    LensRows(splats[rank], camera).AddCotangent(cotangents[rank], sums);
  }
};

// Sums of kSums terms per item, over several pieces of items.
template <int kSums>
class PiecewiseSums {
 public:
  // items: number in all pieces together; pieces: their maximum number. Only the last chunk of a piece
  // may be shorter than ChunkSize(0).
  PiecewiseSums(Index items, Index pieces) : partial_(kSums * (items / ChunkSize(0) + pieces)) {}
  template <class Term>
  void Add(const Term& term, Index items, const char* name) {
    const Index chunk = ChunkSize(items), chunks = (items + chunk - 1) / chunk;
    device::Launch(SumChunks<kSums, Term>{term, items, chunk, partial_.data() + kSums * chunks_}, chunks, name);
    chunks_ += chunks;
  }
  // Waits for the device.
  void Read(double* sums) const {
    std::vector<double> partial(static_cast<std::size_t>(kSums * chunks_));
    device::CopyToHost(partial.data(), partial_.data(), partial.size() * sizeof(double));
    for (std::size_t i = 0; i < partial.size(); ++i) sums[i % kSums] += partial[i];
  }

 private:
  DeviceBuffer<double> partial_;
  Index chunks_ = 0;
};

}  // namespace

void PoseTangents(const Model<float>& model, const PosedCamera& view, const std::int32_t* rank_of,
                  const PoseTangent& xi, SplatTangent<float>* tangents) {
  RunByDegree<PoseTangentOne>(model, view, "tangent of the pose", WorldMotion(view, xi), rank_of, tangents);
}

PoseTangent PoseCotangent(const Model<float>& model, const PosedCamera& view, const std::int32_t* rank_of,
                          const SplatTangent<float>* cotangents) {
  PiecewiseSums<kPoseTangent> pieces(model.count, splat::kMaxShDegree + 1);
  ForEachDegree<PoseCotangentOne>(
      model, view, [&](const auto& one, Index count) { pieces.Add(one, count, "adjoint of the pose"); }, rank_of,
      cotangents);
  double sums[kPoseTangent] = {};
  pieces.Read(sums);
  WorldMotion motion;
  for (int axis = 0; axis < 3; ++axis) motion.turn[axis] = sums[axis], motion.shift[axis] = sums[3 + axis];
  return motion.InCamera(view);
}

void LensTangents(const Splat<float>* splats, Index count, const PosedCamera& camera, const LensTangent& delta,
                  SplatTangent<float>* tangents) {
  device::ForEach(count, LensTangentOne{camera, delta, splats, tangents}, "tangent of the lens");
}

void AddTangents(const SplatTangent<float>* tangents, Index count, SplatTangent<float>* sum) {
  device::ForEach(count, AddTangentOne{tangents, sum}, "sum of tangents");
}

LensTangent LensCotangent(const Splat<float>* splats, Index count, const PosedCamera& camera,
                          const SplatTangent<float>* cotangents) {
  PiecewiseSums<kLensTangent> pieces(count, 1);
  pieces.Add(LensCotangentOne{camera, splats, cotangents}, count, "adjoint of the lens");
  LensTangent sum;
  pieces.Read(sum.v);
  return sum;
}

}  // namespace vesta::splat::device_passes
