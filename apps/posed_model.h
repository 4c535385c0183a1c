// A splat and the scene it shows: what refine, eval and render start from.
#pragma once

#include <array>
#include <string>

#include "problems/gaussian_splatting/io/ply.h"
#include "problems/gaussian_splatting/model/scene.h"

namespace vesta::app {

// Loads the scene as --downscale says; images with an alpha channel lie over the given colour.
gs::Scene LoadSceneOver(const std::string& path, const std::array<float, 3>& background);

struct PosedModel {
  gs::SplatModel model;  // its background is the one to render over
  gs::Scene scene;
};

// Reads both. Background: --background where given, else what the .ply states, else black.
PosedModel LoadPosedModel(const std::string& ply, const std::string& scene);

// A line that doubts whether splat and scene belong together, where the photographs are met so badly (the mean PSNR of
// the training views, dB) that they hardly can; else empty.
std::string DoubtOfScene(double train_psnr);

std::array<double, 3> ToDouble(const std::array<float, 3>& color);

}  // namespace vesta::app
