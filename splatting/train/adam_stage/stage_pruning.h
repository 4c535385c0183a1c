// SPDX-License-Identifier: Apache-2.0
// Pruning during the Adam stage (pruning/pruning_options.h). Scores are always computed on the host from full-size
// training views.
#pragma once

#include <algorithm>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "kernels/core/profile.h"
#include "splatting/pruning/coverage.h"
#include "splatting/pruning/harmonics.h"
#include "splatting/pruning/prune.h"
#include "splatting/pruning/pruning_options.h"
#include "splatting/train/adam_stage/trained_model.h"
#include "splatting/train/forecast/forecast.h"
#include "splatting/train/session/session.h"

namespace vesta::gs {

template <class B>
class StagePruning {
 public:
  // timer: predicts the time of scoring, and receives the measured time.
  StagePruning(TrainingSession& session, IterationTimer& timer)
      : session_(session), options_(session.options().pruning), timer_(timer) {}

  // What precedes a densification: shrinks and removes Gaussians, as `plan` has it and time allows. degree: the SH
  // degree in use. Calls free_memory(), which may free the workspace of the iterations, before it removes any.
  template <class FreeMemory>
  void PrepareGrowth(AdamStageState<B>& state, const IterationPlan& plan, int degree, const FreeMemory& free_memory) {
    if (plan.shrinks_unseen)
      Work(
          state, [] {}, [&] { ShrinkUnseen(state, degree); });
    if (plan.prunes_before_growth && ClaimTime(1, kPartWhileGrowing * plan.scoring_fraction, state)) {
      Work(state, free_memory, [&] { PruneByAic(state, degree); });
    }
  }
  // The pruning that follows the iteration of `plan` and its densification, with the arguments of PrepareGrowth.
  template <class FreeMemory>
  void Prune(AdamStageState<B>& state, const IterationPlan& plan, int degree, const FreeMemory& free_memory) {
    const bool prunes = plan.prunes && ClaimTime(1, plan.scoring_fraction, state);
    // Degrees are lowered only after all SH bands are in use.
    const bool lowers = plan.lowers_sh_degrees && degree > 0 && degree == state.model.sh_degree() &&
                        ClaimTime(2, kPartForDegrees, state);
    if (!prunes && !lowers) return;
    Work(state, free_memory, [&] {
      // Degrees are lowered first, because scoring Gaussians is then faster.
      if (lowers) LowerDegrees(state, degree);
      if (prunes && state.before_pruning == 0) state.before_pruning = state.model.count();
      if (prunes && options_.prunes_to_count()) PruneToCount(state, degree);
      if (prunes && !options_.prunes_to_count()) PruneByAic(state, degree);
    });
  }

  // Call at the end of the stage. Adds a note if more Gaussians remain than requested, or if scoring was skipped for
  // lack of time.
  void AddPruningNotes(const AdamStageState<B>& state, Index gaussians) const {
    if (state.scoring_skipped > 0) {
      session_.Note(notes::kScoringSkipped, state.scoring_skipped, session_.options().time_limit);
    }
    const Index wanted = CountAfter(options_, {1, 1}, state.before_pruning > 0 ? state.before_pruning : gaussians);
    if (!options_.prunes_to_count() || gaussians <= wanted) return;
    session_.Note(notes::kKeepsMoreThanAsked, gaussians, wanted, options_.keep_fraction);
  }

 private:
  // Fractions of the time for scoring: rounds before densifications leave time for lowering degrees.
  static constexpr double kPartWhileGrowing = 0.5, kPartForDegrees = 0.5;

  // Whether there is time for scoring with `passes` passes over all views. Over the whole stage, scoring may take the
  // fraction kScoringFraction of a time limit; by now, it may take `part` times that time. Always true if keep_fraction
  // is set. Counts skipped rounds. Collective.
  bool ClaimTime(double passes, double part, AdamStageState<B>& state) {
    const double limit = session_.options().time_limit;
    if (limit <= 0 || options_.prunes_to_count()) return true;
    const double free = part * kScoringFraction * limit - state.scoring_seconds;
    const auto gaussians = static_cast<double>(state.model.count());
    const bool fits =
        timer_.is_known() && passes * timer_.ScoringSeconds(gaussians, session_.IterationsPerEpoch()) <= free;
    const bool has_time = session_.processes().OfFirst(fits ? 1 : 0) > 0;
    if (!has_time) ++state.scoring_skipped;
    return has_time;
  }
  template <class FreeMemory, class Change>
  void Work(AdamStageState<B>& state, const FreeMemory& free_memory, const Change& change) {
    const ScopedPhase phase("pruning");
    free_memory();
    session_.memory().NoteModel(state.model.layout());
    change();
    copy_ = SplatModel();
  }
  void ShrinkUnseen(AdamStageState<B>& state, int degree) {
    const std::vector<float> by = LogShrinkage(OnHost(state, degree), MakeScoringViews());
    if (std::ranges::any_of(by, [](float of_one) { return of_one > 0; })) state.model.ShrinkLongerAxes(by);
  }
  void KeepOnly(const std::vector<Index>& kept, AdamStageState<B>& state) {
    if (static_cast<Index>(kept.size()) < state.model.count()) state.model.Keep(kept);
  }
  void PruneToCount(AdamStageState<B>& state, int degree) {
    const Index left = CountAfter(options_, state.span, state.before_pruning);
    if (left >= state.model.count()) return;
    Score(state, [&] { return SelectToKeep(OnHost(state, degree), MakeScoringViews(), options_.shrink_unseen, left); });
  }
  void PruneByAic(AdamStageState<B>& state, int degree) {
    const auto round = static_cast<std::uint64_t>(state.iteration);
    Score(state, [&] {
      return KeepByAic(OnHost(state, degree), MakeScoringViews(), options_.aic_weight, session_.options().seed, round);
    });
  }
  // Keeps the Gaussians that select() returns, and measures its time.
  template <class Select>
  void Score(AdamStageState<B>& state, const Select& select) {
    const Index scored = state.model.count();
    const double begin = session_.Seconds();
    KeepOnly(select(), state);
    timer_.ObserveScoring(scored, session_.Seconds() - begin);
    state.scoring_seconds += session_.Seconds() - begin;
  }
  void LowerDegrees(AdamStageState<B>& state, int degree) {
    const double begin = session_.Seconds();
    const splat::Model<float> model = OnHost(state, degree);
    const ShRemovalCost removal(model, MakeScoringViews());
    const std::vector<std::uint8_t> degrees = DegreesByAic(model, removal, options_.sh_aic_weight);
    for (int a = splat::kSh; a < splat::NumAttributes(model.sh_degree - 1); ++a) {
      state.model.SetAttribute(a, SubstituteCoefficients(model, removal, degrees, a));
    }
    state.model.SetDegrees(degrees);
    state.scoring_seconds += session_.Seconds() - begin;
  }
  // Values of one SH attribute for all Gaussians that have it. Gaussians with lowered degree get the refitted
  // coefficient of ShRemovalCost.
  static std::vector<float> SubstituteCoefficients(const splat::Model<float>& model, const ShRemovalCost& removal,
                                                   const std::vector<std::uint8_t>& degrees, int attribute) {
    const float* own = model.x + model.Offset(attribute);
    std::vector<float> values(own, own + model.Rows(attribute));
    for (std::size_t i = 0; i < values.size(); ++i) {
      const int degree = degrees[i];
      const bool is_kept = attribute < splat::NumAttributes(degree);
      const auto gaussian = static_cast<Index>(i);
      if (is_kept && degree < model.DegreeOf(gaussian)) {
        values[i] = removal.Coefficient(gaussian, degree, attribute - splat::kSh);
      }
    }
    return values;
  }
  // Valid until the next call.
  splat::Model<float> OnHost(const AdamStageState<B>& state, int degree) {
    splat::Model<float> model = state.model.kernel_model(degree);
    if constexpr (!std::is_same_v<typename B::Space, Host>) {
      state.model.DownloadParameters(copy_);
      model.x = copy_.data.data();
    }
    return model;
  }
  ScoringViews MakeScoringViews() const {
    return TrainingViewsOf(session_.scene(), session_.options().background, session_.processes());
  }

  TrainingSession& session_;
  const PruningOptions& options_;
  IterationTimer& timer_;
  SplatModel copy_;  // host copy of a device model
};

}  // namespace vesta::gs
