// The same bits for any number of threads.
#include <gtest/gtest.h>

#include "kernels/core/parallel.h"
#include "problems/gaussian_splatting/cameras/refine_jointly.h"
#include "tests/problems/gaussian_splatting/cameras/perturbed_view.h"

namespace vesta::gs {
namespace {

// everything(): numbers.
template <class Everything>
void ExpectSameForAnyNumber(const Everything& everything) {
  const int before = NumThreads();
  SetNumThreads(1);
  const std::vector<double> expected = everything();
  for (const int threads : {2, 3}) {
    SetNumThreads(threads);
    EXPECT_TRUE(everything() == expected) << threads;
  }
  SetNumThreads(before);
}

TEST(GsThreads, AlignmentIsBitIdenticalForAnyNumber) {
  const SplatModel model = test::RandomModel(1500, 1, 21);
  const View view = test::RingWithImages(model, 3, 80, 64).views[1];
  const View start = test::PerturbedView(view, test::RandomMotion(0.3, 0.01, 22));
  const auto everything = [&] {
    const Alignment alignment = AlignView(model, start, {.free = {true, true}, .near = 0.01, .max_iterations = 4});
    EXPECT_TRUE(alignment.is_found());
    HostBuffer<double> x(kViewParameters);
    Pack(alignment.found, x);
    std::vector<double> numbers(x.begin(), x.end());
    numbers.insert(numbers.end(), {alignment.cost_before, alignment.cost_after, double(alignment.iterations),
                                   MedianShift(model, start, MovedView(start, alignment.found.motion), 0.01)});
    return numbers;
  };
  ExpectSameForAnyNumber(everything);
}

TEST(GsThreads, JointRefinementIsBitIdenticalForAnyNumber) {
  const SplatModel model = test::RandomModel(1500, 1, 23);
  const Scene scene = test::RingWithImages(model, 4, 48, 40);
  std::vector<View> given;
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    given.push_back(test::PerturbedView(scene.views[v], test::RandomMotion(0.3, 0.01, 24 + v)));
  }
  std::vector<const View*> views;
  views.reserve(given.size());
  for (const View& view : given) views.push_back(&view);
  for (const bool eliminate : {false, true}) {
    JointOptions options;
    options.free = {true, true}, options.eliminate_views = eliminate;
    options.iterations = 2, options.near = 0.01;
    ExpectSameForAnyNumber([&] {
      const JointRefinement refined = RefineJointly(test::Perturbed(model, 0.01, 29), views, {}, options);
      std::vector<double> numbers(refined.model.data.begin(), refined.model.data.end());
      for (const ViewUnknowns& view : refined.views) {
        HostBuffer<double> x(kViewParameters);
        Pack(view, x);
        numbers.insert(numbers.end(), x.begin(), x.end());
      }
      EXPECT_LT(refined.summary.final_cost, refined.summary.initial_cost);
      return numbers;
    });
  }
}

}  // namespace
}  // namespace vesta::gs
