// SPDX-License-Identifier: Apache-2.0
#include "bench/training_race/training_run.h"

#include <cstring>
#include <type_traits>

#include "bench/child_process.h"
#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "kernels/core/process_memory.h"
#include "splatting/adam/adam_options.h"

namespace vesta::bench {
namespace {

// The child sends one message per history row: a Head, and the values of the model that it announces. Messages are sent
// at once, so that they do not count as memory of the training.
struct Head {
  gs::HistoryRow row;
  double peak_mib = 0;        // so far
  splat::ModelLayout layout;  // of the model that follows; none without Gaussians
};
static_assert(std::is_trivially_copyable_v<Head>);

void SendRow(const gs::HistoryRow& row, const splat::Model<float>* model, const Send& send) {
  const Head head{row, PeakMemoryMib(), model ? splat::ModelLayout(*model) : splat::ModelLayout()};
  send(&head, sizeof head);
  if (!model) return;
  send(model->x, static_cast<std::size_t>(model->Size()) * sizeof(float));
}

void Train(const gs::Scene& scene, const TrainingJob& job, const Send& send) {
  const bool has_lm = job.options.lm.iterations > 0;
  gs::TrainCallbacks callbacks;
  callbacks.evaluated = [&](const gs::HistoryRow& row, const splat::Model<float>& model) {
    // Without LM stage, send the model with the last row.
    const bool is_start = has_lm ? row.stage == gs::Stage::kLm && row.iteration == 0
                                 : row.iteration == gs::NumIterations(job.options.adam);
    SendRow(row, is_start ? &model : nullptr, send);
  };
  if (job.start) {
    gs::TrainOptions lm_alone = job.options;
    lm_alone.adam.iterations = 0;
    gs::Refine(scene, *job.start, lm_alone, {job.seconds_before, 0}, callbacks);
  } else {
    gs::Train(scene, job.options, {job.seconds_before, 0}, callbacks);
  }
}

TrainingRun Receive(const std::string& bytes) {
  TrainingRun run;
  std::size_t at = 0;
  const auto take = [&](void* values, std::size_t size) {
    VESTA_CHECK(bytes.size() - at >= size, "a training sent too few bytes");
    std::memcpy(values, bytes.data() + at, size);
    at += size;
  };
  while (at < bytes.size()) {
    Head head;
    take(&head, sizeof head);
    run.curve.push_back(head.row);
    if (head.row.stage == gs::Stage::kAdam) run.adam_peak_mib = head.peak_mib;
    if (head.layout.count == 0) continue;
    run.lm_start.Resize(head.layout);
    take(run.lm_start.data.data(), run.lm_start.data.size() * sizeof(float));
  }
  return run;
}

}  // namespace

TrainingRun TrainAlone(const gs::Scene& scene, const TrainingJob& job, int threads) {
  const ChildResult child = RunInChild(job.name, [&](const Send& send) {
    ReturnFreedMemoryToSystem();
    SetNumThreads(threads);
    Train(scene, job, send);
  });
  if (child.failed) Fail(kUnavailable, "{}: the training failed", job.name);
  TrainingRun run = Receive(child.bytes);
  if (run.curve.empty()) Fail(kUnavailable, "{}: the training left no history", job.name);
  run.peak_mib = child.peak_mib;
  return run;
}

}  // namespace vesta::bench
