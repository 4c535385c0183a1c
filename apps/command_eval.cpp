// eval: the image quality of a splat.
#include <fmt/format.h>

#include "apps/commands.h"
#include "apps/metrics_json.h"
#include "apps/output_folder.h"
#include "apps/posed_model.h"
#include "kernels/core/parallel.h"
#include "problems/gaussian_splatting/evaluate/metrics.h"

namespace vesta::app {

int RunEval(const CommandLine& line) {
  const Flags& flags = line.flags;
  if (!flags.json.empty()) CheckWritable("json", flags.json);
  const PosedModel posed = LoadPosedModel(line);
  gs::Renderer renderer(ToDouble(posed.model.background), gs::NearPlane(posed.scene));
  const gs::Evaluation evaluation = renderer.Evaluate(posed.model, posed.scene);
  fmt::print("{:<6}{:>6}{:>9}{:>9}\n", "views", "", "PSNR", "SSIM");
  fmt::print("{:<6}{:>6}{:>9.3f}{:>9.4f}\n", "test", evaluation.test.views, evaluation.test.psnr, evaluation.test.ssim);
  fmt::print("{:<6}{:>6}{:>9.3f}{:>9.4f}\n", "train", evaluation.train.views, evaluation.train.psnr,
             evaluation.train.ssim);
  fmt::print("cost {:.6f}, {} Gaussians of SH degree {}\n", evaluation.cost, posed.model.count, posed.model.sh_degree);
  fmt::print("{}", DoubtOfScene(evaluation.train.psnr));
  if (!flags.json.empty()) WriteEvaluationJson(flags.json, evaluation, posed.model, {.threads = NumThreads()});
  return 0;
}

}  // namespace vesta::app
