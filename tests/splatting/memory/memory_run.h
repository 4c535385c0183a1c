// SPDX-License-Identifier: Apache-2.0
// Short runs that measure memory.
#pragma once

#include <gtest/gtest.h>

#include <ostream>
#include <regex>
#include <string>

#include "splatting/train/trainer.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"

namespace vesta::gs::test {

// Few pixels and many parameters, or the reverse.
struct MemoryCase {
  const char* name;
  Index gaussians;
  int width, height;
  void (*apply)(TrainOptions&);
};
inline void PrintTo(const MemoryCase& c, std::ostream* os) { *os << c.name; }

// A few LM iterations unless the case changes that; its Adam part; no densification.
struct MemoryRun {
  Scene scene;
  SplatModel model;
  TrainOptions options;

  MemoryRun(const MemoryCase& c, int lm_iterations, int pcg_iterations)
      : scene(RingOfCameras(6, c.width, c.height, false)), model(RandomModel(c.gaussians, 3, 5)) {
    RenderTruth(Perturbed(model, 0.02, 6), 0, &scene);
    options.adam.iterations = 0;
    options.adam.evaluations = 1;
    options.density.enabled = false;
    options.lm.iterations = lm_iterations;
    options.lm.function_tolerance = 0;
    options.lm.jacobian = JacobianKind::kCachedViews;
    options.lm.pcg_iterations = pcg_iterations;
    c.apply(options);
  }

  // Train makes a model from the same number of points.
  TrainResult Run(const StageRunners& stages = HostStages()) const {
    return options.adam.runs() ? Train(scene, options, {}, {}, stages) : Refine(scene, model, options, {}, {}, stages);
  }
};

// The first amount in GiB in a message.
inline double FirstGib(const std::string& message) {
  std::smatch found;
  EXPECT_TRUE(std::regex_search(message, found, std::regex("([0-9.]+) GiB"))) << message;
  return found.empty() ? 0 : std::stod(found[1]);
}

}  // namespace vesta::gs::test
