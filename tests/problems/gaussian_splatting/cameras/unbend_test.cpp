#include "problems/gaussian_splatting/cameras/unbend.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "kernels/gaussian_splatting/lens_jacobian.h"
#include "kernels/gaussian_splatting/pose_jacobian.h"
#include "problems/gaussian_splatting/cameras/bend_derivative.h"
#include "problems/gaussian_splatting/cameras/bent_as_found.h"
#include "problems/gaussian_splatting/cameras/seen_view.h"
#include "problems/gaussian_splatting/cameras/view_curvature.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "problems/gaussian_splatting/model/to_kernel.h"
#include "problems/gaussian_splatting/train/view_passes.h"
#include "tests/problems/gaussian_splatting/cameras/bent_photograph.h"
#include "tests/problems/gaussian_splatting/cameras/perturbed_view.h"

namespace vesta::gs {
namespace {

const Camera kCamera{160, 120, {.fx = 130, .fy = 140, .cx = 85, .cy = 58}};

// Smooth, and nowhere the same.
Image Waves() {
  Image image(kCamera.width, kCamera.height);
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        image.plane(c)[y * image.width + x] =
            static_cast<float>(0.5 + 0.2 * std::sin(0.15 * x + c) + 0.2 * std::cos(0.11 * y));
      }
    }
  }
  return image;
}

TEST(Unbend, TakesBackWhatTheLensDid) {
  const Image straight = Waves();
  const RadialCoefficients radial{0.05, -0.02};
  const Image bent = test::Bent(straight, kCamera, radial), back = Unbent(bent, kCamera, radial);
  ASSERT_EQ(back.mask.size(), straight.num_pixels());
  double before = 0, after = 0;
  for (std::size_t i = 0; i < straight.rgb.size(); ++i) {
    // The border has no neighbours to interpolate between, and beyond it nothing was photographed.
    const std::size_t pixel = i % straight.num_pixels();
    const auto column = static_cast<int>(pixel) % straight.width, row = static_cast<int>(pixel) / straight.width;
    if (column < 8 || row < 8 || column >= straight.width - 8 || row >= straight.height - 8) continue;
    before = std::max<double>(before, std::abs(bent.rgb[i] - straight.rgb[i]));
    after = std::max<double>(after, std::abs(back.rgb[i] - straight.rgb[i]));
  }
  EXPECT_GT(before, 0.02);
  EXPECT_LT(after, 0.001);
}

TEST(Unbend, MasksWhatThePhotographDoesNotShow) {
  const Image image = Waves();
  const auto left_out = [&](double k1) {
    const Image unbent = Unbent(image, kCamera, {k1, 0});
    return std::ranges::count(unbent.mask, std::uint8_t{0});
  };
  EXPECT_EQ(left_out(0), 0);
  EXPECT_EQ(left_out(-0.05), 0) << "inside of it";
  EXPECT_GT(left_out(0.05), 0);
  EXPECT_LT(left_out(0.05), image.width * image.height / 10);
  // What took no part before takes none.
  Image masked = image;
  masked.mask.assign(masked.num_pixels(), 1);
  std::fill_n(masked.mask.begin(), 40 * masked.width, std::uint8_t{0});
  const Image unbent = Unbent(masked, kCamera, {-0.05, 0});
  EXPECT_TRUE(std::all_of(unbent.mask.begin(), unbent.mask.begin() + 39 * masked.width,
                          [](std::uint8_t counts) { return counts == 0; }));
  EXPECT_EQ(unbent.mask[unbent.num_pixels() - 80], 1);
}

TEST(Unbend, MovesTheCornerByWholeFifthsOfAPixel) {
  const double none[2] = {1e-6, -1e-6}, some[2] = {0.031, -0.017};
  EXPECT_EQ(Visible(kCamera, none), RadialCoefficients{});
  const RadialCoefficients visible = Visible(kCamera, some);
  EXPECT_LE(std::abs(CornerBend(kCamera, visible.data()) - CornerBend(kCamera, some)), 0.2);
  EXPECT_EQ(Visible(kCamera, visible.data()), visible);
  EXPECT_NEAR(CornerOf(kCamera), std::hypot(85 / 130.0, 62 / 140.0), 1e-15);
  EXPECT_NEAR(CornerBend({200, 100, {.fx = 100, .fy = 100, .cx = 100, .cy = 50}}, some),
              100 * std::pow(1.25, 1.5) * (0.031 - 0.017 * 1.25), 1e-9);
}

TEST(BendDerivative, IsThatOfTheBentImage) {
  const Image image = Waves();
  constexpr double kStep = 0.01;
  for (int k = 0; k < kRadialTangent; ++k) {
    RadialCoefficients more{}, less{};
    more[static_cast<std::size_t>(k)] = kStep, less[static_cast<std::size_t>(k)] = -kStep;
    const Image above = test::Bent(image, kCamera, more), below = test::Bent(image, kCamera, less);
    std::vector<float> derivative(image.rgb.size());
    const BendDerivative<float> of{image.rgb.data(), nullptr, derivative.data(), image.width, image.height,
                                   kCamera.lens,     k + 1};
    for (Index pixel = 0; pixel < static_cast<Index>(image.num_pixels()); ++pixel) of(pixel);
    double most = 0, off = 0;
    for (std::size_t i = 0; i < derivative.size(); ++i) {
      const auto pixel = static_cast<int>(i % image.num_pixels()), column = pixel % image.width,
                 row = pixel / image.width;
      if (column < 4 || row < 4 || column >= image.width - 4 || row >= image.height - 4) continue;
      most = std::max<double>(most, std::abs(derivative[i]));
      off = std::max(off, std::abs(derivative[i] - (above.rgb[i] - below.rgb[i]) / (2 * kStep)));
    }
    EXPECT_GT(most, 0.5);
    EXPECT_LT(off, 0.02 * most) << k;
  }
}

// What is left out may show anything.
TEST(BendDerivative, LooksAtNothingThatIsLeftOut) {
  Image image = Waves();
  image.mask.assign(image.num_pixels(), 1);
  constexpr std::size_t kLeftOut = 20 * 160 + 30;
  image.mask[kLeftOut] = 0;
  const auto derivative = [&] {
    std::vector<float> values(image.rgb.size());
    const BendDerivative<float> of{
        image.rgb.data(), image.mask.data(), values.data(), image.width, image.height, kCamera.lens, 1};
    for (Index pixel = 0; pixel < static_cast<Index>(image.num_pixels()); ++pixel) of(pixel);
    for (int c = 0; c < 3; ++c) values[static_cast<std::size_t>(c) * image.num_pixels() + kLeftOut] = 0;
    return values;
  };
  const std::vector<float> before = derivative();
  for (int c = 0; c < 3; ++c) image.plane(c)[kLeftOut] = 7;
  EXPECT_EQ(derivative(), before);
  image.mask[kLeftOut] = 1;
  EXPECT_NE(derivative(), before);
}

// A splat as it is in truth and the bent photograph of a wide lens: what Gauss-Newton makes of what the passes left,
// the pinhole held fast.
TEST(BendDerivative, LeadsToTheBendOfAPhotograph) {
  using B = CpuBackend<float>;
  SplatModel model = test::RandomModel(300, 0, 7);
  test::Widen(2, &model);
  Scene scene = test::RingOfCameras(3, 160, 120, true);
  View& view = scene.views[0];
  view.camera.lens.fx = view.camera.lens.fy = 110;
  test::RenderTruth(model, 0, &scene);
  constexpr FreeUnknowns kFree{.pose = false, .color = false, .lens = true, .radial = true};
  const RadialCoefficients radial{0.08, -0.03};
  const Image bent = test::Bent(view.image, view.camera, radial);
  const splat::Model<float> kernel = ToKernelModel(model);
  LensChange found;
  for (int step = 0; step < 8; ++step) {
    const Image photograph = Unbent(bent, view.camera, {found.radial[0], found.radial[1]});
    const TargetView<B> target{ToPosedCamera(view, NearPlane(scene)), ValuesOf(photograph), MaskOf(photograph)};
    ViewPasses<B> passes;
    std::vector<float> g(model.data.size());
    const double background[3] = {};
    passes.AddGradient(kernel, target, background, g.data());
    const splat::Lens& about = view.camera.lens;
    const SeenView<B> seen{
        0, kernel, target, about, passes.view, passes.workspace.splat_sums.data(), passes.image, passes.image_gradient};
    const std::vector<double> gradient = GradientOf(seen, kFree), H = ViewCurvature(kFree, {}, kernel, target, about);
    const double a = H[28], b = H[29], c = H[35];  // the last two rows and columns of six
    found.radial[0] -= (c * gradient[4] - b * gradient[5]) / (a * c - b * b);
    found.radial[1] -= (a * gradient[5] - b * gradient[4]) / (a * c - b * b);
  }
  EXPECT_LT(test::BendLeft(view.camera, radial, found), test::BendLeft(view.camera, radial, {}) / 10);
}

// What a lens was found to be, in the terms of the photographs' own camera.
class LensOfPhotographs : public testing::Test {
 protected:
  // The farthest that a direction is seen from where it should be, pixels of the file.
  static double Apart(const BentCamera& given, const LensChange& found) {
    const BentCamera as_found = FitBent(given, kCamera, found).camera;
    const splat::Lens now = found.Of(kCamera.lens);
    double most = 0;
    for (double u = 0; u <= kCamera.width; u += 8) {
      for (double v = 0; v <= kCamera.height; v += 8) {
        const double X = (u - now.cx) / now.fx, Y = (v - now.cy) / now.fy;
        // To the given pinhole's photograph, bent about its principal point, from there to the file.
        const double x = (u - kCamera.lens.cx) / kCamera.lens.fx, y = (v - kCamera.lens.cy) / kCamera.lens.fy;
        const double r2 = x * x + y * y, factor = 1 + r2 * (found.radial[0] + r2 * found.radial[1]);
        const auto want = Distort(given.distortion, factor * x, factor * y), have = Distort(as_found.distortion, X, Y);
        const auto& lens = as_found.camera.lens;
        const auto& file = given.camera.lens;
        most = std::max(most, std::hypot(lens.fx * have[0] + lens.cx - file.fx * want[0] - file.cx,
                                         lens.fy * have[1] + lens.cy - file.fy * want[1] - file.cy));
      }
    }
    return most;
  }
  // Twice the size of what is trained on.
  BentCamera bent_{{340, 260, {.fx = 260, .fy = 280, .cx = 172, .cy = 128}},
                   {.is_fisheye = false, .radial = {-0.1, 0.03}, .tangential = {0.001, -0.002}}};
};

TEST_F(LensOfPhotographs, SeesWhatWasFound) {
  LensChange found;
  found.radial[0] = 0.04, found.radial[1] = -0.01;
  EXPECT_GT(CornerBend(kCamera, found.radial), 0.5) << "worth a look";
  EXPECT_LT(Apart(bent_, found), 0.02);
  found.log_focal[0] = 0.01, found.log_focal[1] = 0.008, found.shift[0] = 0.005, found.shift[1] = -0.004;
  EXPECT_LT(Apart(bent_, found), 0.02);
  EXPECT_NEAR(FitBent(bent_, kCamera, found).most_pixels, Apart(bent_, found), 0.005);
  BentCamera fisheye = bent_;
  fisheye.distortion = {.is_fisheye = true, .radial = {0.02, -0.01}};
  EXPECT_TRUE(FitBent(fisheye, kCamera, found).camera.distortion.is_fisheye);
  EXPECT_GT(FitBent(fisheye, kCamera, found).most_pixels, 0.1) << "no tangential coefficients: told";
  found.shift[0] = found.shift[1] = 0;
  EXPECT_LT(Apart(fisheye, found), 0.02);
}

TEST_F(LensOfPhotographs, IsTheGivenOneWhereNothingWasFound) { EXPECT_EQ(FitBent(bent_, kCamera, {}).camera, bent_); }

// A bend of a lens without distortion is that distortion.
TEST_F(LensOfPhotographs, HasTheCoefficientsThatWereFound) {
  LensChange found;
  found.radial[0] = 0.04, found.radial[1] = -0.01;
  const BentCamera as_found = FitBent({bent_.camera, {}}, kCamera, found).camera;
  EXPECT_NEAR(as_found.distortion.radial[0], 0.04, 1e-6);
  EXPECT_NEAR(as_found.distortion.radial[1], -0.01, 1e-6);
  EXPECT_NEAR(as_found.distortion.radial[2], 0, 1e-6);
  EXPECT_NEAR(as_found.camera.lens.fx, 260, 1e-4);
}

TEST_F(LensOfPhotographs, IsThatOfTestViewsToo) {
  Scene scene;
  for (int v = 0; v < 4; ++v) {
    View& view = scene.views.emplace_back();
    view.camera = kCamera;
    if (v < 3) view.bent = bent_;
    if (v == 1) view.role = ViewRole::kTest;
  }
  std::vector<ViewUnknowns> found(3);
  found[0].lens.radial[0] = found[1].lens.radial[0] = 0.02;
  std::vector<View> views(4);
  EXPECT_LT(BendAsFound(scene, found, &views), 0.02);
  EXPECT_EQ(views[0].bent, FitBent(bent_, kCamera, found[0].lens).camera);
  EXPECT_EQ(views[1].bent, views[0].bent);
  EXPECT_FALSE(views[3].bent);
}

}  // namespace
}  // namespace vesta::gs
