#include "solver/internal/trust_region/step_doubt.h"

#include <fmt/format.h>

#include <algorithm>

namespace vesta {

void StepDoubt::OnReject(double predicted, bool finite) {
  promised_ = std::max(promised_, predicted);
  increase_ = std::max(increase_, -predicted);
  if (!finite) blocked_ = std::max(blocked_, predicted);
}

std::string StepDoubt::Words(bool accepted, double least) const {
  if (blocked_ > least) {
    return fmt::format("; a step to gain {:.3e} leads to where the cost is not finite", blocked_);
  }
  if (accepted) return "";
  if (std::string increase = IncreaseWords(least); !increase.empty()) return increase;
  if (promised_ > least) {
    return fmt::format("; a step was to gain {:.3e}: are the derivatives right? CheckProblem says what is wrong",
                       promised_);
  }
  return "";
}

std::string StepDoubt::IncreaseWords(double least) const {
  if (increase_ <= least) return "";
  return "; the model predicts an increase: J and J^T are not adjoint? CheckProblem says what is wrong";
}

}  // namespace vesta
