// SPDX-License-Identifier: Apache-2.0
// Measures each splatting pass, the loss and an iteration of Adam, and compares them with the lower bounds of
// docs/performance.md:
//
//   kernels [SCENE PLY] [--threads 1,2] [--repeats N] [--scaling yes] [--json FILE]
//
// SCENE and PLY give a real workload; the default is synthetic. --scaling yes adds series in which pixels, Gaussians or
// views double, up to a million Gaussians and pixels.
#include <fmt/format.h>

#include "bench/kernel_times/vector_rate.h"
#include "bench/kernel_times/workload.h"
#include "bench/report.h"
#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "kernels/core/random.h"
#include "kernels/gaussian_splatting/formulas/layout.h"
#include "kernels/gaussian_splatting/view/splat_view.h"
#include "kernels/image/photometric_loss.h"
#include "problems/gaussian_splatting/lm/splat_problem.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "solver/internal/normal_equations/problem_adaptor.h"
#include "splatting/adam/adam.h"
#include "splatting/evaluate/evaluation.h"

namespace vesta::bench {
namespace {

// Vector instructions of the formulas (docs/performance.md) per covered vector of pixels.
constexpr double kForward = 18, kTangent = 28, kBoth = 32, kAdjoint = 42, kGram = 88;

// Passes over one workload.
class Bench {
 public:
  Bench(const Workload& workload, int threads, int repeats, double rate, Report& report)
      : workload_(workload), threads_(threads), repeats_(repeats), rate_(rate), report_(report) {
    SetNumThreads(threads);
    view_.Build(model(), workload.views.front(), background_, workspace_);
    visits_ = view_.CountVisits();
  }

  void RasterPasses() {
    const Index values = workload_.shape().NumValues();
    HostBuffer<float> image(values), d_image(values), u(values);
    HostBuffer<splat::SplatTangent<float>> tangents(view_.num_splats()), pair_sums(view_.num_pairs());
    HostBuffer<splat::SplatGram<float>> pair_grams(view_.num_pairs());
    CounterRandom random(1, 0);
    for (float& value : u) value = static_cast<float>(random.Uniform());
    for (auto& tangent : tangents) {
      for (float& w : tangent.w) w = static_cast<float>(random.Uniform() - 0.5);
    }
    const splat::TileLists<float> lists = view_.Lists();
    const splat::RasterKernels<float>& raster = splat::GetRasterKernels<float>();
    const auto over_tiles = [&](const auto& pass) {
      ParallelFor(Index{lists.tiles_x} * lists.tiles_y, 4, [&](Index tile) { pass(static_cast<int>(tile)); });
    };
    Add("forward", kForward, [&] { over_tiles([&](int tile) { raster.forward(lists, tile, image.data()); }); });
    Add("tangent", kTangent,
        [&] { over_tiles([&](int tile) { raster.tangent(lists, tile, tangents.data(), d_image.data()); }); });
    Add("both at once", kBoth, [&] {
      over_tiles([&](int tile) { raster.forward_tangent(lists, tile, tangents.data(), image.data(), d_image.data()); });
    });
    Add("adjoint", kAdjoint,
        [&] { over_tiles([&](int tile) { raster.adjoint(lists, tile, image.data(), u.data(), pair_sums.data()); }); });
    Add("Gram", kGram,
        [&] { over_tiles([&](int tile) { raster.gram(lists, tile, image.data(), u.data(), pair_grams.data()); }); });
  }

  void Operators() {
    const ImageShape shape = workload_.shape();
    const Index parameters = static_cast<Index>(workload_.model.data.size());
    HostBuffer<float> image(shape.NumValues()), d_image(shape.NumValues()), weighted(shape.NumValues());
    HostBuffer<float> dx(parameters), gradient(parameters), blocks(66 * workload_.model.count);
    HostBuffer<float> sh_diagonal(parameters - splat::kSh * workload_.model.count);
    CounterRandom random(2, 0);
    for (float& value : dx) value = static_cast<float>(random.Uniform() - 0.5);
    const HostSpan<const float> truth(workload_.photographs.front().data(), shape.NumValues());
    PhotometricLoss<float> loss;
    PhotometricLinearization<float> linearization;
    view_.Render(image.data());
    Add("project, sort, bin", 0, [&] { view_.Build(model(), workload_.views.front(), background_, workspace_); });
    Add("J v", 0, [&] { view_.ApplyJ(model(), dx.data(), d_image.data(), workspace_); });
    Add("loss gradient and W", 0, [&] { loss.Linearize(image, truth, shape, d_image, linearization); });
    Add("W v", 0, [&] { loss.ApplyW(linearization, d_image, weighted); });
    Add("J^T u", 0, [&] { view_.AddJT(model(), image.data(), d_image.data(), gradient.data(), workspace_); });
    for (const splat::CacheFormat format : {splat::CacheFormat::kFull, splat::CacheFormat::kHalf}) {
      const int bits = format == splat::CacheFormat::kFull ? 32 : 16;
      splat::SplatView<float> cached;
      cached.Build(model(), workload_.views.front(), background_, workspace_);
      Add(fmt::format("cache{}: build", bits), 0, [&] { cached.CacheJacobian(image.data(), format, workspace_); });
      Add(fmt::format("cache{}: J v", bits), 0, [&] { cached.ApplyJ(model(), dx.data(), d_image.data(), workspace_); });
      Add(fmt::format("cache{}: J^T u", bits), 0,
          [&] { cached.AddJT(model(), image.data(), d_image.data(), gradient.data(), workspace_); });
      fmt::print("cache{}: {} entries, {:.1f} MiB\n", bits, cached.cache().num_entries(),
                 static_cast<double>(cached.cache().num_bytes()) / (1 << 20));
    }
    Add("Gram blocks", 0, [&] {
      view_.AddGram(model(), image.data(), linearization.diagonal.data(), blocks.data(), sh_diagonal.data(),
                    workspace_);
    });
  }

  // As in training: one view at full resolution, a step for every Gaussian it sees; the views in turn.
  double AdamIteration() {
    const ImageShape shape = workload_.shape();
    HostBuffer<float> image(shape.NumValues()), u(shape.NumValues());
    gs::SplatModel trained = workload_.model;
    HostBuffer<float> gradient(static_cast<Index>(trained.data.size()));
    gs::Adam<CpuBackend<float>> adam{gs::LearningRates()};
    HostBuffer<float> units(trained.count);
    std::fill(units.begin(), units.end(), static_cast<float>(workload_.extent));
    adam.SetUnits(std::move(units));
    const HostSpan<float> parameters(trained.data.data(), static_cast<Index>(trained.data.size()));
    PhotometricLoss<float> loss({.l1_floor = 0});
    std::size_t next = 0;
    const int attributes = splat::NumAttributes(trained.sh_degree);
    const double ms = Add("Adam iteration", 0, [&] {
      const std::size_t k = next++ % workload_.views.size();
      const splat::Model<float> x = gs::ToKernelModel(trained);
      view_.Build(x, workload_.views[k], background_, workspace_);
      view_.Render(image.data());
      loss.Gradient(image, HostSpan<const float>(workload_.photographs[k].data(), shape.NumValues()), shape, u);
      view_.AddJT(x, image.data(), u.data(), gradient.data(), workspace_);
      adam.Step(trained, parameters, gradient.data(), attributes, 1e-3);
    });
    // A step clears the gradient, and does nothing with a zero gradient. So each timed call first copies the gradient
    // of the last view.
    const std::size_t k = next % workload_.views.size();
    view_.Build(gs::ToKernelModel(trained), workload_.views[k], background_, workspace_);
    HostBuffer<float> last(gradient.size());
    view_.AddJT(gs::ToKernelModel(trained), image.data(), u.data(), last.data(), workspace_);
    Add("of that, Adam's step", 0, [&] {
      std::copy(last.begin(), last.end(), gradient.begin());
      adam.Step(trained, parameters, gradient.data(), attributes, 1e-3);
    });
    return ms;
  }

  // LM's work on all views at one x: linearisation and one product with H.
  double LmProduct() {
    std::vector<gs::TargetView<CpuBackend<float>>> targets;
    for (std::size_t v = 0; v < workload_.views.size(); ++v) {
      const std::vector<float>& truth = workload_.photographs[v];
      targets.push_back({workload_.views[v], {truth.data(), static_cast<Index>(truth.size())}});
    }
    gs::SplatProblemOptions options;
    options.count = workload_.model.count;
    options.gradient_shrinkage = 0;
    gs::SplatProblem<CpuBackend<float>> problem(options, targets);
    const auto size = static_cast<Index>(workload_.model.data.size());
    const HostSpan<const float> x(workload_.model.data.data(), size);
    HostBuffer<float> v(size), Hv(size);
    v.CopyFrom(x);
    return Add("linearize, H v", 0,
               [&] { ProblemAdaptor<CpuBackend<float>>(problem).CheckedLinearize(x, 0)->ApplyH(v, Hv); });
  }

 private:
  splat::Model<float> model() const { return gs::ToKernelModel(workload_.model); }

  // instructions: lower bound per useful vector; 0: none.
  template <class Body>
  double Add(const std::string& pass, double instructions, const Body& body) {
    const double ms = MedianMilliseconds(repeats_, body);
    const double floor = instructions * static_cast<double>(visits_.useful) / (rate_ * threads_) / 1e6;
    report_.Add(
        {{"workload", workload_.name},
         {"threads", static_cast<double>(threads_)},
         {"pass", pass},
         {"ms", ms},
         {"floor ms", floor},
         {"% of floor", 100 * floor / ms},
         {"ns per pixel and splat", 1e6 * ms / static_cast<double>(visits_.pixels)},
         {"splats", static_cast<double>(view_.num_splats())},
         {"pairs", static_cast<double>(view_.num_pairs())},
         {"vectors a pair", static_cast<double>(visits_.vectors) / static_cast<double>(visits_.pairs)},
         {"useful", static_cast<double>(visits_.useful) / static_cast<double>(visits_.vectors)},
         {"lanes used", static_cast<double>(visits_.pixels) / static_cast<double>(visits_.useful)},
         {"splats a pixel", static_cast<double>(visits_.pixels) / static_cast<double>(workload_.shape().PlaneSize())}});
    return ms;
  }

  const Workload& workload_;
  const int threads_, repeats_;
  const double rate_;
  Report& report_;
  const double background_[3] = {0, 0, 0};
  splat::SplatView<float> view_;
  splat::ViewWorkspace<float> workspace_;
  splat::VisitCounts visits_;
};

std::vector<int> ThreadCounts(const std::string& list) {
  std::vector<int> counts;
  for (std::size_t begin = 0; begin < list.size();) {
    const std::size_t end = std::min(list.find(',', begin), list.size());
    counts.push_back(std::stoi(list.substr(begin, end - begin)));
    begin = end + 1;
  }
  return counts;
}

void Scaling(int threads, int repeats, double rate, Report& report) {
  constexpr double kOverlap = 40, kMost = 2.1;
  const auto series = [&](const char* what, const auto& workload_at, const auto& time) {
    double last = 0;
    for (int k = 0; k < 4; ++k) {
      const Workload workload = workload_at(k);
      Bench bench(workload, threads, repeats, rate, report);
      const double ms = time(bench);
      if (last > 0) {
        report.AddTarget(
            {fmt::format("{} doubled, to {}", what, workload.name), ms / last, "x", kMost, ms / last <= kMost});
      }
      last = ms;
    }
  };
  const auto adam = [](Bench& bench) { return bench.AdamIteration(); };
  series(
      "pixels", [](int k) { return SyntheticWorkload(100'000, Index{125'000} << k, kOverlap); }, adam);
  series(
      "Gaussians", [](int k) { return SyntheticWorkload(Index{125'000} << k, 1'000'000, kOverlap); }, adam);
  series(
      "views", [](int k) { return SyntheticWorkload(20'000, 100'000, kOverlap, 4 << k); },
      [](Bench& bench) { return bench.LmProduct(); });
}

void Run(const Arguments& arguments) {
  if (arguments.positional.size() != 0 && arguments.positional.size() != 2) {
    Fail(kBadArgument, "usage: kernels [SCENE PLY] [--threads 1,2 --repeats N --scaling yes --json FILE]");
  }
  const int repeats = std::stoi(arguments.Flag("repeats", "11"));
  const std::vector<int> threads = ThreadCounts(arguments.Flag("threads", "1,2"));
  const Workload workload = arguments.positional.empty()
                                ? SyntheticWorkload(20'000, 190'000, 40)
                                : RealWorkload(arguments.positional[0], arguments.positional[1]);
  const double rate = VectorOperationsPerNanosecond(ActiveIsa());
  fmt::print("{}: {:.2f} vector operations a nanosecond and thread\n", IsaName(ActiveIsa()), rate);
  Report report("kernels");
  for (const int count : threads) {
    Bench bench(workload, count, repeats, rate, report);
    bench.RasterPasses();
    bench.Operators();
    bench.AdamIteration();
  }
  if (arguments.Flag("scaling", "") == "yes") Scaling(threads.back(), 5, rate, report);
  report.Finish(arguments.Flag("json", ""));
}

}  // namespace
}  // namespace vesta::bench

int main(int argc, char** argv) {
  try {
    vesta::bench::Run({argc, argv, {"threads", "repeats", "scaling", "json"}});
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "kernels: {}\n", error.what());
    return 1;
  }
}
