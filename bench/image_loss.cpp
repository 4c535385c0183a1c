// Time of the photometric loss of one view of 504 x 378 pixels, single precision, on one thread.
#include <benchmark/benchmark.h>

#include "kernels/core/parallel.h"
#include "kernels/image/photometric_loss.h"
#include "kernels/image/ssim_jacobian.h"

namespace vesta {
namespace {

constexpr ImageShape kShape{.width = 504, .height = 378};

// A pattern with detail at every scale of the window, values within 0..1.
HostBuffer<float> Pattern(Index step) {
  HostBuffer<float> image(kShape.NumValues());
  for (Index i = 0; i < image.size(); ++i) image[i] = static_cast<float>(i * step % 1009) / 1009.0f;
  return image;
}

struct View {
  HostBuffer<float> rendered = Pattern(7), truth = Pattern(31), out{kShape.NumValues()};
  PhotometricLoss<float> loss;

  View() { SetNumThreads(1); }
};

void BM_Value(benchmark::State& state) {
  View view;
  for (auto _ : state) benchmark::DoNotOptimize(view.loss.Evaluate(view.rendered, view.truth, kShape));
}
BENCHMARK(BM_Value)->Unit(benchmark::kMillisecond);

void BM_Gradient(benchmark::State& state) {
  View view;
  for (auto _ : state) benchmark::DoNotOptimize(view.loss.Gradient(view.rendered, view.truth, kShape, view.out));
}
BENCHMARK(BM_Gradient)->Unit(benchmark::kMillisecond);

void BM_Linearize(benchmark::State& state) {
  View view;
  PhotometricLinearization<float> w;
  for (auto _ : state) benchmark::DoNotOptimize(view.loss.Linearize(view.rendered, view.truth, kShape, view.out, w));
}
BENCHMARK(BM_Linearize)->Unit(benchmark::kMillisecond);

void BM_ApplyW(benchmark::State& state) {
  View view;
  PhotometricLinearization<float> w;
  view.loss.Linearize(view.rendered, view.truth, kShape, view.out, w);
  for (auto _ : state) view.loss.ApplyW(w, view.rendered, view.out);
}
BENCHMARK(BM_ApplyW)->Unit(benchmark::kMillisecond);

void BM_JacobianAdjoint(benchmark::State& state) {
  View view;
  SsimJacobian<float> jacobian;
  jacobian.Linearize(view.rendered, view.truth, kShape, view.out);
  for (auto _ : state) jacobian.ApplyAdjoint(view.truth, view.out);
}
BENCHMARK(BM_JacobianAdjoint)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace vesta

BENCHMARK_MAIN();
