// SPDX-License-Identifier: Apache-2.0
// Block-diagonal matrices on a GPU: the loop over the groups. Kernels: block_diagonal.cu.
#include "kernels/core/block_diagonal.h"
#include "kernels/core/block_diagonal.inl"
#include "kernels/core/cuda_backend.h"

namespace vesta {

template <class B>
void BlockDiagonal<B>::AddToDiagonal(double scale, typename B::ConstVectorView d) {
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    device::AddToBlockDiagonal(groups_[g], scale, d.data(), values_.data() + first_value_[g]);
  }
}

template <class B>
void BlockDiagonal<B>::Diagonal(typename B::VectorView out) const {
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    device::BlockDiagonalOf(groups_[g], values_.data() + first_value_[g], out.data());
  }
}

template <class B>
void BlockDiagonal<B>::Apply(typename B::ConstVectorView x, typename B::VectorView y) const {
  VESTA_CHECK(x.size() == num_parameters_ && y.size() == num_parameters_, "vectors of {} and {} entries, matrix of {}",
              x.size(), y.size(), num_parameters_);
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    device::MultiplyBlocks(groups_[g], values_.data() + first_value_[g], x.data(), y.data());
  }
}

template <class B>
Index BlockDiagonal<B>::Factorize() {
  DeviceBuffer<unsigned long long> num_replaced(1);
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    device::FactorizeBlocks(groups_[g], values_.data() + first_value_[g], num_replaced.data());
  }
  unsigned long long count = 0;
  num_replaced.CopyTo({&count, 1});
  return static_cast<Index>(count);
}

template <class B>
void BlockDiagonal<B>::Solve(typename B::ConstVectorView x, typename B::VectorView y) const {
  VESTA_CHECK(x.size() == num_parameters_ && y.size() == num_parameters_, "vectors of {} and {} entries, matrix of {}",
              x.size(), y.size(), num_parameters_);
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    device::SolveBlocks(groups_[g], values_.data() + first_value_[g], x.data(), y.data());
  }
}

template class BlockDiagonal<CudaBackend<float>>;
template class BlockDiagonal<CudaBackend<double>>;

}  // namespace vesta
