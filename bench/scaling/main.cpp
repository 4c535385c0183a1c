// SPDX-License-Identifier: Apache-2.0
// Measures products and LM steps of a distributed problem in an MPI process, and the data received from others.
//
//   mpirun -n P scaling bal [--cameras 200] [--points 100000] [--track 8] [--threads 1] [--repeats 5] [--parts 64]
//                           [--plain yes] [--json FILE]
//   mpirun -n P scaling splats SCENE SPLAT.ply [--downscale 1] [--views N] [--threads 1] ...
//
// bal: a generated bundle adjustment. splats: the LM problem of a splat on all training views of a scene, or the first
// N.
// --plain: the single-process problem without parts. Rank 0 reports one row: medians in milliseconds; exchanges and MiB
// that it receives in one product, measured (in total and all-gathered) and predicted; its peak memory.
// bench/scaling.py runs this program for several P.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bench/collections/generate_bundle.h"
#include "bench/report.h"
#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "kernels/core/process_memory.h"
#include "kernels/mpi/mpi_communicator.h"
#include "problems/bundle_adjustment/bundle_parts.h"
#include "problems/gaussian_splatting/lm/lm_stage_options.h"
#include "problems/gaussian_splatting/lm/splat_problem.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "solver/distributed/distributed_problem.h"
#include "solver/levenberg_marquardt.h"
#include "solver/lm_options.h"
#include "solver/reduced_system.h"
#include "splatting/distributed/splat_parts.h"
#include "splatting/io/scenes/load_scene.h"
#include "splatting/io/splats/ply.h"

namespace vesta::bench {
namespace {

constexpr double kMib = 1 << 20;

// Received in one call of body.
struct Received {
  double exchanges = 0, mib = 0, gathered_mib = 0;
};
template <class Body>
Received MeasureReceived(const Communicator& ranks, const Body& body) {
  const RankTraffic before = ranks.traffic();
  body();
  return {static_cast<double>(ranks.traffic().exchanges - before.exchanges),
          static_cast<double>(ranks.traffic().bytes - before.bytes) / kMib,
          static_cast<double>(ranks.traffic().gathered - before.gathered) / kMib};
}

// Measures one problem at x. distributed: the same problem, or null if it has no parts.
template <Backend B>
Row Measure(Communicator& ranks, Problem<B>& problem, DistributedProblem<B>* distributed, typename B::ConstVectorView x,
            const LmOptions& lm, int repeats) {
  B backend;
  const ProblemAdaptor<B> all(problem);
  const Index n = all.num_tangent();
  std::unique_ptr<LinearizationAdaptor<B>> linearization;
  typename B::Vector g(n), v(n), Hv(n), d(n);
  const double linearize = MedianMilliseconds(repeats, [&] {
    linearization = all.CheckedLinearize(x, 0);
    linearization->Gradient(g);
  });
  linearization = all.CheckedLinearize(x, 0);
  linearization->Gradient(g);
  backend.Copy(g, v);
  const double product = MedianMilliseconds(repeats, [&] { linearization->ApplyH(v, Hv); });
  const Received heard = MeasureReceived(ranks, [&] { linearization->ApplyH(v, Hv); });
  double reduced_product = 0;
  Received reduced_heard;
  if (const auto reduced = linearization->MakeReducedSystem()) {
    linearization->DiagJTJ(d);
    reduced->SetDamping(1e-4, d);
    typename B::Vector y(reduced->size());
    const auto kept = g.view().subspan(0, reduced->size());
    reduced_product = MedianMilliseconds(repeats, [&] { reduced->Apply(kept, y); });
    reduced_heard = MeasureReceived(ranks, [&] { reduced->Apply(kept, y); });
  }
  linearization.reset();
  const double cost = MedianMilliseconds(repeats, [&] { problem.Cost(x); });
  typename B::Vector start;
  const double step = MedianMilliseconds(std::min(repeats, 3), [&] {
    start.CopyFrom(x);
    LmOptions one = lm;
    one.max_iterations = 1;
    SolveLm<B>(one, backend, problem, start.view());
  });
  const double foreseen = distributed
                              ? static_cast<double>(distributed->tangent_sum().plan().ReceivedValues(ranks.rank()) *
                                                    static_cast<Index>(sizeof(typename B::Scalar))) /
                                    kMib
                              : 0;
  return {{"processes", static_cast<double>(ranks.size())},
          {"threads", static_cast<double>(NumThreads())},
          {"parts", distributed ? static_cast<double>(distributed->parts().num_parts()) : 0.0},
          {"parameters", static_cast<double>(n)},
          {"scalar_bytes", static_cast<double>(sizeof(typename B::Scalar))},
          {"linearize_ms", linearize},
          {"product_ms", product},
          {"reduced_product_ms", reduced_product},
          {"cost_ms", cost},
          {"step_ms", step},
          {"product_exchanges", heard.exchanges},
          {"product_mib", heard.mib},
          {"product_gathered_mib", heard.gathered_mib},
          {"product_mib_foreseen", foreseen},
          {"reduced_exchanges", reduced_heard.exchanges},
          {"reduced_mib", reduced_heard.mib},
          {"reduced_gathered_mib", reduced_heard.gathered_mib},
          {"peak_mib", PeakMemoryMib()}};
}

int Whole(const Arguments& arguments, const char* flag, const char* fallback) {
  return std::stoi(arguments.Flag(flag, fallback));
}

Row MeasureBundle(Communicator& ranks, const Arguments& arguments) {
  bundle::BundleData data = bundle::Generate({.num_cameras = Whole(arguments, "cameras", "200"),
                                              .num_points = Whole(arguments, "points", "100000"),
                                              .mean_track = std::stod(arguments.Flag("track", "8"))});
  const HostSpan<const double> x(data.x.data(), static_cast<Index>(data.x.size()));
  const int repeats = Whole(arguments, "repeats", "5");
  using Cpu = CpuBackend<double>;
  if (arguments.Flag("plain", "") == "yes") {
    bundle::BundleProblem problem(data);
    return Measure<Cpu>(ranks, problem, nullptr, x, bundle::BundleLmOptions(), repeats);
  }
  bundle::BundleParts parts(data, Whole(arguments, "parts", "64"));
  DistributedProblem<Cpu> problem(ranks, parts);
  return Measure<Cpu>(ranks, problem, &problem, x, bundle::BundleLmOptions(), repeats);
}

Row MeasureSplats(Communicator& ranks, const Arguments& arguments) {
  if (arguments.positional.size() != 3) Fail(kBadArgument, "usage: scaling splats SCENE SPLAT.ply");
  gs::LoadSceneOptions loading;
  loading.downscale = Whole(arguments, "downscale", "1");
  const gs::SplatModel model = gs::ReadSplatPly(arguments.positional[2]);
  loading.eps2d = model.eps2d, loading.antialiased = model.antialiased;
  const gs::Scene scene = gs::LoadScene(arguments.positional[1], loading);
  using Cpu = CpuBackend<float>;
  std::vector<const gs::View*> views = gs::TrainingViews(scene.views);
  const auto wanted = static_cast<std::size_t>(Whole(arguments, "views", "0"));
  if (wanted > views.size()) Fail(kBadArgument, "--views {}: the scene has {} training views", wanted, views.size());
  if (wanted > 0) views.resize(wanted);
  const std::vector<gs::TargetView<Cpu>> targets = gs::MakeTargets<Cpu>(views, gs::NearPlane(scene));
  gs::LmStageOptions lm;
  gs::SplatProblemOptions options = gs::SplatProblemOptionsOf(lm, model);
  gs::SplatProblem<Cpu> whole(options, targets);
  const HostSpan<const float> x(model.data.data(), static_cast<Index>(model.data.size()));
  const int repeats = Whole(arguments, "repeats", "5");
  if (arguments.Flag("plain", "") == "yes") {
    return Measure<Cpu>(ranks, whole, nullptr, x, gs::LmEngineOptions(lm), repeats);
  }
  gs::SplatParts parts(whole);
  DistributedProblem<Cpu> problem(ranks, parts);
  return Measure<Cpu>(ranks, problem, &problem, x, gs::LmEngineOptions(lm), repeats);
}

int Main(int argc, char** argv) {
  const Arguments arguments(
      argc, argv, {"cameras", "points", "track", "threads", "repeats", "parts", "plain", "views", "downscale", "json"});
  SetNumThreads(Whole(arguments, "threads", "1"));
  const std::unique_ptr<Communicator> ranks =
      IsStartedInRanks() ? StartMpi() : std::make_unique<SingleRankCommunicator>();
  const std::string what = arguments.positional.empty() ? "" : arguments.positional[0];
  if (what != "bal" && what != "splats") Fail(kBadArgument, "usage: scaling bal, or scaling splats SCENE SPLAT.ply");
  try {
    Report report("scaling");
    report.Add(what == "bal" ? MeasureBundle(*ranks, arguments) : MeasureSplats(*ranks, arguments));
    if (ranks->rank() == 0) report.Finish(arguments.Flag("json", ""));
  } catch (const std::exception& error) {
    ranks->Abandon(error.what());
    throw;
  }
  return 0;
}

}  // namespace
}  // namespace vesta::bench

int main(int argc, char** argv) { return vesta::bench::ReportErrors("scaling", vesta::bench::Main, argc, argv); }
