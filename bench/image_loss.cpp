// SPDX-License-Identifier: Apache-2.0
// Measures the photometric loss of one view of 504 x 378 pixels in float, on one and two threads.
//
//   image_loss [--json FILE]
#include <functional>
#include <string>
#include <vector>

#include "bench/report.h"
#include "kernels/core/parallel.h"
#include "kernels/image/photometric_loss.h"

namespace vesta::bench {
namespace {

constexpr ImageShape kShape{.width = 504, .height = 378};

// Detail at every scale of the SSIM window; values in [0, 1].
HostBuffer<float> Pattern(Index step) {
  HostBuffer<float> image(kShape.NumValues());
  for (Index i = 0; i < image.size(); ++i) image[i] = static_cast<float>(i * step % 1009) / 1009.0f;
  return image;
}

class LossTimes {
 public:
  LossTimes() {
    loss_.Linearize(rendered_, truth_, kShape, out_, w_);
    // Two threads first: a second thread that starts late may be scheduled on the core of the first.
    const std::vector<double> two = Times(2), one = Times(1);
    SetNumThreads(2);
    const double vectors = static_cast<double>(kShape.NumValues()) / 16.0;
    for (std::size_t i = 0; i < operations_.size(); ++i) {
      report_.Add({{"operation", operations_[i].name},
                   {"ms_1", one[i]},
                   {"ms_2", two[i]},
                   {"ratio", one[i] / two[i]},
                   {"ns_16", 1e6 * one[i] / vectors}});
    }
  }
  void Finish(const std::string& json) const { report_.Finish(json); }

 private:
  struct Operation {
    std::string name;
    std::function<void()> body;
  };

  std::vector<double> Times(int threads) const {
    SetNumThreads(threads);
    std::vector<double> times;
    for (const Operation& operation : operations_) times.push_back(MedianMilliseconds(200, operation.body));
    return times;
  }

  HostBuffer<float> rendered_ = Pattern(7), truth_ = Pattern(31), out_{kShape.NumValues()};
  PhotometricLoss<float> loss_;
  PhotometricLinearization<float> w_;
  std::vector<Operation> operations_{
      {"value", [this] { loss_.Evaluate(rendered_, truth_, kShape); }},
      {"gradient", [this] { loss_.Gradient(rendered_, truth_, kShape, out_); }},
      {"gradient and W", [this] { loss_.Linearize(rendered_, truth_, kShape, out_, w_); }},
      {"W v", [this] { loss_.ApplyW(w_, rendered_, out_); }},
  };
  Report report_{"image_loss"};
};

}  // namespace
}  // namespace vesta::bench

int main(int argc, char** argv) {
  const vesta::bench::Arguments arguments(argc, argv, {"json"});
  const vesta::bench::LossTimes times;
  times.Finish(arguments.Flag("json", ""));
  return 0;
}
