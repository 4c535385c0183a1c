// SPDX-License-Identifier: Apache-2.0
// Benchmark of the CUDA kernels on a large workload. Compares the results with the host, times iterations of Adam and
// LM, and compares each pass with the limits of the device (roofline).
//
//   gpu_kernels [--gaussians 1000000] [--pixels 1000000] [--views 100] [--overlap 40] [--repeats 20] [--json FILE]
//   gpu_kernels --probe yes       prints the name of the GPU and runs a small kernel on it
//
// The JSON is written after each part, so that it is useful if the program is stopped. Exit status: 1 if the device
// disagrees with the host or between two runs, otherwise 0. Without a GPU it is 0, or 3 with VESTA_REQUIRE_CUDA=1 or
// --probe.
//
// bytes: each input read once and each output written once. flops: operations of the formulas for all pixels that a
// splat covers (docs/performance.md lists the instructions; each counts as two). All other work is ignored.
#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <map>
#include <string_view>

#include "bench/gpu/ceilings.h"
#include "bench/gpu/host_comparison.h"
#include "bench/gpu/whole_steps.h"
#include "bench/kernel_times/workload.h"
#include "bench/report.h"
#include "kernels/core/block_diagonal.h"
#include "kernels/core/device_kernels.h"
#include "kernels/gaussian_splatting/device/device_passes.h"
#include "kernels/gaussian_splatting/device/device_splat_view.h"
#include "kernels/gaussian_splatting/view/splat_view.h"
#include "problems/gaussian_splatting/model/device_splat_backend.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "splatting/adam/device_adam_steps.h"

namespace vesta::bench {
namespace {

using Gpu = CudaBackend<float>;

class GpuBench {
 public:
  GpuBench(const Workload& workload, int repeats, Report& report)
      : workload_(workload), repeats_(repeats), report_(report) {
    bytes_per_second_ = CopyBytesPerSecond();
    flops_per_second_ = FlopsPerSecond();
    fmt::print("copy {:.0f} GB/s, multiply-adds {:.1f} TFLOP/s\n", bytes_per_second_ / 1e9, flops_per_second_ / 1e12);
    std::fflush(stdout);
  }

  // Times each pass over the first view. Keeps its buffers, so it must run after WholeSteps, which measures peak
  // memory.
  void Passes() {
    const Workload& workload = workload_;
    x_.CopyFrom(HostSpan<const float>(workload.model.data.data(), static_cast<Index>(workload.model.data.size())));
    Build();
    splat::SplatView<float> host;
    splat::ViewWorkspace<float> workspace;
    host.Build(gs::ToKernelModel(workload.model), workload.views.front(), background_, workspace);
    visits_ = host.CountVisits();
    const double pairs = static_cast<double>(view_.num_pairs()), splats = static_cast<double>(view_.num_splats()),
                 values = static_cast<double>(workload_.shape().NumValues()),
                 n = static_cast<double>(workload_.model.count),
                 attributes = static_cast<double>(workload_.model.num_attributes()),
                 visits = static_cast<double>(visits_.pixels);
    const Index size = workload_.shape().NumValues();
    DeviceBuffer<float> image(size), d_image(size), weighted(size), dx(x_.size()), g(x_.size()), first(x_.size()),
        second(x_.size()), truth;
    truth.CopyFrom(HostSpan<const float>(workload_.photographs.front().data(), size));
    Gpu().Fill(1e-3, dx);
    Gpu().Fill(1e-3, d_image);
    const auto model = Model();
    // Bytes per pair of splat and tile: 4 for the index and 48 for the splat; 44 for its tangent or its sums, 144 for
    // its Gram sums.
    const double lists = 52 * pairs, image_bytes = 4 * values, parameters = 4 * attributes * n;
    Add("project, sort, bin", "projection", 0, parameters + 48 * n + 100 * splats + 60 * pairs, [&] { Build(); });
    forward_ =
        Add("forward", "forward pass", 2 * 18 * visits, lists + image_bytes, [&] { view_.Render(image.data()); });
    j_v_ = Add("J v", "tangent pass", 2 * 28 * visits, lists + 44 * pairs + image_bytes + 2 * parameters,
               [&] { view_.ApplyJ(model, dx.data(), d_image.data(), workspace_); });
    jt_u_ = Add("J^T u", "adjoint pass", 2 * 42 * visits, lists + 88 * pairs + 2 * image_bytes + 3 * parameters,
                [&] { view_.AddJT(model, image.data(), d_image.data(), g.data(), workspace_); });
    DeviceBuffer<float> blocks(66 * workload_.model.count), sh(x_.size() - splat::kSh * workload_.model.count);
    DevicePhotometricLoss loss;
    DevicePhotometricLinearization w;
    Add("loss gradient and W", "SSIM windows", 0, 14 * image_bytes,
        [&] { loss.Linearize(image, truth, workload_.shape(), d_image, w); });
    Add("W v", "weighted blur", 0, 7 * image_bytes, [&] { loss.ApplyW(w, d_image, weighted); });
    Add("Gram blocks", "Gram pass", 2 * 88 * visits,
        lists + 288 * pairs + 2 * image_bytes + 2 * parameters + 2 * 4 * 66 * n,
        [&] { view_.AddGram(model, image.data(), w.diagonal.data(), blocks.data(), sh.data(), workspace_); });
    CachedProducts(lists, visits, image.data(), dx.data(), d_image.data(), g.data());
    AdamSteps(n, g, dx, first, second);
    Gpu backend;
    Gpu::Slots slots(1);
    Add("dot product", "reduction", 0, 2 * parameters,
        [&] { backend.Dot(dx.view(), g.view(), backend.SlotOf(slots, 0)); });
    Add("a x + b y", "Axpby", 0, 3 * parameters, [&] { backend.Axpby(0.5, dx, 0.5, g); });
    BlockDiagonal<Gpu> preconditioner(
        splat::kGeometry * workload_.model.count,
        {{.size = splat::kGeometry, .count = workload_.model.count, .component_stride = workload_.model.count}});
    backend.Fill(1, preconditioner.all_values());
    const auto part = [&](DeviceBuffer<float>& v) { return v.view().subspan(0, preconditioner.num_parameters()); };
    Add("preconditioner", "BlockDiagonal::Solve", 0, 4 * (66 + 22) * n,
        [&] { preconditioner.Solve(part(dx), part(g)); });
    const double both = forward_ + jt_u_;
    report_.AddTarget({"J v over forward and backward", j_v_ / both, "x", 1, j_v_ <= both});
    report_.AddTarget({"J^T u over forward and backward", jt_u_ / both, "x", 1, jt_u_ <= both});
    report_.AddTarget({"J v, of the nearer ceiling", share_["J v"], "%", 50, share_["J v"] >= 50});
    report_.AddTarget({"J^T u, of the nearer ceiling", share_["J^T u"], "%", 50, share_["J^T u"] >= 50});
  }

  // Returns true if device and host agree.
  bool Comparison() {
    const HostComparison found = CompareWithHost(workload_);
    const auto add = [&](const char* name, double value, double goal) {
      report_.AddTarget({name, value, "", goal, value <= goal});
    };
    add("image, relative difference to the host", found.image, HostComparison::kImageGoal);
    add("J v, relative difference to the host", found.j_v, HostComparison::kProductGoal);
    add("J^T u, relative difference to the host", found.jt_u, HostComparison::kProductGoal);
    add("values that differ between two runs", static_cast<double>(found.differing), 0);
    return found.Agrees();
  }

  void WholeSteps() {
    AddStep("Adam iteration", AdamIterationCost(workload_, 2 * repeats_));
    const StepCost lm = LmIterationCost(workload_);
    AddStep("LM iteration, all views", lm);
    report_.AddTarget({"an LM iteration with 8 products", lm.seconds, "s", 3, lm.seconds < 3});
    report_.AddTarget({"peak memory of LM", lm.peak_gib, "GiB", 16, lm.peak_gib < 16});
  }

 private:
  // Products with the cached Jacobian, of 8 bytes per entry. lists: bytes of the tile lists. The cache adds a mask and
  // the offset of the entries per pair.
  void CachedProducts(double lists, double visits, const float* image, const float* dx, float* d_image, float* g) {
    const auto pairs = static_cast<double>(view_.num_pairs());
    const double values = static_cast<double>(workload_.shape().NumValues()),
                 parameters = 4 * static_cast<double>(x_.size());
    const double kept = 8 * visits + 64 * pairs;
    const auto model = Model();
    Add("cache16, making", "filling entries", 2 * 44 * visits, 2 * lists + 2 * kept + 4 * values,
        [&] { view_.CacheJacobian(image, splat::CacheFormat::kHalf, workspace_); });
    Add("cache16, J v", "cached tangent", 2 * 14 * visits, lists + kept + 44 * pairs + 4 * values + 2 * parameters,
        [&] { view_.ApplyJ(model, dx, d_image, workspace_); });
    Add("cache16, J^T u", "cached adjoint", 2 * 12 * visits, lists + kept + 88 * pairs + 4 * values + 3 * parameters,
        [&] { view_.AddJT(model, image, d_image, g, workspace_); });
    Build();
  }

  // Adam's step on all parameters, with diagonal and with block second moments of the geometry.
  void AdamSteps(double n, DeviceBuffer<float>& gradient, DeviceBuffer<float>& x, DeviceBuffer<float>& first,
                 DeviceBuffer<float>& second) {
    const Index count = workload_.model.count;
    gs::AdamStepArrays arrays{.blocks = {},
                              .layout = workload_.model,
                              .first_diagonal = 0,
                              .attributes = workload_.model.num_attributes(),
                              .views = 1,
                              .seen = 0,
                              .rate = {}};
    arrays.blocks.count = count;
    arrays.blocks.gradient = gradient.data();
    arrays.blocks.parameters = x.data();
    arrays.blocks.first = first.data();
    arrays.blocks.second = second.data();
    arrays.blocks.step = arrays.blocks.root_correction2 = 1;
    arrays.blocks.beta2 = gs::kAdamBeta2;
    gs::BlockBases<Device> bases;
    // A step clears the gradient, and does nothing with a zero gradient. So fill it before each step.
    const auto step = [&] {
      Gpu().Fill(1, gradient);
      gs::AdamSteps<Device>::Run(arrays, bases);
    };
    const double parameters = 4 * static_cast<double>(x.size());
    Add("Adam's step", "step of Adam", 0, 9 * parameters, step);
    bases = gs::BlockBases<Device>(count);
    arrays.first_diagonal = gs::kBlockSize;
    const double turned = (gs::kBlockNumbers + gs::kBasisSize + gs::kBlockSize) / double{gs::kRotationInterval};
    const double rest = 9.0 * (workload_.model.num_attributes() - gs::kBlockSize);
    Add("Adam's step in blocks", "step of Adam's blocks", 0,
        4 * (9 * gs::kBlockSize + gs::kBlockNumbers + gs::kCovarianceSize + turned + rest) * n, step);
  }

  splat::Model<float> Model() const { return {x_.data(), workload_.model.layout(), workload_.model.sh_degree}; }
  void Build() { view_.Build(Model(), workload_.views.front(), background_, workspace_); }

  // kernel: for the register count.
  template <class Body>
  double Add(const std::string& pass, const std::string& kernel, double flops, double bytes, const Body& body) {
    const device::HostWork before = device::CountedHostWork();
    int calls = 0;
    const double ms = DeviceMilliseconds(repeats_, [&] {
      body();
      ++calls;
    });
    const device::HostWork after = device::CountedHostWork();
    int registers = 0;
    for (const device::KernelStatistics& facts : device::KernelTable()) {
      if (facts.name == kernel) registers = facts.registers;
    }
    AddRow(pass, ms, static_cast<double>(after.launches - before.launches) / calls,
           static_cast<double>(after.waits - before.waits) / calls, flops, bytes, registers);
    return ms;
  }
  void AddStep(const std::string& name, const StepCost& cost) {
    AddRow(name, 1e3 * cost.seconds, cost.launches, cost.waits, 0, 0, 0);
  }
  void AddRow(const std::string& pass, double ms, double launches, double waits, double flops, double bytes,
              int registers) {
    const double of_bytes = 100 * bytes / (1e-3 * ms) / bytes_per_second_,
                 of_flops = 100 * flops / (1e-3 * ms) / flops_per_second_;
    share_[pass] = std::max(of_bytes, of_flops);
    report_.Add({{"pass", pass},
                 {"ms", ms},
                 {"launches", launches},
                 {"waits", waits},
                 {"MB", bytes / 1e6},
                 {"% of bandwidth", of_bytes},
                 {"GFLOP", flops / 1e9},
                 {"% of flops", of_flops},
                 {"registers", static_cast<double>(registers)}});
    // At once: the program may be stopped before the table.
    fmt::print("{}: {:.3f} ms, {:.0f} launches, {:.0f} waits\n", pass, ms, launches, waits);
    std::fflush(stdout);
  }

  const Workload& workload_;
  const int repeats_;
  Report& report_;
  const double background_[3] = {0, 0, 0};
  double bytes_per_second_ = 0, flops_per_second_ = 0, forward_ = 0, j_v_ = 0, jt_u_ = 0;
  std::map<std::string, double> share_;
  DeviceBuffer<float> x_;
  splat::DeviceSplatView view_;
  splat::DeviceViewWorkspace workspace_;
  splat::VisitCounts visits_;
};

// Runs a small kernel, then prints the name of the GPU.
int Probe() {
  const DeviceInfo& device = QueryDevice();
  const DeviceBuffer<float> zeros(1000);
  DeviceBuffer<float> ones(1000);
  Gpu().Fill(1, ones);
  Gpu().Axpby(1, zeros, 1, ones);
  const double sum = Gpu().Dot(ones.view(), ones.view());
  fmt::print("{}, capability {}.{}, {} multiprocessors, {:.1f} of {:.1f} GiB free\n", device.name,
             device.capability / 10, device.capability % 10, device.multiprocessors,
             static_cast<double>(device::FreeBytes()) / (1 << 30), static_cast<double>(device.memory) / (1 << 30));
  if (sum == 1000) return 0;
  fmt::print("a dot product of 1000 ones is {}\n", sum);
  return 1;
}

int Run(int argc, char** argv) {
  const Arguments arguments(argc, argv, {"gaussians", "pixels", "views", "overlap", "repeats", "json", "probe"});
  const bool probes = arguments.Flag("probe", "no") == "yes";
  if (!QueryDevice().usable) {
    fmt::print("no GPU to use ({})\n", QueryDevice().name);
    const char* require = std::getenv("VESTA_REQUIRE_CUDA");
    return probes || (require != nullptr && std::string_view(require) == "1") ? 3 : 0;
  }
  if (probes) return Probe();
  const Workload workload =
      SyntheticWorkload(arguments.Count("gaussians", 1'000'000), arguments.Count("pixels", 1'000'000),
                        arguments.Count("overlap", 40), arguments.Count("views", 100));
  Report report("gpu_kernels");
  GpuBench bench(workload, arguments.Count("repeats", 20), report);
  const std::string json = arguments.Flag("json", "");
  const bool agrees = bench.Comparison();
  report.WriteJson(json);
  bench.WholeSteps();
  report.WriteJson(json);
  bench.Passes();
  report.Finish(json);
  return agrees ? 0 : 1;
}

}  // namespace
}  // namespace vesta::bench

int main(int argc, char** argv) { return vesta::bench::ReportErrors("gpu_kernels", vesta::bench::Run, argc, argv); }
