// SPDX-License-Identifier: Apache-2.0
#include "tests/apps/tiny_scene.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "splatting/io/images/image_file.h"

namespace vesta::test {
namespace {

// A smooth pattern that moves from view to view.
gs::Image Picture(int view) {
  gs::Image image(kTinyWidth, kTinyHeight);
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < kTinyHeight; ++y) {
      for (int x = 0; x < kTinyWidth; ++x) {
        const double phase = 0.3 * x + 0.2 * (c + 1) * y + 0.1 * view + c;
        image.plane(c)[y * kTinyWidth + x] = static_cast<float>(0.5 + 0.4 * std::sin(phase));
      }
    }
  }
  return image;
}

}  // namespace

gs::ColmapModel TinyModel() {
  gs::ColmapModel model;
  model.cameras.push_back(
      {.id = 1, .camera = {kTinyWidth, kTinyHeight, {40, 40, kTinyWidth / 2.0, kTinyHeight / 2.0}}, .distortion = {}});
  for (int i = 0; i < kTinyViews; ++i) {
    const double half_angle = 0.03 * (i - 0.5 * kTinyViews);
    model.images.push_back({.id = static_cast<std::uint32_t>(i + 1),
                            .rotation = {std::cos(half_angle), 0, std::sin(half_angle), 0},
                            .translation = {0, 0, 4},
                            .camera_id = 1,
                            .name = fmt::format("{:03}.png", i)});
  }
  for (int i = 0; i < 60; ++i) {
    model.points.push_back({.id = static_cast<std::uint64_t>(i + 1),
                            .position = {std::sin(1.0 * i), 0.7 * std::sin(2.3 * i + 1), 0.5 * std::cos(3.1 * i)},
                            .color = {static_cast<std::uint8_t>(4 * i), 128, static_cast<std::uint8_t>(255 - 4 * i)}});
  }
  return model;
}

void WriteTinyScene(const std::string& scene, const gs::ColmapModel& model) {
  const std::filesystem::path folder = scene;
  std::filesystem::create_directories(folder / "images");
  for (int i = 0; i < kTinyViews; ++i) {
    gs::SavePng((folder / "images" / fmt::format("{:03}.png", i)).string(), Picture(i));
  }
  gs::WriteColmapModel(model, (folder / "sparse" / "0").string(), gs::ColmapFormat::kBinary);
}

}  // namespace vesta::test
