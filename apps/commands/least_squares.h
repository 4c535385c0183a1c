// SPDX-License-Identifier: Apache-2.0
// Common parts of the commands that solve a least-squares problem: bundle_adjust and pose_graph.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>

#include "apps/cli/flags.h"
#include "solver/lm_options.h"
#include "solver/loss.h"
#include "solver/summary.h"

namespace vesta::app {

// The robust loss of --loss and --loss_scale; null for none. Throws UsageError for a scale without a loss.
std::shared_ptr<const Loss> LossOf(const Flags& flags);

// Throws Error if the files of --out and --json cannot be written, or would replace the input.
void CheckOutputs(const CommandLine& line);

// Sets the limits of --iterations, --pcg_iterations and --time_limit.
void SetLimits(const Flags& flags, LmOptions& options);

// To call after each iteration: logs it if `log`, and stops after Ctrl-C.
CallbackResult AfterIteration(const LmIteration& row, bool log);

// One object per iteration.
nlohmann::ordered_json HistoryOf(const LmSummary& summary);

}  // namespace vesta::app
