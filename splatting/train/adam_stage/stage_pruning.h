// SPDX-License-Identifier: Apache-2.0
// Pruning during the Adam stage (pruning/pruning_options.h). Scores are always computed on the host from full-size
// training views.
#pragma once

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

  // Does the pruning that is due after the iteration of `plan` and its densification. degree: the SH degree in use. If
  // anything is due, calls before() first, which may free the workspace of the iterations.
  template <class Before>
  void Prune(AdamStageState<B>& state, const IterationPlan& plan, int degree, const Before& before) {
    const bool prunes = plan.prunes && ClaimTime(1, plan.pruning_fraction, state);
    // Degrees are lowered only after all SH bands are in use.
    const bool lowers = plan.lowers_sh_degrees && degree > 0 && degree == state.model.sh_degree() &&
                        ClaimTime(2, kPartForDegrees, state);
    if (!plan.prunes_unseen && !prunes && !lowers) return;
    const ScopedPhase phase("pruning");
    before();
    session_.memory().NoteModel(state.model.layout());
    if (plan.prunes_unseen) KeepOnly(WellObserved(OnHost(state, degree), MakeScoringViews()), state);
    // Degrees are lowered first, because scoring Gaussians is then faster.
    if (lowers) LowerDegrees(state, degree);
    if (prunes) PruneByScore(state, degree);
    copy_ = SplatModel();
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
  static constexpr double kPartForDegrees = 0.5;  // fraction of the time for scoring

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
  void KeepOnly(const std::vector<Index>& kept, AdamStageState<B>& state) {
    if (static_cast<Index>(kept.size()) < state.model.count()) state.model.Keep(kept);
  }
  void PruneByScore(AdamStageState<B>& state, int degree) {
    if (state.before_pruning == 0) state.before_pruning = state.model.count();
    const Index scored = state.model.count(), left = CountAfter(options_, state.span, state.before_pruning);
    if (options_.prunes_to_count() && left >= scored) return;
    const double begin = session_.Seconds();
    const auto round = static_cast<std::uint64_t>(state.iteration);
    const splat::Model<float> model = OnHost(state, degree);
    const std::vector<Index> kept =
        options_.prunes_to_count()
            ? SelectToKeep(model, MakeScoringViews(), options_.prune_unseen, left)
            : KeepByAic(model, MakeScoringViews(), AicWeightAt(options_, state.span), session_.options().seed, round);
    KeepOnly(kept, state);
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
