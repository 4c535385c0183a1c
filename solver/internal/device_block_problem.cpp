// SPDX-License-Identifier: Apache-2.0
#include "solver/device_block_problem.h"

#include "kernels/core/check.h"
#include "kernels/core/row_blocks.h"

namespace vesta {
namespace {

DeviceBuffer<Index> Upload(const std::vector<Index>& values) {
  DeviceBuffer<Index> buffer;
  buffer.CopyFrom(HostSpan<const Index>(values.data(), static_cast<Index>(values.size())));
  return buffer;
}

}  // namespace

template <class S>
struct DeviceBlockProblem<S>::Data {
  Index num_parameters;
  std::unique_ptr<DeviceResiduals<S>> residuals;
  std::vector<BlockGroup> groups;
  DeviceBuffer<Index> index, entries, first_entry, segments, segment_end, first_segment;
  DeviceBuffer<S> cost_residuals;

  Index num_residuals() const { return residuals->num_residual_blocks() * residuals->residuals_per_block(); }
  RowBlocksTranspose transpose() const {
    return {entries.data(), first_entry.data(), segments.data(), segment_end.data(), first_segment.data()};
  }
};

template <class S>
class DeviceBlockProblem<S>::Linear final : public Linearization<CudaBackend<S>>, public WithBlocks<CudaBackend<S>> {
 public:
  Linear(const Data& data, ConstVectorView x) : data_(data), residuals_(data.num_residuals()) {
    const DeviceResiduals<S>& residuals = *data.residuals;
    jacobian_.ResizeForOverwrite(data.num_residuals() * residuals.parameters_per_block());
    partial_.ResizeForOverwrite(data.segments.size());
    residuals.Evaluate(data.index.data(), x.data(), residuals_.data(), jacobian_.data());
    rows_ = {residuals.num_residual_blocks(), residuals.residuals_per_block(), residuals.parameters_per_block(),
             data.index.data(), jacobian_.data()};
  }
  Index num_residuals() const override { return data_.num_residuals(); }
  Index num_parameters() const override { return data_.num_parameters; }
  ConstVectorView residuals() const override { return residuals_; }
  void ApplyJ(ConstVectorView v, VectorView u) override { device::ApplyRows(rows_, v.data(), u.data()); }
  void ApplyJT(ConstVectorView u, VectorView g) override { Transposed(u.data(), g.data()); }
  void DiagJTJ(VectorView d) override { Transposed(nullptr, d.data()); }
  std::vector<BlockGroup> block_groups() const override { return data_.groups; }
  void BlockGram(BlockDiagonal<B>& diagonal) override {
    for (std::size_t g = 0; g < data_.groups.size(); ++g) {
      device::GramBlocks(rows_, data_.transpose(), data_.groups[g], diagonal.values(static_cast<int>(g)).data());
    }
  }

 private:
  void Transposed(const S* u, S* g) {
    device::ApplyRowsTransposed(rows_, data_.transpose(), data_.segments.size(), data_.num_parameters, u,
                                partial_.data(), g);
  }

  const Data& data_;
  DeviceBuffer<S> residuals_, jacobian_, partial_;
  RowBlocks<S> rows_;
};

template <class S>
DeviceBlockProblem<S>::DeviceBlockProblem(Index num_parameters, std::unique_ptr<DeviceResiduals<S>> residuals,
                                          const std::vector<Index>& index, std::vector<BlockGroup> groups) {
  const Index blocks = residuals->num_residual_blocks();
  VESTA_CHECK(static_cast<Index>(index.size()) == blocks * residuals->parameters_per_block(),
              "index has {} entries for {} residual blocks of {} parameters", index.size(), blocks,
              residuals->parameters_per_block());
  for (const Index p : index) VESTA_CHECK(p >= 0 && p < num_parameters, "index {} of {} parameters", p, num_parameters);
  const HostRowTranspose transpose(num_parameters, index, blocks);
  data_ = std::make_unique<Data>(Data{num_parameters,
                                      std::move(residuals),
                                      std::move(groups),
                                      Upload(index),
                                      Upload(transpose.entries),
                                      Upload(transpose.first_entry),
                                      Upload(transpose.segments),
                                      Upload(transpose.segment_end),
                                      Upload(transpose.first_segment),
                                      {}});
}

template <class S>
DeviceBlockProblem<S>::~DeviceBlockProblem() = default;

template <class S>
Index DeviceBlockProblem<S>::num_parameters() const {
  return data_->num_parameters;
}

template <class S>
double DeviceBlockProblem<S>::Cost(ConstVectorView x) {
  this->CheckSize(x);
  DeviceBuffer<S>& r = data_->cost_residuals;
  r.ResizeForOverwrite(data_->num_residuals());
  data_->residuals->Evaluate(data_->index.data(), x.data(), r.data(), nullptr);
  return 0.5 * B().Dot(r.view(), r.view());
}

template <class S>
std::unique_ptr<Linearization<CudaBackend<S>>> DeviceBlockProblem<S>::Linearize(ConstVectorView x) {
  this->CheckSize(x);
  return std::make_unique<Linear>(*data_, x);
}

template class DeviceBlockProblem<float>;
template class DeviceBlockProblem<double>;

}  // namespace vesta
