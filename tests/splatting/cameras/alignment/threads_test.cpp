// SPDX-License-Identifier: Apache-2.0
// Results are bit-identical for any number of threads.
#include <gtest/gtest.h>

#include "splatting/cameras/alignment/align_view.h"
#include "splatting/train/trainer.h"
#include "tests/splatting/cameras/perturbed_view.h"
#include "tests/support/any_threads.h"

namespace vesta::gs {
namespace {

TEST(GsThreads, AlignmentIsBitIdenticalForAnyNumber) {
  const SplatModel model = test::RandomModel(1500, 1, 21);
  const View view = test::RingWithImages(model, 3, 80, 64).views[1];
  const View start = test::PerturbedView(view, test::RandomMotion(0.3, 0.01, 22));
  vesta::test::ExpectSameForAnyThreads([&] {
    const Alignment alignment = AlignView(model, start, {.free = {true, true}, .near = 0.01, .max_iterations = 4});
    EXPECT_TRUE(alignment.is_found());
    HostBuffer<double> x(kViewParameters);
    Pack(alignment.found, x);
    std::vector<double> numbers(x.begin(), x.end());
    numbers.insert(numbers.end(), {alignment.cost_before, alignment.cost_after, double(alignment.iterations),
                                   MedianShift(model, start, MovedView(start, alignment.found.motion), 0.01)});
    return numbers;
  });
}

TEST(GsThreads, JointRefinementIsBitIdenticalForAnyNumber) {
  const SplatModel model = test::RandomModel(1500, 1, 23);
  const Scene given = test::WithCamerasOff(test::RingWithImages(model, 4, 48, 40), 0.3, 0.01);
  TrainOptions options;
  options.adam.iterations = 0, options.lm.iterations = 2;
  options.cameras.refine = CameraChoice::kPoseAndExposure;
  vesta::test::ExpectSameForAnyThreads([&] {
    const TrainResult refined = Refine(given, test::Perturbed(model, 0.01, 29), options, {}, {});
    std::vector<double> numbers(refined.model.data.begin(), refined.model.data.end());
    for (const ViewUnknowns& view : refined.cameras) {
      HostBuffer<double> x(kViewParameters);
      Pack(view, x);
      numbers.insert(numbers.end(), x.begin(), x.end());
    }
    EXPECT_LT(refined.history.back().cost, refined.history.front().cost);
    return numbers;
  });
}

}  // namespace
}  // namespace vesta::gs
