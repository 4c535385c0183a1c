// SPDX-License-Identifier: Apache-2.0
// Code of both kinds of LM stage: Gaussians alone (SplatLm), and Gaussians with cameras (JointLm, both in lm_stage.h).
// It has the saved state, start, iteration loop, resulting model, and reaction when a GPU runs out of memory.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "kernels/core/archive.h"
#include "kernels/core/check.h"
#include "kernels/core/device_memory.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "solver/levenberg_marquardt.h"
#include "splatting/train/session/session.h"

namespace vesta::gs {

// The first part of a saved LM stage. The solver's state (LmStepper::Save) follows: first its parameter vector x, which
// begins with the model. Options and photographs are not saved.
struct LmStageHeader {
  splat::ModelLayout layout;
  int done = 0;                   // iterations of earlier solves; several if a GPU ran out of memory
  std::vector<float> units;       // length units of the Gaussians at the start
  bool eliminates_views = false;  // whether PCG solves the reduced system (with camera refinement)

  template <class Archive>
  void Visit(Archive& archive) {
    archive(layout, done, units, eliminates_views);
  }
};

inline SplatModel ModelOfLmStage(std::string_view saved) {
  ArchiveReader reader(saved);
  LmStageHeader header;
  SplatModel model;
  reader(header, model.data);
  static_cast<splat::ModelLayout&>(model) = header.layout;
  VESTA_CHECK(model.IsValid() && static_cast<Index>(model.data.size()) >= model.Size(),
              "a saved model of {} parameters for {} Gaussians", model.data.size(), model.count);
  model.data.resize(static_cast<std::size_t>(model.Size()));  // with camera refinement the views follow
  return model;
}

// A new or resumed LM stage.
class LmStart {
 public:
  // Throws Error, naming the checkpoint, if the saved state does not belong to this stage.
  LmStart(TrainingSession& session, const SplatModel& model)
      : session_(session), saved_(session.saved().Take(Stage::kLm)), reader_(saved_ ? *saved_ : std::string_view()) {
    if (!saved_) {
      header = {model, 0, TrainingUnits(session, model)};
      return;
    }
    session.saved().Validate([&] { reader_(header); });
    if (header.done < 0 || header.done > session.saved().first_iteration()) session.saved().Refuse();
  }
  LmStart(const LmStart&) = delete;
  LmStart& operator=(const LmStart&) = delete;

  bool saved() const { return saved_.has_value(); }
  // Constructs a Stepper from `args` and the solver's saved state; call at most once. Throws like the constructor.
  template <class Stepper, class... Args>
  Stepper MakeStepper(Args&&... args) {
    return session_.saved().Validate([&] { return Stepper(std::forward<Args>(args)..., reader_); });
  }
  // Finished iterations of the saved solve; 0 for a new stage.
  int finished() const { return saved_ ? session_.saved().first_iteration() - header.done : 0; }

  LmStageHeader header;

 private:
  TrainingSession& session_;
  std::optional<std::string_view> saved_;
  ArchiveReader reader_;
};

// The best model so far; refers to the stepper's memory.
template <Backend B>
splat::Model<float> BestOf(const LmStepper<B>& stepper, const splat::ModelLayout& layout) {
  return {stepper.x().data(), layout, layout.sh_degree};
}

// Runs the stepper until it is done or the session stops. header: saved before the solver's state in checkpoints. best:
// the best model, for the history. moved: called after each step. Returns the solver's full report.
template <Backend B>
std::string RunLmSteps(TrainingSession& session, LmStepper<B>& stepper, LmStageHeader& header,
                       const ModelToRecord& best, const std::function<void()>& moved) {
  const int first = header.done;
  const auto save = [&](ArchiveWriter& archive) {
    archive(header);
    stepper.Save(archive);
  };
  double values = 0;
  for (const View* view : session.training_views()) {
    values += static_cast<double>(ImageShape{view->camera.width, view->camera.height}.NumValues());
  }
  if (first == 0 && stepper.summary().iterations.size() == 1 && !session.history().ends_with(Stage::kLm)) {
    session.history().Record(Stage::kLm, 0, best);
    if (!stepper.done()) session.interim().SaveWhereDue(Stage::kLm, 0, save);
  }
  // The next step and its evaluation are expected to take as long as the latest ones.
  for (double latest = 0; !stepper.done() && !session.early_end().ShouldStop(latest);) {
    const double begin = session.clock().Total();
    const LmIteration& row = stepper.Step();
    moved();
    session.history().Record(Stage::kLm, first + row.iteration, best);
    session.Report({Stage::kLm, first + row.iteration, session.plan().lm.iterations, session.Seconds(),
                    row.cost / values, session.history().training_psnr(), best.gaussians,
                    fmt::format("lambda {:.1e} rho {:.2f} gamma {:.2f} pcg {}{}", row.lambda, row.rho, row.gamma,
                                row.pcg_iterations, row.accepted ? "" : " rejected")});
    session.interim().SnapshotWhereDue(Stage::kLm, first + row.iteration, best.on_host);
    if (!stepper.done()) {
      session.interim().SaveWhereDue(Stage::kLm, first + row.iteration, save);
      session.interim().ServeViewer(Stage::kLm, first + row.iteration, best.on_host, save);
    }
    latest = session.clock().Total() - begin;
  }
  if (session.early_end().stopped() && !stepper.done()) {
    session.interim().SaveWhereDue(Stage::kLm, first + stepper.summary().iterations.back().iteration, save);
  }
  const LmSummary& summary = stepper.summary();
  if (summary.status == LmStatus::kFunctionTolerance && session.plan().lm.function_tolerance > 0) {
    session.Note(notes::kLmGainsLittle, first + summary.iterations.back().iteration, session.plan().lm.iterations,
                 session.plan().lm.function_tolerance);
  }
  return summary.FullReport();
}

// The best model of an LM stage so far: the first elements of the stepper's x, in the memory of backend B and, after
// TakeBest, on the host.
template <class B>
class LmModel {
 public:
  // copies: device copies of the training photographs for evaluation; empty: the session's photographs are used.
  // workspace: for evaluation; the solver must not need its content between steps. model: has the layout; TakeBest()
  // stores the parameters in it. All must outlive this object.
  LmModel(TrainingSession& session, const LmStepper<B>& stepper, std::span<const TargetView<B>> copies,
          typename SplatBackend<B>::Workspace& workspace, SplatModel& model)
      : session_(session), stepper_(stepper), copies_(copies), workspace_(workspace), model_(model) {}

  // Call after each step.
  void AfterStep() {
    if constexpr (!kOnHost) TakeBest();
  }
  // Copies the best model to `model`.
  void TakeBest() {
    const Index n = model_.Size();
    model_.data.resize(static_cast<std::size_t>(n));
    B().ToHost(stepper_.x().subspan(0, n), {model_.data.data(), n});
  }
  // For the history.
  ModelToRecord Recorded() {
    return {model_.count, [this] { return Evaluate(); }, [this] { return OnHost(); }};
  }

 private:
  static constexpr bool kOnHost = std::is_same_v<typename B::Space, Host>;

  splat::Model<float> OnHost() const { return kOnHost ? BestOf(stepper_, model_) : ToKernelModel(model_); }
  Evaluation Evaluate() {
    return EvaluateOrDownload<B>(
        session_, copies_, [&] { return BestOf(stepper_, model_); }, workspace_, [this] { return OnHost(); });
  }

  TrainingSession& session_;
  const LmStepper<B>& stepper_;
  std::span<const TargetView<B>> copies_;
  typename SplatBackend<B>::Workspace& workspace_;
  SplatModel& model_;
};

// `problem`, a SplatLm or a JointLm (lm_stage.h), creates the least-squares problem and its start vector; Moved() is
// called after each step. Stores the best model in `model`, records the last state in the history and returns the
// solver's full report. If a GPU runs out of memory, the stage continues from its best model with less memory if
// problem.ReduceMemory() is true; else it ends after the last finished iteration, with an empty report. Throws
// OutOfDeviceMemory if no iteration was finished and there was no Adam stage. Throws Error if a saved state does not
// belong to this stage.
template <class B, class StageProblem>
std::string SolveLmStage(TrainingSession& session, SplatModel& model, LmStart& start, StageProblem& problem) {
  constexpr bool kOnHost = std::is_same_v<typename B::Space, Host>;
  vesta::LmOptions engine = problem.EngineOptions();
  int& done = start.header.done;
  int finished = start.finished();  // iterations of the current solve
  bool resumes = start.saved();
  for (;;) {
    try {
      Problem<B>& solved = problem.MakeProblem();
      B backend;
      typename B::Vector x;
      if (!resumes) x = problem.Start(model);
      if constexpr (kOnHost) model.data = std::vector<float>();  // of the current solve
      engine.max_iterations = std::max(0, session.plan().lm.iterations - done);
      LmStepper<B> stepper = resumes ? start.template MakeStepper<LmStepper<B>>(engine, backend, solved)
                                     : LmStepper<B>(engine, backend, solved, std::move(x));
      if (std::exchange(resumes, false)) problem.Resumed(stepper);
      LmModel<B> best(session, stepper, problem.copies(), problem.workspace(), model);
      std::string report = RunLmSteps(session, stepper, start.header, best.Recorded(), [&] {
        problem.Moved(stepper);
        best.AfterStep();
        ++finished;
      });
      best.TakeBest();
      return report;
    } catch (const OutOfDeviceMemory& error) {
      done += std::exchange(finished, 0);
      resumes = false;  // the model is the result of the saved solve
      if (!problem.ReduceMemory()) {
        if (done == 0 && !session.options().adam.runs()) throw;
        session.Note(notes::kLmEnds, done, error.what());
        return "";
      }
      session.Note(notes::kLmByOneView, error.what());
    }
  }
}

}  // namespace vesta::gs
