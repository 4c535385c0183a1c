// SPDX-License-Identifier: Apache-2.0
// The quality of a model in any memory space, for a session.
#pragma once

#include <functional>
#include <span>

#include "kernels/core/device_memory.h"
#include "splatting/evaluate/evaluation.h"
#include "splatting/train/session/session.h"

namespace vesta::gs {

// Evaluate, on the host where a GPU has no room for it. copies: of the training views' photographs, where the memory of
// B has them. model(), on_host(): give the model in the memory of B, which may have no room for it, and of the host.
template <class B>
Evaluation EvaluateOrDownload(TrainingSession& session, std::span<const TargetView<B>> copies,
                              const std::function<splat::Model<float>()>& model,
                              typename SplatBackend<B>::Workspace& workspace, const ModelOnHost& on_host) {
  try {
    return Evaluate<B>(session.scene(), session.options().background, copies, model(), workspace,
                       session.history().measured_views());
  } catch (const OutOfDeviceMemory&) {
    return session.history().Evaluate(on_host());
  }
}

}  // namespace vesta::gs
