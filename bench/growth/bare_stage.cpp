// SPDX-License-Identifier: Apache-2.0
#include "bench/growth/bare_stage.h"

#include <algorithm>

#include "splatting/train/trainer.h"

namespace vesta::bench {

BareStage::BareStage(const gs::Scene& scene, const gs::TrainOptions& options)
    : session_(scene, options, 0, callbacks_), state_(gs::StartAdam<Cpu>(session_, gs::InitialModel(scene, options))) {
  views_.LoadFull();
}

gs::IterationPlan BareStage::NextPlan() const {
  const double all = iterations();
  return session_.schedule().At({done() / all, (done() + 1) / all});
}

double BareStage::ValuesOf(const gs::IterationPlan& plan) const {
  double pixels = 0;
  for (const gs::View* view : session_.training_views()) {
    const gs::ImageSize size =
        plan.is_coarse ? gs::CoarseSize(*view) : gs::ImageSize{view->camera.width, view->camera.height};
    pixels += static_cast<double>(size.width) * size.height;
  }
  return ImageShape::kChannels * pixels / static_cast<double>(session_.training_views().size());
}

int BareStage::Attributes(const gs::IterationPlan& plan) const {
  return splat::NumAttributes(std::min(plan.max_sh_degree, state_.model.sh_degree()));
}

void BareStage::Step(const gs::IterationPlan& plan) {
  views_.ChooseSize(plan.is_coarse);
  const double cost = views_.Step(plan, std::min(plan.max_sh_degree, state_.model.sh_degree()), &state_);
  state_.CountIteration(plan.span, cost);
}

gs::Evaluation BareStage::Evaluate() {
  return session_.history().Evaluate(state_.model.result(state_.model.sh_degree()));
}

std::string BareStage::Save() {
  std::string bytes;
  ArchiveWriter writer([&](std::string_view piece) { bytes.append(piece); });
  writer(state_);
  return bytes;
}

void BareStage::Restore(const std::string& bytes) {
  ArchiveReader reader(bytes);
  reader(state_);
}

}  // namespace vesta::bench
