#include "problems/gaussian_splatting/cameras/refine_jointly.h"

#include <gtest/gtest.h>

#include "kernels/core/error.h"
#include "kernels/math/quaternion.h"
#include "problems/gaussian_splatting/cameras/gauge.h"
#include "problems/gaussian_splatting/evaluate/quality.h"
#include "tests/problems/gaussian_splatting/cameras/perturbed_view.h"

namespace vesta::gs {
namespace {

// Photographs of a model, beside another one close to it and cameras 0.3 degrees off.
struct KnownAnswer {
  SplatModel truth = test::RandomModel(60, 1, 31);
  Scene scene = test::RingWithImages(truth, 8, 64, 48);
  SplatModel model = test::Perturbed(truth, 0.01, 32);
  std::vector<View> given;
  std::vector<const View*> views, true_views;
  JointOptions options;

  KnownAnswer() {
    for (std::size_t v = 0; v < scene.views.size(); ++v) {
      given.push_back(test::PerturbedView(scene.views[v], test::RandomMotion(0.3, 0.01, 40 + v)));
    }
    for (std::size_t v = 0; v < scene.views.size(); ++v) {
      views.push_back(&given[v]);
      true_views.push_back(&scene.views[v]);
    }
    options.near = NearPlane(scene);
    options.extent = scene.extent;
    options.iterations = 25;
    options.lm.min_gain = 0;
    options.lm.pcg_iterations = 15;
    // The views agree: they are of one model.
    options.lm.view_agreement = 0;
  }
  // The largest distance in pixels between where the model's means are seen and where they should be, what all views
  // share apart.
  double LargestError(const std::vector<ViewUnknowns>& found) const {
    double largest = 0;
    // From where they should be.
    std::vector<ViewUnknowns> apart(found.size());
    for (std::size_t v = 0; v < found.size(); ++v) {
      const splat::CameraMotion off = test::RandomMotion(0.3, 0.01, 40 + v);
      splat::CameraMotion& motion = apart[v].motion;
      double turn[9];
      QuaternionProduct(found[v].motion.quaternion, off.quaternion, motion.quaternion);
      RotationFromQuaternion(found[v].motion.quaternion, turn);
      for (int i = 0; i < 3; ++i) {
        motion.translation[i] = found[v].motion.translation[i];
        for (int k = 0; k < 3; ++k) motion.translation[i] += turn[3 * i + k] * off.translation[k];
      }
    }
    // Each round takes out what is left, to first order.
    for (int round = 0; round < 10; ++round) RemoveCommonMotion(true_views, 2 * scene.extent, &apart);
    for (std::size_t v = 0; v < found.size(); ++v) {
      const View& view = scene.views[v];
      largest = std::max(largest, test::LargestShift(truth, view, MovedView(view, apart[v].motion)));
    }
    return largest;
  }
};

void ExpectRecovered(bool eliminate_views) {
  KnownAnswer known;
  known.options.eliminate_views = eliminate_views;
  known.options.prior_weight = 1e-4;
  const double before = known.LargestError(std::vector<ViewUnknowns>(known.given.size()));
  ASSERT_GT(before, 0.3);
  const JointRefinement refined = RefineJointly(known.model, known.views, {}, known.options);
  // Where no value is off, each costs half of l1_floor.
  const double values = 8 * 3 * 64 * 48, least = PhotometricWeights{}.l1 * PhotometricWeights{}.l1_floor / 2 * values;
  EXPECT_LT(refined.summary.final_cost - least, 0.01 * (refined.summary.initial_cost - least));
  EXPECT_LT(known.LargestError(refined.views), 0.15 * before) << refined.summary.FullReport();
}
TEST(RefineJointly, RecoversCamerasAndSplats) { ExpectRecovered(false); }
TEST(RefineJointly, RecoversThemWithViewsEliminated) { ExpectRecovered(true); }

TEST(RefineJointly, FindsExposuresAlong) {
  KnownAnswer known;
  known.options.free.color = true;
  const double gains[] = {0.9, 1.1, 1.05, 0.95, 1, 1.02, 0.98, 1};
  for (std::size_t v = 0; v < known.given.size(); ++v) {
    for (float& value : known.given[v].image.rgb) value *= static_cast<float>(gains[v]);
  }
  known.options.prior_weight = 1e-4;  // by the default gains come out up to 0.02 too near to 1
  for (const bool eliminate : {false, true}) {
    known.options.eliminate_views = eliminate;
    const JointRefinement refined = RefineJointly(known.model, known.views, {}, known.options);
    double mean = 0;
    for (const ViewUnknowns& view : refined.views) mean += view.color.gain[1] / 8;
    EXPECT_NEAR(mean, 1, 0.005);  // held by the prior
    for (std::size_t v = 0; v < known.given.size(); ++v) {
      EXPECT_NEAR(refined.views[v].color.gain[1] / mean, gains[v], 0.005) << v;
    }
  }
}

// One view tells nothing of depth, and one that sees nothing tells nothing at all.
TEST(RefineJointly, OneViewAndABlindOne) {
  KnownAnswer known;
  known.options.iterations = 3;
  const JointRefinement one = RefineJointly(known.model, {known.views[0]}, {}, known.options);
  EXPECT_LE(one.summary.final_cost, one.summary.initial_cost);
  EXPECT_TRUE(std::isfinite(one.summary.final_cost));
  std::vector<ViewUnknowns> start(8);
  start[3].motion = {{0, 0, 1, 0}, {0, 0, 0}};  // turned round
  known.options.free.color = true;
  for (const bool eliminate : {false, true}) {
    known.options.eliminate_views = eliminate;
    const JointRefinement blind = RefineJointly(known.model, known.views, start, known.options);
    EXPECT_LT(blind.summary.final_cost, blind.summary.initial_cost);
    for (const ViewUnknowns& view : blind.views) EXPECT_TRUE(std::isfinite(view.motion.Angle() + view.color.gain[0]));
  }
}

TEST(RefineJointly, RefusesWhatIsNoStart) {
  KnownAnswer known;
  std::vector<ViewUnknowns> start(8);
  start[2].color.gain[1] = 0;
  EXPECT_THROW(RefineJointly(known.model, known.views, start, known.options), Error);
  EXPECT_THROW(RefineJointly(known.model, known.views, std::vector<ViewUnknowns>(7), known.options), Error);
  EXPECT_THROW(RefineJointly(known.model, {}, {}, known.options), Error);
  start = std::vector<ViewUnknowns>(8);
  start[3].lens.radial[0] = 0.01;
  EXPECT_THROW(RefineJointly(known.model, known.views, start, known.options), Error) << "the photograph is bent";
  known.options.free = {.lens = true};
  start[3].lens = {.log_focal = {0.01, 0.01}};
  EXPECT_THROW(RefineJointly(known.model, known.views, start, known.options), Error) << "the others have that lens too";
  for (ViewUnknowns& view : start) view.lens = {.log_focal = {2, 2}};
  EXPECT_THROW(RefineJointly(known.model, known.views, start, known.options), Error) << "no lens is so long";
  known.options.free = {false, false};
  EXPECT_THROW(RefineJointly(known.model, known.views, {}, known.options), Error);
}

}  // namespace
}  // namespace vesta::gs
