// eval: the image quality of a splat.
#include "apps/commands.h"
#include "apps/doubts.h"
#include "apps/metrics_json.h"
#include "apps/outputs.h"
#include "apps/posed_model.h"
#include "apps/print.h"
#include "kernels/core/atomic_file.h"
#include "kernels/core/parallel.h"
#include "problems/gaussian_splatting/evaluate/metrics.h"

namespace vesta::app {

int RunEval(const CommandLine& line) {
  const Flags& flags = line.flags;
  RunFiles files = FilesOf(line);
  if (!flags.json.empty()) files.Writes(Given("json", flags.json), flags.json);
  files.Check();
  if (!flags.json.empty()) CheckWritable("json", flags.json);
  const PosedModel posed = LoadPosedModel(line);
  files.ReadsScene(line.arguments[1], posed.scene);
  files.Check();
  gs::Renderer renderer(ToDouble(posed.model.background), gs::NearPlane(posed.scene));
  const gs::Evaluation evaluation = renderer.Evaluate(posed.model, posed.scene);
  Print("{:<6}{:>6}{:>9}{:>9}\n", "views", "", "PSNR", "SSIM");
  const auto print_row = [](const char* name, const gs::Quality& quality) {
    Print("{:<6}{:>6}{:>9}{:>9}\n", name, quality.views, Figure(quality.psnr, 3), Figure(quality.ssim, 4));
  };
  print_row("test", evaluation.test);
  print_row("train", evaluation.train);
  Print("cost {:.6f}, {} Gaussians of SH degree {}\n", evaluation.cost, posed.model.count, posed.model.sh_degree);
  Print("{}", DoubtOfScene(evaluation.train.psnr));
  if (!flags.json.empty()) {
    WriteFileAtomically(flags.json, EvaluationJson(evaluation, posed.model, {.threads = NumThreads()}));
  }
  return 0;
}

}  // namespace vesta::app
