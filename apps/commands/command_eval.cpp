// SPDX-License-Identifier: Apache-2.0
// eval: measures the image quality of a splat.
#include <optional>

#include "apps/cli/outputs.h"
#include "apps/cli/print.h"
#include "apps/commands/commands.h"
#include "apps/inputs/input_warnings.h"
#include "apps/inputs/scene_and_splat.h"
#include "apps/training/metrics_json.h"
#include "kernels/core/files.h"
#include "kernels/core/parallel.h"
#include "splatting/cameras/alignment/align_view.h"
#include "splatting/evaluate/evaluation.h"

namespace vesta::app {
namespace {

void PrintQuality(const char* name, const gs::Quality& quality) {
  Print("{:<8}{:>4}{:>9}{:>9}\n", name, quality.views, Figure(quality.psnr, 3), Figure(quality.ssim, 4));
}

// Measures the test views again with fitted cameras; nothing for Align::kNone.
std::optional<gs::AlignedEvaluation> MeasureAligned(const PosedModel& posed, Align align) {
  if (align == Align::kNone) return std::nullopt;
  gs::AlignOptions options;
  options.free.color = align == Align::kPoseAndColor;
  options.background = ToDouble(posed.model.background);
  options.near = gs::NearPlane(posed.scene);
  return gs::EvaluateAligned(posed.model, posed.scene, options);
}

void PrintAligned(const gs::AlignedEvaluation& aligned) {
  PrintQuality("aligned", aligned.whole);
  if (aligned.right.views > 0) {
    PrintQuality(" right", aligned.right);
    PrintQuality(" exposed", aligned.right_exposed);
  }
  if (aligned.whole.views == 0) return;
  Print("aligned: test cameras fitted to the splat, moved by {:.4f} degrees, {:.3f} pixels (medians)", aligned.degrees,
        aligned.pixels);
  if (aligned.not_found > 0) Print("; {} could not be fitted and kept their cameras", aligned.not_found);
  Print("\n");
  if (aligned.right.views > 0)
    Print("right: right halves of the images; exposed: with the exposure fitted on the left halves\n");
}

}  // namespace

int RunEval(const CommandLine& line) {
  const Flags& flags = line.flags;
  RunFiles files = FilesOf(line);
  if (!flags.json.empty()) files.Writes(FlagText("json", flags.json), flags.json);
  files.Check();
  if (!flags.json.empty()) CheckWritable("json", flags.json);
  const PosedModel posed = LoadPosedModel(line);
  files.ReadsScene(line.arguments[1], posed.scene);
  files.Check();
  gs::Renderer renderer(ToDouble(posed.model.background), gs::NearPlane(posed.scene));
  const gs::Evaluation evaluation = renderer.Evaluate(posed.model, posed.scene);
  Print("{:<8}{:>4}{:>9}{:>9}\n", "views", "", "PSNR", "SSIM");
  PrintQuality("test", evaluation.test);
  PrintQuality("train", evaluation.train);
  const std::optional<gs::AlignedEvaluation> aligned = MeasureAligned(posed, flags.align);
  if (aligned) PrintAligned(*aligned);
  Print("training loss {}, {} Gaussians of SH degree {}\n", Figure(evaluation.cost, 6), posed.model.count,
        posed.model.sh_degree);
  if (evaluation.train.views > 0) Print("{}", WarningOfScene(evaluation.train.psnr));
  if (!flags.json.empty()) {
    WriteFileAtomically(
        flags.json, EvaluationJson(evaluation, aligned ? &*aligned : nullptr, posed.model, {.threads = NumThreads()}));
  }
  return 0;
}

}  // namespace vesta::app
