#include "apps/posed_model.h"

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

std::array<double, 3> ToDouble(const std::array<float, 3>& color) {
  return {static_cast<double>(color[0]), static_cast<double>(color[1]), static_cast<double>(color[2])};
}

}  // namespace vesta::app
