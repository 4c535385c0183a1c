// SPDX-License-Identifier: Apache-2.0
// Residuals and Jacobian products of the example. Each instrument measures a part of one signal s. It smooths the
// signal by a known recursive filter, the matrix B_k, and has an unknown gain g_k and offset o_k: instrument k reads
// g_k (B_k s)_i + o_k at time i.
#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "solver/problem_interfaces.h"
#include "solver/reduced_system.h"

using Backend = vesta::CpuBackend<double>;
using VectorView = Backend::VectorView;
using ConstVectorView = Backend::ConstVectorView;
using Blocks = vesta::BlockDiagonal<Backend>;
using vesta::Index;

// x contains the signal, then gain and offset of each instrument except the first, which is calibrated: gain 1 and
// offset 0. Without a calibrated instrument the solution would not be unique: the signal c s with gains g_k / c fits
// the readings as well as s, for any c.
struct Setup {
  Index instruments, length, stride;  // instrument k reads at the times from k * stride up to k * stride + length - 1

  // Numbers of signal values, of gains and offsets, and of readings.
  Index times() const { return (instruments - 1) * stride + length; }
  Index own() const { return 2 * (instruments - 1); }
  Index readings() const { return instruments * length; }
  double Gain(ConstVectorView x, Index k) const { return k == 0 ? 1 : x[times() + 2 * k - 2]; }
  double Offset(ConstVectorView x, Index k) const { return k == 0 ? 0 : x[times() + 2 * k - 1]; }
  // Coefficient of the recursive filter, in [0, 1).
  double Memory(Index k) const { return 0.3 + 0.25 * static_cast<double>(k % 3); }
  // The part of a vector of all readings that belongs to instrument k, and the part of the signal that it measures.
  template <class V>
  V Of(Index k, V readings) const {
    return readings.subspan(k * length, length);
  }
  template <class V>
  V Seen(Index k, V signal) const {
    return signal.subspan(k * stride, length);
  }
  // out = scale B_k seen.
  void Smooth(Index k, double scale, ConstVectorView seen, VectorView out) const {
    double memory = Memory(k), value = 0;
    for (Index i = 0; i < length; ++i) out[i] = value = memory * value + scale * (1 - memory) * seen[i];
  }
  // seen += scale B_k^T u.
  void AddTransposed(Index k, double scale, ConstVectorView u, VectorView seen) const {
    double memory = Memory(k), value = 0;
    for (Index i = length - 1; i >= 0; --i) seen[i] += value = memory * value + scale * (1 - memory) * u[i];
  }
  // The 2 x 2 blocks of gain and offset of the instruments. offset: index of the first gain.
  vesta::BlockGroup OwnGroup(Index offset) const {
    return {.size = 2, .count = instruments - 1, .offset = offset, .component_stride = 1, .block_stride = 2};
  }
};

// J = [J_s J_o]. J_s has the columns of the signal, J_o the columns of the gains and offsets.
class ReadingsLinearization final : public vesta::Linearization<Backend>,
                                    public vesta::WithBlocks<Backend>,
                                    public vesta::WithReducedSystem<Backend> {
 public:
  ReadingsLinearization(const Setup& setup, ConstVectorView x, ConstVectorView readings)
      : setup_(setup), x_(x), smoothed_(setup.readings()), residuals_(setup.readings()) {
    for (Index k = 0; k < setup.instruments; ++k) {
      const VectorView smoothed = setup.Of(k, smoothed_.view()), r = setup.Of(k, residuals_.view());
      setup.Smooth(k, 1, setup.Seen(k, x), smoothed);
      for (Index i = 0; i < setup.length; ++i)
        r[i] = setup.Gain(x, k) * smoothed[i] + setup.Offset(x, k) - setup.Of(k, readings)[i];
    }
  }
  const Setup& setup() const { return setup_; }
  Index num_residuals() const override { return setup_.readings(); }
  Index num_parameters() const override { return setup_.times() + setup_.own(); }
  ConstVectorView residuals() const override { return residuals_; }
  void ApplyJ(ConstVectorView v, VectorView u) override {
    ApplySignalJ(v.subspan(0, setup_.times()), u);
    AddOwnJ(1, v.subspan(setup_.times(), setup_.own()), u);
  }
  void ApplyJT(ConstVectorView u, VectorView g) override {
    ApplySignalJT(u, g.subspan(0, setup_.times()));
    ApplyOwnJT(u, g.subspan(setup_.times(), setup_.own()));
  }
  void DiagJTJ(VectorView d) override {
    Blocks blocks(num_parameters(), block_groups());
    BlockGram(blocks);
    blocks.Diagonal(d);
  }
  std::vector<vesta::BlockGroup> block_groups() const override {
    return {{.size = 1, .count = setup_.times()}, setup_.OwnGroup(setup_.times())};
  }
  void BlockGram(Blocks& blocks) override {
    const VectorView signal = blocks.values(0), own = blocks.values(1);
    const Index count = setup_.instruments - 1;
    for (Index k = 0; k < setup_.instruments; ++k) {
      // Column i of B_k is (1 - m) (1, m, m^2, ...) from row i on, with m = Memory(k).
      double memory = setup_.Memory(k), scale = setup_.Gain(x_, k) * (1 - memory), sum = 0;
      const VectorView seen = setup_.Seen(k, signal);
      for (Index i = setup_.length - 1; i >= 0; --i) seen[i] += scale * scale * (sum = memory * memory * sum + 1);
      if (k == 0) continue;
      for (const double value : setup_.Of(k, smoothed_.view())) {
        own[vesta::PackedLower(0, 0) * count + k - 1] += value * value;
        own[vesta::PackedLower(1, 0) * count + k - 1] += value;
        own[vesta::PackedLower(1, 1) * count + k - 1] += 1;
      }
    }
  }
  std::unique_ptr<vesta::ReducedSystem<Backend>> MakeReducedSystem() override;

  // u = J_s v.
  void ApplySignalJ(ConstVectorView v, VectorView u) const {
    for (Index k = 0; k < setup_.instruments; ++k)
      setup_.Smooth(k, setup_.Gain(x_, k), setup_.Seen(k, v), setup_.Of(k, u));
  }
  // g = J_s^T u.
  void ApplySignalJT(ConstVectorView u, VectorView g) const {
    std::fill(g.begin(), g.end(), 0.0);
    for (Index k = 0; k < setup_.instruments; ++k)
      setup_.AddTransposed(k, setup_.Gain(x_, k), setup_.Of(k, u), setup_.Seen(k, g));
  }
  // u += scale J_o w.
  void AddOwnJ(double scale, ConstVectorView w, VectorView u) const {
    for (Index k = 1; k < setup_.instruments; ++k) {
      const ConstVectorView smoothed = setup_.Of(k, smoothed_.view());
      const VectorView out = setup_.Of(k, u);
      for (Index i = 0; i < setup_.length; ++i) out[i] += scale * (smoothed[i] * w[2 * k - 2] + w[2 * k - 1]);
    }
  }
  // h = J_o^T u.
  void ApplyOwnJT(ConstVectorView u, VectorView h) const {
    std::fill(h.begin(), h.end(), 0.0);
    for (Index k = 1; k < setup_.instruments; ++k) {
      const ConstVectorView smoothed = setup_.Of(k, smoothed_.view()), in = setup_.Of(k, u);
      for (Index i = 0; i < setup_.length; ++i) {
        h[2 * k - 2] += smoothed[i] * in[i];
        h[2 * k - 1] += in[i];
      }
    }
  }

 private:
  const Setup& setup_;
  ConstVectorView x_;
  Backend::Vector smoothed_, residuals_;  // B_k s of all instruments; residuals
};
