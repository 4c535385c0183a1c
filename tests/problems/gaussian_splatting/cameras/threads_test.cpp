// The same bits for any number of threads.
#include <gtest/gtest.h>

#include "kernels/core/parallel.h"
#include "tests/problems/gaussian_splatting/cameras/perturbed_view.h"

namespace vesta::gs {
namespace {

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
                                   MedianShift(model, start, alignment.found.motion, 0.01)});
    return numbers;
  };
  const int before = NumThreads();
  SetNumThreads(1);
  const std::vector<double> expected = everything();
  for (const int threads : {2, 3}) {
    SetNumThreads(threads);
    EXPECT_TRUE(everything() == expected) << threads;
  }
  SetNumThreads(before);
}

}  // namespace
}  // namespace vesta::gs
