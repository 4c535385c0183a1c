// SPDX-License-Identifier: Apache-2.0
// A problem whose Jacobian Ceres could not store: recovers an image of 2048 x 2048 pixels from three coded exposures,
// matrix-free, and compares it with the image that generated them.
//
//   bench/matrix_free_at_scale [--side 2048] [--frames 3] [--threads 0] [--json FILE]
#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "bench/deconvolution/photon_image.h"
#include "bench/report.h"
#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "kernels/core/process_memory.h"
#include "solver/levenberg_marquardt.h"

namespace vesta::bench {
namespace {

using B = CpuBackend<double>;

constexpr double kGib = 1024.0 * 1024.0 * 1024.0;

// Differences between the recovered light and the true one.
struct Errors {
  double largest_relative = 0;
  double rms = 0;
  // Upper bound of rms, from |A e|^2 >= least |e|^2.
  double rms_bound = 0;
};

Errors Compare(Index side, const std::vector<deconvolution::Aperture>& apertures, HostSpan<const double> x,
               HostSpan<const double> scene) {
  Errors errors;
  HostBuffer<double> difference(x.size());
  for (Index k = 0; k < x.size(); ++k) {
    difference[k] = std::exp(x[k]) - scene[k];
    errors.largest_relative = std::max(errors.largest_relative, std::abs(difference[k]) / scene[k]);
  }
  const HostBuffer<double> exposed = deconvolution::Expose(side, apertures, difference);
  B backend;
  const double pixels = static_cast<double>(x.size()), least = deconvolution::NormalSymbol(apertures).least;
  errors.rms = std::sqrt(backend.Dot(difference, difference) / pixels);
  errors.rms_bound = std::sqrt(backend.Dot(exposed, exposed) / least / pixels);
  return errors;
}

int PositiveFlag(const Arguments& arguments, const std::string& name, const std::string& fallback, int least) {
  const std::string text = arguments.Flag(name, fallback);
  std::size_t used = 0;
  int value = least - 1;
  try {
    value = std::stoi(text, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  if (used != text.size() || text.empty() || value < least)
    Fail(kBadArgument, "--{} is {}; choose {} or more", name, text, least);
  return value;
}

void Run(const Arguments& arguments) {
  const Index side = PositiveFlag(arguments, "side", "2048", 1);
  const int frames = PositiveFlag(arguments, "frames", "3", 1);
  SetNumThreads(PositiveFlag(arguments, "threads", "0", 0));

  const auto apertures = deconvolution::CodedApertures(frames);
  const HostBuffer<double> scene = deconvolution::TestScene(side);
  deconvolution::PhotonImage problem(side, apertures, deconvolution::Expose(side, apertures, scene));
  B backend;
  B::Vector x(problem.num_parameters());
  backend.Fill(problem.UniformStart(), x);
  fmt::print("{} unknowns, {} residuals, {} entries of J\n", problem.num_parameters(), problem.num_residuals(),
             problem.jacobian_entries());
  const auto print_row = [](const LmIteration& row) {
    fmt::print("iteration {:2}: cost {:.6e}, gradient {:.2e}, {} PCG iterations, {:.1f} s\n", row.iteration, row.cost,
               row.gradient_max_norm, row.pcg_iterations, row.seconds);
    std::fflush(stdout);
    return CallbackResult::kContinue;
  };
  const LmSummary summary = SolveLm(deconvolution::PhotonImageOptions(), backend, problem, x.view(), print_row);
  const double peak = PeakMemoryMib() / 1024;  // before the comparison
  fmt::print("{}\n", summary.BriefReport());
  const Errors errors = Compare(side, apertures, x, scene);
  const double stored = problem.stored_jacobian_bytes() / kGib;

  Report report("matrix_free_at_scale");
  report.Add({{"side", static_cast<double>(side)},
              {"frames", static_cast<double>(frames)},
              {"stored J, GiB", stored},
              {"peak memory, GiB", peak},
              {"seconds", summary.total_seconds},
              {"LM iterations", static_cast<double>(summary.iterations.size() - 1)},
              {"PCG iterations", static_cast<double>(summary.num_pcg_iterations)},
              {"cost at start", summary.initial_cost},
              {"cost", summary.final_cost},
              {"largest relative error", errors.largest_relative},
              {"rms error", errors.rms},
              {"its bound", errors.rms_bound}});
  report.AddTarget({"stored Jacobian, at least", stored, "GiB", 24, stored >= 24});
  report.AddTarget({"peak memory", peak, "GiB", 4, peak <= 4});
  report.AddTarget({"largest relative error of a pixel", errors.largest_relative, "", 1e-6,
                    errors.largest_relative <= 1e-6 && errors.rms <= errors.rms_bound});
  report.Finish(arguments.Flag("json", ""));
}

}  // namespace
}  // namespace vesta::bench

int main(int argc, char** argv) {
  try {
    vesta::bench::Run({argc, argv, {"side", "frames", "threads", "json"}});
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "matrix_free_at_scale: {}\n", error.what());
    return 1;
  }
}
