// Each pass of the GPU beside what the device can do at most, and a step of LM at scale.
//
//   gpu_kernels [--gaussians 1000000] [--pixels 1000000] [--views 100] [--overlap 40] [--repeats 20] [--json FILE]
//
// bytes: each input read once, each output written once; flops: those of the formulas for pixels that a splat is part
// of (docs/performance.md counts the instructions; two operations each). Neither counts what the kernels do besides.
#include <fmt/format.h>

#include <chrono>
#include <map>

#include "bench/gpu/ceilings.h"
#include "bench/kernel_times/workload.h"
#include "bench/report.h"
#include "kernels/core/device_kernels.h"
#include "kernels/gaussian_splatting/device_passes.h"
#include "kernels/gaussian_splatting/device_splat_view.h"
#include "problems/gaussian_splatting/adam/device_adam_steps.h"
#include "problems/gaussian_splatting/evaluate/metrics.h"
#include "problems/gaussian_splatting/lm/splat_problem.h"
#include "problems/gaussian_splatting/model/device_splat_backend.h"
#include "solver/levenberg_marquardt.h"

namespace vesta::bench {
namespace {

using Gpu = CudaBackend<float>;

class GpuBench {
 public:
  GpuBench(const Workload& workload, int repeats, Report& report)
      : workload_(workload), repeats_(repeats), report_(report) {
    fmt::print("measuring the ceilings of {}\n", QueryDevice().name);
    bytes_per_second_ = CopyBytesPerSecond();
    flops_per_second_ = FlopsPerSecond();
    fmt::print("copy {:.0f} GB/s, multiply-adds {:.1f} TFLOP/s\n", bytes_per_second_ / 1e9, flops_per_second_ / 1e12);
    x_.CopyFrom(HostSpan<const float>(workload.model.data.data(), static_cast<Index>(workload.model.data.size())));
    Build();
    splat::SplatView<float> host;
    splat::ViewWorkspace<float> workspace;
    host.Build(gs::ToKernelModel(workload.model), workload.views.front(), background_, workspace);
    visits_ = host.CountVisits();
  }

  void Passes() {
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
    // A splat and tile pair: the rank and the splat's 48 bytes; its tangent or sums 36, its Gram sums 144.
    const double lists = 52 * pairs, image_bytes = 4 * values, parameters = 4 * attributes * n;
    Add("project, sort, bin", "projection", 0, parameters + 48 * n + 100 * splats + 60 * pairs, [&] { Build(); });
    forward_ =
        Add("forward", "forward pass", 2 * 18 * visits, lists + image_bytes, [&] { view_.Render(image.data()); });
    j_v_ = Add("J v", "tangent pass", 2 * 28 * visits, lists + 36 * pairs + image_bytes + 2 * parameters,
               [&] { view_.ApplyJ(model, dx.data(), d_image.data(), workspace_); });
    jt_u_ = Add("J^T u", "adjoint pass", 2 * 38 * visits, lists + 72 * pairs + 2 * image_bytes + 3 * parameters,
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
  }

  // One iteration of LM with 8 products, all views.
  void LmIteration() {
    std::vector<gs::TargetView<CpuBackend<float>>> targets;
    for (std::size_t v = 0; v < workload_.views.size(); ++v) {
      const std::vector<float>& truth = workload_.photographs[v];
      targets.push_back({workload_.views[v], {truth.data(), static_cast<Index>(truth.size())}});
    }
    const std::vector<gs::TargetView<CudaBackend<float>>> on_device = gs::TargetsIn<CudaBackend<float>>(targets);
    gs::SplatProblemOptions options;
    options.count = workload_.model.count;
    options.view_agreement = 0;
    device::ResetPeak();
    gs::SplatProblem<CudaBackend<float>> problem(options, on_device);
    LmOptions engine;
    engine.max_iterations = 2;
    engine.function_tolerance = engine.gradient_tolerance = engine.parameter_tolerance = 0;
    engine.column_scaling = ColumnScaling::kNone;
    engine.normal_system.preconditioner = PreconditionerKind::kBlockJacobi;
    engine.normal_system.pcg.max_iterations = 8;
    engine.normal_system.pcg.model_tolerance = 0;
    engine.SetStepRule(StepRule::kSoft);
    Gpu backend;
    LmStepper<Gpu> stepper(engine, backend, problem, x_.view());
    const auto begin = std::chrono::steady_clock::now();
    stepper.Step();
    device::Synchronize();
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    const double peak = static_cast<double>(device::PeakBytes()) / (1 << 30);
    AddRow("LM iteration, all views", 1e3 * seconds, 0, 0, 0);
    report_.AddTarget({"an LM iteration with 8 products", seconds, "s", 3, seconds < 3});
    report_.AddTarget({"peak memory of LM", peak, "GiB", 16, peak < 16});
    const double both = forward_ + jt_u_;
    report_.AddTarget({"J v over forward and backward", j_v_ / both, "x", 1, j_v_ <= both});
    report_.AddTarget({"J^T u over forward and backward", jt_u_ / both, "x", 1, jt_u_ <= both});
    report_.AddTarget({"J v, of the nearer ceiling", share_["J v"], "%", 50, share_["J v"] >= 50});
    report_.AddTarget({"J^T u, of the nearer ceiling", share_["J^T u"], "%", 50, share_["J^T u"] >= 50});
  }

 private:
  // Products with the Jacobian kept in 8 bytes an entry. lists: bytes of the lists by tile, to which each pair adds its
  // mask and where its entries are.
  void CachedProducts(double lists, double visits, const float* image, const float* dx, float* d_image, float* g) {
    const auto pairs = static_cast<double>(view_.num_pairs());
    const double values = static_cast<double>(workload_.shape().NumValues()),
                 parameters = 4 * static_cast<double>(x_.size());
    const double kept = 8 * visits + 64 * pairs;
    const auto model = Model();
    Add("cache16, making", "filling entries", 2 * 44 * visits, 2 * lists + 2 * kept + 4 * values,
        [&] { view_.CacheJacobian(image, splat::CacheFormat::kHalf, workspace_); });
    Add("cache16, J v", "cached tangent", 2 * 14 * visits, lists + kept + 36 * pairs + 4 * values + 2 * parameters,
        [&] { view_.ApplyJ(model, dx, d_image, workspace_); });
    Add("cache16, J^T u", "cached adjoint", 2 * 12 * visits, lists + kept + 72 * pairs + 4 * values + 3 * parameters,
        [&] { view_.AddJT(model, image, d_image, g, workspace_); });
    Build();
  }

  // Adam's step on all parameters, each alone, and with the geometry in blocks.
  void AdamSteps(double n, DeviceBuffer<float>& gradient, DeviceBuffer<float>& x, DeviceBuffer<float>& first,
                 DeviceBuffer<float>& second) {
    const Index count = workload_.model.count;
    gs::AdamStepArrays arrays{
        .blocks = {}, .first_diagonal = 0, .attributes = workload_.model.num_attributes(), .steps = 0, .rate = {}};
    arrays.blocks.count = count;
    arrays.blocks.gradient = gradient.data();
    arrays.blocks.parameters = x.data();
    arrays.blocks.first = first.data();
    arrays.blocks.second = second.data();
    arrays.blocks.step = arrays.blocks.root_correction2 = 1;
    gs::BlockBases<Device> bases;
    // A step leaves its gradient zero, and one by zero has nothing to do: it is filled anew each time.
    const auto step = [&] {
      Gpu().Fill(1, gradient);
      gs::AdamSteps<Device>::Run(arrays, bases);
    };
    const double parameters = 4 * static_cast<double>(x.size());
    Add("Adam's step", "step of Adam", 0, 9 * parameters, step);
    bases = gs::BlockBases<Device>(count);
    arrays.first_diagonal = gs::kBlockSize;
    const double turned = (gs::kBlockNumbers + gs::kBasisSize + gs::kBlockSize) / double{gs::kTurnEvery};
    const double rest = 9.0 * (workload_.model.num_attributes() - gs::kBlockSize);
    Add("Adam's step in blocks", "step of Adam's blocks", 0,
        4 * (9 * gs::kBlockSize + gs::kBlockNumbers + gs::kCovarianceSize + turned + rest) * n, step);
  }

  splat::Model<float> Model() const {
    return {x_.data(), workload_.model.count, workload_.model.sh_degree, workload_.model.sh_degree};
  }
  void Build() { view_.Build(Model(), workload_.views.front(), background_, workspace_); }

  // kernel: whose registers are shown.
  template <class Body>
  double Add(const std::string& pass, const std::string& kernel, double flops, double bytes, const Body& body) {
    const double ms = DeviceMilliseconds(repeats_, body);
    int registers = 0;
    for (const device::KernelFacts& facts : device::KernelTable()) {
      if (facts.name == kernel) registers = facts.registers;
    }
    AddRow(pass, ms, flops, bytes, registers);
    return ms;
  }
  void AddRow(const std::string& pass, double ms, double flops, double bytes, int registers) {
    const double of_bytes = 100 * bytes / (1e-3 * ms) / bytes_per_second_,
                 of_flops = 100 * flops / (1e-3 * ms) / flops_per_second_;
    share_[pass] = std::max(of_bytes, of_flops);
    report_.Add({{"pass", pass},
                 {"ms", ms},
                 {"MB", bytes / 1e6},
                 {"% of bandwidth", of_bytes},
                 {"GFLOP", flops / 1e9},
                 {"% of flops", of_flops},
                 {"registers", static_cast<double>(registers)}});
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

int Run(int argc, char** argv) {
  const Arguments arguments(argc, argv, {"gaussians", "pixels", "views", "overlap", "repeats", "json"});
  if (!QueryDevice().usable) {
    fmt::print("skipped: no GPU to use ({})\n", QueryDevice().name);
    return 0;
  }
  const Workload workload =
      MadeUpWorkload(arguments.Count("gaussians", 1'000'000), arguments.Count("pixels", 1'000'000),
                     arguments.Count("overlap", 40), arguments.Count("views", 100));
  Report report("gpu_kernels");
  {
    GpuBench bench(workload, arguments.Count("repeats", 20), report);
    bench.Passes();
    bench.LmIteration();
  }
  report.Finish(arguments.Flag("json", ""));
  return 0;
}

}  // namespace
}  // namespace vesta::bench

int main(int argc, char** argv) {
  try {
    return vesta::bench::Run(argc, argv);
  } catch (const vesta::Error& error) {
    fmt::print(stderr, "gpu_kernels: {}\n", error.what());
    return 1;
  }
}
