#include "apps/posed_model.h"

#include <fmt/format.h>

#include "apps/flags.h"
#include "apps/train_flags.h"
#include "problems/gaussian_splatting/io/load_scene.h"

namespace vesta::app {

gs::Scene LoadSceneOver(const std::string& path, const std::array<float, 3>& background) {
  gs::LoadSceneOptions options;
  options.downscale = FLAGS_downscale;
  options.background = background;
  options.memory_budget_gib = FLAGS_memory_budget;
  options.random_points.seed = FLAGS_seed;
  return gs::LoadScene(path, options);
}

PosedModel LoadPosedModel(const std::string& ply, const std::string& scene) {
  PosedModel posed;
  posed.model = gs::ReadSplatPly(ply);
  if (IsSet("background")) posed.model.background = BackgroundFromFlag();
  posed.scene = LoadSceneOver(scene, posed.model.background);
  return posed;
}

std::string DoubtOfScene(double train_psnr) {
  constexpr double kAnyTwoPhotographs = 14;  // about what pictures of two different things have
  if (train_psnr >= kAnyTwoPhotographs) return "";
  return fmt::format(
      "The splat meets the photographs at {:.1f} dB only: is it of this scene, in the same frame and scale, and over "
      "--background?\n",
      train_psnr);
}

std::array<double, 3> ToDouble(const std::array<float, 3>& color) {
  return {static_cast<double>(color[0]), static_cast<double>(color[1]), static_cast<double>(color[2])};
}

}  // namespace vesta::app
