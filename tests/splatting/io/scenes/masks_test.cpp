// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/images/image_file.h"
#include "splatting/io/scenes/load_scene.h"
#include "splatting/io/scenes/photographs.h"
#include "tests/splatting/io/nine_views.h"

namespace vesta::gs {
namespace {

constexpr int kGreyPng = 0, kRgbaPng = 6;  // colour types of libpng

// 0 (black) left of `white_from`; 1, the darkest other value, elsewhere.
std::string MaskPng(int width, int height, int white_from) {
  PngSource source{width, height, kGreyPng, 8, false, {}};
  for (int i = 0; i < width * height; ++i) source.bytes.push_back(i % width < white_from ? 0 : 1);
  return EncodePng(source);
}

// A scene with photographs in a subfolder.
class MaskScene : public NineViews {
 protected:
  MaskScene() : NineViews("a/view", ".jpg") {}
  std::vector<View> Load(int downscale = 1) const {
    LoadSceneOptions options;
    options.downscale = downscale;
    return LoadScene(folder_.path(), options).views;
  }
};

TEST_F(MaskScene, MasksAreFoundByName) {
  WriteBytes(folder_ / "masks/a/view1.jpg.png", MaskPng(60, 40, 20));
  WriteBytes(folder_ / "masks/a/view2.png", MaskPng(60, 40, 30));
  WriteBytes(folder_ / "masks/view3.jpg.png", MaskPng(60, 40, 30));
  WriteBytes(folder_ / "masks/a/view4.jpg.mask.png", MaskPng(60, 40, 15));
  const std::vector<View> views = Load();
  EXPECT_TRUE(views[0].image.mask.empty() && views[3].image.mask.empty());
  ASSERT_EQ(views[1].image.mask.size(), 60u * 40u);
  EXPECT_EQ(views[1].image.mask[60 * 5 + 19], 0);
  EXPECT_EQ(views[1].image.mask[60 * 5 + 20], 1) << "every value above black counts";
  EXPECT_EQ(UnmaskedPixels(views[1].image), 40u * 40u);
  EXPECT_EQ(UnmaskedFraction(views[2].image), 0.5);
  EXPECT_EQ(UnmaskedFraction(views[4].image), 0.75);
  EXPECT_EQ(views[1].image.rgb, views[0].image.rgb) << "the photograph is unchanged";
  EXPECT_THAT(
      LoadScene(folder_.path()).notes,
      testing::ElementsAre("3 of 9 images have a mask; black pixels of a mask are neither trained on nor measured"));
}

TEST_F(MaskScene, MasksFollowTheSizeOfTheImage) {
  WriteBytes(folder_ / "masks/a/view1.jpg.png", MaskPng(30, 20, 10));
  WriteBytes(folder_ / "masks/a/view2.jpg.png", MaskPng(120, 80, 41));
  EXPECT_EQ(UnmaskedPixels(Load()[1].image), 40u * 40u);
  EXPECT_EQ(UnmaskedPixels(Load()[2].image), 40u * 40u) << "scaled by nearest neighbour";
  const Image third = Load(3)[1].image;  // 20 x 13: a pixel counts if it covers no masked pixel
  EXPECT_EQ(third.mask[6], 0);
  EXPECT_EQ(third.mask[7], 1);
  EXPECT_EQ(UnmaskedPixels(third), 13u * 13u);
}

TEST_F(MaskScene, MasksAreUndistortedWithTheImage) {
  model_.cameras[0].distortion.radial = {0.2};
  WriteModel();
  WriteBytes(folder_ / "masks/a/view1.jpg.png", MaskPng(60, 40, 30));
  const View view = Load()[1];
  ASSERT_EQ(view.image.mask.size(), view.image.num_pixels());
  EXPECT_NEAR(UnmaskedFraction(view.image), 0.5, 0.05);
  // On the axis the mask border stays at 30; the principal point is 30.5.
  const auto row = static_cast<std::size_t>(view.camera.lens.cy) * static_cast<std::size_t>(view.image.width);
  const auto border = static_cast<std::size_t>(view.camera.lens.cx);
  EXPECT_EQ(view.image.mask[row + border - 2], 0);
  EXPECT_EQ(view.image.mask[row + border + 2], 1);
}

TEST_F(MaskScene, WhatIsNotOpaqueDoesNotCount) {
  PngSource source{60, 40, kRgbaPng, 8, false, {}};
  for (int i = 0; i < 60 * 40; ++i) {
    const auto alpha = static_cast<std::uint8_t>(i % 60 < 10 ? 0 : i % 60 < 15 ? 128 : 255);
    source.bytes.insert(source.bytes.end(), {50, 100, 200, alpha});
  }
  WriteBytes(folder_ / "images/a/view1.jpg", EncodePng(source));
  const Image image = Load()[1].image;
  EXPECT_EQ(UnmaskedPixels(image), 45u * 40u);
  EXPECT_EQ(image.plane(1)[30], 100 / 255.0f);
}

TEST_F(MaskScene, MasksThatCannotBeUsedAreRefused) {
  const std::string mask = folder_ / "masks/a/view4.jpg.png";
  WriteBytes(mask, "no image");
  EXPECT_THAT([&] { Load(); }, ThrowsError(kBadFile, mask));
  WriteBytes(mask, MaskPng(40, 60, 10));
  EXPECT_THAT([&] { Load(); }, ThrowsError(kBadFile, mask, "40", "60"));
  WriteBytes(mask, MaskPng(60, 40, 60));
  EXPECT_THAT([&] { Load(); }, ThrowsError(kBadFile, mask));
  std::filesystem::remove(mask);
  WriteBytes(folder_ / "images/a/view4.jpg",
             EncodePng({60, 40, kRgbaPng, 8, false, std::vector<std::uint8_t>(60 * 40 * 4, 0)}));
  EXPECT_THAT([&] { Load(); }, ThrowsError(kBadFile, "view4.jpg"));
}

TEST_F(MaskScene, AFolderOfMasksOfOtherImagesIsNoted) {
  WriteBytes(folder_ / "mask/view4.png", MaskPng(60, 40, 10));
  EXPECT_THAT(
      LoadScene(folder_.path()).notes,
      testing::ElementsAre("mask/ has no mask with the name of an image, such as mask/a/view0.jpg.png: images are "
                           "used without masks"));
}

TEST_F(MaskScene, FramesOfANerfSceneNameTheirOwn) {
  std::filesystem::remove_all(folder_ / "sparse");
  const auto write = [&](const std::string& mask) {
    WriteBytes(folder_ / "transforms.json",
               R"({"camera_angle_x": 1.0, "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]], "frames": [)"
               R"({"file_path": "images/a/view0.jpg", "mask_path": ")" +
                   mask +
                   R"("},)"
                   R"({"file_path": "images/a/view1.jpg"}]})");
  };
  WriteBytes(folder_ / "of/zero.png", MaskPng(60, 40, 15));
  write("of/zero.png");
  EXPECT_EQ(UnmaskedFraction(Load()[0].image), 0.75);
  EXPECT_TRUE(Load()[1].image.mask.empty());
  write("of/none.png");
  EXPECT_THAT([&] { Load(); }, ThrowsError(kNotFound, "of/none.png", "mask"));
  write("../zero.png");
  EXPECT_THAT([&] { Load(); }, ThrowsError(kBadFile, "0", "../zero.png"));
  // A transparent rendering is composited, and all pixels count.
  std::vector<std::uint8_t> clear(60 * 40 * 4, 0);
  WriteBytes(folder_ / "images/a/view1.jpg", EncodePng({60, 40, kRgbaPng, 8, false, clear}));
  write("of/zero.png");
  EXPECT_TRUE(Load()[1].image.mask.empty());
}

}  // namespace
}  // namespace vesta::gs
