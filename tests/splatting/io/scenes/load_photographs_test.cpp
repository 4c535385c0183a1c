// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/bytes/bytes.h"
#include "splatting/io/images/image_file.h"
#include "splatting/io/scenes/load_scene.h"
#include "splatting/io/scenes/photographs.h"
#include "tests/splatting/io/test_images.h"
#include "tests/splatting/io/test_scene.h"

namespace vesta::gs {
namespace {

constexpr int kViews = 9;
constexpr double kBytes = 3 * sizeof(float) * 60 * 40;  // of one decoded photograph

// Different photographs with distortion; one with a mask, one of half the size.
class LoadPhotographsTest : public testing::Test {
 protected:
  LoadPhotographsTest() {
    std::filesystem::create_directories(folder_ / "images");
    ColmapModel model = ExampleModel();
    model.images.clear();
    for (std::uint32_t i = 0; i < kViews; ++i) {
      ColmapImage image;
      image.id = i;
      image.camera_id = 1;
      image.name = "view" + std::to_string(i) + ".png";
      model.images.push_back(image);
      Image picture(i == 5 ? 30 : 60, i == 5 ? 20 : 40);
      for (std::size_t k = 0; k < picture.rgb.size(); ++k) {
        picture.rgb[k] = static_cast<float>((k * (i + 3)) % 256) / 255.0f;
      }
      SavePng(ImagePath(i), picture);
    }
    std::filesystem::create_directories(folder_ / "masks");
    Image mask(60, 40);
    for (float& value : mask.rgb) value = 1;
    for (int c = 0; c < 3; ++c) mask.plane(c)[700] = 0;
    SavePng(folder_ / "masks/view2.png", mask);
    WriteColmapModel(model, folder_ / "sparse/0", ColmapFormat::kBinary);
    model_ = model;
  }
  std::string ImagePath(std::uint32_t i) const { return folder_ / ("images/view" + std::to_string(i) + ".png"); }
  Scene Load(double photographs, int downscale = 1) const {
    LoadSceneOptions options;
    options.photographs_bytes = photographs * kBytes;
    options.downscale = downscale;
    return LoadScene(folder_.path(), options);
  }
  static void ExpectSamePhotographs(const Scene& a, const Scene& b) {
    ASSERT_EQ(a.views.size(), b.views.size());
    for (std::size_t v = 0; v < a.views.size(); ++v) {
      EXPECT_EQ(a.views[v].Photograph()->rgb, b.views[v].Photograph()->rgb) << v;
      EXPECT_EQ(a.views[v].Photograph()->mask, b.views[v].Photograph()->mask) << v;
      EXPECT_EQ(a.views[v].camera.width, b.views[v].camera.width);
      EXPECT_EQ(a.views[v].camera.lens.cx, b.views[v].camera.lens.cx);
    }
  }
  void Distort() {
    model_.cameras[0].model = ColmapCameraModel::kOpenCv;
    model_.cameras[0].distortion = {.radial = {-0.2, 0.03}, .tangential = {0.001, 0.002}};
    WriteColmapModel(model_, folder_ / "sparse/0", ColmapFormat::kBinary);
  }
  TempFolder folder_;
  ColmapModel model_;
};

TEST_F(LoadPhotographsTest, AreTheSameWhereverTheyAre) {
  for (const int downscale : {1, 3}) {
    const Scene all = Load(100, downscale);
    EXPECT_EQ(all.photographs, nullptr);
    EXPECT_FALSE(all.views[4].image.empty());
    for (const double photographs : {2.0, 4.5}) {
      const Scene stored = Load(photographs / downscale / downscale, downscale);
      ASSERT_NE(stored.photographs, nullptr);
      EXPECT_TRUE(stored.views[4].image.empty());
      for (int epoch = 0; epoch < 2; ++epoch) ExpectSamePhotographs(all, stored);
      // A background decode may add one photograph.
      EXPECT_LE(stored.photographs->kept_bytes(), stored.photographs->budget_bytes() + kBytes);
    }
  }
}

TEST_F(LoadPhotographsTest, AreUndistortedAnewEachTime) {
  Distort();
  const Scene all = Load(100), stored = Load(4);
  ASSERT_NE(stored.photographs, nullptr);
  EXPECT_TRUE(stored.views[1].distortion.is_none());
  for (int epoch = 0; epoch < 2; ++epoch) ExpectSamePhotographs(all, stored);
}

// Eight full-size photographs, a quarter of one, and a mask of one byte per pixel.
TEST_F(LoadPhotographsTest, TheLastByteDecides) {
  const double bytes = 8.25 * kBytes + 60 * 40;
  EXPECT_EQ(Load(bytes / kBytes).photographs, nullptr);
  const Scene stored = Load((bytes - 1) / kBytes);
  ASSERT_NE(stored.photographs, nullptr);
  EXPECT_GT(stored.photographs->kept_bytes(), 7 * kBytes) << "photographs that fit are decoded only once";
  EXPECT_THAT(stored.notes,
              testing::Contains(testing::StartsWith("9 photographs take 0 MiB, but at most 0 MiB stay in memory")));
}

// The image files determine the size, not the cameras.
TEST_F(LoadPhotographsTest, LessThanTwoAreRefused) {
  EXPECT_THAT([&] { Load(1.9); }, ThrowsError(kOutOfMemory, "--photographs_mib", "0.1"));
  model_.cameras[0].camera = ResizeCamera(model_.cameras[0].camera, 6000, 4000);
  WriteColmapModel(model_, folder_ / "sparse/0", ColmapFormat::kBinary);
  EXPECT_NE(Load(2).photographs, nullptr);
  WriteBytes(ImagePath(4), "not an image");
  EXPECT_THAT([&] { Load(2); }, ThrowsError(kBadFile, "view4.png"));
}

// At the start, only as many photographs are decoded as the store can keep.
TEST_F(LoadPhotographsTest, BeyondTheBudgetHeadersAreRead) {
  const std::string damaged = ImagePath(8), whole = ReadFile(damaged);
  WriteBytes(damaged, whole.substr(0, whole.size() / 2));
  EXPECT_THAT([&] { Load(100); }, ThrowsError(kBadFile, "view8.png"));
  const Scene stored = Load(2);
  EXPECT_EQ(stored.views[8].camera.width, 60);
  EXPECT_THAT([&] { stored.views[8].Photograph(); }, ThrowsError(kBadFile, "view8.png"));
  WriteBytes(damaged, whole);
  SavePng(damaged, Image(60, 60));
  EXPECT_THAT([&] { Load(2); }, ThrowsError(kBadFile, "view8.png", "60"));
}

TEST_F(LoadPhotographsTest, HeadersForetellWhatIsRead) {
  for (const bool is_distorted : {false, true}) {
    if (is_distorted) Distort();
    for (const int downscale : {1, 3}) {
      View view;
      view.camera = model_.cameras[0].camera;
      view.distortion = model_.cameras[0].distortion;
      const PhotographRule rule{.downscale = downscale, .alpha_is_mask = is_distorted};
      for (const std::uint32_t i : {1u, 2u, 5u}) {
        view.image_path = ImagePath(i);
        view.mask_path = i == 2 ? (folder_ / "masks/view2.png") : "";
        const PredictedPhotograph foreseen = PredictPhotograph(view, rule);
        const ViewPhotograph read = ReadPhotograph(view, rule);
        EXPECT_EQ(foreseen.camera.width, read.image.width);
        EXPECT_EQ(foreseen.camera.height, read.image.height);
        EXPECT_EQ(foreseen.camera.lens.cx, read.camera.lens.cx);
        // The prediction assumes an alpha channel, which these images do not have.
        const double expected = BytesOf(read.image), pixels = static_cast<double>(read.image.num_pixels());
        const double alpha_bytes = !rule.alpha_is_mask ? sizeof(float) : read.image.mask.empty() ? 1 : 0;
        EXPECT_EQ(foreseen.bytes, expected + alpha_bytes * pixels);
        EXPECT_GE(foreseen.work_bytes, read.work_bytes);
        EXPECT_LE(foreseen.work_bytes, 5 * read.work_bytes) << "the bound is not too loose";
      }
    }
  }
}

TEST_F(LoadPhotographsTest, OneThatIsGoneOrOfAnotherSizeLaterIsNamed) {
  const Scene stored = Load(2);
  const auto look_at_all = [&] {
    for (const View& view : stored.views) view.Photograph();
  };
  SavePng(ImagePath(6), Image(120, 80));
  EXPECT_THAT(look_at_all, ThrowsError(kBadFile, "view6.png"));
  std::filesystem::remove(ImagePath(6));
  EXPECT_THAT(look_at_all, ThrowsError(kNotFound, "view6.png"));
  EXPECT_EQ(stored.views[7].Photograph()->width, 60) << "the other photographs are still readable";
}

}  // namespace
}  // namespace vesta::gs
