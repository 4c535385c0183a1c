#include "kernels/image/ssim_jacobian.h"

#include "kernels/core/check.h"
#include "kernels/image/photometric_formula.h"

namespace vesta {

template <class S>
void SsimSlopeImages<S>::Resize(Index num_values) {
  if (p.size() == num_values) return;
  for (HostBuffer<S>* image : {&p, &q, &s}) image->Resize(num_values);
}

template <class S>
void SsimJacobian<S>::Linearize(ConstView rendered, ConstView truth, const ImageShape& shape, View dissimilarity) {
  bands_.Resize(shape);
  const Index n = shape.NumValues();
  VESTA_CHECK(rendered.size() == n && truth.size() == n && dissimilarity.size() == n,
              "rendered {}, truth {}, out {} values, want {}", rendered.size(), truth.size(), dissimilarity.size(), n);
  slopes_.Resize(n);
  rendered_ = rendered;
  truth_ = truth;
  bands_.Run(&ImageKernels<S>::windows, WindowArgs<S>{.rendered = rendered.data(),
                                                      .truth = truth.data(),
                                                      .dissimilarity = dissimilarity.data(),
                                                      .p = slopes_.p.data(),
                                                      .q = slopes_.q.data(),
                                                      .s = slopes_.s.data()});
}

template <class S>
void SsimJacobian<S>::Run(Kernel kernel, ConstView in, View out) {
  const Index n = rendered_.size();
  VESTA_CHECK(n > 0, "Linearize first");
  VESTA_CHECK(in.size() == n && out.size() == n, "in {}, out {} values, want {}", in.size(), out.size(), n);
  bands_.Run(kernel, JacobianArgs<S>{.rendered = rendered_.data(),
                                     .truth = truth_.data(),
                                     .p = slopes_.p.data(),
                                     .q = slopes_.q.data(),
                                     .s = slopes_.s.data(),
                                     .in = in.data(),
                                     .out = out.data()});
}

template <class S>
void SsimJacobian<S>::Apply(ConstView v, View out) {
  Run(&ImageKernels<S>::tangent, v, out);
}

template <class S>
void SsimJacobian<S>::ApplyAdjoint(ConstView u, View out) {
  Run(&ImageKernels<S>::adjoint, u, out);
}

template <class S>
void SsimJacobian<S>::Diagonal(View out) const {
  VESTA_CHECK(out.size() == rendered_.size(), "out {} values, want {}", out.size(), rendered_.size());
  const auto tap = static_cast<S>(GaussianTaps()[kWindowRadius]);
  const S centre = tap * tap;
  for (Index i = 0; i < out.size(); ++i) {
    const S x = rendered_[i];
    out[i] = centre * SsimAdjoint(x, x - truth_[i], slopes_.p[i], slopes_.q[i], slopes_.s[i]);
  }
}

template struct SsimSlopeImages<float>;
template struct SsimSlopeImages<double>;
template class SsimJacobian<float>;
template class SsimJacobian<double>;

}  // namespace vesta
