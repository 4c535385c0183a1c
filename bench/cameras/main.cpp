// Trainings from cameras that are not where they are said to be: what each way of finding them along comes to.
//
//   cameras SCENE [--degrees 0.3] [--centre 0.01] [--exposure 0] [--focal 0] [--seeds 0] [--reports yes] [--json FILE]
//           [--methods none,gauss_newton,adam:1e-3:1e-3] [--joint_iterations 8] [--joint_pcg 4] [--rounds 4]
//           [--prior 0.01] -- [flags of vesta train]
//
// Each view is turned and shifted at random, those of test too, and training views are exposed so; all focal lengths
// are too long by --focal (perturbed_scene.h), and lenses are found where that is not 0.
// Methods: exact (nothing is perturbed, nothing found), settled (nothing is perturbed, gauss_newton all the same: where
// the splat takes right cameras), none, late (perturbed only after the Adam stage), gauss_newton, adam:R:T with these
// rates, auto. What comes after settled is measured beside where that ended, too: what is left of the perturbation.
// After a method, with a plus, what follows the Adam stage (endings.h; lm by default). PSNR of the test views, as
// stated and with their cameras (and exposures) fitted (cameras/aligned_evaluation.h).
#include <fmt/format.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench/cameras/endings.h"
#include "bench/cameras/gains.h"
#include "bench/cameras/measure.h"
#include "bench/cameras/methods.h"
#include "bench/cameras/perturbed_scene.h"
#include "bench/report.h"
#include "bench/training_race/setup.h"
#include "kernels/core/parallel.h"
#include "problems/gaussian_splatting/model/to_kernel.h"

namespace vesta::bench {
namespace {

double Number(const Arguments& arguments, const char* flag, const char* fallback) {
  return std::stod(arguments.Flag(flag, fallback));
}

gs::JointOptions JointOptionsOf(const gs::Scene& scene, const gs::TrainOptions& options, gs::CameraChoice free,
                                const Arguments& arguments) {
  gs::JointOptions joint;
  joint.free = gs::FreeBy(free);
  joint.lm = options.lm;
  joint.lm.min_gain = 0;
  joint.lm.pcg_iterations = arguments.Count("joint_pcg", 4);
  joint.iterations = arguments.Count("joint_iterations", 8);
  joint.rates = options.rates;
  joint.background = options.background;
  joint.near = gs::NearPlane(scene);
  joint.extent = scene.extent;
  joint.prior_weight = Number(arguments, "prior", "0.01");
  return joint;
}

// A training and what follows it, by several methods one after the other: several endings may follow one training.
class Trainings {
 public:
  struct Outcome {
    gs::TrainResult result;
    int products = 0;  // RunEnding's
  };

  explicit Trainings(const Arguments& arguments) : arguments_(arguments) {}

  // Trained on one scene and ended on the other, which differ in their cameras alone.
  Outcome Run(const Method& method, const gs::Scene& trained, const gs::Scene& ended, gs::TrainOptions options) {
    options.cameras = method.cameras;
    if (method.ending == Ending::kLm) return {gs::Train(trained, options, 0, {})};
    options.lm.iterations = 0;
    const std::string name = fmt::format("{} {}", method.training, options.seed);
    if (latest_name_ != name) latest_name_ = name, latest_ = gs::Train(trained, options, 0, {});
    Outcome outcome{latest_};
    outcome.result.lm_seconds = 0;
    return method.ending == Ending::kNothing ? outcome : End(method, ended, options, std::move(outcome));
  }

 private:
  Outcome End(const Method& method, const gs::Scene& scene, const gs::TrainOptions& options, Outcome outcome) const {
    gs::TrainResult& result = outcome.result;
    Ended ended =
        RunEnding(method.ending, std::move(result.model), gs::TrainingViews(scene.views), result.cameras,
                  {JointOptionsOf(scene, options, method.ending_finds, arguments_), arguments_.Count("rounds", 4)});
    result.model = std::move(ended.model);
    result.cameras = std::move(ended.views);
    result.lm_seconds = ended.seconds;
    result.lm_report = std::move(ended.report);
    outcome.products = ended.products;
    return outcome;
  }

  const Arguments& arguments_;
  std::string latest_name_;  // with its seed
  gs::TrainResult latest_;   // without an ending
};

void Append(Row columns, Row* row) {
  for (auto& column : columns) row->push_back(std::move(column));
}

int Main(int argc, char** argv) {
  const RaceSetup setup = SetUpRace(argc, argv,
                                    {"degrees", "centre", "exposure", "focal", "seeds", "methods", "json",
                                     "joint_iterations", "joint_pcg", "rounds", "prior", "reports"});
  const Arguments& arguments = setup.arguments;
  const Perturbation by{Number(arguments, "degrees", "0.3"), Number(arguments, "centre", "0.01"),
                        Number(arguments, "exposure", "0"), Number(arguments, "focal", "0")};
  std::vector<Method> methods;
  for (const std::string& name : SplitAtCommas(arguments.Flag("methods", "exact,none,gauss_newton"))) {
    methods.push_back(MethodOf(name, by, setup.options.cameras));
  }
  SetNumThreads(setup.threads);
  Report report("cameras");
  Trainings trainings(arguments);
  for (const std::string& seed : SplitAtCommas(arguments.Flag("seeds", "0"))) {
    std::vector<double> gains;
    const gs::Scene perturbed = Perturbed(setup.scene, by, std::stoull(seed), &gains);
    gains = OfTrainingViews(perturbed, gains);
    std::optional<FoundCameras> settled;
    gs::TrainOptions options = setup.options;
    options.seed = std::stoull(seed);
    for (const Method& method : methods) {
      const gs::Scene& given = method.is_unperturbed() ? setup.scene : perturbed;
      const auto [result, products] =
          trainings.Run(method, method.perturbs_late() ? setup.scene : given, given, options);
      if (arguments.Flag("reports", "") == "yes") fmt::print("{}\n", result.lm_report);
      FoundCameras found = FoundBy(result, given);
      const TrueCameras truth{setup.scene, method.is_unperturbed() ? GainsOf(setup.scene, {}) : gains};
      Row row{{"scene", setup.scene_name}, {"degrees", by.degrees}, {"centre", by.centre},  {"exposure", by.exposure},
              {"focal", by.focal},         {"seed", seed},          {"method", method.name}};
      Append(MeasureCameras(truth, found, settled), &row);
      Append(MeasureImages(result, found, given, options), &row);
      Append({{"adam_seconds", result.adam_seconds},
              {"end_seconds", result.lm_seconds},
              {"end_products", static_cast<double>(products)}},
             &row);
      report.Add(std::move(row));
      if (method.settles()) settled = std::move(found);
      for (const std::string& note : result.notes) fmt::print("{}: {}\n", method.name, note);
      report.WriteJson(arguments.Flag("json", ""));
    }
  }
  report.Finish(arguments.Flag("json", ""));
  return 0;
}

}  // namespace
}  // namespace vesta::bench

int main(int argc, char** argv) { return vesta::bench::ReportErrors("cameras", vesta::bench::Main, argc, argv); }
